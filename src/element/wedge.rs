//! Six- and fifteen-node wedges (C3D6, C3D15).
//!
//! Corners 1 to 3 have the barycentric coordinates 1 - r - s, r, s at t = -1, 4 to 6 lie above them;
//! nodes 7 to 15 are the midsides 12, 23, 31, 45, 56, 64, 14, 25, 36.

use super::shape::Shape;

pub(super) const CORNERS: [[f64; 3]; 6] =
    [[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];

/// The corner pair of each midside node.
pub(super) const SIDES: [[usize; 2]; 9] = [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]];

pub(super) const FACES_6: [&[usize]; 5] = [&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]];

pub(super) const FACES_15: [&[usize]; 5] = [
    &[0, 2, 1, 8, 7, 6],
    &[3, 4, 5, 9, 10, 11],
    &[0, 1, 4, 3, 6, 13, 9, 12],
    &[1, 2, 5, 4, 7, 14, 10, 13],
    &[2, 0, 3, 5, 8, 12, 11, 14],
];

/// Derivatives of the triangle's barycentric coordinates by r and s.
const DL: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];

pub(super) fn shape_6([r, s, t]: [f64; 3]) -> Shape {
    let l = [1.0 - r - s, r, s];
    let mut out = Shape::zero();
    for i in 0..6 {
        let (c, end) = (i % 3, if i < 3 { -1.0 } else { 1.0 });
        let along = 0.5 * (1.0 + end * t);
        out.values[i] = l[c] * along;
        out.derivatives[i] = [DL[c][0] * along, DL[c][1] * along, 0.5 * end * l[c]];
    }
    out
}

pub(super) fn shape_15([r, s, t]: [f64; 3]) -> Shape {
    let l = [1.0 - r - s, r, s];
    let bubble = 1.0 - t * t;
    let mut out = Shape::zero();
    for i in 0..6 {
        let (c, end) = (i % 3, if i < 3 { -1.0 } else { 1.0 });
        let (along, quadratic) = (1.0 + end * t, l[c] * (2.0 * l[c] - 1.0));
        out.values[i] = 0.5 * (quadratic * along - l[c] * bubble);
        let across = 0.5 * ((4.0 * l[c] - 1.0) * along - bubble);
        out.derivatives[i] = [DL[c][0] * across, DL[c][1] * across, 0.5 * end * quadratic + l[c] * t];
    }
    for (i, [a, b]) in (6..).zip(SIDES) {
        if i >= 12 {
            out.values[i] = l[a] * bubble;
            out.derivatives[i] = [DL[a][0] * bubble, DL[a][1] * bubble, -2.0 * t * l[a]];
            continue;
        }
        let (end, a, b) = (if i < 9 { -1.0 } else { 1.0 }, a % 3, b % 3);
        let along = 1.0 + end * t;
        out.values[i] = 2.0 * l[a] * l[b] * along;
        let across = |c: usize| 2.0 * (DL[a][c] * l[b] + l[a] * DL[b][c]) * along;
        out.derivatives[i] = [across(0), across(1), 2.0 * end * l[a] * l[b]];
    }
    out
}
