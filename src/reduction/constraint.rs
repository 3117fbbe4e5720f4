//! The static response of a part whose interfaces are held or moved.
//!
//! With X = K^+ W (W: the interface motions as columns, q = W^T u), a response with prescribed q is
//! u = K^+ f + X mu + R alpha, where the interface forces mu and the rigid part alpha follow from
//!
//! ```text
//! [ W^T X   W^T R ] [ mu    ]   [ q - W^T K^+ f ]
//! [ R^T W     0   ] [ alpha ] = [ -R^T f        ]
//! ```
//!
//! Interface motions that depend on each other (overlapping footprints) are first replaced by
//! independent combinations: those whose flexibility, of the part's elasticity and of its motion as a rigid
//! body together, is above 1e-9 of the largest. A plate one brick thick between two interfaces has motions
//! without any elastic flexibility (a push on both sides in proportion to its mass bends nothing); they are
//! independent all the same, because the part follows them as a whole.

use super::ReductionError;
use super::flexibility::Flexibility;
use crate::linalg::{LinalgError, independent_directions, multiply, multiply_transposed};
use nalgebra::{DMatrix, Dyn, LU};

pub(super) struct Constrained<'a> {
    flexibility: &'a Flexibility<'a>,
    /// Independent interface motions, n x k.
    pub motions: DMatrix<f64>,
    /// The unknowns that the interfaces touch, and the motions' rows there.
    touched: Vec<usize>,
    touched_motions: DMatrix<f64>,
    responses: DMatrix<f64>,
    /// Brings the saddle's rigid columns to the size of its compliance.
    scale: f64,
    saddle: LU<f64, Dyn, Dyn>,
}

impl<'a> Constrained<'a> {
    /// `attachments` = K^+ `motions`.
    pub fn new(
        part: &str,
        flexibility: &'a Flexibility<'a>,
        motions: &DMatrix<f64>,
        attachments: &DMatrix<f64>,
    ) -> Result<Self, ReductionError> {
        let failed = |source: LinalgError| ReductionError::Linalg { part: part.to_string(), source };
        let mut compliance = multiply_transposed(motions, attachments);
        if flexibility.rigid.ncols() > 0 {
            let whole = multiply_transposed(motions, &flexibility.rigid);
            // One size for both, so that neither drowns the other.
            let scale = compliance.trace().abs() / whole.norm_squared().max(f64::MIN_POSITIVE);
            compliance += multiply(&whole, &whole.transpose()) * scale;
        }
        let combine = independent_directions(&(0.5 * (&compliance + compliance.transpose())), 1e-9).map_err(failed)?;
        let motions = multiply(motions, &combine);
        let responses = multiply(attachments, &combine);
        let compliance = multiply_transposed(&motions, &responses);
        let touched: Vec<usize> = (0..motions.nrows()).filter(|&i| motions.row(i).iter().any(|v| *v != 0.0)).collect();
        let touched_motions = motions.select_rows(&touched);
        if motions.ncols() < flexibility.rigid.ncols() {
            let free = flexibility.rigid.ncols() - motions.ncols();
            return Err(ReductionError::NotHeld { part: part.to_string(), free });
        }
        let hold = multiply_transposed(&motions, &flexibility.rigid);
        let (k, r) = hold.shape();
        let mut matrix = DMatrix::zeros(k + r, k + r);
        matrix.view_mut((0, 0), (k, k)).copy_from(&compliance);
        if r > 0 {
            let singular = hold.clone().svd(false, false).singular_values;
            let free = singular.iter().filter(|s| **s < 1e-8 * singular.max()).count();
            if free > 0 {
                return Err(ReductionError::NotHeld { part: part.to_string(), free });
            }
            // Both blocks are brought to one scale.
            let scale = if compliance.norm() > 0.0 { compliance.norm() / hold.norm() } else { 1.0 };
            matrix.view_mut((0, k), (k, r)).copy_from(&(&hold * scale));
            matrix.view_mut((k, 0), (r, k)).copy_from(&(hold.transpose() * scale));
            let responses = Self::with_rigid(responses, flexibility, scale);
            let saddle = matrix.lu();
            return Ok(Self { flexibility, motions, touched, touched_motions, responses, scale, saddle });
        }
        Ok(Self { flexibility, motions, touched, touched_motions, responses, scale: 1.0, saddle: matrix.lu() })
    }

    /// Responses [X, scale R], so that u is one product of the saddle's solution.
    fn with_rigid(responses: DMatrix<f64>, flexibility: &Flexibility<'_>, scale: f64) -> DMatrix<f64> {
        let (n, k) = responses.shape();
        let mut all = responses.resize_horizontally(k + flexibility.rigid.ncols(), 0.0);
        all.view_mut((0, k), (n, flexibility.rigid.ncols())).copy_from(&(&flexibility.rigid * scale));
        all
    }

    fn complete(&self, right_side: &DMatrix<f64>) -> DMatrix<f64> {
        let solution = self.saddle.solve(right_side).expect("the saddle matrix was checked to be regular");
        multiply(&self.responses, &solution)
    }

    /// Constraint modes: unit motions of the independent interface combinations, n x k.
    pub fn constraint_modes(&self) -> DMatrix<f64> {
        let k = self.motions.ncols();
        let size = self.responses.ncols();
        let mut right_side = DMatrix::zeros(size, k);
        right_side.view_mut((0, 0), (k, k)).fill_with_identity();
        self.complete(&right_side)
    }

    /// The response to loads with the interfaces held.
    pub fn apply(&self, load: &DMatrix<f64>) -> DMatrix<f64> {
        let k = self.motions.ncols();
        let size = self.responses.ncols();
        let elastic = self.flexibility.apply(load);
        let mut right_side = DMatrix::zeros(size, load.ncols());
        right_side
            .view_mut((0, 0), (k, load.ncols()))
            .copy_from(&-multiply_transposed(&self.touched_motions, &elastic.select_rows(&self.touched)));
        if size > k {
            let balance = multiply_transposed(&self.flexibility.rigid, load) * -self.scale;
            right_side.view_mut((k, 0), (size - k, load.ncols())).copy_from(&balance);
        }
        elastic + self.complete(&right_side)
    }
}
