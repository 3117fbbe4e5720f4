//! The fixed basis of the machine: one for all positions and all joint stiffnesses.
//!
//! An eigenvector of the coupled machine obeys (Lambda - omega^2) x = -B^T f, so in the coordinates
//! above the kept band x = (Lambda^-1 + omega^2 Lambda^-2 + ..) B^T f. The basis keeps every
//! coordinate in the band and, above it, the span of Lambda^-1 b and omega_b^2 Lambda^-2 b of every
//! spring and port at training positions, cut by a singular value decomposition in the energy norm.

use super::CouplingError;
use super::model::SideBySide;
use crate::linalg::{multiply, multiply_transposed, orthonormal_span, symmetric_eigen, independent_directions};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// How much the fixed basis keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasisOptions {
    /// Component coordinates up to this frequency are kept, Hz.
    pub band: f64,
    /// Singular values (of unit static responses in the energy norm) below this are cut.
    pub tolerance: f64,
    /// Directions above this frequency are cut, Hz: the dense eigensolver's absolute error grows with the largest eigenvalue.
    pub highest: f64,
}

impl BasisOptions {
    /// For frequencies up to `band` (Hz).
    pub fn for_band(band: f64) -> Self {
        Self { band: 3.0 * band, tolerance: 1e-4, highest: 1e5 }
    }
}

/// Designs may stiffen a joint up to this factor without a new basis.
const STIFFEST: f64 = 4.0;

/// Training positions lie at most this share of the shortest footprint apart.
const SPACING: f64 = 0.28;

/// Eigenvalues in the basis, (rad/s)^2, and the basis over the side-by-side coordinates, orthonormal.
pub(super) fn fixed_basis(machine: &SideBySide, options: BasisOptions) -> Result<(DVector<f64>, DMatrix<f64>), CouplingError> {
    let n = machine.n();
    let edge = (TAU * options.band).powi(2);
    let low: Vec<usize> = (0..n).filter(|&i| machine.eigenvalues[i] <= edge).collect();
    let high: Vec<usize> = (0..n).filter(|&i| machine.eigenvalues[i] > edge).collect();
    let lambda: Vec<f64> = high.iter().map(|&i| machine.eigenvalues[i]).collect();
    // The frequency at which second moments are weighed: a third of the kept band, where results are wanted.
    let omega_squared = edge / 9.0;

    let mut columns: Vec<DVector<f64>> = Vec::new();
    // A spring in series with the flexibility c = b^T Lambda^-1 b of what is cut: its share c / (c + 1/k)
    // says how much the cut matters, at the stiffest k that a design may have.
    let mut push = |row: Vec<f64>, flexibility: f64| {
        let unit = (row.iter().zip(&lambda).map(|(b, l)| b * b / l).sum::<f64>() + flexibility).sqrt();
        if unit > 0.0 {
            let first = DVector::from_iterator(row.len(), row.iter().zip(&lambda).map(|(b, l)| b / (unit * l.sqrt())));
            let second = DVector::from_iterator(row.len(), first.iter().zip(&lambda).map(|(v, l)| v * omega_squared / l));
            columns.push(first);
            columns.push(second);
        }
    };
    let select = |rows: &DMatrix<f64>, s: usize| -> Vec<f64> { high.iter().map(|&i| rows[(s, i)]).collect() };
    for port in machine.outputs.iter().chain(&machine.inputs) {
        push(high.iter().map(|&i| port.row[i]).collect(), 0.0);
    }
    let positions = training_positions(machine);
    let rows = positions.iter().map(|&p| machine.rows(p)).collect::<Result<Vec<_>, _>>()?;
    let stiffness = positions.iter().map(|&p| machine.stiffness(p)).collect::<Result<Vec<_>, _>>()?;
    for s in 0..rows[0].nrows() {
        let stiffest = STIFFEST * stiffness.iter().map(|k| k[s]).fold(0.0, f64::max);
        let flexibility = if stiffest > 0.0 { 1.0 / stiffest } else { 0.0 };
        let mut previous: Option<Vec<f64>> = None;
        for rows in &rows {
            let row = select(rows, s);
            // A spring whose row does not change with the position is trained once.
            if previous.as_ref() != Some(&row) {
                push(row.clone(), flexibility);
                previous = Some(row);
            }
        }
    }
    let energy_span = orthonormal_span(&DMatrix::from_columns(&columns), options.tolerance)?;
    // Back from the energy norm: x = Lambda^-1/2 y, then orthonormal in the mass norm.
    let mut vectors = energy_span;
    for (mut row, l) in vectors.row_iter_mut().zip(&lambda) {
        row /= l.sqrt();
    }
    let vectors = multiply(&vectors, &independent_directions(&multiply_transposed(&vectors, &vectors), 1e-14)?);
    let mut weighted = vectors.clone();
    for (mut row, l) in weighted.row_iter_mut().zip(&lambda) {
        row *= *l;
    }
    let stiffness = multiply_transposed(&vectors, &weighted);
    let eigen = symmetric_eigen(&(0.5 * (&stiffness + stiffness.transpose())))?;
    let limit = (TAU * options.highest).powi(2);
    let kept = eigen.values.iter().take_while(|l| **l <= limit).count();
    let vectors = multiply(&vectors, &eigen.vectors.columns(0, kept).into_owned());

    let mut basis = DMatrix::zeros(n, low.len() + kept);
    for (k, &i) in low.iter().enumerate() {
        basis[(i, k)] = 1.0;
    }
    for (row, &i) in high.iter().enumerate() {
        for k in 0..kept {
            basis[(i, low.len() + k)] = vectors[(row, k)];
        }
    }
    let mut order: Vec<(f64, usize)> = low.iter().map(|&i| machine.eigenvalues[i]).chain(eigen.values.iter().take(kept).copied()).zip(0..).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let values = DVector::from_iterator(order.len(), order.iter().map(|(l, _)| *l));
    let basis = DMatrix::from_fn(n, order.len(), |i, k| basis[(i, order[k].1)]);
    Ok((values, basis))
}

/// Positions over the whole travel, at most a fraction of a footprint apart.
fn training_positions(machine: &SideBySide) -> Vec<f64> {
    let [from, to] = machine.axis.travel;
    let shortest = machine.joints.iter().filter_map(|j| j.footprint).fold(f64::INFINITY, f64::min);
    let intervals = if shortest.is_finite() { ((to - from).abs() / (SPACING * shortest)).ceil().max(1.0) as usize } else { 1 };
    (0..=intervals).map(|i| from + (to - from) * i as f64 / intervals as f64).collect()
}
