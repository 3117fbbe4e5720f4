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

/// The crate's ten-node tetrahedron, by its kind.
pub mod tet10 {
    use stiffmap::element::{self, ElementMatrices};
    use stiffmap::mesh::CellKind::Tet10;

    fn ten<T: Copy>(values: [T; element::MAX_NODES]) -> [T; 10] {
        std::array::from_fn(|i| values[i])
    }

    pub fn shape(at: [f64; 3]) -> [f64; 10] {
        ten(element::shape(Tet10, at).values)
    }

    pub fn shape_derivatives(at: [f64; 3]) -> [[f64; 3]; 10] {
        ten(element::shape(Tet10, at).derivatives)
    }

    pub fn gradients(x: &[[f64; 3]; 10], at: [f64; 3]) -> ([[f64; 3]; 10], f64) {
        let (g, det) = element::gradients(Tet10, x, at);
        (ten(g), det)
    }

    pub fn faces() -> [[usize; 6]; 4] {
        std::array::from_fn(|k| element::faces(Tet10)[k].try_into().expect("six nodes"))
    }

    pub fn matrices(x: &[[f64; 3]; 10], young: f64, poisson: f64, density: f64) -> Result<ElementMatrices, f64> {
        element::matrices(Tet10, x, young, poisson, density)
    }
}

/// The crate's six-node triangle.
pub mod tri6 {
    use stiffmap::element::face;

    pub fn shape(at: [f64; 2]) -> [f64; 6] {
        std::array::from_fn(|i| face::shape(6, at).0[i])
    }

    pub fn shape_derivatives(at: [f64; 2]) -> [[f64; 2]; 6] {
        std::array::from_fn(|i| face::shape(6, at).1[i])
    }

    pub fn area_element(x: &[[f64; 3]; 6], at: [f64; 2]) -> f64 {
        face::area_element(x, at)
    }
}
