//! Single ten-node tetrahedra.

use super::SIDES;

/// Midsides halfway between four corners.
pub fn straight(corners: [[f64; 3]; 4]) -> [[f64; 3]; 10] {
    let mut x = [[0.0; 3]; 10];
    x[..4].copy_from_slice(&corners);
    for (k, [a, b]) in SIDES.into_iter().enumerate() {
        x[4 + k] = std::array::from_fn(|c| 0.5 * (corners[a][c] + corners[b][c]));
    }
    x
}

/// A skewed one with straight sides, m.
pub fn skewed() -> [[f64; 3]; 10] {
    straight([[0.1, -0.2, 0.05], [1.3, 0.1, 0.2], [0.2, 0.9, -0.1], [0.3, 0.2, 1.4]])
}

/// The same with curved sides.
pub fn curved() -> [[f64; 3]; 10] {
    let mut x = skewed();
    for (k, node) in x[4..].iter_mut().enumerate() {
        for (c, value) in node.iter_mut().enumerate() {
            *value += 0.05 * (7.3 * (3 * k + c) as f64).sin();
        }
    }
    x
}
