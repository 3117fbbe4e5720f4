//! Ten-node tetrahedron (C3D10).
//!
//! Corners 1 to 4 have the barycentric coordinates 1 - r - s - t, r, s, t; nodes 5 to 10 are the
//! midsides 12, 23, 31, 14, 24, 34. The geometry is isoparametric, so sides may be curved.
//! Stiffness by the four-point rule (as CalculiX's C3D10), consistent mass by Keast's fifteen points.

use super::quadrature::{tet_degree_2, tet_degree_5};

/// Nodes of the element.
pub const NODES: usize = 10;

/// The corner pair of each midside node.
const SIDES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Faces as six-node triangles (three corners, then the midsides 12, 23, 31 of the face), outward.
pub const FACES: [[usize; 6]; 4] = [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [2, 0, 3, 6, 7, 9]];

/// Shape functions at (r, s, t).
pub fn shape([r, s, t]: [f64; 3]) -> [f64; NODES] {
    let l = [1.0 - r - s - t, r, s, t];
    let mut n = [0.0; NODES];
    for (n, l) in n.iter_mut().zip(l) {
        *n = l * (2.0 * l - 1.0);
    }
    for (n, [a, b]) in n[4..].iter_mut().zip(SIDES) {
        *n = 4.0 * l[a] * l[b];
    }
    n
}

/// Derivatives of the shape functions by r, s, t at (r, s, t).
pub fn shape_derivatives([r, s, t]: [f64; 3]) -> [[f64; 3]; NODES] {
    const DL: [[f64; 3]; 4] = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let l = [1.0 - r - s - t, r, s, t];
    let mut d = [[0.0; 3]; NODES];
    for i in 0..4 {
        d[i] = DL[i].map(|g| g * (4.0 * l[i] - 1.0));
    }
    for (d, [a, b]) in d[4..].iter_mut().zip(SIDES) {
        for c in 0..3 {
            d[c] = 4.0 * (l[a] * DL[b][c] + l[b] * DL[a][c]);
        }
    }
    d
}

/// Gradients of the shape functions in physical coordinates (1/m), and det J (m^3).
///
/// The gradients are meaningless where the determinant is not positive; callers look at it first.
pub fn gradients(nodes: &[[f64; 3]; NODES], at: [f64; 3]) -> ([[f64; 3]; NODES], f64) {
    let d = shape_derivatives(at);
    let mut j = [[0.0; 3]; 3]; // j[a][c] = d x_c / d r_a
    for (x, d) in nodes.iter().zip(&d) {
        for a in 0..3 {
            for c in 0..3 {
                j[a][c] += d[a] * x[c];
            }
        }
    }
    let cofactor = |a: usize, c: usize| {
        let (a1, a2, c1, c2) = ((a + 1) % 3, (a + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        j[a1][c1] * j[a2][c2] - j[a1][c2] * j[a2][c1]
    };
    let det = (0..3).map(|c| j[0][c] * cofactor(0, c)).sum::<f64>();
    // d r_a / d x_c = cofactor(a, c) / det, so grad N = sum_a dN/dr_a * cofactor(a, .) / det.
    let mut inverse = [[0.0; 3]; 3];
    for (a, row) in inverse.iter_mut().enumerate() {
        for (c, value) in row.iter_mut().enumerate() {
            *value = cofactor(a, c) / det;
        }
    }
    let gradient = d.map(|d| {
        let mut g = [0.0; 3];
        for (c, g) in g.iter_mut().enumerate() {
            *g = d[0] * inverse[0][c] + d[1] * inverse[1][c] + d[2] * inverse[2][c];
        }
        g
    });
    (gradient, det)
}

/// Stiffness (N/m) and mass (kg; the same for x, y, z) of one element.
#[derive(Clone, Debug)]
pub struct ElementMatrices {
    /// 3 x 3 blocks `stiffness[a][b]` of node pair (a, b), N/m.
    pub stiffness: [[[[f64; 3]; 3]; NODES]; NODES],
    /// `mass[a][b]` of node pair (a, b), kg.
    pub mass: [[f64; NODES]; NODES],
}

/// Stiffness and consistent mass of an isotropic element.
///
/// # Errors
/// The smallest Jacobian determinant (m^3), if it is not positive at a quadrature point: the element
/// is inverted or folded.
///
/// # Source
/// Zienkiewicz and Taylor, The Finite Element Method, vol. 1, ch. 6; rules in [`super::quadrature`].
pub fn matrices(
    nodes: &[[f64; 3]; NODES],
    young: f64,
    poisson: f64,
    density: f64,
) -> Result<Box<ElementMatrices>, f64> {
    let lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let shear = young / (2.0 * (1.0 + poisson));
    let mut out = Box::new(ElementMatrices { stiffness: [[[[0.0; 3]; 3]; NODES]; NODES], mass: [[0.0; NODES]; NODES] });
    let mut smallest = f64::INFINITY;
    for point in tet_degree_2() {
        let (g, det) = gradients(nodes, point.at);
        smallest = smallest.min(det);
        let w = point.weight * det;
        for a in 0..NODES {
            for b in 0..NODES {
                let dot = g[a][0] * g[b][0] + g[a][1] * g[b][1] + g[a][2] * g[b][2];
                let block = &mut out.stiffness[a][b];
                for i in 0..3 {
                    for j in 0..3 {
                        block[i][j] += w * (lame * g[a][i] * g[b][j] + shear * g[a][j] * g[b][i]);
                    }
                    block[i][i] += w * shear * dot;
                }
            }
        }
    }
    for point in tet_degree_5() {
        let n = shape(point.at);
        let (_, det) = gradients(nodes, point.at);
        smallest = smallest.min(det);
        let w = point.weight * det * density;
        for a in 0..NODES {
            for b in 0..NODES {
                out.mass[a][b] += w * n[a] * n[b];
            }
        }
    }
    if smallest > 0.0 { Ok(out) } else { Err(smallest) }
}
