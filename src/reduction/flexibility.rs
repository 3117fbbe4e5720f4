//! The static response of a part, in inertia relief where nothing holds it.
//!
//! A clamped part: u = K^-1 f. A free part: the load is balanced by rigid accelerations,
//! f' = f - M R (R^T f), the response is taken with six unknowns held (the reaction is zero because
//! f' is in equilibrium), and its rigid content is removed, u' = u - R (R^T M u). This is the
//! generalised inverse of K on the elastic subspace; its eigenvalues are 1 / omega^2 of the elastic
//! modes, so a Lanczos iteration with it cannot lose a rigid mode.

use crate::linalg::{Cholesky, LinalgError, Ordering, independent_directions, multiply, multiply_transposed};
use crate::solid::SecondOrder;
use nalgebra::DMatrix;

/// Static flexibility of a part on its elastic subspace.
pub(super) struct Flexibility<'a> {
    system: &'a SecondOrder,
    factor: Cholesky,
    held: Vec<usize>,
    /// Mass-orthonormal rigid motions, n x 6 or n x 0.
    pub rigid: DMatrix<f64>,
    mass_rigid: DMatrix<f64>,
}

impl<'a> Flexibility<'a> {
    pub fn new(system: &'a SecondOrder, ordering: &Ordering) -> Result<Self, LinalgError> {
        let mass_times = system.mass.multiply(&system.rigid);
        let combine = independent_directions(&multiply_transposed(&system.rigid, &mass_times), 1e-14)?;
        let rigid = multiply(&system.rigid, &combine);
        let mass_rigid = multiply(&mass_times, &combine);
        let held = statically_determinate(&rigid);
        let factor = if held.is_empty() {
            Cholesky::new(&system.stiffness, ordering)?
        } else {
            Cholesky::new(&system.stiffness.with_uncoupled(&held), ordering)?
        };
        Ok(Self { system, factor, held, rigid, mass_rigid })
    }

    /// The elastic response to an n x b block of loads.
    pub fn apply(&self, load: &DMatrix<f64>) -> DMatrix<f64> {
        if self.held.is_empty() {
            return self.factor.solve(load);
        }
        let mut balanced = load - multiply(&self.mass_rigid, &multiply_transposed(&self.rigid, load));
        for &unknown in &self.held {
            balanced.row_mut(unknown).fill(0.0);
        }
        let mut u = self.factor.solve(&balanced);
        self.remove_rigid(&mut u);
        u
    }

    /// u - R (R^T M u).
    pub fn remove_rigid(&self, u: &mut DMatrix<f64>) {
        if self.rigid.ncols() > 0 {
            *u -= multiply(&self.rigid, &multiply_transposed(&self.mass_rigid, u));
        }
    }

    /// K^-1 M X on the elastic subspace.
    pub fn apply_mass(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        self.apply(&self.system.mass.multiply(x))
    }
}

/// One unknown for each rigid motion, such that holding them stops the part and strains nothing:
/// pivoted Gram-Schmidt over the rows of the rigid motions.
fn statically_determinate(rigid: &DMatrix<f64>) -> Vec<usize> {
    let mut rows = rigid.clone();
    let mut held = Vec::new();
    for _ in 0..rigid.ncols() {
        let norm = |i: usize| rows.row(i).norm_squared();
        let Some(pivot) = (0..rows.nrows()).max_by(|&a, &b| norm(a).total_cmp(&norm(b))) else { break };
        held.push(pivot);
        let unit = rows.row(pivot).normalize().transpose();
        let along = &rows * &unit;
        rows -= along * unit.transpose();
    }
    held
}
