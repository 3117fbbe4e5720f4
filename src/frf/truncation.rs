//! Which modes a map sums and how it accounts for the rest.
//!
//! The modes up to twice the highest frequency of the grid are summed one by one. Each mode above is
//! expanded about 0 Hz in s = j omega, with a_0 = omega_r^2 (1 + j eta_r), a_1 = 2 zeta_r omega_r:
//!
//! ```text
//! 1 / (a_0 + a_1 s + s^2) = sum c_k s^k,   c_0 = 1 / a_0,   c_k = -(a_1 c_(k-1) + c_(k-2)) / a_0
//! ```
//!
//! and their sum, with the static compliance that no mode carries, is one polynomial a position: the
//! even terms the stiffness and mass of the rest, the odd ones its damping. The degree is raised
//! until the polynomial meets the tolerance at probe frequencies, measured against all modes.

use super::{FrfError, ModalSystem};
use crate::modal::Modes;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Which modes are summed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Selection {
    /// All modes up to twice the highest frequency, the rest as a polynomial within this tolerance
    /// (Frobenius, relative).
    Controlled {
        /// Largest relative Frobenius difference to the sum over all modes.
        tolerance: f64,
    },
    /// Exactly this many elastic modes (the paper's setting).
    Exactly {
        /// Elastic modes.
        modes: usize,
        /// Whether the constant residual R0 = H(0) - sum phi phi^T / omega_r^2 is carried.
        residual: bool,
    },
}

/// What truncation did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truncation {
    /// Fewest modes summed at a position.
    pub fewest_modes: usize,
    /// Most modes summed at a position.
    pub most_modes: usize,
    /// Degree of the residual polynomial; `None` without one.
    pub degree: Option<usize>,
    /// Largest relative Frobenius difference to the sum over all modes at the probe frequencies.
    pub error: f64,
}

/// Highest degree tried.
const HIGHEST_DEGREE: usize = 12;
/// Probe frequencies over the band.
const PROBES: usize = 24;

/// The modal systems of all positions for frequencies up to `highest` (Hz), and what was truncated.
///
/// # Errors
/// [`FrfError::Truncation`] if no degree meets the tolerance.
pub fn modal_systems(
    modes: &[Modes],
    highest: f64,
    selection: Selection,
) -> Result<(Vec<ModalSystem>, Truncation), FrfError> {
    let kept = |modes: &Modes| {
        let elastic = match selection {
            Selection::Controlled { .. } => modes.count_up_to(2.0 * highest).max(modes.free),
            Selection::Exactly { modes: n, .. } => modes.free + n,
        };
        elastic.min(modes.eigenvalues.len())
    };
    let tails: Vec<Tail<'_>> = modes.iter().map(|m| Tail { modes: m, kept: kept(m) }).collect();
    let probes: Vec<f64> = (1..=PROBES).map(|k| highest * k as f64 / PROBES as f64).collect();
    let error = |degree: Option<usize>| tails.par_iter().map(|t| t.error(degree, &probes)).reduce(|| 0.0, f64::max);
    let (degree, error) = match selection {
        Selection::Exactly { residual, .. } => {
            let degree = residual.then_some(0);
            (degree, error(degree))
        }
        Selection::Controlled { tolerance } => {
            let mut best = f64::INFINITY;
            let found = (0..=HIGHEST_DEGREE).find_map(|d| {
                best = error(Some(d));
                (best <= tolerance).then_some((Some(d), best))
            });
            found.ok_or(FrfError::Truncation { degree: HIGHEST_DEGREE, error: best, tolerance })?
        }
    };
    let real = matches!(selection, Selection::Exactly { .. });
    let systems = tails.par_iter().map(|t| t.system(degree, real)).collect();
    let counts = tails.iter().map(|t| t.summed().count());
    Ok((
        systems,
        Truncation {
            fewest_modes: counts.clone().min().unwrap_or(0),
            most_modes: counts.max().unwrap_or(0),
            degree,
            error,
        },
    ))
}

/// The modal system of all modes of one position, with the static compliance that no mode carries.
pub fn full_system(modes: &Modes) -> ModalSystem {
    Tail { modes, kept: modes.eigenvalues.len() }.system(Some(0), false)
}

/// The modes of one position, split into those summed and the rest.
struct Tail<'a> {
    modes: &'a Modes,
    kept: usize,
}

impl Tail<'_> {
    /// Modes summed one by one: free ones only if the ports feel them.
    fn summed(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.kept).filter(|&r| r >= self.modes.free || self.modes.is_felt(r))
    }

    fn amplitude(&self, r: usize) -> DMatrix<f64> {
        self.modes.outputs.column(r) * self.modes.inputs.column(r).transpose()
    }

    /// Coefficients of the residual polynomial.
    fn coefficients(&self, degree: usize, real: bool) -> Vec<DMatrix<Complex<f64>>> {
        let mut out = vec![self.direct(real)];
        out.resize(degree + 1, DMatrix::zeros(self.modes.direct.nrows(), self.modes.direct.ncols()));
        for r in self.kept..self.modes.eigenvalues.len() {
            let amplitude = self.amplitude(r);
            let eta = if real { 0.0 } else { self.modes.loss_factors[r] };
            let a0 = Complex::new(1.0, eta) * self.modes.eigenvalues[r];
            let a1 = 2.0 * self.modes.damping_ratios[r] * self.modes.eigenvalues[r].sqrt();
            let (mut before, mut c) = (Complex::new(0.0, 0.0), a0.inv());
            for matrix in &mut out {
                matrix.zip_apply(&amplitude, |m, a| *m += c * a);
                (before, c) = (c, -(c * a1 + before) / a0);
            }
        }
        out
    }

    /// The static compliance that no mode carries, with the machine's loss factor unless it is to be real.
    fn direct(&self, real: bool) -> DMatrix<Complex<f64>> {
        let eta = if real { 0.0 } else { self.modes.direct_loss_factor };
        self.modes.direct.map(|v| v / Complex::new(1.0, eta))
    }

    /// Largest relative difference between the polynomial (or nothing) and the modes it stands for.
    fn error(&self, degree: Option<usize>, probes: &[f64]) -> f64 {
        let polynomial = degree.map(|d| self.coefficients(d, false));
        let one = |frequency: f64| {
            let s = Complex::new(0.0, TAU * frequency);
            let sum = |range: &mut dyn Iterator<Item = usize>| {
                let mut h: DMatrix<Complex<f64>> = DMatrix::zeros(self.modes.direct.nrows(), self.modes.direct.ncols());
                for r in range {
                    let l = self.modes.eigenvalues[r];
                    let den = Complex::new(1.0, self.modes.loss_factors[r]) * l
                        + s * s
                        + s * (2.0 * self.modes.damping_ratios[r] * l.sqrt());
                    h.zip_apply(&self.amplitude(r), |m, a| *m += Complex::new(a, 0.0) / den);
                }
                h
            };
            let rest = sum(&mut (self.kept..self.modes.eigenvalues.len())) + self.direct(false);
            let all = sum(&mut self.summed()) + &rest;
            let stands_for =
                polynomial.iter().flatten().rev().fold(rest.map(|_| Complex::new(0.0, 0.0)), |p, c| p * s + c);
            (rest - stands_for).norm() / all.norm()
        };
        probes.iter().map(|&f| one(f)).fold(0.0, f64::max)
    }

    fn system(&self, degree: Option<usize>, real: bool) -> ModalSystem {
        let summed: Vec<usize> = self.summed().collect();
        let columns = |shapes: &DMatrix<f64>| shapes.select_columns(&summed);
        ModalSystem {
            frequencies: summed.iter().map(|&r| self.modes.frequency(r)).collect(),
            damping_ratios: summed.iter().map(|&r| self.modes.damping_ratios[r]).collect(),
            loss_factors: summed.iter().map(|&r| self.modes.loss_factors[r]).collect(),
            outputs: columns(&self.modes.outputs),
            inputs: columns(&self.modes.inputs),
            residual: degree.map_or_else(Vec::new, |d| self.coefficients(d, real)),
        }
    }
}
