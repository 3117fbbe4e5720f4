//! The incompatible modes of the eight-node brick (C3D8I).
//!
//! The displacements get the terms (1 - r^2) a_1 + (1 - s^2) a_2 + (1 - t^2) a_3, which let the element bend
//! without shearing. Each a is a vector of three parameters that belong to the element alone, so that a mode
//! stands beside the shape functions as a ninth, tenth and eleventh node would. Its gradient is taken with the
//! Jacobian at the centre, J_0, and scaled by det J_0 / det J,
//!
//! ```text
//! grad = (det J_0 / det J) J_0^-1 [-2 r, -2 s, -2 t],      integral grad dV = 0,
//! ```
//!
//! so that a constant stress does no work on the modes and distorted meshes pass the patch test.
//!
//! The modes carry mass: where the element bends, its middle moves too. The parameters therefore stay unknowns
//! of the part. Without their mass the frequencies of coarse meshes are up to twice as far off;
//! `docs/elements.md` has the comparison.
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

/// Incompatible modes of an element; each has one parameter a direction.
pub(super) const MODES: usize = 3;

/// Values of the modes at (r, s, t).
pub(super) fn values(at: [f64; 3]) -> [f64; MODES] {
    at.map(|x| 1.0 - x * x)
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
    pub fn gradients(&self, at: [f64; 3], det: f64) -> [[f64; 3]; MODES] {
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
