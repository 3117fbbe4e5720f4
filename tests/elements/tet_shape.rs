//! The ten-node tetrahedron and its six-node faces: shape functions, gradients, faces.

use crate::support::tets::{curved, skewed, straight};
use crate::support::tets::{tet10, tri6};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

const UNIT: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

prop_compose! {
    fn inside()(u in 0.0..1.0f64, v in 0.0..1.0f64, w in 0.0..1.0f64) -> [f64; 3] {
        // Ordered numbers cut the unit interval into barycentric coordinates.
        let mut cuts = [u, v, w];
        cuts.sort_by(f64::total_cmp);
        [cuts[0], cuts[1] - cuts[0], cuts[2] - cuts[1]]
    }
}

#[test]
fn each_shape_function_is_one_at_its_own_node_and_zero_at_the_others() {
    for (i, at) in straight(UNIT).into_iter().enumerate() {
        for (j, n) in tet10::shape(at).into_iter().enumerate() {
            assert!((n - f64::from(u8::from(i == j))).abs() < 1e-15, "N{j} at {i}");
        }
    }
    let face = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];
    for (i, at) in face.into_iter().enumerate() {
        for (j, n) in tri6::shape(at).into_iter().enumerate() {
            assert!((n - f64::from(u8::from(i == j))).abs() < 1e-15, "N{j} at {i}");
        }
    }
}

proptest! {
    #[test]
    fn shape_functions_sum_to_one_and_their_derivatives_to_zero(at in inside()) {
        prop_assert!((tet10::shape(at).iter().sum::<f64>() - 1.0).abs() < 1e-14);
        prop_assert!((tri6::shape([at[0], at[1]]).iter().sum::<f64>() - 1.0).abs() < 1e-14);
        for c in 0..3 {
            prop_assert!(tet10::shape_derivatives(at).iter().map(|d| d[c]).sum::<f64>().abs() < 1e-14);
        }
        for c in 0..2 {
            let sum: f64 = tri6::shape_derivatives([at[0], at[1]]).iter().map(|d| d[c]).sum();
            prop_assert!(sum.abs() < 1e-14);
        }
    }

    // Central differences of quadratic functions are exact but for rounding, 1e-16 / h.
    #[test]
    fn derivatives_are_the_central_differences_of_the_shape_functions(at in inside()) {
        let h = 1e-2;
        let (d, elsewhere) = (tet10::shape_derivatives(at), tet10::shape_derivatives([at[0] + h, at[1], at[2]]));
        let (mut error, mut control) = (0.0f64, 0.0f64);
        for c in 0..3 {
            let moved = |s: f64| { let mut p = at; p[c] += s; tet10::shape(p) };
            let (up, down) = (moved(h), moved(-h));
            for i in 0..10 {
                let difference = (up[i] - down[i]) / (2.0 * h);
                error = error.max((difference - d[i][c]).abs());
                control = control.max((difference - elsewhere[i][c]).abs());
            }
        }
        prop_assert!(error < 1e-12, "{error:.1e}");
        prop_assert!(control > 1e-2, "derivatives at another point differ");
        let flat = [at[0], at[1]];
        let d = tri6::shape_derivatives(flat);
        for c in 0..2 {
            let moved = |s: f64| { let mut p = flat; p[c] += s; tri6::shape(p) };
            for ((up, down), d) in moved(h).into_iter().zip(moved(-h)).zip(d) {
                prop_assert!(((up - down) / (2.0 * h) - d[c]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn physical_gradients_on_a_curved_element_are_the_differences_along_its_own_lines(at in inside()) {
        let x = curved();
        let (g, _) = tet10::gradients(&x, at);
        let place = |p: [f64; 3]| -> Vector3<f64> {
            tet10::shape(p).iter().zip(&x).map(|(n, x)| Vector3::from(*x) * *n).sum()
        };
        let h = 1e-2;
        for c in 0..3 {
            let moved = |s: f64| { let mut p = at; p[c] += s; p };
            let dx = place(moved(h)) - place(moved(-h));
            let (up, down) = (tet10::shape(moved(h)), tet10::shape(moved(-h)));
            for i in 0..10 {
                let along = Vector3::from(g[i]).dot(&dx);
                prop_assert!((up[i] - down[i] - along).abs() < 1e-13);
            }
        }
        // A linear field is reproduced: sum of x_i (x) grad N_i is the unit matrix.
        let unit: Matrix3<f64> = g.iter().zip(&x).map(|(g, x)| Vector3::from(*x) * Vector3::from(*g).transpose()).sum();
        prop_assert!((unit - Matrix3::identity()).amax() < 1e-12);
    }
}

#[test]
fn faces_look_outward_and_their_midsides_follow_their_corners() {
    let x = skewed();
    let mut volume = 0.0;
    for face in tet10::faces() {
        let p = face.map(|i| Vector3::from(x[i]));
        let opposite = (0..4).find(|i| !face[..3].contains(i)).expect("a corner is left");
        let area = 0.5 * (p[1] - p[0]).cross(&(p[2] - p[0]));
        assert!(area.dot(&(p[0] - Vector3::from(x[opposite]))) > 0.0, "outward");
        assert!(0.5 * (p[2] - p[0]).cross(&(p[1] - p[0])).dot(&(p[0] - Vector3::from(x[opposite]))) < 0.0);
        for k in 0..3 {
            assert!((p[3 + k] - 0.5 * (p[k] + p[(k + 1) % 3])).norm() < 1e-15, "midside {k}");
        }
        let coordinates = face.map(|i| x[i]);
        assert!((tri6::area_element(&coordinates, [0.2, 0.3]) - 2.0 * area.norm()).abs() < 1e-14);
        volume += area.dot(&((p[0] + p[1] + p[2]) / 3.0)) / 3.0;
    }
    let (_, det) = tet10::gradients(&x, [0.25; 3]);
    assert!((volume - det / 6.0).abs() < 1e-15, "divergence theorem: {volume} and {}", det / 6.0);
}
