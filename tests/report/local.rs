//! The page's local coordinates against the whole model with changed joints.

use crate::support::slide::{Slide, ratio};
use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;
use stiffmap::coupling::{BasisOptions, CoupledModel, couple};
use stiffmap::figures::report::{LocalBasis, local_basis};
use stiffmap::modal::{modes_at, modes_of};

/// Highest frequency, Hz.
const HIGHEST: f64 = 2500.0;
const ZETA: f64 = 0.01;

/// sum p q^T / (lambda - omega^2 + 2 j zeta omega sqrt(lambda)) + d.
fn sum(lambda: &[f64], p: &DMatrix<f64>, q: &DMatrix<f64>, d: &DMatrix<f64>, frequency: f64) -> DMatrix<Complex<f64>> {
    let omega = TAU * frequency;
    let mut h = d.map(|v| Complex::new(v, 0.0));
    for (r, l) in lambda.iter().enumerate() {
        let l = l.max(0.0);
        let den = Complex::new(l - omega * omega, 2.0 * ZETA * omega * l.sqrt());
        h += (p.column(r) * q.column(r).transpose()).map(|v| Complex::from(v) / den);
    }
    h
}

/// The changed machine in local coordinates, as the page solves it.
fn changed(basis: &LocalBasis, dk: &[f64], ports: usize) -> (Vec<f64>, DMatrix<f64>, DMatrix<f64>) {
    let s = dk.len();
    let c = &basis.residual;
    let change = DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(dk));
    let inner = DMatrix::identity(s, s) + &change * c.view((0, 0), (s, s));
    let f = inner.lu().solve(&change).expect("I + dk C is regular");
    let e = basis.rows.rows(0, s).into_owned();
    let fe = &f * &e;
    let mut k = e.transpose() * &fe;
    for (r, l) in basis.eigenvalues.iter().enumerate() {
        k[(r, r)] += l;
    }
    let c_ps = c.view((s, 0), (ports, s)).into_owned();
    let p = basis.rows.rows(s, ports).into_owned() - &c_ps * &fe;
    let d = c.view((s, s), (ports, ports)).into_owned() - &c_ps * &f * c_ps.transpose();
    let eigen = (0.5 * (&k + k.transpose())).symmetric_eigen();
    (eigen.eigenvalues.as_slice().to_vec(), p * eigen.eigenvectors, d)
}

fn worst(model: &CoupledModel, factor: impl Fn(usize) -> f64, reported: impl Fn(usize) -> f64) -> f64 {
    let damping = ratio(ZETA);
    let mut worst: f64 = 0.0;
    for position in [0.3, 0.041, -0.3] {
        let at = model.at(position).unwrap();
        let k = model.stiffness(position).unwrap();
        let modes = modes_at(model, &damping, position, model.n()).unwrap();
        let springs: Vec<usize> = (0..k.len()).collect();
        let basis = local_basis(model, &at, &k, &modes, &springs, HIGHEST).unwrap();
        let dk: Vec<f64> = k.iter().enumerate().map(|(s, k)| (factor(s) - 1.0) * k).collect();
        let stiffness: Vec<f64> = k.iter().enumerate().map(|(s, k)| reported(s) * k).collect();
        let whole = modes_of(model, &damping, &at, &stiffness, model.n()).unwrap();
        let ports = whole.outputs.nrows();
        let (lambda, p, d) = changed(&basis, &dk, ports);
        for step in 1..=250 {
            let f = HIGHEST * f64::from(step) / 250.0;
            let exact = sum(&whole.eigenvalues, &whole.outputs, &whole.inputs, &whole.direct, f);
            worst = worst.max((sum(&lambda, &p, &p, &d, f) - &exact).norm() / exact.norm());
        }
    }
    worst
}

#[test]
fn local_coordinates_follow_changed_joints() {
    let slide = Slide::new(true);
    let model = couple(&slide.machine, &slide.parts, BasisOptions::up_to(2.0 * HIGHEST)).unwrap();
    let screw = slide.machine.joints.iter().flat_map(|j| &j.springs).count() - 1;
    for (name, factor) in
        [("as run", [1.0, 1.0]), ("guides 1.5", [1.5, 1.0]), ("guides 0.3", [0.3, 1.0]), ("screw 4", [1.0, 4.0])]
    {
        let of = |s: usize| factor[usize::from(s == screw)];
        let error = worst(&model, of, of);
        println!("{name}: {error:.1e}");
        assert!(error <= 3e-4, "{name}: {error:.2e}");
    }
    let control = worst(&model, |_| 1.5, |_| 1.49);
    assert!(control > 1e-3, "control: another stiffness, {control:.2e}");
}
