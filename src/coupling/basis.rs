//! The fixed basis of the machine: one for all positions and all joint stiffnesses.
//!
//! An eigenvector of the coupled machine obeys (Lambda - omega^2) x = -B^T f, so in the coordinates
//! above the kept band x = (Lambda^-1 + omega^2 Lambda^-2 + ..) B^T f. The basis keeps every
//! coordinate in the band; above it, the static term is carried exactly, at every position, by a
//! residual flexibility in series with the joints, and the inertia of the responses by a few
//! directions: the span of Lambda^-1 b and Lambda^-2 b of every spring and port over the travel, cut
//! by a singular value decomposition in the mass norm (what is cut has no inertia to speak of).

use super::CouplingError;
use super::side_by_side::SideBySide;
use crate::linalg::{LinalgError, multiply, multiply_transposed, orthonormal_span, symmetric_eigen, triangle};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// How much the fixed basis keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasisOptions {
    /// Results are wanted up to this frequency, Hz.
    pub frequency: f64,
    /// Component coordinates up to this frequency are kept, Hz.
    pub band: f64,
    /// Inertia of a static response that may be cut at `frequency`, as a share of the joint's own
    /// flexibility; the square root of it.
    pub tolerance: f64,
    /// Designs may stiffen a joint up to this factor without a new basis.
    pub stiffest: f64,
}

impl BasisOptions {
    /// For results up to a frequency (Hz).
    ///
    /// On the bundled mill, 900 Hz: 272 coordinates and 1e-6 of the first 30 frequencies against the
    /// superelements side by side, over the travel.
    pub fn up_to(frequency: f64) -> Self {
        Self { frequency, band: 2.0 * frequency, tolerance: 1.5e-3, stiffest: 4.0 }
    }
}

/// Training positions lie at most this share of the shortest footprint apart.
const SPACING: f64 = 0.28;

/// Coordinates kept as they are, and directions in the others.
#[derive(Clone, Debug)]
pub(super) struct FixedBasis {
    /// Side-by-side coordinates in the band.
    pub low: Vec<usize>,
    /// The other side-by-side coordinates.
    pub high: Vec<usize>,
    /// Eigenvalues of the high coordinates, (rad/s)^2.
    pub high_eigenvalues: Vec<f64>,
    /// Orthonormal directions in the high coordinates that also diagonalise their stiffness, n_high x n_u.
    pub directions: DMatrix<f64>,
    /// Eigenvalues of all kept coordinates, low ones first, (rad/s)^2.
    pub eigenvalues: DVector<f64>,
}

/// A part's strain energy in the residual response to spring forces.
#[derive(Clone, Debug)]
pub struct ResidualEnergy {
    /// Between basis coordinates and forces, n x n_springs.
    pub with_basis: DMatrix<f64>,
    /// Between forces, n_springs x n_springs, m/N.
    pub between_forces: DMatrix<f64>,
}

impl ResidualEnergy {
    /// Twice the part's strain energy as a form in columns of motions over the basis and of loads on the rows; `stiffness`
    /// is the part's in the basis.
    pub fn strain_energy(&self, stiffness: &DMatrix<f64>, motion: &DMatrix<f64>, loads: &DMatrix<f64>) -> DMatrix<f64> {
        let crossed = multiply_transposed(motion, &multiply(&self.with_basis, loads));
        let form = multiply_transposed(motion, &multiply(stiffness, motion))
            + &crossed
            + crossed.transpose()
            + multiply_transposed(loads, &multiply(&self.between_forces, loads));
        0.5 * (&form + form.transpose())
    }
}

impl FixedBasis {
    /// Forms the basis of a machine.
    pub fn new(machine: &SideBySide, options: BasisOptions) -> Result<Self, CouplingError> {
        let n = machine.n();
        let edge = (TAU * options.band).powi(2);
        let (low, high): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| machine.eigenvalues[i] <= edge);
        let high_eigenvalues: Vec<f64> = high.iter().map(|&i| machine.eigenvalues[i]).collect();
        let mut basis =
            Self { low, high, high_eigenvalues, directions: DMatrix::zeros(0, 0), eigenvalues: DVector::zeros(0) };
        let responses = basis.training_responses(machine, (TAU * options.frequency).powi(2), options.stiffest)?;
        let span = orthonormal_span(&responses, options.tolerance)?;
        let (directions, values) = stiffness_axes(&span, &basis.high_eigenvalues)?;
        basis.directions = directions;
        let kept = basis.low.iter().map(|&i| machine.eigenvalues[i]).chain(values.iter().copied());
        basis.eigenvalues = DVector::from_vec(kept.collect());
        Ok(basis)
    }

    /// Columns omega Lambda^-1 b and omega^3 Lambda^-2 b, relative to each spring's own flexibility
    /// in series with that of the high coordinates.
    fn training_responses(
        &self,
        machine: &SideBySide,
        omega_squared: f64,
        stiffest: f64,
    ) -> Result<DMatrix<f64>, CouplingError> {
        let lambda = &self.high_eigenvalues;
        let mut columns: Vec<DVector<f64>> = Vec::new();
        let mut push = |row: &[f64], flexibility: f64| {
            columns.extend(inertia_columns(row, lambda, flexibility, omega_squared).into_iter().flatten());
        };
        for port in machine.outputs.iter().chain(&machine.inputs) {
            push(&self.high.iter().map(|&i| port.row[i]).collect::<Vec<_>>(), 0.0);
        }
        let positions = training_positions(machine);
        let rows = positions.iter().map(|&p| machine.rows(p)).collect::<Result<Vec<_>, _>>()?;
        let stiffness = positions.iter().map(|&p| machine.stiffness(p)).collect::<Result<Vec<_>, _>>()?;
        for s in 0..rows[0].nrows() {
            let stiffest = stiffest * stiffness.iter().map(|k| k[s]).fold(0.0, f64::max);
            let flexibility = if stiffest > 0.0 { 1.0 / stiffest } else { 0.0 };
            let mut previous: Option<Vec<f64>> = None;
            for rows in &rows {
                let row: Vec<f64> = self.high.iter().map(|&i| rows[(s, i)]).collect();
                // A spring whose row does not change with the position is trained once.
                if previous.as_ref() != Some(&row) {
                    push(&row, flexibility);
                    previous = Some(row);
                }
            }
        }
        Ok(if columns.is_empty() { DMatrix::zeros(self.high.len(), 0) } else { DMatrix::from_columns(&columns) })
    }

    /// Coordinates.
    pub fn n(&self) -> usize {
        self.eigenvalues.len()
    }

    /// Rows over the side-by-side coordinates as rows over the basis.
    pub fn project(&self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        let low = DMatrix::from_fn(rows.nrows(), self.low.len(), |s, k| rows[(s, self.low[k])]);
        let high = multiply(&self.high_of(rows), &self.directions);
        let mut out = low.resize_horizontally(self.n(), 0.0);
        out.columns_mut(self.low.len(), high.ncols()).copy_from(&high);
        out
    }

    /// A factor T of the static flexibility of rows that the basis leaves out, T^T T =
    /// R_h (Lambda_h^-1 - U (U^T Lambda_h U)^-1 U^T) R_h^T.
    ///
    /// With V = Lambda_h^1/2 U Lambda_U^-1/2, which is orthonormal, it is that of (I - V V^T) Lambda_h^-1/2 R_h^T:
    /// a sum of squares, so no digits cancel.
    pub fn residual_factor(&self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        let mut high = self.high_of(rows).transpose();
        let mut kept = self.directions.clone();
        for (mut column, l) in kept.column_iter_mut().zip(self.eigenvalues.iter().skip(self.low.len())) {
            column /= l.sqrt();
        }
        for ((mut row, mut kept), l) in high.row_iter_mut().zip(kept.row_iter_mut()).zip(&self.high_eigenvalues) {
            row /= l.sqrt();
            kept *= l.sqrt();
        }
        high -= multiply(&kept, &multiply_transposed(&kept, &high));
        triangle(&high)
    }

    /// The static response to unit forces on rows that the basis leaves out, over the high coordinates:
    /// X = (Lambda_h^-1 - U (U^T Lambda_h U)^-1 U^T) R_h^T, n_high x n_rows.
    pub fn residual_response(&self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        let high = self.high_of(rows);
        let mut kept = multiply(&high, &self.directions);
        for (mut column, l) in kept.column_iter_mut().zip(self.eigenvalues.iter().skip(self.low.len())) {
            column /= *l;
        }
        let mut response = high.transpose();
        for (mut row, l) in response.row_iter_mut().zip(&self.high_eigenvalues) {
            row /= *l;
        }
        response - multiply(&self.directions, &kept.transpose())
    }

    /// Strain energy of one part in the residual response to forces on rows.
    ///
    /// With X of [`Self::residual_response`] and Lambda_p the part's share of
    /// Lambda_h: U^T Lambda_p X between the basis and the forces, and X^T Lambda_p X between forces.
    /// Over all parts the first adds up to zero and the second to the residual flexibility.
    pub fn residual_energy(&self, rows: &DMatrix<f64>, part: impl Fn(usize) -> bool) -> ResidualEnergy {
        let response = self.residual_response(rows);
        let mut weighted = response.clone();
        for (k, (mut row, l)) in weighted.row_iter_mut().zip(&self.high_eigenvalues).enumerate() {
            row *= if part(self.high[k]) { *l } else { 0.0 };
        }
        let mut with_basis = DMatrix::zeros(self.n(), rows.nrows());
        with_basis
            .rows_mut(self.low.len(), self.directions.ncols())
            .copy_from(&multiply_transposed(&self.directions, &weighted));
        ResidualEnergy { with_basis, between_forces: multiply_transposed(&response, &weighted) }
    }

    /// Shapes over the basis as shapes over the side-by-side coordinates.
    pub fn over_parts(&self, shapes: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(self.low.len() + self.high.len(), shapes.ncols());
        for (k, &i) in self.low.iter().enumerate() {
            out.row_mut(i).copy_from(&shapes.row(k));
        }
        let high = multiply(&self.directions, &shapes.rows_range(self.low.len()..).into_owned());
        for (k, &i) in self.high.iter().enumerate() {
            out.row_mut(i).copy_from(&high.row(k));
        }
        out
    }

    /// The basis as a matrix over the side-by-side coordinates, n_side_by_side x n.
    pub fn matrix(&self) -> DMatrix<f64> {
        let mut q = DMatrix::zeros(self.low.len() + self.high.len(), self.n());
        for (k, &i) in self.low.iter().enumerate() {
            q[(i, k)] = 1.0;
        }
        for (h, &i) in self.high.iter().enumerate() {
            for u in 0..self.directions.ncols() {
                q[(i, self.low.len() + u)] = self.directions[(h, u)];
            }
        }
        q
    }

    fn high_of(&self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(rows.nrows(), self.high.len(), |s, k| rows[(s, self.high[k])])
    }
}

/// Columns omega^3 Lambda^-2 b and omega Lambda^-1 b of a row over coordinates with eigenvalues lambda, relative to
/// the root of a flexibility in series with the row's own; none if both are zero.
pub(super) fn inertia_columns(
    row: &[f64],
    lambda: &[f64],
    flexibility: f64,
    omega_squared: f64,
) -> Option<[DVector<f64>; 2]> {
    let unit = (row.iter().zip(lambda).map(|(b, l)| b * b / l).sum::<f64>() + flexibility).sqrt();
    (unit > 0.0).then(|| {
        let scale = omega_squared.sqrt() / unit;
        let first = DVector::from_iterator(row.len(), row.iter().zip(lambda).map(|(b, l)| scale * b / l));
        let second = first.iter().zip(lambda).map(|(v, l)| v * omega_squared / l);
        [DVector::from_iterator(row.len(), second), first]
    })
}

/// The orthonormal directions of a span that diagonalise diag(lambda), and their eigenvalues.
pub(super) fn stiffness_axes(span: &DMatrix<f64>, lambda: &[f64]) -> Result<(DMatrix<f64>, DVector<f64>), LinalgError> {
    let mut weighted = span.clone();
    for (mut row, l) in weighted.row_iter_mut().zip(lambda) {
        row *= *l;
    }
    let stiffness = multiply_transposed(span, &weighted);
    let eigen = symmetric_eigen(&(0.5 * (&stiffness + stiffness.transpose())))?;
    Ok((multiply(span, &eigen.vectors), eigen.values))
}

/// Positions over the whole travel, at most a fraction of a footprint apart, or of the rail's elements where these are
/// longer: see `coupling/training.rs`.
fn training_positions(machine: &SideBySide) -> Vec<f64> {
    let [from, to] = machine.axis.travel;
    let shortest = machine.joints.iter().filter_map(|j| j.told_apart(&machine.axis)).fold(f64::INFINITY, f64::min);
    let intervals =
        if shortest.is_finite() { ((to - from).abs() / (SPACING * shortest)).ceil().max(1.0) as usize } else { 1 };
    (0..=intervals).map(|i| from + (to - from) * i as f64 / intervals as f64).collect()
}
