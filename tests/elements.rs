//! The ten-node tetrahedron and its six-node faces: shape functions, stiffness, mass.

mod support;

use nalgebra::{DMatrix, Matrix3, Vector3};
use proptest::prelude::*;
use stiffmap::element::{tet10, tri6};
use stiffmap::solid::assemble;
use support::dense::{full, rigid_field, symmetric_values};
use support::{SIDES, box_mesh, distort_inside, part};

const UNIT: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn straight(corners: [[f64; 3]; 4]) -> [[f64; 3]; 10] {
    let mut x = [[0.0; 3]; 10];
    x[..4].copy_from_slice(&corners);
    for (k, [a, b]) in SIDES.into_iter().enumerate() {
        x[4 + k] = std::array::from_fn(|c| 0.5 * (corners[a][c] + corners[b][c]));
    }
    x
}

fn skewed() -> [[f64; 3]; 10] {
    straight([[0.1, -0.2, 0.05], [1.3, 0.1, 0.2], [0.2, 0.9, -0.1], [0.3, 0.2, 1.4]])
}

/// The same with curved sides.
fn curved() -> [[f64; 3]; 10] {
    let mut x = skewed();
    for (k, node) in x[4..].iter_mut().enumerate() {
        for (c, value) in node.iter_mut().enumerate() {
            *value += 0.05 * (7.3 * (3 * k + c) as f64).sin();
        }
    }
    x
}

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
    for face in tet10::FACES {
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

fn element_stiffness(x: &[[f64; 3]; 10]) -> DMatrix<f64> {
    let m = tet10::matrices(x, 210e9, 0.3, 7850.0).expect("not inverted");
    DMatrix::from_fn(30, 30, |i, j| m.stiffness[i / 3][j / 3][i % 3][j % 3])
}

#[test]
fn an_element_has_exactly_six_rigid_motions_straight_or_curved() {
    for x in [skewed(), curved()] {
        let k = element_stiffness(&x);
        assert!((&k - k.transpose()).amax() < 1e-15 * k.amax() * 30.0);
        for q in 0..6 {
            let mut motion = [0.0; 6];
            motion[q] = 1.0;
            let force = &k * rigid_field(&x, [0.0; 3], motion);
            assert!(force.amax() < 1e-13 * k.amax(), "motion {q}: {:.1e}", force.amax() / k.amax());
        }
        let values = symmetric_values(&k);
        assert!(values[5].abs() < 1e-13 * values[29]);
        assert!(values[6] > 1e-4 * values[29], "and not a seventh: {:.1e}", values[6] / values[29]);
        // Control: a stretch is no rigid motion.
        let stretch = nalgebra::DVector::from_fn(30, |i, _| if i % 3 == 0 { x[i / 3][0] } else { 0.0 });
        assert!((&k * stretch).amax() > 1e-3 * k.amax());
    }
}

// Zienkiewicz and Taylor, or by the formula a! b! c! d! 6 V / (a + b + c + d + 3)! for barycentric monomials.
#[test]
fn consistent_mass_of_a_straight_element_is_the_closed_form() {
    let x = skewed();
    let m = tet10::matrices(&x, 210e9, 0.3, 7850.0).expect("not inverted").mass;
    let mass = 7850.0 * tet10::gradients(&x, [0.25; 3]).1 / 6.0;
    let touches = |side: [usize; 2], corner: usize| side.contains(&corner);
    for a in 0..10 {
        for b in 0..10 {
            let expected = match (a < 4, b < 4) {
                (true, true) => {
                    if a == b {
                        6.0
                    } else {
                        1.0
                    }
                }
                (true, false) => {
                    if touches(SIDES[b - 4], a) {
                        -4.0
                    } else {
                        -6.0
                    }
                }
                (false, true) => {
                    if touches(SIDES[a - 4], b) {
                        -4.0
                    } else {
                        -6.0
                    }
                }
                (false, false) => match SIDES[a - 4].iter().filter(|c| SIDES[b - 4].contains(c)).count() {
                    2 => 32.0,
                    1 => 16.0,
                    _ => 8.0,
                },
            } * mass
                / 420.0;
            assert!((m[a][b] - expected).abs() < 1e-14 * mass, "{a} {b}: {} {expected}", m[a][b]);
        }
    }
}

#[test]
fn mass_of_a_curved_element_is_density_times_the_volume_inside_its_faces() {
    let x = curved();
    // Divergence theorem over the curved faces with a fine midpoint rule, which shares nothing with the crate's quadrature.
    let n = 400;
    let mut volume = 0.0;
    for face in tet10::FACES {
        let p = face.map(|i| Vector3::from(x[i]));
        let mut cell = |r: f64, s: f64| {
            let (mut at, mut u, mut v) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
            for ((p, n), d) in p.iter().zip(tri6::shape([r, s])).zip(tri6::shape_derivatives([r, s])) {
                at += p * n;
                u += p * d[0];
                v += p * d[1];
            }
            volume += at.dot(&u.cross(&v)) / 3.0 * 0.5 / (n * n) as f64;
        };
        for i in 0..n {
            for j in 0..n - i {
                cell((i as f64 + 1.0 / 3.0) / n as f64, (j as f64 + 1.0 / 3.0) / n as f64);
                if i + j < n - 1 {
                    cell((i as f64 + 2.0 / 3.0) / n as f64, (j as f64 + 2.0 / 3.0) / n as f64);
                }
            }
        }
    }
    let total = |x: &[[f64; 3]; 10]| {
        let m = tet10::matrices(x, 210e9, 0.3, 7850.0).expect("not inverted").mass;
        m.iter().flatten().sum::<f64>()
    };
    assert!((total(&x) / (7850.0 * volume) - 1.0).abs() < 1e-5, "the midpoint rule's own error is some 1 / n^2");
    assert!((total(&skewed()) / (7850.0 * volume) - 1.0).abs() > 1e-2, "the straight element has another volume");
}

#[test]
fn an_inverted_or_folded_element_is_refused_with_its_determinant() {
    let mut x = skewed();
    x.swap(0, 1);
    assert!(matches!(tet10::matrices(&x, 210e9, 0.3, 7850.0), Err(det) if det < 0.0));
    let mut folded = skewed();
    folded[4] = folded[1];
    assert!(matches!(tet10::matrices(&folded, 210e9, 0.3, 7850.0), Err(det) if det <= 0.0));
}

#[test]
fn a_distorted_mesh_passes_the_patch_test() {
    let mut mesh = box_mesh([0.0; 3], [1.0, 1.0, 1.0], [3, 3, 3]);
    distort_inside(&mut mesh, 0.06);
    let system = assemble(&part("cube", &[], vec![]), &mesh).expect("assembles");
    assert_eq!(system.n_dof(), 3 * mesh.nodes.len());
    let outside: std::collections::BTreeSet<usize> = mesh.node_sets.values().flatten().copied().collect();
    let gradient = Matrix3::new(1.0, 0.4, -0.3, 0.2, -0.7, 0.5, 0.1, 0.6, 0.8);
    let force = |field: &dyn Fn(Vector3<f64>) -> Vector3<f64>| {
        let u = DMatrix::from_fn(system.n_dof(), 1, |i, _| field(mesh.nodes[i / 3].into())[i % 3]);
        let f = system.stiffness.multiply(&u);
        let inner = (0..mesh.nodes.len()).filter(|n| !outside.contains(n));
        inner.flat_map(|n| (0..3).map(move |c| 3 * n + c)).map(|i| f[(i, 0)].abs()).fold(0.0, f64::max) / f.amax()
    };
    let linear = force(&|x| gradient * x);
    assert!(linear < 1e-13, "{linear:.1e} of the surface forces");
    let quadratic = force(&|x| gradient * x + 0.1 * Vector3::new(x.x * x.x, x.y * x.z, 0.0));
    assert!(quadratic > 1e-4, "a field of varying stress leaves forces inside: {quadratic:.1e}");
}

#[test]
fn a_distorted_mesh_has_six_rigid_motions_and_the_mass_and_inertia_of_its_box() {
    let (size, from) = ([0.3, 0.2, 0.5], [0.1, -0.4, 2.0]);
    let mut mesh = box_mesh(from, size, [2, 2, 2]);
    distort_inside(&mut mesh, 0.01);
    let system = assemble(&part("box", &[], vec![]), &mesh).expect("assembles");
    let scale = system.stiffness.values().iter().fold(0.0f64, |m, v| m.max(v.abs()));
    assert_eq!(system.rigid.ncols(), 6);
    assert!(system.stiffness.multiply(&system.rigid).amax() < 1e-12 * scale);
    let values = symmetric_values(&full(&system.stiffness));
    assert!(values[5].abs() < 1e-13 * values[values.len() - 1] && values[6] > 1e-6 * values[values.len() - 1]);

    let mass = 7850.0 * size.iter().product::<f64>();
    assert!((system.total_mass / mass - 1.0).abs() < 1e-13);
    for c in 0..3 {
        assert!((system.centre_of_mass[c] - from[c] - 0.5 * size[c]).abs() < 1e-13);
        let across: f64 = (0..3).filter(|k| *k != c).map(|k| size[k] * size[k]).sum();
        // m x^2 about the origin is some 100 times the inertia about the centre, which costs two digits.
        assert!((system.inertia[(c, c)] / (mass * across / 12.0) - 1.0).abs() < 1e-11);
    }
    let modal_mass = support::dense::full(&system.mass);
    let gram = system.rigid.transpose() * modal_mass * &system.rigid;
    assert!((gram[(0, 0)] / mass - 1.0).abs() < 1e-12 && (gram[(5, 5)] / system.inertia[(2, 2)] - 1.0).abs() < 1e-11);
    assert!(gram[(0, 5)].abs() < 1e-12 * mass, "rotations about the centre of mass carry no momentum");
}
