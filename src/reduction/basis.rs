//! Rayleigh-Ritz in the span of blocks of vectors.
//!
//! The span is made orthonormal in the stiffness, not in the mass: a motion without inertia (a rotation to
//! which no mass belongs) still has stiffness, so it is kept and answers statically. With K = I the
//! eigenproblem is M z = mu z, omega^2 = 1 / mu; a motion without inertia has mu = 0.

use super::ReductionError;
use crate::linalg::{LinalgError, independent_directions, multiply, multiply_transposed, symmetric_eigen};
use crate::solid::SecondOrder;
use nalgebra::{DMatrix, DVector};

/// Directions of a block whose strain energy falls below this share of the largest, after what earlier blocks
/// already span has been taken out and each vector scaled to unit energy, are dropped.
const INDEPENDENT: f64 = 1e-10;

/// A vector of which less than this is left once earlier blocks are taken out is rounding.
const ROUNDING: f64 = 1e-10;

/// Inertia below this share of the largest is none: the motion is kept as one at this share, 1e7 times the part's
/// lowest frequency, where it answers statically.
const INERTIA: f64 = 1e-14;

/// Ritz values (rad/s)^2, ascending, and mass-orthonormal Ritz vectors of the span of rigid motions
/// and blocks. The rigid motions come first with exactly zero.
pub(super) fn rayleigh_ritz(
    part: &str,
    system: &SecondOrder,
    rigid: &DMatrix<f64>,
    blocks: Vec<DMatrix<f64>>,
) -> Result<(Vec<f64>, DMatrix<f64>), ReductionError> {
    let failed = |source: LinalgError| ReductionError::Linalg { part: part.to_string(), source };
    let mass_rigid = system.mass.multiply(rigid);
    // V and K V, block by block.
    let mut basis: Vec<(DMatrix<f64>, DMatrix<f64>)> = Vec::new();
    for mut block in blocks {
        if rigid.ncols() > 0 {
            let whole = energies(&block, &system.mass.multiply(&block));
            for _ in 0..2 {
                block -= multiply(rigid, &multiply_transposed(&mass_rigid, &block));
            }
            // A rigid motion but for rounding (a unit motion of a part's only interface) strains nothing.
            for (k, left) in energies(&block, &system.mass.multiply(&block)).into_iter().enumerate() {
                if left < ROUNDING * ROUNDING * whole[k] {
                    block.column_mut(k).fill(0.0);
                }
            }
        }
        let whole = energies(&block, &system.stiffness.multiply(&block));
        let mut stiffness_block = DMatrix::zeros(0, 0);
        for pass in 0..2 {
            for (v, kv) in &basis {
                block -= multiply(v, &multiply_transposed(kv, &block));
            }
            if rigid.ncols() > 0 {
                block -= multiply(rigid, &multiply_transposed(&mass_rigid, &block));
            }
            stiffness_block = system.stiffness.multiply(&block);
            // What earlier blocks span but for rounding would be scaled up to directions of its own.
            for (k, left) in energies(&block, &stiffness_block).into_iter().enumerate().filter(|_| pass == 0) {
                if left < ROUNDING * ROUNDING * whole[k] {
                    block.column_mut(k).fill(0.0);
                    stiffness_block.column_mut(k).fill(0.0);
                }
            }
            let gram = multiply_transposed(&block, &stiffness_block);
            let combine = independent_directions(&(0.5 * (&gram + gram.transpose())), INDEPENDENT).map_err(failed)?;
            block = multiply(&block, &combine);
            stiffness_block = multiply(&stiffness_block, &combine);
            if rigid.ncols() > 0 {
                block -= multiply(rigid, &multiply_transposed(&mass_rigid, &block));
            }
        }
        basis.push((block, stiffness_block));
    }
    let v = side_by_side(basis.iter().map(|(v, _)| v));
    let kv = side_by_side(basis.iter().map(|(_, kv)| kv));
    drop(basis);
    // K is the identity here but for rounding, which the factor of what it is takes out.
    let gram = multiply_transposed(&v, &kv);
    let indefinite = |eigenvalue: f64| ReductionError::Indefinite { part: part.to_string(), eigenvalue };
    let root = (0.5 * (&gram + gram.transpose())).cholesky().ok_or_else(|| indefinite(gram.diagonal().min()))?.l();
    let mass = multiply_transposed(&v, &system.mass.multiply(&v));
    let half = root.solve_lower_triangular(&mass).ok_or_else(|| indefinite(0.0))?.transpose();
    let mass = root.solve_lower_triangular(&half).ok_or_else(|| indefinite(0.0))?;
    let eigen = symmetric_eigen(&(0.5 * (&mass + mass.transpose()))).map_err(failed)?;

    let columns = eigen.values.len();
    let least = INERTIA * eigen.values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    if let Some(&negative) = eigen.values.iter().find(|mu| **mu < -1e3 * least) {
        return Err(indefinite(negative.recip()));
    }
    // The largest mu is the lowest mode.
    let inertia = DVector::from_fn(columns, |k, _| eigen.values[columns - 1 - k].max(least));
    let turned = DMatrix::from_fn(columns, columns, |i, k| eigen.vectors[(i, columns - 1 - k)] / inertia[k].sqrt());
    let turned = root.tr_solve_lower_triangular(&turned).ok_or_else(|| indefinite(0.0))?;
    let mut vectors = rigid.clone().resize_horizontally(rigid.ncols() + columns, 0.0);
    vectors.columns_mut(rigid.ncols(), columns).copy_from(&multiply(&v, &turned));
    let eigenvalues = std::iter::repeat_n(0.0, rigid.ncols()).chain(inertia.iter().map(|mu| mu.recip())).collect();
    Ok((eigenvalues, vectors))
}

/// v^T A v of each column of V, from V and A V: twice the strain energy, or the squared mass norm.
fn energies(block: &DMatrix<f64>, product: &DMatrix<f64>) -> Vec<f64> {
    (0..block.ncols()).map(|k| block.column(k).dot(&product.column(k))).collect()
}

pub(super) fn side_by_side<'a>(blocks: impl Iterator<Item = &'a DMatrix<f64>> + Clone) -> DMatrix<f64> {
    let rows = blocks.clone().next().map_or(0, |b| b.nrows());
    let mut out = DMatrix::zeros(rows, blocks.clone().map(|b| b.ncols()).sum());
    let mut at = 0;
    for block in blocks {
        out.columns_mut(at, block.ncols()).copy_from(block);
        at += block.ncols();
    }
    out
}
