//! The rigid motion of a surface as rows over its nodes' displacements.
//!
//! ```text
//! q = (sum w_i R_i^T R_i)^-1 sum w_i R_i^T u_i,    R_i = [I, -[x_i - x_ref]x]
//! ```
//!
//! with w_i the integral of shape function N_i over the surface: three translations of the reference
//! point, then three rotations (distributing coupling). A common rigid motion of the surface is
//! reproduced exactly, whatever the weights, so springs between two interfaces never push the ground.

use nalgebra::{DMatrix, Matrix6, SMatrix, Vector3};

/// Six rows over the displacements of some nodes.
#[derive(Clone, Debug)]
pub struct NodeRows {
    /// Node indices, ascending.
    pub nodes: Vec<usize>,
    /// 6 x 3 n_nodes: three translations (1), three rotations (1/m).
    pub rows: DMatrix<f64>,
}

/// The rigid motion of a surface at its reference point.
#[derive(Clone, Debug)]
pub struct InterfaceMotion {
    /// Reference point, m: the area centroid.
    pub centroid: [f64; 3],
    /// Area, m^2.
    pub area: f64,
    /// Rows at the reference point.
    pub rows: NodeRows,
}

impl InterfaceMotion {
    /// From node coordinates and area weights; `None` if the weighted nodes do not fix a rigid motion
    /// (no area, or all on one line).
    pub fn from_weights(weights: &[(usize, f64)], coordinate: impl Fn(usize) -> [f64; 3]) -> Option<Self> {
        let area: f64 = weights.iter().map(|(_, w)| w).sum();
        if weights.len() < 3 || area <= 0.0 {
            return None;
        }
        let mut centroid = [0.0; 3];
        for (node, w) in weights {
            let x = coordinate(*node);
            for c in 0..3 {
                centroid[c] += w * x[c] / area;
            }
        }
        // Lengths are scaled by the radius of gyration, so that the 6 x 6 system is well conditioned at any size.
        let arm = |node: usize| Vector3::from(coordinate(node)) - Vector3::from(centroid);
        let radius = (weights.iter().map(|(n, w)| w.abs() * arm(*n).norm_squared()).sum::<f64>() / area).sqrt();
        if radius.is_nan() || radius <= 0.0 {
            return None;
        }
        let blocks: Vec<SMatrix<f64, 3, 6>> = weights.iter().map(|(n, _)| rigid_block(arm(*n) / radius)).collect();
        let mut gram = Matrix6::zeros();
        for ((_, w), r) in weights.iter().zip(&blocks) {
            gram += *w / area * (r.transpose() * r);
        }
        let eigenvalues = gram.symmetric_eigenvalues();
        if eigenvalues.min() < 1e-9 * eigenvalues.max() {
            return None;
        }
        let inverse = gram.try_inverse()?;
        let mut rows = DMatrix::zeros(6, 3 * weights.len());
        for (k, ((_, w), r)) in weights.iter().zip(&blocks).enumerate() {
            let mut part: SMatrix<f64, 6, 3> = inverse * r.transpose() * (*w / area);
            for rotation in 3..6 {
                part.row_mut(rotation).scale_mut(1.0 / radius);
            }
            rows.view_mut((0, 3 * k), (6, 3)).copy_from(&part);
        }
        let nodes = weights.iter().map(|(n, _)| *n).collect();
        Some(Self { centroid, area, rows: NodeRows { nodes, rows } })
    }
}

/// u_i = R_i q: displacement of a node at `arm` from the reference point.
fn rigid_block(arm: Vector3<f64>) -> SMatrix<f64, 3, 6> {
    let mut r = SMatrix::<f64, 3, 6>::zeros();
    r.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
    r.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-arm.cross_matrix()));
    r
}

/// Coefficients over (three translations, three rotations) at a reference point of the translation
/// along `direction` of the point at `arm` from it: d . (t + theta x arm).
pub fn rotation_arm(direction: [f64; 3], arm: [f64; 3]) -> [f64; 6] {
    let (d, a) = (Vector3::from(direction), Vector3::from(arm));
    let c = a.cross(&d); // d . (theta x a) = theta . (a x d)
    [d.x, d.y, d.z, c.x, c.y, c.z]
}

/// A direction in words: `x`, or its components, of which the first that is not zero is positive.
pub fn axis_name(direction: Vector3<f64>) -> String {
    let d = direction.normalize();
    for (name, value) in ["x", "y", "z"].iter().zip(d.iter()) {
        if value.abs() > 0.9999 {
            return (*name).to_string();
        }
    }
    format!("({:.3}, {:.3}, {:.3})", d.x, d.y, d.z)
}
