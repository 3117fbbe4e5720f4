//! The lowest modes of a body that may be free, by shift and invert.
//!
//! ```text
//! (K + s M)^-1 M phi = phi / (lambda + s),    s > 0
//! ```
//!
//! A zero shift fails on a free body; a positive s keeps the matrix definite, and rigid motions come out
//! as lambda = 0 beside the elastic modes. How many there are is known from K R = 0, not from a size: a
//! slender boom bends at 0.1 Hz. The shift is found in steps: the first follows from the size of K and M, the
//! next from the lowest elastic mode seen, until the two are comparable, so that rounding in K, which is
//! amplified by lambda_max / s, stays small. The modes are counted by the inertia of
//! K - sigma M with sigma in a gap behind the last of them, so that none is missed, not one of a pair.
//!
//! # Source
//! T. Ericsson, A. Ruhe, The spectral transformation Lanczos method, Math. Comput. 35 (1980); the count is
//! Sylvester's law of inertia.

use super::{Cholesky, Indefinite, LanczosOptions, LinalgError, Ordering, SparseSymmetric, Spectrum, lowest_modes};
use crate::interrupt::Interrupt;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// The lowest modes, rigid motions included.
#[derive(Clone, Debug)]
pub struct FreeSpectrum {
    /// omega_r^2, (rad/s)^2, ascending; those of rigid motions are zero to rounding, of either sign.
    pub eigenvalues: Vec<f64>,
    /// Mass-normalised shapes, n x n_modes.
    pub shapes: DMatrix<f64>,
    /// Modes at zero.
    pub rigid: usize,
    /// Largest residual |(K + s M)^-1 M x (lambda + s) - x| in the mass norm.
    pub residual: f64,
    /// Modes below [`Self::counted_below`] by the inertia of K - sigma M.
    pub counted: usize,
    /// The shift sigma of the count, (rad/s)^2.
    pub counted_below: f64,
}

/// Modes computed beyond those wanted, so that the last wanted one has a gap behind it.
const SPARE: usize = 4;
/// Passes that look for the shift, and the modes that each looks at.
const PASSES: usize = 8;
const SCOUTS: usize = 4;
/// Vectors a step of the iteration: at first, as many as a free body has rigid motions; while modes are
/// missed (several loose bodies, an element of high symmetry) twice as many, up to the widest, and twice
/// the spare modes.
const BLOCK: usize = 6;
const WIDEST: usize = 96;
/// Eigenvalues further apart than this share are not of one multiple root.
const DISTINCT: f64 = 1e-6;
/// Beside the shift an eigenvalue below this share of it is not seen in a scouting pass.
const SEEN: f64 = 1e-3;
/// The shift is at least this share of the average of K over M: below, rounding of K makes K + s M indefinite.
const LEAST_SHIFT: f64 = 1e-13;

/// The `modes` lowest modes of K phi = lambda M phi, or as many as there are; K leaves `rigid` motions free.
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`] if K + s M is not, [`LinalgError::NotConverged`],
/// [`LinalgError::ModesMissed`] if the inertia counts another number, [`LinalgError::Interrupted`].
///
/// # Accuracy
/// Some 1e-10 of an elastic eigenvalue for shifts comparable to the lowest of them.
pub fn shift_invert_modes(
    stiffness: &SparseSymmetric,
    mass: &SparseSymmetric,
    ordering: &Ordering,
    rigid: usize,
    modes: usize,
    interrupt: Option<&Interrupt>,
) -> Result<FreeSpectrum, LinalgError> {
    let n = stiffness.n();
    let wanted = modes.min(n);
    let trace = |a: &SparseSymmetric| a.diagonal().iter().sum::<f64>();
    let largest = trace(stiffness) / trace(mass);
    if wanted == 0 || !largest.is_finite() || largest <= 0.0 {
        return Err(LinalgError::Eigen { n });
    }
    let solve = |shift: f64, modes: usize, block: usize, tolerance: f64| -> Result<Spectrum, LinalgError> {
        let factor = Cholesky::new(&stiffness.plus_scaled(shift, mass), ordering)?;
        let inverse = |load: &DMatrix<f64>| factor.solve(load);
        let options = LanczosOptions { modes: modes.min(n), block: block.min(n), tolerance, beyond: 0, interrupt };
        let mut spectrum = lowest_modes(mass, &inverse, options)?;
        spectrum.eigenvalues.iter_mut().for_each(|l| *l -= shift);
        Ok(spectrum)
    };
    let mut shift = 1e-7 * largest;
    for _ in 0..PASSES {
        let values = match solve(shift, SCOUTS + rigid, BLOCK, 1e-4) {
            Err(LinalgError::NotPositiveDefinite { .. }) if shift < 1e-7 * largest => {
                shift *= 10.0;
                break;
            }
            values => values?.eigenvalues,
        };
        let Some(&first) = values.get(rigid) else { break };
        if first > SEEN * shift && (0.05..=20.0).contains(&(shift / first)) {
            break;
        }
        let next = if first > SEEN * shift { first } else { SEEN * shift };
        let next = next.max(LEAST_SHIFT * largest);
        if next == shift {
            break;
        }
        shift = next;
    }
    let (mut block, mut spare) = (BLOCK, SPARE);
    loop {
        let Spectrum { eigenvalues, shapes, residual, .. } = solve(shift, wanted + spare, block, 1e-9)?;
        // Rigid motions are zero but for rounding, and count as one cluster.
        let zero = eigenvalues.iter().take(rigid).fold(1e-9 * shift, |m: f64, l| m.max(l.abs()));
        let rigid = rigid.min(eigenvalues.len());
        let found = FreeSpectrum { eigenvalues, shapes, rigid, residual, counted: 0, counted_below: 0.0 };
        let all = found.eigenvalues.len() < (wanted + spare).min(n);
        match count(found, stiffness, mass, ordering, wanted, Cut { zero, all }) {
            // A block sees no more members of a multiple root than it has vectors, and behind the root
            // there must be another for a gap.
            Err(LinalgError::ModesMissed { .. }) if block < WIDEST.min(2 * n) => {
                (block, spare) = (2 * block, 2 * spare)
            }
            counted => return counted,
        }
    }
}

/// How modes are cut off.
struct Cut {
    /// Eigenvalues below this are rigid motions.
    zero: f64,
    /// Whether there are no more modes: of a body with motions without inertia fewer than unknowns.
    all: bool,
}

/// Cuts the spare modes off and counts those below the widest gap behind the wanted ones.
fn count(
    mut found: FreeSpectrum,
    stiffness: &SparseSymmetric,
    mass: &SparseSymmetric,
    ordering: &Ordering,
    wanted: usize,
    Cut { zero, all }: Cut,
) -> Result<FreeSpectrum, LinalgError> {
    let values = &found.eigenvalues;
    let last = values.len();
    let gap = |k: usize| (values[k] - values[k - 1]) / values[k].abs().max(values[k - 1].abs()).max(zero);
    let widest = (wanted..last).max_by(|&a, &b| gap(a).total_cmp(&gap(b)));
    let all = all || last == stiffness.n();
    // Of a body with fewer modes than asked for there may be nothing behind the last.
    let cut = widest.filter(|&k| !all || gap(k) > DISTINCT).unwrap_or(last);
    let sigma = if cut < last { 0.5 * (values[cut - 1] + values[cut]) } else { 2.0 * values[last - 1].abs() };
    let counted = Indefinite::new(&stiffness.plus_scaled(-sigma, mass), ordering)?.negative_eigenvalues();
    // Massless combinations have no finite frequency: a body with few unknowns may have fewer modes.
    if counted != cut {
        return Err(LinalgError::ModesMissed { found: cut, counted, frequency_hz: sigma.max(0.0).sqrt() / TAU });
    }
    (found.counted, found.counted_below) = (counted, sigma);
    let kept = wanted.min(last);
    found.eigenvalues.truncate(kept);
    found.rigid = found.rigid.min(kept);
    found.shapes = found.shapes.columns(0, kept).into_owned();
    Ok(found)
}
