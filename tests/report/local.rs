//! The coordinates that the page holds, against the whole model with changed joints.

use crate::support::slide::Slide;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;
use stiffmap::coupling::{BasisOptions, CoupledModel, couple};
use stiffmap::figures::report::PAGE;
use stiffmap::linalg::symmetric_eigen;

/// Highest frequency, Hz.
const HIGHEST: f64 = 2500.0;
const ZETA: f64 = 0.01;

/// A machine by its K (M = I), its ports' rows and what follows without delay.
struct Machine {
    stiffness: DMatrix<f64>,
    outputs: DMatrix<f64>,
    inputs: DMatrix<f64>,
    direct: DMatrix<f64>,
}

impl Machine {
    /// sum p q^T / (lambda - omega^2 + 2 j zeta omega sqrt(lambda)) + D at all frequencies.
    fn receptances(&self) -> Vec<DMatrix<Complex<f64>>> {
        let eigen = symmetric_eigen(&self.stiffness).unwrap();
        let (p, q) = (&self.outputs * &eigen.vectors, &self.inputs * &eigen.vectors);
        let at = |frequency: f64| {
            let omega = TAU * frequency;
            let mut h = self.direct.map(|v| Complex::new(v, 0.0));
            for (r, l) in eigen.values.iter().enumerate() {
                let l = l.max(0.0);
                let den = Complex::new(l - omega * omega, 2.0 * ZETA * omega * l.sqrt());
                h += (p.column(r) * q.column(r).transpose()).map(|v| Complex::from(v) / den);
            }
            h
        };
        (1..=250).map(|step| at(HIGHEST * f64::from(step) / 250.0)).collect()
    }
}

/// Largest difference between few coordinates and all of them when each spring is `factor` times as stiff, and
/// `reported` times in the whole model.
fn worst(model: &CoupledModel, factor: impl Fn(usize) -> f64, reported: impl Fn(usize) -> f64) -> f64 {
    let mut worst: f64 = 0.0;
    for position in [0.3, 0.041, -0.3] {
        let at = model.at(position).unwrap();
        let base = model.stiffness(position).unwrap();
        let modes = model.eigen(&at, &model.coupled(&at, &base).unwrap(), &base).unwrap();
        let varied: Vec<usize> = (0..base.len()).collect();
        let around = model.around_modes(&at, &base, &modes, &varied, HIGHEST, PAGE).unwrap();
        assert!(around.n() < model.n(), "{} of {} coordinates", around.n(), model.n());
        let times = |by: &dyn Fn(usize) -> f64| base.iter().enumerate().map(|(s, k)| by(s) * k).collect::<Vec<_>>();
        let few = around.coupled(&times(&factor)).unwrap();
        let stiffness = around.stiffness_matrix(&few);
        let few = Machine { stiffness, outputs: few.outputs, inputs: few.inputs, direct: few.direct };
        let whole = model.coupled(&at, &times(&reported)).unwrap();
        let stiffness = model.stiffness_matrix(&whole);
        let whole = Machine { stiffness, outputs: whole.outputs, inputs: whole.inputs, direct: whole.direct };
        for (h, exact) in few.receptances().iter().zip(whole.receptances()) {
            worst = worst.max((h - &exact).norm() / exact.norm());
        }
    }
    worst
}

#[test]
fn the_pages_coordinates_follow_changed_joints() {
    let slide = Slide::new(true);
    let model = couple(&slide.machine, &slide.parts, BasisOptions::up_to(2.0 * HIGHEST)).unwrap();
    let screw = slide.machine.joints.iter().flat_map(|j| &j.springs).count() - 1;
    for (name, factor) in
        [("as run", [1.0, 1.0]), ("guides 1.5", [1.5, 1.0]), ("guides 0.3", [0.3, 1.0]), ("screw 4", [1.0, 4.0])]
    {
        let of = |s: usize| factor[usize::from(s == screw)];
        let error = worst(&model, of, of);
        println!("{name}: {error:.1e}");
        assert!(error <= 3e-5, "{name}: {error:.2e}");
    }
    let control = worst(&model, |_| 1.5, |_| 1.49);
    assert!(control > 1e-3, "control: another stiffness, {control:.2e}");
}
