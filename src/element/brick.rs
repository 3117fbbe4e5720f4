//! Eight- and twenty-node bricks (C3D8, C3D8I, C3D20, C3D20R).
//!
//! Corners 1 to 4 lie at t = -1, 5 to 8 above them; nodes 9 to 20 are the midsides 12, 23, 34, 41,
//! 56, 67, 78, 85, 15, 26, 37, 48.

use super::shape::Shape;

pub(super) const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// The corner pair of each midside node.
pub(super) const SIDES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

pub(super) const FACES_8: [&[usize]; 6] =
    [&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]];

pub(super) const FACES_20: [&[usize]; 6] = [
    &[0, 3, 2, 1, 11, 10, 9, 8],
    &[4, 5, 6, 7, 12, 13, 14, 15],
    &[0, 1, 5, 4, 8, 17, 12, 16],
    &[1, 2, 6, 5, 9, 18, 13, 17],
    &[2, 3, 7, 6, 10, 19, 14, 18],
    &[3, 0, 4, 7, 11, 16, 15, 19],
];

pub(super) fn shape_8(at: [f64; 3]) -> Shape {
    let mut out = Shape::zero();
    for (i, corner) in CORNERS.iter().enumerate() {
        let f: [f64; 3] = std::array::from_fn(|c| 1.0 + at[c] * corner[c]);
        out.values[i] = f[0] * f[1] * f[2] / 8.0;
        out.derivatives[i] = std::array::from_fn(|c| corner[c] * f[(c + 1) % 3] * f[(c + 2) % 3] / 8.0);
    }
    out
}

pub(super) fn shape_20(at: [f64; 3]) -> Shape {
    let mut out = Shape::zero();
    for (i, corner) in CORNERS.iter().enumerate() {
        let f: [f64; 3] = std::array::from_fn(|c| 1.0 + at[c] * corner[c]);
        let sum = f[0] + f[1] + f[2] - 5.0; // r r_i + s s_i + t t_i - 2
        out.values[i] = f[0] * f[1] * f[2] * sum / 8.0;
        out.derivatives[i] = std::array::from_fn(|c| corner[c] * f[(c + 1) % 3] * f[(c + 2) % 3] * (sum + f[c]) / 8.0);
    }
    for (i, [a, b]) in (8..).zip(SIDES) {
        // Along one coordinate the midside's function is 1 - x^2, along the others linear.
        let place: [f64; 3] = std::array::from_fn(|c| 0.5 * (CORNERS[a][c] + CORNERS[b][c]));
        let f: [f64; 3] =
            std::array::from_fn(|c| if place[c] == 0.0 { 1.0 - at[c] * at[c] } else { 1.0 + at[c] * place[c] });
        let slope: [f64; 3] = std::array::from_fn(|c| if place[c] == 0.0 { -2.0 * at[c] } else { place[c] });
        out.values[i] = f[0] * f[1] * f[2] / 4.0;
        out.derivatives[i] = std::array::from_fn(|c| slope[c] * f[(c + 1) % 3] * f[(c + 2) % 3] / 4.0);
    }
    out
}
