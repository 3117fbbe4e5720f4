//! Six-node triangle: a face of a ten-node tetrahedron.
//!
//! Corners 1 to 3 have the barycentric coordinates 1 - r - s, r, s; nodes 4 to 6 are the midsides
//! 12, 23, 31.

/// Nodes of the face.
pub const NODES: usize = 6;

/// Shape functions at (r, s).
pub fn shape([r, s]: [f64; 2]) -> [f64; NODES] {
    let l = 1.0 - r - s;
    [l * (2.0 * l - 1.0), r * (2.0 * r - 1.0), s * (2.0 * s - 1.0), 4.0 * l * r, 4.0 * r * s, 4.0 * s * l]
}

/// Derivatives of the shape functions by r and s at (r, s).
pub fn shape_derivatives([r, s]: [f64; 2]) -> [[f64; 2]; NODES] {
    let l = 1.0 - r - s;
    [
        [1.0 - 4.0 * l, 1.0 - 4.0 * l],
        [4.0 * r - 1.0, 0.0],
        [0.0, 4.0 * s - 1.0],
        [4.0 * (l - r), -4.0 * r],
        [4.0 * s, 4.0 * r],
        [-4.0 * s, 4.0 * (l - s)],
    ]
}

/// Area element |dx/dr x dx/ds| (m^2) at (r, s).
pub fn area_element(nodes: &[[f64; 3]; NODES], at: [f64; 2]) -> f64 {
    let (mut u, mut v) = ([0.0; 3], [0.0; 3]);
    for (x, d) in nodes.iter().zip(shape_derivatives(at)) {
        for c in 0..3 {
            u[c] += d[0] * x[c];
            v[c] += d[1] * x[c];
        }
    }
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt()
}
