//! How far the reduction of the parts puts the coupled frequencies off.
//!
//! The fixed basis is compared with the superelements elsewhere; this is about the superelements themselves,
//! which lack the parts' own motions above their last component mode. [`Beyond`](crate::reduction::Beyond) holds
//! some of those motions, Z. With the coupled modes x_r over the superelements' coordinates and
//! g_r = Z^T (K - lambda_r M) V x_r,
//!
//! ```text
//! lambda_r is too high by   sum_z g_rz^2 / (Lambda_z - lambda_r)
//! ```
//!
//! where Lambda_z lies far above; the motions near and below lambda_r are solved together with the modes, so
//! that a mode which the reduction does not have at all is seen too. Frequencies are compared by rank.
//!
//! # Source
//! As of `reduction/beyond.rs`; the sum is second-order perturbation (Parlett, 11).

use super::{ModalError, Modes};
use crate::coupling::CoupledModel;
use crate::linalg::{
    LinalgError, independent_directions, multiply, multiply_transposed, symmetric_eigen, symmetric_eigen_fast,
};
use crate::reduction::Superelement;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// The estimate at one position.
#[derive(Clone, Debug, PartialEq)]
pub struct ReductionEstimate {
    /// Position, m.
    pub position: f64,
    /// By how much each elastic mode's frequency is too high, relative to itself, by rank.
    pub frequencies: Vec<f64>,
    /// The motions that say most, for the map.
    pub motions: Vec<MissingMotion>,
}

/// A motion of a part that the reduction lacks, over the elastic modes.
#[derive(Clone, Debug, PartialEq)]
pub struct MissingMotion {
    /// Lambda_z, (rad/s)^2.
    pub eigenvalue: f64,
    /// z^T K V x_r of each mode.
    pub stiffness: DVector<f64>,
    /// z^T M V x_r of each mode.
    pub mass: DVector<f64>,
}

impl MissingMotion {
    /// g_r = z^T (K - lambda M) V x_r.
    fn coupling(&self, r: usize, lambda: f64) -> f64 {
        self.stiffness[r] - lambda * self.mass[r]
    }

    /// The largest share of a mode's eigenvalue that the motion takes, as if it lay far above.
    fn weight(&self, lambda: &[f64]) -> f64 {
        let share = |(r, l): (usize, &f64)| self.coupling(r, *l).powi(2) / (l * self.eigenvalue);
        lambda.iter().enumerate().map(share).fold(0.0, f64::max)
    }
}

/// Motions that are kept for the map.
const KEPT: usize = 64;

/// Motions below this multiple of the highest frequency wanted are solved with the modes, the others are summed.
const NEAR: f64 = 2.0;
/// Modes up to this multiple of the highest frequency wanted take part.
const MODES: f64 = 1.5;
/// The motions beyond are some of those that lack, and not converged: what they show is multiplied by this. On the
/// bundled mill the estimate is then 1.3 to 2.3 times the true error of the superelements.
pub const SAFETY: f64 = 2.0;
/// The dense eigenproblem up to this order is solved with full accuracy for its lowest modes.
const SMALL: usize = 200;
/// Directions below this share of the strongest are left out where motions and modes depend on each other.
const DEPENDENT: f64 = 1e-10;

/// The estimate for the `wanted` lowest elastic modes at a position.
///
/// # Errors
/// [`ModalError`] of the position or of the small eigenproblem.
pub fn reduction_estimate(
    model: &CoupledModel,
    superelements: &[Superelement],
    modes: &Modes,
    wanted: usize,
) -> Result<ReductionEstimate, ModalError> {
    let position = modes.position;
    let failed = |source: LinalgError| ModalError::Eigen { position, source };
    let elastic = modes.eigenvalues.len() - modes.free;
    let wanted = wanted.min(elastic);
    if wanted == 0 {
        return Ok(ReductionEstimate { position, frequencies: Vec::new(), motions: Vec::new() });
    }
    let highest = modes.frequency(modes.free + wanted - 1);
    let taking_part = modes.count_up_to(MODES * highest).max(modes.free + wanted) - modes.free;
    let lambda: Vec<f64> = modes.eigenvalues[modes.free..modes.free + taking_part].to_vec();
    let shapes = modes.shapes.columns(modes.free, taking_part).into_owned();
    let x = model.whole_shapes(position, &shapes)?;
    let edge = (TAU * NEAR * highest).powi(2);

    // Of every part the motions that it lacks, over the modes.
    let mut motions: Vec<MissingMotion> = Vec::new();
    for (part, first) in superelements.iter().zip(&model.side_by_side.first_column) {
        let own = x.rows(*first, part.n()).into_owned();
        let (k, m) = (multiply(&part.beyond.stiffness, &own), multiply(&part.beyond.mass, &own));
        motions.extend(part.beyond.eigenvalues.iter().enumerate().map(|(z, &eigenvalue)| MissingMotion {
            eigenvalue,
            stiffness: k.row(z).transpose(),
            mass: m.row(z).transpose(),
        }));
    }
    let (near, above): (Vec<&MissingMotion>, Vec<&MissingMotion>) = motions.iter().partition(|z| z.eigenvalue < edge);
    let far = |r: usize| {
        let of = |z: &&MissingMotion| z.coupling(r, lambda[r]).powi(2) / (z.eigenvalue - lambda[r]);
        above.iter().map(of).sum::<f64>()
    };
    let lowered = lowered(&lambda, &near).map_err(failed)?;
    let one = |r: usize| {
        let exact = (lowered[r] - far(r)).max(0.0);
        SAFETY * (1.0 - (exact / lambda[r]).sqrt()).max(0.0)
    };
    let frequencies = (0..wanted).map(one).collect();
    motions.sort_by(|a, b| b.weight(&lambda).total_cmp(&a.weight(&lambda)));
    motions.truncate(KEPT);
    Ok(ReductionEstimate { position, frequencies, motions })
}

/// The lowest eigenvalues of the modes together with the motions near them, as many as there are modes.
fn lowered(lambda: &[f64], near: &[&MissingMotion]) -> Result<Vec<f64>, LinalgError> {
    if near.is_empty() {
        return Ok(lambda.to_vec());
    }
    let (m, n) = (lambda.len(), lambda.len() + near.len());
    let mut stiffness = DMatrix::zeros(n, n);
    let mut mass = DMatrix::identity(n, n);
    for (r, l) in lambda.iter().enumerate() {
        stiffness[(r, r)] = *l;
    }
    for (z, motion) in near.iter().enumerate() {
        stiffness[(m + z, m + z)] = motion.eigenvalue;
        for r in 0..m {
            (stiffness[(m + z, r)], stiffness[(r, m + z)]) = (motion.stiffness[r], motion.stiffness[r]);
            (mass[(m + z, r)], mass[(r, m + z)]) = (motion.mass[r], motion.mass[r]);
        }
    }
    let reduced = match mass.clone().cholesky() {
        Some(root) => {
            let failed = || LinalgError::Eigen { n };
            let half = root.l().solve_lower_triangular(&stiffness).ok_or_else(failed)?.transpose();
            root.l().solve_lower_triangular(&half).ok_or_else(failed)?
        }
        // A motion that the modes span already brings nothing of its own.
        None => {
            let own = independent_directions(&mass, DEPENDENT)?;
            multiply_transposed(&own, &multiply(&stiffness, &own))
        }
    };
    let reduced = 0.5 * (&reduced + reduced.transpose());
    let eigen = if reduced.nrows() <= SMALL { symmetric_eigen(&reduced)? } else { symmetric_eigen_fast(&reduced)? };
    Ok(eigen.values.iter().take(m).copied().collect())
}
