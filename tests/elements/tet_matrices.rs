//! Stiffness and mass of the ten-node tetrahedron: rigid motions, patch test, mass and inertia.

use crate::support::dense::{full, rigid_field, symmetric_values};
use crate::support::tets::{curved, skewed};
use crate::support::tets::{tet10, tri6};
use crate::support::{SIDES, box_mesh, distort_inside, part};
use nalgebra::{DMatrix, Matrix3, Vector3};
use stiffmap::solid::assemble;

fn element_stiffness(x: &[[f64; 3]; 10]) -> DMatrix<f64> {
    let m = tet10::matrices(x, 210e9, 0.3, 7850.0).expect("not inverted");
    DMatrix::from_fn(30, 30, |i, j| m.stiffness(i / 3, j / 3)[i % 3][j % 3])
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
    let m = tet10::matrices(&x, 210e9, 0.3, 7850.0).expect("not inverted");
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
            assert!((m.mass(a, b) - expected).abs() < 1e-14 * mass, "{a} {b}: {} {expected}", m.mass(a, b));
        }
    }
}

#[test]
fn mass_of_a_curved_element_is_density_times_the_volume_inside_its_faces() {
    let x = curved();
    // Divergence theorem over the curved faces with a fine midpoint rule, which shares nothing with the crate's quadrature.
    let n = 400;
    let mut volume = 0.0;
    for face in tet10::faces() {
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
        let m = tet10::matrices(x, 210e9, 0.3, 7850.0).expect("not inverted");
        (0..100).map(|k| m.mass(k / 10, k % 10)).sum::<f64>()
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
    let modal_mass = full(&system.mass);
    let gram = system.rigid.transpose() * modal_mass * &system.rigid;
    assert!((gram[(0, 0)] / mass - 1.0).abs() < 1e-12 && (gram[(5, 5)] / system.inertia[(2, 2)] - 1.0).abs() < 1e-11);
    assert!(gram[(0, 5)].abs() < 1e-12 * mass, "rotations about the centre of mass carry no momentum");
}
