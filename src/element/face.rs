//! Faces of solid elements: triangles of three and six nodes, quadrilaterals of four and eight.
//!
//! Triangle: corners 1 to 3 have the barycentric coordinates 1 - r - s, r, s; nodes 4 to 6 are the
//! midsides 12, 23, 31. Quadrilateral: corners (-1, -1), (1, -1), (1, 1), (-1, 1); nodes 5 to 8 are the
//! midsides 12, 23, 34, 41. The kind follows from the number of nodes.

/// Nodes of the largest face.
pub const MAX_NODES: usize = 8;

/// Corners of a face of so many nodes.
pub fn corner_count(nodes: usize) -> usize {
    match nodes {
        3 | 6 => 3,
        4 | 8 => 4,
        _ => panic!("a face of {nodes} nodes; there are 3, 4, 6, 8"),
    }
}

/// Places of the corners in the reference face.
pub fn corners(nodes: usize) -> &'static [[f64; 2]] {
    const TRIANGLE: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    const SQUARE: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    if corner_count(nodes) == 3 { &TRIANGLE } else { &SQUARE }
}

/// Shape functions with their derivatives by r and s at (r, s); entries past the face's nodes are zero.
pub fn shape(nodes: usize, at: [f64; 2]) -> ([f64; MAX_NODES], [[f64; 2]; MAX_NODES]) {
    match nodes {
        3 | 6 => triangle(nodes, at),
        4 | 8 => quadrilateral(nodes, at),
        _ => panic!("a face of {nodes} nodes; there are 3, 4, 6, 8"),
    }
}

fn triangle(nodes: usize, [r, s]: [f64; 2]) -> ([f64; MAX_NODES], [[f64; 2]; MAX_NODES]) {
    const DL: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
    let l = [1.0 - r - s, r, s];
    let (mut n, mut d) = ([0.0; MAX_NODES], [[0.0; 2]; MAX_NODES]);
    if nodes == 3 {
        n[..3].copy_from_slice(&l);
        d[..3].copy_from_slice(&DL);
        return (n, d);
    }
    for i in 0..3 {
        let next = (i + 1) % 3;
        n[i] = l[i] * (2.0 * l[i] - 1.0);
        d[i] = DL[i].map(|g| g * (4.0 * l[i] - 1.0));
        n[3 + i] = 4.0 * l[i] * l[next];
        d[3 + i] = std::array::from_fn(|c| 4.0 * (l[i] * DL[next][c] + l[next] * DL[i][c]));
    }
    (n, d)
}

fn quadrilateral(nodes: usize, at: [f64; 2]) -> ([f64; MAX_NODES], [[f64; 2]; MAX_NODES]) {
    let (mut n, mut d) = ([0.0; MAX_NODES], [[0.0; 2]; MAX_NODES]);
    for (i, corner) in corners(nodes).iter().enumerate() {
        let f: [f64; 2] = std::array::from_fn(|c| 1.0 + at[c] * corner[c]);
        // With midsides the corner's function is the bilinear one times r r_i + s s_i - 1.
        let (sum, slope) = if nodes == 8 { (f[0] + f[1] - 3.0, 1.0) } else { (1.0, 0.0) };
        n[i] = f[0] * f[1] * sum / 4.0;
        d[i] = std::array::from_fn(|c| corner[c] * f[1 - c] * (sum + slope * f[c]) / 4.0);
    }
    for (k, [r, s]) in [[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]].into_iter().enumerate().take(nodes - 4) {
        let f = |x: f64, at: f64| if x == 0.0 { (1.0 - at * at, -2.0 * at) } else { (1.0 + at * x, x) };
        let ((fr, dr), (fs, ds)) = (f(r, at[0]), f(s, at[1]));
        n[4 + k] = fr * fs / 2.0;
        d[4 + k] = [dr * fs / 2.0, fr * ds / 2.0];
    }
    (n, d)
}

/// Area element |dx/dr x dx/ds| (m^2) at (r, s).
pub fn area_element(nodes: &[[f64; 3]], at: [f64; 2]) -> f64 {
    let (mut u, mut v) = ([0.0; 3], [0.0; 3]);
    for (x, d) in nodes.iter().zip(shape(nodes.len(), at).1) {
        for c in 0..3 {
            u[c] += d[0] * x[c];
            v[c] += d[1] * x[c];
        }
    }
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt()
}
