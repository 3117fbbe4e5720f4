//! The incompatible modes of the eight-node brick (C3D8I).
//!
//! The displacements get the terms (1 - r^2) a_1 + (1 - s^2) a_2 + (1 - t^2) a_3, which let the element bend
//! without shearing. Each a is a vector of three parameters that belong to the element alone. The gradients are
//! taken with the Jacobian at the centre, J_0, and scaled by det J_0 / det J,
//!
//! ```text
//! grad = (det J_0 / det J) J_0^-1 [-2 r, -2 s, -2 t],      integral grad dV = 0,
//! ```
//!
//! so that a constant stress does no work on the modes and distorted meshes pass the patch test.
//!
//! The modes carry mass: where the element bends, its middle moves too. At the 2 x 2 x 2 points of the mass each
//! mode has the value 2/3, so that the mass knows their sum alone: two of three combinations,
//!
//! ```text
//! (a_1 + a_2 + a_3) / 3 at each mode,      a_1 - a_3,      a_2 - a_3,
//! ```
//!
//! have none and are eliminated in the element, exactly at any frequency. The first, the mean mode, stays: it stands
//! beside the shape functions as a ninth node would, with three unknowns of the element's own. Without the modes'
//! mass the frequencies of coarse meshes are up to twice as far off; `docs/elements.md` has the comparison.
//!
//! # Source
//! E. L. Wilson, R. L. Taylor, W. P. Doherty, J. Ghaboussi, Incompatible displacement models (1973);
//! R. L. Taylor, P. J. Beresford, E. L. Wilson, A non-conforming element for stress analysis, Int. J.
//! Numer. Methods Eng. 10 (1976). The mass is that of CalculiX, C3D8I.
//!
//! # Differs
//! CalculiX leaves the factor det J_0 / det J out: the same on parallelepipeds, elsewhere its element fails
//! the patch test. [`det_variation`] says how far an element is from a parallelepiped.

use super::quadrature::brick;
use super::shape::{inverse_jacobian, physical, shape};
use crate::mesh::CellKind;
use nalgebra::SMatrix;

/// Nodes, and functions with all incompatible modes.
const NODES: usize = 8;
pub(super) const FUNCTIONS: usize = NODES + 3;

/// Value of the mean mode at (r, s, t).
pub(super) fn mean_value(at: [f64; 3]) -> f64 {
    at.iter().map(|x| (1.0 - x * x) / 3.0).sum()
}

/// The stiffness over the nodes and the mean mode, 9 x 9 blocks, from that over the nodes and the three modes.
///
/// `None` where the element is so distorted that a mode moves without resistance.
pub(super) fn without_massless(stiffness: &[[[f64; 3]; 3]]) -> Option<Vec<[[f64; 3]; 3]>> {
    const ALL: usize = 3 * FUNCTIONS;
    const KEPT: usize = 3 * (NODES + 1);
    const GONE: usize = ALL - KEPT;
    let given = SMatrix::<f64, ALL, ALL>::from_fn(|i, j| stiffness[(i / 3) * FUNCTIONS + j / 3][i % 3][j % 3]);
    let mut combine = SMatrix::<f64, ALL, ALL>::identity();
    for c in 0..3 {
        let [first, second, third] = [0, 1, 2].map(|mode| 3 * (NODES + mode) + c);
        for (row, shares) in
            [(first, [1.0, 1.0, 1.0].map(|s| s / 3.0)), (second, [1.0, 0.0, -1.0]), (third, [0.0, 1.0, -1.0])]
        {
            for (column, share) in [first, second, third].into_iter().zip(shares) {
                combine[(row, column)] = share;
            }
        }
    }
    let changed = combine * given * combine.transpose();
    let own = changed.fixed_view::<GONE, GONE>(KEPT, KEPT).into_owned().cholesky()?;
    let coupling = changed.fixed_view::<GONE, KEPT>(KEPT, 0).into_owned();
    let kept = changed.fixed_view::<KEPT, KEPT>(0, 0) - coupling.transpose() * own.solve(&coupling);
    kept.fixed_view::<3, 3>(3 * NODES, 3 * NODES).into_owned().cholesky()?;
    let n = NODES + 1;
    let block = |k: usize| std::array::from_fn(|i| std::array::from_fn(|j| kept[(3 * (k / n) + i, 3 * (k % n) + j)]));
    Some((0..n * n).map(block).collect())
}

/// The Jacobian at an element's centre, from which the gradients of its modes follow.
pub(super) struct Centre {
    inverse: [[f64; 3]; 3],
    det: f64,
}

impl Centre {
    /// That of an element with these nodes.
    pub fn of(nodes: &[[f64; 3]]) -> Self {
        let (inverse, det) = inverse_jacobian(nodes, &shape(CellKind::Hex8, [0.0; 3]).derivatives);
        Self { inverse, det }
    }

    /// The determinant, m^3.
    pub fn det(&self) -> f64 {
        self.det
    }

    /// Gradients of the modes (1/m) at (r, s, t), where the Jacobian has the determinant `det`.
    pub fn gradients(&self, at: [f64; 3], det: f64) -> [[f64; 3]; 3] {
        std::array::from_fn(|a| self.inverse[a].map(|g| -2.0 * at[a] * g * self.det / det))
    }
}

/// How much the Jacobian's determinant of an eight-node brick varies over its 2 x 2 x 2 points, relative to that
/// at the centre: 0 for a parallelepiped.
pub fn det_variation(nodes: &[[f64; 3]]) -> f64 {
    let centre = Centre::of(nodes);
    let off = |at| (physical(nodes, &shape(CellKind::Hex8, at)).1 / centre.det - 1.0).abs();
    brick(2).into_iter().map(|point| off(point.at)).fold(0.0, f64::max)
}
