//! What a reduction leaves out, for an estimate of its error.
//!
//! The iteration that finds the component modes has more vectors than modes in the end: Ritz vectors Z above the
//! last mode kept. They hold the interfaces still, so no joint reads them, and stand for the motions that the
//! reduction lacks. With V the superelement's basis (M = I, K = Lambda),
//!
//! ```text
//! K = [ Lambda   V^T K Z ]      M = [ I        V^T M Z ]
//!     [ Z^T K V  Lambda_Z]          [ Z^T M V  I       ]
//! ```
//!
//! is the part with more of its own motions in it. How far its coupled frequencies lie below those without Z
//! is the estimate; `modal/estimate.rs` forms it.
//!
//! # Source
//! The residual of a Ritz vector in the norm of the inverse: B. N. Parlett, The Symmetric Eigenvalue Problem
//! (SIAM 1998), 11; for reduced models J.-G. Kim, P.-S. Lee, Int. J. Numer. Methods Eng. 102 (2015), from which
//! it differs in that the vectors above the cut are those of the iteration, not a static residual.

use super::ReductionError;
use crate::linalg::{LinalgError, independent_directions, multiply, multiply_transposed, symmetric_eigen};
use crate::solid::SecondOrder;
use nalgebra::DMatrix;

/// Motions above the component modes kept, coupled with the superelement.
#[derive(Clone, Debug, PartialEq)]
pub struct Beyond {
    /// Lambda_Z, (rad/s)^2, ascending.
    pub eigenvalues: Vec<f64>,
    /// Z^T K V, n_beyond x n.
    pub stiffness: DMatrix<f64>,
    /// Z^T M V, n_beyond x n.
    pub mass: DMatrix<f64>,
}

/// Directions of Z below this share of the strongest are left out.
const INDEPENDENT: f64 = 1e-8;

impl Beyond {
    /// From vectors Z (n_dof x n_beyond) that hold the interfaces still.
    pub(super) fn new(
        part: &str,
        system: &SecondOrder,
        vectors: &DMatrix<f64>,
        z: DMatrix<f64>,
    ) -> Result<Self, ReductionError> {
        let failed = |source: LinalgError| ReductionError::Linalg { part: part.to_string(), source };
        let (mz, kz) = (system.mass.multiply(&z), system.stiffness.multiply(&z));
        let symmetric = |a: DMatrix<f64>| 0.5 * (&a + a.transpose());
        let combine = independent_directions(&symmetric(multiply_transposed(&z, &mz)), INDEPENDENT).map_err(failed)?;
        let own = multiply_transposed(&combine, &multiply(&multiply_transposed(&z, &kz), &combine));
        let eigen = symmetric_eigen(&symmetric(own)).map_err(failed)?;
        let combine = multiply(&combine, &eigen.vectors);
        let with = |az: &DMatrix<f64>| multiply_transposed(&combine, &multiply_transposed(az, vectors));
        Ok(Self { eigenvalues: eigen.values.iter().copied().collect(), stiffness: with(&kz), mass: with(&mz) })
    }

    /// Motions.
    pub fn n(&self) -> usize {
        self.eigenvalues.len()
    }

    /// The same for a material with other moduli: stiffness and mass of mass-normalised motions.
    pub(super) fn scale(&mut self, ratio: f64) {
        self.eigenvalues.iter_mut().for_each(|l| *l *= ratio);
        self.stiffness *= ratio;
    }
}
