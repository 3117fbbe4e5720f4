//! Sensitivities of a design's metrics to its variables, by the modes route.
//!
//! For springs they are analytic. With e_sr the elongation of spring s in mode r, h_s the elongation for
//! a unit force at a port, and an extremum's frequency held (its own shift is of second order),
//!
//! ```text
//! d omega_r^2 / dk_s = e_sr^2
//! dH_ij / dk_s = - (1 + j eta) h_si h_sj
//!                - j omega sum_rq L_ir w_r e_sr (c_r - c_q) / (omega_r^2 - omega_q^2) e_sq w_q R_jq
//! ```
//!
//! where w_r are the modes' weights and c_r = 2 zeta_r omega_r: a modal ratio follows the modes as they
//! change (Daleckii and Krein's divided difference of C as a function of K). Damping and the moduli of
//! parts are taken by a central difference of the whole evaluation.

use super::{Design, Evaluator, ModesRoute, PositionMetrics, SweepError};
use crate::linalg::multiply;
use crate::machine::Damping;
use crate::modal::Modes;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Relative step of the central differences.
const STEP: f64 = 1e-4;

/// Derivatives of one position's metrics by one variable, in the metrics' units per unit of the variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// Of the largest |H| of each direct pair.
    pub peak: Vec<f64>,
    /// Of the most negative real part of each direct pair.
    pub most_negative_real: Vec<f64>,
    /// Of the static compliance of each direct pair.
    pub static_compliance: Vec<f64>,
    /// Of each family's eigenfrequency; `None` where tracking lost it.
    pub families: Vec<Option<f64>>,
    /// Whether it is analytic; a difference otherwise.
    pub analytic: bool,
}

impl ModesRoute<'_> {
    /// Sensitivities at a design, `[variable][position]`; `design` makes one from values of the variables.
    ///
    /// # Errors
    /// [`SweepError`] of the design or of one beside it.
    ///
    /// # Accuracy
    /// Analytic ones are those of the evaluation to 1e-6, but for loss factors and dampers of single joints
    /// and parts, whose own projection on the modes is not differentiated; differences keep some 1e-5.
    pub fn sensitivities(
        &self,
        values: &[f64],
        design: &(dyn Fn(&[f64]) -> Result<Design, SweepError> + Sync),
    ) -> Result<Vec<Vec<Sensitivity>>, SweepError> {
        let here = design(values)?;
        let metrics = self.evaluate(std::slice::from_ref(&here)).swap_remove(0)?;
        let one = |variable: usize| -> Result<Vec<Sensitivity>, SweepError> {
            let step = STEP * values[variable].abs().max(f64::MIN_POSITIVE);
            let beside = |sign: f64| {
                let mut moved = values.to_vec();
                moved[variable] += sign * step;
                design(&moved)
            };
            let (below, above) = (beside(-1.0)?, beside(1.0)?);
            if only_springs(&below, &here) && only_springs(&above, &here) && self.is_near(&here)? {
                let at = |k: usize| self.analytic(&here, [&below, &above], 2.0 * step, k, &metrics[k]);
                return (0..metrics.len()).into_par_iter().map(at).collect();
            }
            let [below, above]: [_; 2] = [below, above].map(|d| self.evaluate(std::slice::from_ref(&d)).swap_remove(0));
            Ok(below?.iter().zip(&above?).map(|(a, b)| difference(a, b, 2.0 * step)).collect())
        };
        (0..values.len()).map(one).collect()
    }

    fn analytic(
        &self,
        here: &Design,
        beside: [&Design; 2],
        apart: f64,
        index: usize,
        metrics: &PositionMetrics,
    ) -> Result<Sensitivity, SweepError> {
        let prepared = self.prepared();
        let around = &prepared.around[index];
        let springs = |d: &Design| prepared.model.spring_values(&d.machine, around.position);
        let (values, low, high) = (springs(here)?, springs(beside[0])?, springs(beside[1])?);
        let rates: Vec<f64> = low.stiffness.iter().zip(&high.stiffness).map(|(a, b)| (b - a) / apart).collect();
        let modes = self.modes(prepared, here, index)?;
        let coupled = around.coupled(&values.stiffness)?;
        let elongations = multiply(&around.elongations(&coupled), &modes.shapes);
        let direct = around.direct_elongations(&coupled);
        let losses: Vec<f64> =
            values.loss_factors.iter().map(|eta| eta + here.machine.analysis.damping.loss_factor).collect();
        let slope = Slope {
            modes: &modes,
            elongations: &elongations,
            direct: &direct,
            rates: &rates,
            losses: &losses,
            damping: &here.machine.analysis.damping,
        };
        let pairs = metrics.pairs.iter();
        let peak = pairs.clone().map(|p| {
            let (h, dh) = slope.at(p.output, p.input, p.peak.frequency);
            (h.conj() * dh).re / h.norm()
        });
        let real = pairs.clone().map(|p| slope.at(p.output, p.input, p.most_negative_real.frequency).1.re);
        let at_rest = pairs.map(|p| slope.at_rest(p.output, p.input));
        let families = prepared.families[index].iter().map(|shape| {
            let r = super::modes_route::family_mode(&modes, shape.as_ref()?)?;
            // A free motion stays at 0 Hz.
            if r < modes.free {
                return Some(0.0);
            }
            let rate: f64 = rates.iter().enumerate().map(|(s, k)| k * elongations[(s, r)].powi(2)).sum();
            Some(rate / (2.0 * TAU * TAU * modes.frequency(r)))
        });
        Ok(Sensitivity {
            peak: peak.collect(),
            most_negative_real: real.collect(),
            static_compliance: at_rest.collect(),
            families: families.collect(),
            analytic: true,
        })
    }
}

/// The response's slope by a variable that changes the springs at given rates.
struct Slope<'a> {
    modes: &'a Modes,
    /// n_springs x n_modes.
    elongations: &'a DMatrix<f64>,
    /// n_springs x (n_outputs + n_inputs), m/N.
    direct: &'a DMatrix<f64>,
    /// dk_s / dv.
    rates: &'a [f64],
    /// Loss factor of each spring, the machine's included.
    losses: &'a [f64],
    damping: &'a Damping,
}

impl Slope<'_> {
    /// H and dH/dv at a frequency, Hz.
    fn at(&self, output: usize, input: usize, frequency: f64) -> (Complex<f64>, Complex<f64>) {
        let modes = self.modes;
        let omega = TAU * frequency;
        let felt: Vec<usize> = (0..modes.eigenvalues.len()).filter(|&r| r >= modes.free || modes.is_felt(r)).collect();
        let weight = |r: usize| {
            let l = modes.eigenvalues[r];
            let viscous = 2.0 * modes.damping_ratios[r] * l.sqrt() * omega;
            Complex::new(l - omega * omega, l * modes.loss_factors[r] + viscous).inv()
        };
        let left: Vec<Complex<f64>> = felt.iter().map(|&r| weight(r) * modes.outputs[(output, r)]).collect();
        let right: Vec<Complex<f64>> = felt.iter().map(|&r| weight(r) * modes.inputs[(input, r)]).collect();
        let carried = Complex::new(1.0, modes.direct_loss_factor).inv();
        let mut h = carried * modes.direct[(output, input)];
        for (k, &r) in felt.iter().enumerate() {
            h += left[k] * modes.inputs[(input, r)];
        }
        let second = modes.outputs.nrows() + input;
        let mut slope = Complex::new(0.0, 0.0);
        for (s, rate) in self.rates.iter().enumerate().filter(|(_, rate)| **rate != 0.0) {
            let e = |k: usize| self.elongations[(s, felt[k])];
            let sum = |side: &[Complex<f64>]| side.iter().enumerate().map(|(k, v)| v * e(k)).sum::<Complex<f64>>();
            let from_output = sum(&left) + carried * self.direct[(s, output)];
            let from_input = sum(&right) + carried * self.direct[(s, second)];
            slope -= from_output * from_input * Complex::new(1.0, self.losses[s]) * *rate;
            let mut viscous = Complex::new(0.0, 0.0);
            for (a, &r) in felt.iter().enumerate() {
                let inner: Complex<f64> =
                    felt.iter().enumerate().map(|(b, &q)| right[b] * (e(b) * self.divided(r, q))).sum();
                viscous += left[a] * inner * e(a);
            }
            slope -= viscous * Complex::new(0.0, omega * rate);
        }
        (h, slope)
    }

    /// (c_r - c_q) / (omega_r^2 - omega_q^2) of the machine's own viscous damping.
    fn divided(&self, r: usize, q: usize) -> f64 {
        let free = self.modes.free;
        let ratio = |r: usize| {
            let listed = |i: usize| self.damping.ratios.get(i).or(self.damping.ratios.last()).copied();
            r.checked_sub(free).and_then(listed).unwrap_or(0.0)
        };
        let (a, b) = (self.modes.eigenvalues[r], self.modes.eigenvalues[q]);
        let (u, v) = (a.sqrt(), b.sqrt());
        let rayleigh = self.damping.rayleigh.map_or(0.0, |[_, beta]| beta);
        let (zeta, xi) = (ratio(r), ratio(q));
        let modal = if u + v == 0.0 {
            0.0
        } else if zeta == xi || r == q || (a - b).abs() < 1e-9 * a {
            (zeta + xi) / (u + v)
        } else {
            2.0 * (zeta * u - xi * v) / (a - b)
        };
        modal + rayleigh
    }

    /// Slope of the static compliance, m/N.
    fn at_rest(&self, output: usize, input: usize) -> f64 {
        let modes = self.modes;
        let elastic = modes.free..modes.eigenvalues.len();
        let one = |s: usize, rows: &DMatrix<f64>, row: usize, column: usize| {
            let sum: f64 =
                elastic.clone().map(|r| self.elongations[(s, r)] * rows[(row, r)] / modes.eigenvalues[r]).sum();
            sum + self.direct[(s, column)]
        };
        let springs = self.rates.iter().enumerate().filter(|(_, rate)| **rate != 0.0);
        let rate = |(s, rate): (usize, &f64)| {
            -rate * one(s, &modes.outputs, output, output) * one(s, &modes.inputs, input, modes.outputs.nrows() + input)
        };
        springs.map(rate).sum()
    }
}

/// Whether two designs differ in nothing but their springs' stiffness.
fn only_springs(a: &Design, b: &Design) -> bool {
    let machines = (&a.machine, &b.machine);
    let joints = machines.0.joints.iter().zip(&machines.1.joints).all(|(a, b)| {
        a.loss_factor == b.loss_factor && a.springs.iter().zip(&b.springs).all(|(a, b)| a.damping == b.damping)
    });
    let losses = machines.0.parts.iter().zip(&machines.1.parts).all(|(a, b)| a.loss_factor == b.loss_factor);
    a.parts == b.parts && joints && losses && machines.0.analysis.damping == machines.1.analysis.damping
}

fn difference(a: &PositionMetrics, b: &PositionMetrics, apart: f64) -> Sensitivity {
    let pairs = || a.pairs.iter().zip(&b.pairs);
    Sensitivity {
        peak: pairs().map(|(a, b)| (b.peak.value - a.peak.value) / apart).collect(),
        most_negative_real: pairs()
            .map(|(a, b)| (b.most_negative_real.value - a.most_negative_real.value) / apart)
            .collect(),
        static_compliance: a.static_compliance.iter().zip(&b.static_compliance).map(|(a, b)| (b - a) / apart).collect(),
        families: a.families.iter().zip(&b.families).map(|(a, b)| Some((b.as_ref()? - a.as_ref()?) / apart)).collect(),
        analytic: false,
    }
}
