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

use super::{ExactDamping, FrfError, ModalSystem};
use crate::linalg::complex_eigen;
use crate::modal::Modes;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::sync::Arc;

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
/// [`FrfError::Truncation`] if no degree meets the tolerance; [`FrfError::Eigen`] if the complex modes of parts with
/// loss factors could not be had.
pub fn modal_systems(
    modes: &[Modes],
    highest: f64,
    selection: Selection,
) -> Result<(Vec<ModalSystem>, Truncation), FrfError> {
    let kept = |modes: &Modes| {
        let elastic = match selection {
            Selection::Controlled { .. } => {
                modes.count_up_to(2.0 * highest).max(modes.free).max(coupled_by_parts(modes))
            }
            Selection::Exactly { modes: n, .. } => modes.free + n,
        };
        elastic.min(modes.eigenvalues.len())
    };
    let sums: Vec<Sums<'_>> = modes.iter().map(|m| Sums::new(m, kept(m))).collect();
    let probes: Vec<f64> = (1..=PROBES).map(|k| highest * k as f64 / PROBES as f64).collect();
    let error = |degree: Option<usize>| sums.par_iter().map(|s| s.error(degree, &probes)).reduce(|| 0.0, f64::max);
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
            found.ok_or_else(|| {
                overdamped(&sums).unwrap_or(FrfError::Truncation { degree: HIGHEST_DEGREE, error: best, tolerance })
            })?
        }
    };
    let real = matches!(selection, Selection::Exactly { .. });
    let systems = sums.par_iter().map(|s| s.system(degree, real)).collect::<Result<Vec<_>, _>>()?;
    let counts = sums.iter().map(|s| s.own.summed().len());
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

/// The mode that most lacks an oscillation, if any does: a polynomial cannot stand for it.
fn overdamped(sums: &[Sums<'_>]) -> Option<FrfError> {
    let of = |s: &Sums<'_>| {
        let tail = s.coupled.as_ref().unwrap_or(&s.own);
        let each = tail.ratios.iter().enumerate().map(|(r, ratio)| (*ratio, tail.modes.frequency(r)));
        each.max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (ratio, frequency) = sums.iter().filter_map(of).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (ratio > 0.5).then_some(FrfError::Overdamped { frequency, ratio })
}

/// Modes that parts with loss factors couple; what they take from the modes beyond is static and in these already.
fn coupled_by_parts(modes: &Modes) -> usize {
    let parts = modes.dissipation.as_ref().and_then(|d| d.parts.as_ref());
    parts.map_or(0, |parts| parts.between_modes.nrows())
}

/// The modal system of all modes of one position, with the static compliance that no mode carries.
///
/// # Errors
/// [`FrfError::Eigen`] as for [`modal_systems`].
pub fn full_system(modes: &Modes) -> Result<ModalSystem, FrfError> {
    Sums::new(modes, modes.eigenvalues.len()).system(Some(0), false)
}

/// The modes of one position, as projection has them and, where damping couples them, without what couples them.
struct Sums<'a> {
    own: Tail<'a>,
    coupled: Option<Tail<'a>>,
}

impl<'a> Sums<'a> {
    fn new(modes: &'a Modes, kept: usize) -> Self {
        let own = Tail {
            modes,
            kept,
            outputs: Cow::Borrowed(&modes.outputs),
            inputs: Cow::Borrowed(&modes.inputs),
            direct: &modes.direct,
            ratios: Cow::Borrowed(&modes.damping_ratios),
            losses: Cow::Borrowed(&modes.loss_factors),
        };
        let coupled = modes.dissipation.as_ref().map(|d| {
            let below = |rows: &DMatrix<f64>| {
                let all: Vec<_> = rows.row_iter().chain(d.springs.row_iter()).collect();
                DMatrix::from_rows(&all)
            };
            Tail {
                modes,
                kept,
                outputs: Cow::Owned(below(&modes.outputs)),
                inputs: Cow::Owned(below(&modes.inputs)),
                direct: &d.direct,
                ratios: Cow::Borrowed(&d.damping_ratios),
                losses: Cow::Owned((0..d.loss_factors.len()).map(|r| d.loss_factor(r, modes.eigenvalues[r])).collect()),
            }
        });
        Self { own, coupled }
    }

    fn system(&self, degree: Option<usize>, real: bool) -> Result<ModalSystem, FrfError> {
        let mut system = self.own.system(degree, real);
        if let (Some(tail), Some(d)) = (&self.coupled, &self.own.modes.dissipation) {
            let plain = tail.system(degree, real);
            let (plain, is_complex) = match &d.parts {
                None => (plain, false),
                Some(parts) => (complex_modes(&plain, &tail.summed(), parts, d)?, true),
            };
            let exact = ExactDamping::new(plain, is_complex, d.viscous.clone(), d.structural.clone());
            system.exact = Some(Arc::new(exact));
        }
        Ok(system)
    }

    /// Largest relative difference that the polynomial (or nothing) makes in place of the modes it stands for.
    fn error(&self, degree: Option<usize>, probes: &[f64]) -> f64 {
        let Some(tail) = &self.coupled else { return self.own.error(degree, probes, |_, _| ()) };
        let d = self.own.modes.dissipation.as_ref().expect("a coupled tail comes from it");
        let exact = ExactDamping::new(tail.system(None, false), false, d.viscous.clone(), d.structural.clone());
        tail.error(degree, probes, |f, h| exact.eliminate_in(f, h))
    }
}

/// A system's first modes in the complex modes of its parts' complex stiffness: real parts of all rows, then imaginary ones.
fn complex_modes(
    system: &ModalSystem,
    ranks: &[usize],
    parts: &crate::modal::PartLosses,
    d: &crate::modal::Dissipation,
) -> Result<ModalSystem, FrfError> {
    // Those that parts couple stand after the free motions and before the rest.
    let first = system.frequencies.iter().take_while(|f| **f == 0.0).count();
    let end = ranks.iter().take_while(|r| **r < parts.between_modes.nrows()).count().max(first);
    let own = &ranks[first..end];
    let n = own.len();
    let lambda = |k: usize| (TAU * system.frequencies[first + k]).powi(2);
    let stiffness = DMatrix::from_fn(n, n, |a, b| {
        let between = parts.between_modes[(own[a], own[b])];
        if a == b { Complex::new(lambda(a), lambda(a) * d.loss_factors[own[a]]) + between } else { between }
    });
    let eigen = complex_eigen(&stiffness).map_err(|_| FrfError::Eigen { n })?;
    // The viscous part is projected: its coupling between these modes is of third order in the damping.
    let rate = |k: usize| 2.0 * system.damping_ratios[first + k] * lambda(k).sqrt();
    let viscous: Vec<f64> = (0..n)
        .map(|r| (0..n).map(|k| eigen.inverse[(r, k)] * rate(k) * eigen.vectors[(k, r)]).sum::<Complex<f64>>().re)
        .collect();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| eigen.values[a].re.total_cmp(&eigen.values[b].re));
    let mut out = system.clone();
    // The static response loses energy with the modes too, which turns their rows.
    let double = |rows: &DMatrix<f64>, lost: &DMatrix<Complex<f64>>, side: &dyn Fn(usize, usize) -> Complex<f64>| {
        let m = rows.nrows();
        let row = |i: usize, k: usize| rows[(i, first + k)] - lost[(i, own[k])];
        let mut all = DMatrix::zeros(2 * m, rows.ncols());
        all.rows_mut(0, m).copy_from(rows);
        for i in 0..m {
            for (at, &r) in order.iter().enumerate() {
                let value: Complex<f64> = (0..n).map(|k| side(k, r) * row(i, k)).sum();
                (all[(i, first + at)], all[(m + i, first + at)]) = (value.re, value.im);
            }
        }
        all
    };
    // V^-1 = V^T as the matrix is symmetric, once its columns are scaled so that v^T v = 1.
    let norm = |r: usize| (0..n).map(|k| eigen.vectors[(k, r)].powi(2)).sum::<Complex<f64>>().sqrt();
    let norms: Vec<Complex<f64>> = (0..n).map(norm).collect();
    let vector = |k: usize, r: usize| eigen.vectors[(k, r)] / norms[r];
    let inverse = |k: usize, r: usize| eigen.inverse[(r, k)] * norms[r];
    let apart = (0..n * n).map(|at| (vector(at / n, at % n) - inverse(at / n, at % n)).norm()).fold(0.0, f64::max);
    let inverse: &dyn Fn(usize, usize) -> Complex<f64> = if apart < 1e-9 { &vector } else { &inverse };
    out.outputs = double(&system.outputs, &parts.outputs, &vector);
    out.inputs = double(&system.inputs, &parts.inputs, inverse);
    for (at, &r) in order.iter().enumerate() {
        let value = eigen.values[r];
        out.frequencies[first + at] = value.re.max(0.0).sqrt() / TAU;
        out.loss_factors[first + at] = value.im / value.re;
        out.damping_ratios[first + at] = viscous[r] / (2.0 * value.re.max(f64::MIN_POSITIVE).sqrt());
    }
    let grown = |c: &DMatrix<Complex<f64>>| c.clone().resize(2 * c.nrows(), 2 * c.ncols(), Complex::new(0.0, 0.0));
    out.residual = system.residual.iter().map(grown).collect();
    if let Some(still) = out.residual.first_mut() {
        // Of first order in the loss, and exact where all of this flexibility has one loss factor.
        let mean = parts.direct.dot(&d.direct) / d.direct.norm_squared().max(f64::MIN_POSITIVE);
        for (i, j) in (0..d.direct.nrows()).flat_map(|i| (0..d.direct.ncols()).map(move |j| (i, j))) {
            still[(i, j)] -= Complex::new(0.0, parts.direct[(i, j)]) / Complex::new(1.0, mean);
        }
    }
    Ok(out)
}

/// The modes of one position between some rows, split into those summed and the rest.
struct Tail<'a> {
    modes: &'a Modes,
    kept: usize,
    outputs: Cow<'a, DMatrix<f64>>,
    inputs: Cow<'a, DMatrix<f64>>,
    /// Static compliance that no mode carries, between these rows.
    direct: &'a DMatrix<f64>,
    ratios: Cow<'a, [f64]>,
    losses: Cow<'a, [f64]>,
}

impl Tail<'_> {
    /// Modes summed one by one: free ones only if the ports feel them.
    fn summed(&self) -> Vec<usize> {
        (0..self.kept).filter(|&r| r >= self.modes.free || self.modes.is_felt(r)).collect()
    }

    fn amplitude(&self, r: usize) -> DMatrix<f64> {
        self.outputs.column(r) * self.inputs.column(r).transpose()
    }

    fn zero(&self) -> DMatrix<Complex<f64>> {
        DMatrix::zeros(self.direct.nrows(), self.direct.ncols())
    }

    /// Coefficients of the residual polynomial.
    fn coefficients(&self, degree: usize, real: bool) -> Vec<DMatrix<Complex<f64>>> {
        let mut out = vec![self.direct(real)];
        out.resize(degree + 1, self.zero());
        for r in self.kept..self.modes.eigenvalues.len() {
            let amplitude = self.amplitude(r);
            let eta = if real { 0.0 } else { self.losses[r] };
            let a0 = Complex::new(1.0, eta) * self.modes.eigenvalues[r];
            let a1 = 2.0 * self.ratios[r] * self.modes.eigenvalues[r].sqrt();
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
        self.direct.map(|v| v / Complex::new(1.0, eta))
    }

    /// Largest relative difference between the polynomial (or nothing) and the modes it stands for, in the responses
    /// that `finish` makes of the sums at a frequency.
    fn error(&self, degree: Option<usize>, probes: &[f64], finish: impl Fn(f64, &mut DMatrix<Complex<f64>>)) -> f64 {
        let polynomial = degree.map(|d| self.coefficients(d, false));
        let summed = self.summed();
        let one = |frequency: f64| {
            let s = Complex::new(0.0, TAU * frequency);
            let sum = |range: &mut dyn Iterator<Item = usize>| {
                let mut h = self.zero();
                for r in range {
                    let l = self.modes.eigenvalues[r];
                    let den = Complex::new(1.0, self.losses[r]) * l + s * s + s * (2.0 * self.ratios[r] * l.sqrt());
                    h.zip_apply(&self.amplitude(r), |m, a| *m += Complex::new(a, 0.0) / den);
                }
                h
            };
            let rest = sum(&mut (self.kept..self.modes.eigenvalues.len())) + self.direct(false);
            let own = sum(&mut summed.iter().copied());
            let stands_for = polynomial.iter().flatten().rev().fold(self.zero(), |p, c| p * s + c);
            let (mut all, mut taken) = (&own + &rest, &own + &stands_for);
            finish(frequency, &mut all);
            finish(frequency, &mut taken);
            let rows = (self.modes.outputs.nrows(), self.modes.inputs.nrows());
            let apart = if self.direct.shape() == rows { rest - stands_for } else { &all - &taken };
            apart.view((0, 0), rows).norm() / all.view((0, 0), rows).norm()
        };
        probes.iter().map(|&f| one(f)).fold(0.0, f64::max)
    }

    fn system(&self, degree: Option<usize>, real: bool) -> ModalSystem {
        let summed = self.summed();
        let columns = |shapes: &DMatrix<f64>| shapes.select_columns(&summed);
        ModalSystem {
            frequencies: summed.iter().map(|&r| self.modes.frequency(r)).collect(),
            damping_ratios: summed.iter().map(|&r| self.ratios[r]).collect(),
            loss_factors: summed.iter().map(|&r| self.losses[r]).collect(),
            outputs: columns(&self.outputs),
            inputs: columns(&self.inputs),
            residual: degree.map_or_else(Vec::new, |d| self.coefficients(d, real)),
            exact: None,
        }
    }
}
