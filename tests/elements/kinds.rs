//! Every kind of element by itself.

use crate::support::dense::{rigid_field, symmetric_values};
use crate::support::grids::one;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use proptest::prelude::*;
use stiffmap::element::{det_variation, face, faces, gradients, matrices, reference_nodes, shape};
use stiffmap::mesh::CellKind;

/// A point inside the reference domain from three numbers between 0 and 1.
fn inside(kind: CellKind, u: [f64; 3]) -> [f64; 3] {
    let mut cuts = u;
    match kind.corner_count() {
        4 => {
            cuts.sort_by(f64::total_cmp);
            [cuts[0], cuts[1] - cuts[0], cuts[2] - cuts[1]]
        }
        6 => {
            cuts[..2].sort_by(f64::total_cmp);
            [cuts[0], cuts[1] - cuts[0], 2.0 * u[2] - 1.0]
        }
        _ => u.map(|u| 2.0 * u - 1.0),
    }
}

#[test]
fn each_shape_function_is_one_at_its_own_node_and_zero_at_the_others() {
    for kind in CellKind::ALL {
        let nodes = reference_nodes(kind);
        assert_eq!(nodes.len(), kind.node_count());
        for (i, at) in nodes.iter().enumerate() {
            for (j, n) in shape(kind, *at).values.into_iter().enumerate() {
                assert!((n - f64::from(u8::from(i == j))).abs() < 1e-15, "{kind:?}: N{j} at {i}");
            }
        }
    }
    for nodes in [3, 4, 6, 8] {
        let corners = face::corners(nodes);
        let middle = |k: usize| [0, 1].map(|c| 0.5 * (corners[k][c] + corners[(k + 1) % corners.len()][c]));
        let places = corners.iter().copied().chain((0..nodes - corners.len()).map(middle));
        for (i, at) in places.enumerate() {
            for (j, n) in face::shape(nodes, at).0.into_iter().enumerate() {
                assert!((n - f64::from(u8::from(i == j))).abs() < 1e-15, "face of {nodes}: N{j} at {i}");
            }
        }
    }
}

proptest! {
    #[test]
    fn shape_functions_are_a_partition_of_unity_and_derivatives_their_differences(u in prop::array::uniform3(0.0..1.0f64)) {
        // Quadratic in each coordinate, so that central differences are exact but for rounding.
        let h = 1e-2;
        for kind in CellKind::ALL {
            let at = inside(kind, u);
            let here = shape(kind, at);
            prop_assert!((here.values.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            for c in 0..3 {
                prop_assert!(here.derivatives.iter().map(|d| d[c]).sum::<f64>().abs() < 1e-13);
                let moved = |s: f64| { let mut p = at; p[c] += s; shape(kind, p) };
                let (up, down) = (moved(h), moved(-h));
                for i in 0..kind.node_count() {
                    let difference = (up.values[i] - down.values[i]) / (2.0 * h);
                    prop_assert!((difference - here.derivatives[i][c]).abs() < 1e-12, "{kind:?} N{i} by {c}");
                    let control = (difference - up.derivatives[i][c]).abs();
                    prop_assert!(kind != CellKind::Hex20 || i < 8 || c != 0 || control < 1.0);
                }
            }
        }
        for nodes in [3, 4, 6, 8] {
            let at = inside(if nodes % 3 == 0 { CellKind::Tet4 } else { CellKind::Hex8 }, u);
            let at = [at[0], at[1]];
            let (n, d) = face::shape(nodes, at);
            prop_assert!((n.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            for c in 0..2 {
                let moved = |s: f64| { let mut p = at; p[c] += s; face::shape(nodes, p).0 };
                for ((up, down), d) in moved(h).into_iter().zip(moved(-h)).zip(d) {
                    prop_assert!(((up - down) / (2.0 * h) - d[c]).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn gradients_on_a_distorted_element_reproduce_a_linear_field(u in prop::array::uniform3(0.0..1.0f64)) {
        for kind in CellKind::ALL {
            let x = one(kind);
            let at = inside(kind, u);
            let (g, det) = gradients(kind, &x, at);
            prop_assert!(det > 0.0);
            let unit: Matrix3<f64> =
                g.iter().zip(&x).map(|(g, x)| Vector3::from(*x) * Vector3::from(*g).transpose()).sum();
            prop_assert!((unit - Matrix3::identity()).amax() < 1e-12, "{kind:?}");
            let elsewhere = gradients(kind, &x, inside(kind, u.map(|u| 1.0 - u))).0;
            let wrong = shape(kind, at).derivatives;
            let constant = kind == CellKind::Tet4;
            prop_assert!(constant || u.iter().all(|u| (u - 0.5).abs() < 0.1) || g != elsewhere);
            prop_assert!(g.iter().zip(&wrong).any(|(a, b)| a != b), "control: reference derivatives are others");
        }
    }
}

#[test]
fn faces_look_outward_their_midsides_follow_and_they_close_the_volume() {
    for kind in CellKind::ALL {
        let x = reference_nodes(kind);
        let centre: Vector3<f64> = x[..kind.corner_count()].iter().map(|x| Vector3::from(*x)).sum::<Vector3<f64>>()
            / kind.corner_count() as f64;
        assert_eq!(faces(kind).len(), kind.face_count());
        let mut volume = 0.0;
        for local in faces(kind) {
            let p: Vec<Vector3<f64>> = local.iter().map(|&i| x[i].into()).collect();
            let corners = face::corner_count(p.len());
            let mut area = Vector3::zeros();
            for k in 1..corners - 1 {
                area += 0.5 * (p[k] - p[0]).cross(&(p[k + 1] - p[0]));
            }
            let middle = p[..corners].iter().sum::<Vector3<f64>>() / corners as f64;
            assert!(area.dot(&(middle - centre)) > 0.0, "{kind:?} {local:?} looks outward");
            for k in 0..p.len() - corners {
                assert!((p[corners + k] - 0.5 * (p[k] + p[(k + 1) % corners])).norm() < 1e-15, "{kind:?} midside {k}");
            }
            volume += area.dot(&middle) / 3.0;
        }
        let exact = [1.0 / 6.0, 1.0, 8.0][kind.face_count() - 4];
        assert!((volume - exact).abs() < 1e-14, "{kind:?}: divergence theorem gives {volume}");
    }
}

fn stiffness(kind: CellKind, x: &[[f64; 3]]) -> DMatrix<f64> {
    let m = matrices(kind, x, 210e9, 0.3, 7850.0).expect("not inverted");
    let n = 3 * m.functions();
    DMatrix::from_fn(n, n, |i, j| m.stiffness(i / 3, j / 3)[i % 3][j % 3])
}

#[test]
fn an_element_has_its_rigid_motions_and_no_other_that_costs_nothing() {
    for kind in CellKind::ALL {
        let x = one(kind);
        let k = stiffness(kind, &x);
        assert!((&k - k.transpose()).amax() < 1e-13 * k.amax(), "{kind:?} is symmetric");
        for q in 0..6 {
            let mut motion = [0.0; 6];
            motion[q] = 1.0;
            let field = rigid_field(&x, [0.0; 3], motion).resize_vertically(k.nrows(), 0.0);
            assert!((&k * field).amax() < 1e-12 * k.amax(), "{kind:?}, motion {q}");
        }
        // Reduced integration leaves hourglass motions, which neighbours do not share.
        let free = match kind {
            CellKind::Hex20Reduced => 12,
            CellKind::Wedge6 => 7,
            _ => 6,
        };
        let values = symmetric_values(&k);
        let last = values[values.len() - 1];
        assert!(values[free - 1].abs() < 1e-13 * last, "{kind:?}: {:?}", &values[..free]);
        assert!(values[free] > 1e-4 * last, "{kind:?}: no motion more is free: {:?}", &values[..12]);
        let stretch = DVector::from_fn(k.nrows(), |i, _| match x.get(i / 3) {
            Some(x) if i % 3 == 0 => x[0],
            _ => 0.0,
        });
        assert!((&k * stretch).amax() > 1e-3 * k.amax(), "control: a stretch is no rigid motion");
    }
}

#[test]
fn total_mass_is_density_times_volume_and_an_inverted_element_is_refused() {
    for kind in CellKind::ALL {
        let mut x = one(kind);
        let m = matrices(kind, &x, 210e9, 0.3, 7850.0).expect("not inverted");
        let n = m.nodes();
        let total: f64 = (0..n * n).map(|k| m.mass(k / n, k % n)).sum();
        // The volume inside the faces by a fine midpoint rule on each, which shares no quadrature with the crate.
        let volume = volume_inside(kind, &x);
        assert!((total / (7850.0 * volume) - 1.0).abs() < 2e-3, "{kind:?}: {total} and {}", 7850.0 * volume);
        assert!((total / (7850.0 * volume * 1.01) - 1.0).abs() > 2e-3, "control: one per cent is seen");
        x.iter_mut().for_each(|x| x[0] = -x[0]);
        assert!(matches!(matrices(kind, &x, 210e9, 0.3, 7850.0), Err(det) if det <= 0.0), "{kind:?}");
    }
}

fn volume_inside(kind: CellKind, x: &[[f64; 3]]) -> f64 {
    const STEPS: usize = 60;
    let mut volume = 0.0;
    for local in faces(kind) {
        let p: Vec<Vector3<f64>> = local.iter().map(|&i| x[i].into()).collect();
        let square = face::corner_count(p.len()) == 4;
        for i in 0..STEPS {
            for j in 0..STEPS {
                let (a, b) = ((i as f64 + 0.5) / STEPS as f64, (j as f64 + 0.5) / STEPS as f64);
                // The square is folded onto the triangle: r = a, s = b (1 - a).
                let (at, w) =
                    if square { ([2.0 * a - 1.0, 2.0 * b - 1.0], 4.0) } else { ([a, b * (1.0 - a)], 1.0 - a) };
                let (n, d) = face::shape(p.len(), at);
                let (mut y, mut u, mut v) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
                for (k, p) in p.iter().enumerate() {
                    y += p * n[k];
                    u += p * d[k][0];
                    v += p * d[k][1];
                }
                volume += y.dot(&u.cross(&v)) / 3.0 * w / (STEPS * STEPS) as f64;
            }
        }
    }
    volume
}

#[test]
fn how_far_a_brick_is_from_a_parallelepiped_is_that_of_the_closed_form() {
    let corners = reference_nodes(CellKind::Hex8);
    let skewed: Vec<[f64; 3]> =
        corners.iter().map(|[r, s, t]| [2.0 * r + 0.3 * s, s - 0.4 * t, 0.2 * r + 3.0 * t]).collect();
    assert!(det_variation(&skewed) < 1e-14, "a parallelepiped: {}", det_variation(&skewed));
    // x = r (1 - c t), y = s (1 - c t), z = t: det J = (1 - c t)^2, largest at t = -1 / sqrt 3.
    for c in [0.05, 0.3] {
        let frustum: Vec<[f64; 3]> =
            corners.iter().map(|[r, s, t]| [r * (1.0 - c * t), s * (1.0 - c * t), *t]).collect();
        let exact = (1.0 + c / 3f64.sqrt()).powi(2) - 1.0;
        assert!((det_variation(&frustum) / exact - 1.0).abs() < 1e-12, "{c}: {}", det_variation(&frustum));
        assert!((det_variation(&frustum) - 2.0 * c).abs() > 1e-3, "control: not that of the corners");
    }
}
