//! Rayleigh-Ritz in the span of blocks of vectors.

use super::ReductionError;
use crate::linalg::{LinalgError, independent_directions, multiply, multiply_transposed, symmetric_eigen};
use crate::solid::SecondOrder;
use nalgebra::DMatrix;

/// Directions of a block whose squared mass norm falls below this share of the largest, after what
/// earlier blocks already span has been taken out and each vector scaled to unit length, are dropped.
const INDEPENDENT: f64 = 1e-10;

/// A vector of which less than this is left once earlier blocks are taken out is rounding.
const ROUNDING: f64 = 1e-10;

/// Squared mass norms of columns.
fn squares(system: &SecondOrder, block: &DMatrix<f64>) -> Vec<f64> {
    let mass_block = system.mass.multiply(block);
    (0..block.ncols()).map(|k| block.column(k).dot(&mass_block.column(k))).collect()
}

/// Ritz values (rad/s)^2, ascending, and mass-orthonormal Ritz vectors of the span of rigid motions
/// and blocks. The rigid motions come first with exactly zero.
pub(super) fn rayleigh_ritz(
    part: &str,
    system: &SecondOrder,
    rigid: &DMatrix<f64>,
    blocks: Vec<DMatrix<f64>>,
) -> Result<(Vec<f64>, DMatrix<f64>), ReductionError> {
    let failed = |source: LinalgError| ReductionError::Linalg { part: part.to_string(), source };
    let mut basis: Vec<(DMatrix<f64>, DMatrix<f64>)> = vec![(rigid.clone(), system.mass.multiply(rigid))];
    for mut block in blocks {
        let whole = squares(system, &block);
        for pass in 0..2 {
            for (v, mv) in &basis {
                if v.ncols() > 0 {
                    block -= multiply(v, &multiply_transposed(mv, &block));
                }
            }
            // What earlier blocks span but for rounding would be scaled up to directions of its own.
            for (k, left) in squares(system, &block).into_iter().enumerate().filter(|_| pass == 0) {
                if left < ROUNDING * ROUNDING * whole[k] {
                    block.column_mut(k).fill(0.0);
                }
            }
            let gram = multiply_transposed(&block, &system.mass.multiply(&block));
            block = multiply(&block, &independent_directions(&gram, INDEPENDENT).map_err(failed)?);
        }
        let mass_block = system.mass.multiply(&block);
        basis.push((block, mass_block));
    }
    let elastic: Vec<&DMatrix<f64>> = basis[1..].iter().map(|(v, _)| v).collect();
    let columns: usize = elastic.iter().map(|v| v.ncols()).sum();
    let n = system.n_dof();
    let mut v = DMatrix::zeros(n, columns);
    let mut at = 0;
    for block in elastic {
        v.columns_mut(at, block.ncols()).copy_from(block);
        at += block.ncols();
    }
    drop(basis);
    let stiffness = multiply_transposed(&v, &system.stiffness.multiply(&v));
    let eigen = symmetric_eigen(&(0.5 * (&stiffness + stiffness.transpose()))).map_err(failed)?;
    if let Some(&eigenvalue) = eigen.values.iter().find(|l| **l <= 0.0) {
        return Err(ReductionError::Indefinite { part: part.to_string(), eigenvalue });
    }
    let mut vectors = rigid.clone().resize_horizontally(rigid.ncols() + columns, 0.0);
    vectors.columns_mut(rigid.ncols(), columns).copy_from(&multiply(&v, &eigen.vectors));
    let eigenvalues = std::iter::repeat_n(0.0, rigid.ncols()).chain(eigen.values.iter().copied()).collect();
    Ok((eigenvalues, vectors))
}
