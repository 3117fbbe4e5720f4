//! Block Lanczos for the lowest modes of K phi = omega^2 M phi.
//!
//! Works with the inverse operator x -> K^-1 M x, which its caller supplies: constraints are met and
//! rigid modes are projected out there, so the iteration sees only 1 / omega^2 > 0. Full
//! orthogonalisation in the mass inner product keeps double roots apart; a block finds the members
//! of a multiple root together. The iteration stops on residuals that are computed explicitly from
//! the Ritz vectors, not on the recurrence's estimate, and a Rayleigh-Ritz step on the iterated
//! vectors polishes them.
//!
//! # Source
//! R. G. Grimes, J. G. Lewis, H. D. Simon, A shifted block Lanczos algorithm, SIAM J. Matrix Anal. 15 (1994).

use super::dense::Columns;
use super::{
    LinalgError, SparseSymmetric, go_on, independent_directions, multiply, multiply_transposed, symmetric_eigen,
};
use crate::interrupt::Interrupt;
use nalgebra::DMatrix;

/// What to find and how well.
#[derive(Clone, Copy, Debug)]
pub struct LanczosOptions<'a> {
    /// Modes to find.
    pub modes: usize,
    /// Vectors a step; at least the largest multiplicity expected.
    pub block: usize,
    /// Largest |K^-1 M x - x / omega^2| omega^2 in the mass norm.
    pub tolerance: f64,
    /// Vectors of the iteration's space beyond the wanted modes to hand out, at most.
    pub beyond: usize,
    /// Asked at every step whether to stop.
    pub interrupt: Option<&'a Interrupt>,
}

/// The lowest modes.
#[derive(Clone, Debug)]
pub struct Spectrum {
    /// omega_r^2, (rad/s)^2, ascending.
    pub eigenvalues: Vec<f64>,
    /// Mass-normalised shapes, n x n_modes.
    pub shapes: DMatrix<f64>,
    /// Largest explicit residual, relative.
    pub residual: f64,
    /// Ritz vectors of the iteration's space beyond the modes, mass-orthonormal, n x n_beyond: not converged, but
    /// they show what lies above the last mode and cost no further step.
    pub beyond: DMatrix<f64>,
}

/// Eigenvalues further than this above the lowest are those of motions without inertia.
const FINITE: f64 = 1e12;

/// The lowest modes, as many as asked for or as there are.
///
/// `inverse` maps an n x b block of loads M X to K^-1 M X.
///
/// # Errors
/// [`LinalgError::NotConverged`] when the subspace has grown past 6 times the modes plus 20 blocks.
pub fn lowest_modes(
    mass: &SparseSymmetric,
    inverse: &dyn Fn(&DMatrix<f64>) -> DMatrix<f64>,
    options: LanczosOptions<'_>,
) -> Result<Spectrum, LinalgError> {
    let LanczosOptions { modes, block, tolerance, beyond, interrupt } = options;
    assert!(modes > 0 && block > 0, "at least one mode and one vector a step");
    let largest_dimension = 6 * modes + 20 * block;
    let mut krylov = Krylov::new(mass.n());
    // One application moves the start into the operator's range.
    krylov.append(inverse(&mass.multiply(&pseudo_random(mass.n(), block))), mass)?;
    let mut worst = f64::INFINITY;
    loop {
        go_on(interrupt)?;
        let exhausted = !krylov.advance(mass, inverse)?;
        let dimension = krylov.dimension();
        let wanted = modes.min(dimension);
        if dimension < modes + block && !exhausted {
            continue;
        }
        let ritz = symmetric_eigen(&krylov.projected)?;
        // Where the space is used up, the last vectors are motions without inertia, at rounding's distance from zero.
        let inertia = ritz.values.max() / FINITE;
        let wanted = wanted.min(ritz.values.iter().filter(|theta| **theta > inertia).count());
        let best: Vec<usize> = (0..dimension).rev().take(wanted).collect();
        let vectors = DMatrix::from_fn(dimension, wanted, |i, k| ritz.vectors[(i, best[k])]);
        let theta: Vec<f64> = best.iter().map(|&k| ritz.values[k]).collect();
        let estimate = krylov.estimate(&vectors, &theta);
        if exhausted || estimate < tolerance {
            let (x, y) = krylov.ritz_vectors(&vectors, inverse, mass);
            worst = explicit_residual(&x, &y, &theta, mass);
            if exhausted || worst < tolerance {
                let next: Vec<usize> = (0..dimension).rev().skip(wanted).take(beyond).collect();
                let next = DMatrix::from_fn(dimension, next.len(), |i, k| ritz.vectors[(i, next[k])]);
                return polish(&x, &y, mass, worst, krylov.basis.times(&next));
            }
        }
        if dimension > largest_dimension {
            let converged = theta.len().min(krylov.converged(&vectors, &theta, tolerance));
            return Err(LinalgError::NotConverged {
                wanted: modes,
                converged,
                dimension,
                residual: worst.min(estimate),
                tolerance,
            });
        }
    }
}

/// The growing basis, orthonormal in the mass inner product, and the operator projected onto it.
struct Krylov {
    basis: Columns,
    mass_basis: Columns,
    projected: DMatrix<f64>,
    /// Gram matrix of the part of the operator's last image that lies outside the basis.
    remainder: DMatrix<f64>,
    /// M times the newest block, to which the operator has not been applied yet.
    pending: Option<DMatrix<f64>>,
}

impl Krylov {
    fn new(n: usize) -> Self {
        Self {
            basis: Columns::new(n),
            mass_basis: Columns::new(n),
            projected: DMatrix::zeros(0, 0),
            remainder: DMatrix::zeros(0, 0),
            pending: None,
        }
    }

    /// Vectors for which the operator has been applied.
    fn dimension(&self) -> usize {
        self.projected.nrows()
    }

    /// Makes a block orthonormal against the basis and itself and appends it; false if nothing is left of it.
    fn append(&mut self, block: DMatrix<f64>, mass: &SparseSymmetric) -> Result<bool, LinalgError> {
        let mut mass_block = mass.multiply(&block);
        let mut block = block;
        for _ in 0..2 {
            if self.basis.count() > 0 {
                let part = self.mass_basis.transposed_times(&block);
                self.basis.subtract_from(&mut block, &part);
                self.mass_basis.subtract_from(&mut mass_block, &part);
            }
            let combine = independent_directions(&multiply_transposed(&block, &mass_block), 1e-12)?;
            block = multiply(&block, &combine);
            mass_block = multiply(&mass_block, &combine);
            if block.ncols() == 0 {
                return Ok(false);
            }
        }
        self.basis.push(&block);
        self.mass_basis.push(&mass_block);
        self.pending = Some(mass_block);
        Ok(true)
    }

    /// Applies the operator to the newest block, extends the projection, appends what is new;
    /// false when the space is exhausted.
    fn advance(
        &mut self,
        mass: &SparseSymmetric,
        inverse: &dyn Fn(&DMatrix<f64>) -> DMatrix<f64>,
    ) -> Result<bool, LinalgError> {
        let Some(load) = self.pending.take() else { return Ok(false) };
        let mut image = inverse(&load);
        let (old, added) = (self.dimension(), load.ncols());
        let mut column = DMatrix::zeros(old + added, added);
        for _ in 0..2 {
            let part = self.mass_basis.transposed_times(&image);
            self.basis.subtract_from(&mut image, &part);
            column += part;
        }
        let mut grown = DMatrix::zeros(old + added, old + added);
        grown.view_mut((0, 0), (old, old)).copy_from(&self.projected);
        grown.view_mut((0, old), (old + added, added)).copy_from(&column);
        grown.view_mut((old, 0), (added, old + added)).copy_from(&column.transpose());
        self.projected = grown;
        self.remainder = multiply_transposed(&image, &mass.multiply(&image));
        if self.remainder.trace().max(0.0).sqrt() <= 1e-13 * column.norm() {
            return Ok(false);
        }
        self.append(image, mass)
    }

    /// The recurrence's estimate of the largest relative residual.
    fn estimate(&self, vectors: &DMatrix<f64>, theta: &[f64]) -> f64 {
        (0..theta.len()).map(|k| self.estimate_one(vectors, theta, k)).fold(0.0, f64::max)
    }

    fn converged(&self, vectors: &DMatrix<f64>, theta: &[f64], tolerance: f64) -> usize {
        (0..theta.len()).filter(|&k| self.estimate_one(vectors, theta, k) < tolerance).count()
    }

    fn estimate_one(&self, vectors: &DMatrix<f64>, theta: &[f64], k: usize) -> f64 {
        let b = self.remainder.nrows();
        let bottom = vectors.view((vectors.nrows() - b, k), (b, 1)).into_owned();
        let square = (bottom.transpose() * &self.remainder * &bottom)[(0, 0)];
        square.max(0.0).sqrt() / theta[k].abs()
    }

    /// Ritz vectors X = V S and their images K^-1 M X, computed afresh.
    fn ritz_vectors(
        &self,
        vectors: &DMatrix<f64>,
        inverse: &dyn Fn(&DMatrix<f64>) -> DMatrix<f64>,
        mass: &SparseSymmetric,
    ) -> (DMatrix<f64>, DMatrix<f64>) {
        let x = self.basis.times(vectors);
        let y = inverse(&mass.multiply(&x));
        (x, y)
    }
}

fn largest_norm(x: &DMatrix<f64>, mass: &SparseSymmetric) -> f64 {
    let mx = mass.multiply(x);
    (0..x.ncols()).map(|k| x.column(k).dot(&mx.column(k)).max(0.0).sqrt()).fold(0.0, f64::max)
}

fn explicit_residual(x: &DMatrix<f64>, y: &DMatrix<f64>, theta: &[f64], mass: &SparseSymmetric) -> f64 {
    let residual = DMatrix::from_fn(x.nrows(), x.ncols(), |i, k| y[(i, k)] / theta[k] - x[(i, k)]);
    largest_norm(&residual, mass)
}

/// Rayleigh-Ritz on Y = K^-1 M X: Y^T K Y = Y^T M X, because K Y = M X up to constraint forces, which
/// do no work on Y.
fn polish(
    x: &DMatrix<f64>,
    y: &DMatrix<f64>,
    mass: &SparseSymmetric,
    residual: f64,
    beyond: DMatrix<f64>,
) -> Result<Spectrum, LinalgError> {
    let gram = multiply_transposed(y, &mass.multiply(y));
    let combine = independent_directions(&gram, 1e-14)?;
    let stiffness = multiply_transposed(y, &mass.multiply(x));
    let stiffness = multiply_transposed(&combine, &multiply(&stiffness, &combine));
    let eigen = symmetric_eigen(&(0.5 * (&stiffness + stiffness.transpose())))?;
    let shapes = multiply(y, &multiply(&combine, &eigen.vectors));
    Ok(Spectrum { eigenvalues: eigen.values.iter().copied().collect(), shapes, residual, beyond })
}

/// A repeatable block of numbers in (-1, 1) (splitmix64).
fn pseudo_random(n: usize, columns: usize) -> DMatrix<f64> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    DMatrix::from_fn(n, columns, |_, _| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    })
}
