//! Four- and ten-node tetrahedra (C3D4, C3D10).
//!
//! Corners 1 to 4 have the barycentric coordinates 1 - r - s - t, r, s, t; nodes 5 to 10 are the
//! midsides 12, 23, 31, 14, 24, 34. The geometry is isoparametric, so sides may be curved.

use super::shape::Shape;

pub(super) const CORNERS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The corner pair of each midside node.
pub(super) const SIDES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

pub(super) const FACES_4: [&[usize]; 4] = [&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]];

pub(super) const FACES_10: [&[usize]; 4] =
    [&[0, 2, 1, 6, 5, 4], &[0, 1, 3, 4, 8, 7], &[1, 2, 3, 5, 9, 8], &[2, 0, 3, 6, 7, 9]];

/// Derivatives of the barycentric coordinates.
const DL: [[f64; 3]; 4] = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn barycentric([r, s, t]: [f64; 3]) -> [f64; 4] {
    [1.0 - r - s - t, r, s, t]
}

pub(super) fn shape_4(at: [f64; 3]) -> Shape {
    let mut out = Shape::zero();
    out.values[..4].copy_from_slice(&barycentric(at));
    out.derivatives[..4].copy_from_slice(&DL);
    out
}

pub(super) fn shape_10(at: [f64; 3]) -> Shape {
    let l = barycentric(at);
    let mut out = Shape::zero();
    for i in 0..4 {
        out.values[i] = l[i] * (2.0 * l[i] - 1.0);
        out.derivatives[i] = DL[i].map(|g| g * (4.0 * l[i] - 1.0));
    }
    for (i, [a, b]) in (4..).zip(SIDES) {
        out.values[i] = 4.0 * l[a] * l[b];
        out.derivatives[i] = std::array::from_fn(|c| 4.0 * (l[a] * DL[b][c] + l[b] * DL[a][c]));
    }
    out
}
