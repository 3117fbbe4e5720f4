//! Sensitivities of a design's metrics to its variables, by the modes route.
//!
//! For springs they are analytic. With h_s the elongation of spring s for a unit force at a port, x and y the modes'
//! amplitudes for unit forces at output and input, e_sr the elongation of spring s in mode r, all of them damped, and
//! an extremum's frequency held (its own shift is of second order),
//!
//! ```text
//! d omega_r^2 / dk_s = e_sr^2
//! dH_ij / dk_s = - (1 + j eta_s) h_si h_sj
//!                - j omega sum_rq x_ir e_sr (c_r - c_q) / (omega_r^2 - omega_q^2) e_sq y_jq
//! ```
//!
//! where c_r = 2 zeta_r omega_r is what ratios and Rayleigh damping give: a modal ratio follows the modes as they
//! change (Daleckii and Krein's divided difference of C as a function of K). Where parts have loss factors, or damping
//! is projected on the modes, and for all other variables, the whole evaluation is differenced.

use super::{Design, Evaluator, ModesRoute, PositionMetrics, SweepError};
use crate::linalg::multiply;
use crate::machine::Damping;
use crate::modal::Modes;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Relative step of the central differences.
const STEP: f64 = 1e-4;
/// The same to a part's material, which turns all coordinates and leaves more rounding: 5e-10 of a metric.
const PART_STEP: f64 = 2e-4;
/// The first and the last step from zero, in the variable's unit.
const SMALLEST_STEP: f64 = 1e-9;
const LARGEST_STEP: f64 = 1e15;
/// Loss factor of a mode that nothing damps, as in the sums.
const FLOOR: f64 = 1e-9;
/// Relative change of a metric at which a step from zero is large enough.
const FELT: f64 = 1e-5;

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
    /// Analytic ones are those of the evaluation to 1e-6; differences keep some 1e-5. A variable at zero is
    /// differenced to the one side that it may go to.
    pub fn sensitivities(
        &self,
        values: &[f64],
        design: &(dyn Fn(&[f64]) -> Result<Design, SweepError> + Sync),
    ) -> Result<Vec<Vec<Sensitivity>>, SweepError> {
        let here = design(values)?;
        let metrics = self.evaluate(std::slice::from_ref(&here)).swap_remove(0)?;
        let one = |variable: usize| -> Result<Vec<Sensitivity>, SweepError> {
            let beside = |step: f64| {
                let mut moved = values.to_vec();
                moved[variable] += step;
                design(&moved)
            };
            if values[variable] == 0.0 {
                return self.differenced_at_zero(&metrics, &beside);
            }
            let step = STEP * values[variable].abs();
            if beside(step)?.parts != here.parts {
                return self.differenced_by_parts(PART_STEP * values[variable].abs(), &beside);
            }
            let (below, above) = (beside(-step)?, beside(step)?);
            let analytic = only_springs(&below, &here) && only_springs(&above, &here) && is_analytic(&here);
            if analytic && self.is_near(&here)? {
                let at = |k: usize| self.analytic(&here, [&below, &above], 2.0 * step, k, &metrics[k]);
                return (0..metrics.len()).into_par_iter().map(at).collect();
            }
            let [below, above]: [_; 2] = [below, above].map(|d| self.evaluate(std::slice::from_ref(&d)).swap_remove(0));
            Ok(below?.iter().zip(&above?).map(|(a, b)| difference(a, b, 2.0 * step)).collect())
        };
        (0..values.len()).map(one).collect()
    }

    /// Central differences of two steps, extrapolated, by all coordinates of the parts: how many are kept would change with
    /// a part's material, a step of 1e-6 in the metrics.
    fn differenced_by_parts(
        &self,
        step: f64,
        beside: &dyn Fn(f64) -> Result<Design, SweepError>,
    ) -> Result<Vec<Sensitivity>, SweepError> {
        let central = |step: f64| -> Result<Vec<Sensitivity>, SweepError> {
            let [below, above] = [-step, step].map(|h| self.evaluate_untruncated(&beside(h)?));
            Ok(below?.iter().zip(&above?).map(|(a, b)| difference(a, b, 2.0 * step)).collect())
        };
        let (near, far) = (central(step)?, central(2.0 * step)?);
        Ok(near.into_iter().zip(&far).map(|(near, far)| near.blended(4.0 / 3.0, far, -1.0 / 3.0)).collect())
    }

    /// Differences of second order to one side of a variable at zero, whose scale is not known: the step grows until
    /// it is felt.
    fn differenced_at_zero(
        &self,
        here: &[PositionMetrics],
        beside: &dyn Fn(f64) -> Result<Design, SweepError>,
    ) -> Result<Vec<Sensitivity>, SweepError> {
        let at = |step: f64| self.evaluate(&[beside(step)?]).swap_remove(0);
        let mut step = SMALLEST_STEP;
        loop {
            let near = at(step)?;
            let felt = here.iter().zip(&near).map(|(a, b)| change(a, b)).fold(0.0, f64::max);
            if felt >= FELT || step >= LARGEST_STEP {
                let far = at(2.0 * step)?;
                let sides = near.iter().zip(&far).zip(here);
                // f' = (4 f(h) - f(2h) - 3 f(0)) / 2h = 2 (f(h) - f(0)) / h - (f(2h) - f(0)) / 2h.
                return Ok(sides
                    .map(|((near, far), here)| {
                        difference(here, near, step).blended(2.0, &difference(here, far, 2.0 * step), -1.0)
                    })
                    .collect());
            }
            step *= if felt > 0.0 { (FELT / felt).clamp(2.0, 1e3) } else { 1e3 };
        }
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
        let residual = around.residual_of(&coupled);
        let dissipating = values.dissipating();
        let losses: Vec<f64> =
            values.loss_factors.iter().map(|eta| eta + here.machine.analysis.damping.loss_factor).collect();
        let slope = Slope {
            modes: &modes,
            elongations: &elongations,
            residual: &residual,
            dissipating: &dissipating,
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
    /// Compliance that no mode carries between springs, outputs and inputs, m/N.
    residual: &'a DMatrix<f64>,
    /// The springs that dissipate.
    dissipating: &'a [usize],
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
        let (ratios, loss_factors) = match &modes.dissipation {
            Some(d) => (&d.damping_ratios, &d.loss_factors),
            None => (&modes.damping_ratios, &modes.loss_factors),
        };
        let weight = |r: usize| {
            let l = modes.eigenvalues[r];
            let viscous = 2.0 * ratios[r] * l.sqrt() * omega;
            Complex::new(l - omega * omega, l * loss_factors[r].max(FLOOR) + viscous).inv()
        };
        let weights: Vec<Complex<f64>> = felt.iter().map(|&r| weight(r)).collect();
        let carried = Complex::new(1.0, modes.direct_loss_factor).inv();
        let acting: &[usize] = if modes.dissipation.is_some() { self.dissipating } else { &[] };
        let shape = |s: usize, k: usize| self.elongations[(s, felt[k])];
        let second = modes.outputs.nrows() + input;
        let n_springs = self.elongations.nrows();
        // The springs' dissipated forces for a unit force at a port, whose shapes and place in the residual are given.
        let dissipated = |row: &dyn Fn(usize) -> f64, port: usize| -> Vec<Complex<f64>> {
            let m = acting.len();
            let Some(d) = modes.dissipation.as_ref().filter(|_| m > 0) else { return Vec::new() };
            let between = |a: usize, b: usize| {
                let sum: Complex<f64> =
                    weights.iter().enumerate().map(|(k, w)| w * (shape(acting[a], k) * shape(acting[b], k))).sum();
                sum + carried * self.residual[(acting[a], acting[b])]
            };
            // e = (1 + H_ss G)^-1 H_sp, and the forces are -G e.
            let g: Vec<_> = (0..m).map(|a| Complex::new(0.0, d.structural[a] + omega * d.viscous[a])).collect();
            let inner = DMatrix::from_fn(m, m, |a, b| between(a, b) * g[b] + f64::from(u8::from(a == b)));
            let right = DMatrix::from_fn(m, 1, |a, _| {
                let sum: Complex<f64> =
                    weights.iter().enumerate().map(|(k, w)| w * (shape(acting[a], k) * row(k))).sum();
                sum + carried * self.residual[(acting[a], n_springs + port)]
            });
            let elongation =
                inner.lu().solve(&right).unwrap_or_else(|| right.map(|_| Complex::new(f64::NAN, f64::NAN)));
            (0..m).map(|a| -g[a] * elongation[(a, 0)]).collect()
        };
        let out_row = |k: usize| modes.outputs[(output, felt[k])];
        let in_row = |k: usize| modes.inputs[(input, felt[k])];
        let (at_output, at_input) = (dissipated(&out_row, output), dissipated(&in_row, second));
        let amplitude = |row: &dyn Fn(usize) -> f64, forces: &[Complex<f64>], k: usize| {
            let springs = forces.iter().zip(acting).map(|(f, &s)| f * shape(s, k)).sum::<Complex<f64>>();
            weights[k] * (springs + row(k))
        };
        let left: Vec<Complex<f64>> = (0..felt.len()).map(|k| amplitude(&out_row, &at_output, k)).collect();
        let right: Vec<Complex<f64>> = (0..felt.len()).map(|k| amplitude(&in_row, &at_input, k)).collect();
        let beyond = |row: usize, port: usize, forces: &[Complex<f64>]| {
            let springs = forces.iter().zip(acting).map(|(f, &s)| f * self.residual[(row, s)]).sum::<Complex<f64>>();
            carried * (springs + self.residual[(row, n_springs + port)])
        };
        let mut h = beyond(n_springs + output, second, &at_input);
        for (k, y) in right.iter().enumerate() {
            h += y * out_row(k);
        }
        let mut slope = Complex::new(0.0, 0.0);
        for (s, rate) in self.rates.iter().enumerate().filter(|(_, rate)| **rate != 0.0) {
            let e = |k: usize| self.elongations[(s, felt[k])];
            let sum = |side: &[Complex<f64>]| side.iter().enumerate().map(|(k, v)| v * e(k)).sum::<Complex<f64>>();
            let from_output = sum(&left) + beyond(s, output, &at_output);
            let from_input = sum(&right) + beyond(s, second, &at_input);
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
            sum + self.residual[(s, self.elongations.nrows() + column)]
        };
        let springs = self.rates.iter().enumerate().filter(|(_, rate)| **rate != 0.0);
        let rate = |(s, rate): (usize, &f64)| {
            -rate * one(s, &modes.outputs, output, output) * one(s, &modes.inputs, input, modes.outputs.nrows() + input)
        };
        springs.map(rate).sum()
    }
}

/// Whether slopes by springs are known in closed form: not where damping is projected on the modes, which turn, nor
/// where parts dissipate.
fn is_analytic(design: &Design) -> bool {
    let machine = &design.machine;
    let parts = machine.parts.iter().any(|p| p.loss_factor.is_some_and(|eta| eta > 0.0));
    let joints = machine
        .joints
        .iter()
        .any(|j| j.loss_factor.is_some_and(|eta| eta > 0.0) || j.springs.iter().any(|s| s.damping > 0.0));
    !(parts || joints && machine.analysis.damping.projected)
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

/// Largest relative change of a metric.
fn change(a: &PositionMetrics, b: &PositionMetrics) -> f64 {
    let relative = |a: f64, b: f64| if a == b { 0.0 } else { (b - a).abs() / a.abs().max(f64::MIN_POSITIVE) };
    let pairs = a.pairs.iter().zip(&b.pairs).flat_map(|(a, b)| {
        [(a.peak, b.peak), (a.most_negative_real, b.most_negative_real)].map(|(a, b)| relative(a.value, b.value))
    });
    let still = a.static_compliance.iter().zip(&b.static_compliance).map(|(a, b)| relative(*a, *b));
    let families = a.families.iter().zip(&b.families).filter_map(|(a, b)| Some(relative((*a)?, (*b)?)));
    pairs.chain(still).chain(families).filter(|x| x.is_finite()).fold(0.0, f64::max)
}

impl Sensitivity {
    /// `own` times this plus `theirs` times another.
    fn blended(self, own: f64, other: &Self, theirs: f64) -> Self {
        let all = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| own * a + theirs * b).collect();
        let families = self.families.iter().zip(&other.families);
        Self {
            peak: all(&self.peak, &other.peak),
            most_negative_real: all(&self.most_negative_real, &other.most_negative_real),
            static_compliance: all(&self.static_compliance, &other.static_compliance),
            families: families.map(|(a, b)| Some(own * (*a)? + theirs * (*b)?)).collect(),
            analytic: false,
        }
    }
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
