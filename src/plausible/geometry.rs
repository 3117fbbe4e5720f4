//! Distances between points and surfaces, and the axis of a bore.

use nalgebra::{Matrix3, Vector3};

pub(super) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] - b[c])
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| a[c] * b[c]).sum()
}

pub(super) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

/// Distance from a point to the segment between two others.
fn to_segment(p: [f64; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    let (ab, ap) = (minus(b, a), minus(p, a));
    let square = dot(ab, ab);
    let t = if square > 0.0 { (dot(ap, ab) / square).clamp(0.0, 1.0) } else { 0.0 };
    norm(std::array::from_fn(|c| ap[c] - t * ab[c]))
}

/// Distance from a point to a triangle, m.
pub(super) fn to_triangle(p: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> f64 {
    let normal = cross(minus(b, a), minus(c, a));
    let square = dot(normal, normal);
    let edges = [(a, b), (b, c), (c, a)];
    // Above the triangle's inside the nearest point is the foot of the perpendicular; otherwise it is on an edge.
    let inside = |(u, v): &([f64; 3], [f64; 3])| dot(cross(minus(*v, *u), minus(p, *u)), normal) >= 0.0;
    if square > 0.0 && edges.iter().all(inside) {
        return dot(minus(p, a), normal).abs() / square.sqrt();
    }
    edges.iter().map(|(u, v)| to_segment(p, *u, *v)).fold(f64::INFINITY, f64::min)
}

/// Twice the area of a triangle as a vector along its normal.
pub(super) fn twice_area([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    cross(minus(b, a), minus(c, a))
}

/// A surface that goes round an axis.
pub(super) struct Bore {
    /// Unit vector along the axis.
    pub axis: [f64; 3],
    /// Mean distance of the surface from the axis through its centroid, m.
    pub radius: f64,
    /// Whether it goes all the way round, so that its centroid lies on the axis.
    pub closed: bool,
}

/// The axis of a cylindrical or conical surface; `None` for a flat one, or one that is neither.
///
/// With unit normals n and areas A, the matrix sum A n n^T / sum A has the eigenvalues (1/2, 1/2, 0) for a cylinder,
/// and the eigenvector of 0 is its axis; for a plane they are (1, 0, 0).
pub(super) fn bore(triangles: &[[[f64; 3]; 3]], centroid: [f64; 3]) -> Option<Bore> {
    const ALONG: f64 = 0.15;
    const ACROSS: f64 = 0.2;
    const CLOSED: f64 = 0.1;
    let (mut covariance, mut mean, mut total) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
    for triangle in triangles {
        let normal = Vector3::from(twice_area(*triangle));
        let area = normal.norm();
        if area > 0.0 {
            covariance += normal * normal.transpose() / area;
            mean += normal;
            total += area;
        }
    }
    if total <= 0.0 {
        return None;
    }
    let eigen = (covariance / total).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    if eigen.eigenvalues[order[0]] > ALONG || eigen.eigenvalues[order[1]] < ACROSS {
        return None;
    }
    let axis: [f64; 3] = eigen.eigenvectors.column(order[0]).into_owned().into();
    let points = triangles.iter().flatten();
    let count = points.clone().count() as f64;
    let radius = points.map(|x| across(minus(*x, centroid), axis)).sum::<f64>() / count;
    Some(Bore { axis, radius, closed: mean.norm() < CLOSED * total })
}

/// Length of a vector's part across a unit vector.
pub(super) fn across(v: [f64; 3], axis: [f64; 3]) -> f64 {
    let along = dot(v, axis);
    norm(std::array::from_fn(|c| v[c] - along * axis[c]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_a_triangle_are_those_of_its_inside_edges_and_corners() {
        let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        for (point, distance) in [
            ([0.2, 0.2, 0.5], 0.5),
            ([0.5, -2.0, 0.0], 2.0),
            ([-3.0, 0.0, 4.0], 5.0),
            ([1.0, 1.0, 0.0], 0.5_f64.sqrt()),
        ] {
            assert!((to_triangle(point, triangle) - distance).abs() < 1e-15, "{point:?}");
        }
        // All corners on one line: the distance to the segment.
        let flat = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        assert_eq!(to_triangle([1.5, 3.0, 0.0], flat), 3.0);
    }

    /// A prism of `n` sides about x, from `from` to `to` rad.
    fn round(n: usize, from: f64, to: f64) -> Vec<[[f64; 3]; 3]> {
        let at = |i: usize, x: f64| {
            let turn = from + (to - from) * i as f64 / n as f64;
            [x, turn.cos(), turn.sin()]
        };
        let side = |i: usize| {
            let [a, b, c, d] = [at(i, 0.0), at(i + 1, 0.0), at(i + 1, 0.5), at(i, 0.5)];
            [[a, b, c], [a, c, d]]
        };
        (0..n).flat_map(side).collect()
    }

    #[test]
    fn a_bore_knows_its_axis_and_a_plane_has_none() {
        let tau = std::f64::consts::TAU;
        let whole = bore(&round(12, 0.0, tau), [0.25, 0.0, 0.0]).unwrap();
        assert!(whole.axis[0].abs() > 1.0 - 1e-12 && whole.closed && (whole.radius - 1.0).abs() < 1e-12);
        let half = bore(&round(8, 0.0, tau / 2.0), [0.25, 0.0, 0.6]).unwrap();
        assert!(half.axis[0].abs() > 1.0 - 1e-12 && !half.closed);
        assert!(bore(&[[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]], [0.3; 3]).is_none());
    }
}
