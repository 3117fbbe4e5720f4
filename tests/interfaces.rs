//! Interfaces: the area-weighted rigid motion of a surface, clipped surfaces.

mod support;

use nalgebra::{DMatrix, SMatrix, Vector3};
use proptest::prelude::*;
use std::f64::consts::PI;
use std::sync::OnceLock;
use stiffmap::machine::{Interface, Region};
use stiffmap::mesh::Mesh;
use stiffmap::solid::{InterfaceMotion, SolidError, Surface, interface_motions, rotation_arm};
use support::dense::rigid_field;
use support::{box_mesh, on, part, slab};

const SIZE: [f64; 3] = [0.3, 0.2, 0.5];

fn block() -> &'static (Mesh, Surface) {
    static BLOCK: OnceLock<(Mesh, Surface)> = OnceLock::new();
    BLOCK.get_or_init(|| {
        let mesh = box_mesh([0.1, -0.4, 2.0], SIZE, [3, 2, 4]);
        let surface = Surface::of_node_set(&mesh, mesh.node_set("YMAX").expect("set"));
        (mesh, surface)
    })
}

fn everywhere() -> Region {
    slab(0, f64::NEG_INFINITY, f64::INFINITY)
}

fn area(weights: &[(usize, f64)]) -> f64 {
    weights.iter().map(|(_, w)| w).sum()
}

fn motion_of(surface: &Surface, nodes: &[[f64; 3]], region: &Region) -> Option<InterfaceMotion> {
    InterfaceMotion::from_weights(&surface.weights_within(region), |n| nodes[n])
}

/// q from the README's formula, term by term.
fn plain_rows(weights: &[(usize, f64)], nodes: &[[f64; 3]], reference: [f64; 3]) -> DMatrix<f64> {
    let block = |n: usize| {
        let mut r = SMatrix::<f64, 3, 6>::zeros();
        r.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        let arm = Vector3::from(nodes[n]) - Vector3::from(reference);
        r.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-arm.cross_matrix()));
        r
    };
    let gram: SMatrix<f64, 6, 6> = weights.iter().map(|(n, w)| block(*n).transpose() * block(*n) * *w).sum();
    let inverse = gram.try_inverse().expect("the nodes fix a rigid motion");
    let mut rows = DMatrix::zeros(6, 3 * weights.len());
    for (k, (n, w)) in weights.iter().enumerate() {
        rows.view_mut((0, 3 * k), (6, 3)).copy_from(&(inverse * block(*n).transpose() * *w));
    }
    rows
}

fn motion() -> impl Strategy<Value = [f64; 6]> {
    prop::array::uniform6(-1.0..1.0f64)
}

proptest! {
    #[test]
    fn distributing_rows_reproduce_any_rigid_motion_over_any_window(
        q in motion(), centre in 2.05..2.45f64, length in 0.02..0.3f64,
    ) {
        let (mesh, surface) = block();
        let motion = motion_of(surface, &mesh.nodes, &slab(2, centre - 0.5 * length, centre + 0.5 * length)).expect("area");
        let points: Vec<[f64; 3]> = motion.rows.nodes.iter().map(|&n| mesh.nodes[n]).collect();
        let read = &motion.rows.rows * rigid_field(&points, motion.centroid, q);
        for c in 0..6 {
            prop_assert!((read[c] - q[c]).abs() < 1e-11, "{c}: {} {}", read[c], q[c]);
        }
        // Control: the same displacements are another motion at another point, as rotation_arm says.
        let elsewhere = rigid_field(&points, [motion.centroid[0], motion.centroid[1], motion.centroid[2] + 0.1], q);
        let moved = &motion.rows.rows * elsewhere;
        let expected: f64 = rotation_arm([1.0, 0.0, 0.0], [0.0, 0.0, -0.1]).iter().zip(q).map(|(a, b)| a * b).sum();
        prop_assert!((moved[0] - expected).abs() < 1e-11 && (moved[0] - q[0]).abs() >= 0.099 * q[4].abs());
    }

    #[test]
    fn distributing_rows_are_the_formula_of_the_readme(from in 2.0..2.2f64, length in 0.05..0.25f64) {
        let (mesh, surface) = block();
        let weights = surface.weights_within(&slab(2, from, from + length));
        let motion = InterfaceMotion::from_weights(&weights, |n| mesh.nodes[n]).expect("area");
        let plain = plain_rows(&weights, &mesh.nodes, motion.centroid);
        prop_assert!((&plain - &motion.rows.rows).amax() < 1e-10 * plain.amax());
        let mut equal = weights.clone();
        equal.iter_mut().for_each(|(_, w)| *w = 1.0);
        let unweighted = plain_rows(&equal, &mesh.nodes, motion.centroid);
        prop_assert!((&unweighted - &motion.rows.rows).amax() > 1e-2 * plain.amax(), "equal weights are another motion");
    }

    #[test]
    fn windows_that_meet_add_up_to_the_whole_and_each_has_its_own_area(cut in 2.0..2.5f64) {
        let (_, surface) = block();
        let whole = surface.weights_within(&everywhere());
        prop_assert!((area(&whole) - SIZE[0] * SIZE[2]).abs() < 1e-14);
        let (low, high) = (surface.weights_within(&slab(2, f64::NEG_INFINITY, cut)), surface.weights_within(&slab(2, cut, f64::INFINITY)));
        prop_assert!((area(&low) - SIZE[0] * (cut - 2.0)).abs() < 1e-13, "a cut face counts with the part inside");
        for (node, w) in &whole {
            let of = |list: &[(usize, f64)]| list.iter().find(|(n, _)| n == node).map_or(0.0, |(_, w)| *w);
            prop_assert!((of(&low) + of(&high) - w).abs() < 1e-14, "node {node}");
        }
        let middle = 0.5 * (cut + 2.0);
        let slab_weights = surface.weights_in_slab([0.0, 0.0, 1.0], middle, cut - 2.0);
        prop_assert!((area(&slab_weights) - area(&low)).abs() < 1e-13);
        prop_assert!((area(&low) - area(&whole)).abs() > 1e-9 || cut > 2.4999, "control: a window is not the whole");
    }

    #[test]
    fn the_centroid_of_a_clipped_rectangle_is_its_middle(x in 0.1..0.3f64, width in 0.01..0.1f64, z in 2.0..2.3f64, height in 0.01..0.2f64) {
        let (mesh, surface) = block();
        let region = Region { min: [x, -1.0, z], max: [x + width, 1.0, z + height] };
        let motion = motion_of(surface, &mesh.nodes, &region).expect("area");
        let middle = [x + 0.5 * width, -0.2, z + 0.5 * height];
        for c in 0..3 {
            prop_assert!((motion.centroid[c] - middle[c]).abs() < 1e-11, "{:?} {middle:?}", motion.centroid);
        }
        prop_assert!((motion.area / (width * height) - 1.0).abs() < 1e-10);
    }
}

/// A quarter of a tube of inner radius R, bent from a box; YMIN is its inner surface.
fn tube(cells: usize) -> Mesh {
    let (radius, wall, length) = (0.05, 0.02, 0.1);
    let mut mesh = box_mesh([0.0; 3], [0.5 * PI, wall, length], [cells, 1, 2]);
    for x in &mut mesh.nodes {
        let (angle, r) = (x[0] - 0.25 * PI, radius + x[1]);
        *x = [r * angle.sin(), r * angle.cos(), x[2]];
    }
    mesh
}

#[test]
fn area_and_centroid_of_a_cylinders_quarter_converge_to_the_closed_form() {
    let (radius, length) = (0.05, 0.1);
    let height = radius * (0.25 * PI).sin() / (0.25 * PI);
    let errors = [2, 4, 8].map(|cells| {
        let mesh = tube(cells);
        let surface = Surface::of_node_set(&mesh, &mesh.node_sets["YMIN"]);
        let motion = motion_of(&surface, &mesh.nodes, &everywhere()).expect("area");
        assert!(motion.centroid[0].abs() < 1e-5 * radius && (motion.centroid[2] - 0.05).abs() < 1e-5);
        [(motion.area / (0.5 * PI * radius * length) - 1.0).abs(), (motion.centroid[1] / height - 1.0).abs()]
    });
    println!("{errors:?}");
    for c in 0..2 {
        assert!(errors[2][c] < 3e-6, "{errors:?}");
        assert!(
            errors[1][c] > 8.0 * errors[2][c],
            "six-node faces follow the arc with the fourth power of h: {errors:?}"
        );
    }
    let flat = 2.0 * radius * (PI / 8.0).sin() / (0.25 * PI * radius);
    assert!((flat - 1.0).abs() > 1e-2, "control: two flat facets would miss the area by 2.6 %");
}

#[test]
fn a_face_counts_only_with_all_its_nodes_and_only_outside() {
    let (mesh, surface) = block();
    let all: Vec<usize> = (0..mesh.nodes.len()).collect();
    let skin = area(&Surface::of_node_set(mesh, &all).weights_within(&everywhere()));
    let whole = 2.0 * (SIZE[0] * SIZE[1] + SIZE[1] * SIZE[2] + SIZE[2] * SIZE[0]);
    assert!((skin - whole).abs() < 1e-13, "faces between two elements do not count: {skin} {whole}");
    let midside = surface.faces[0].nodes[3];
    let without: Vec<usize> = mesh.node_sets["YMAX"].iter().copied().filter(|n| *n != midside).collect();
    let fewer = Surface::of_node_set(mesh, &without).faces.len();
    assert!(fewer < surface.faces.len() && fewer + 2 >= surface.faces.len(), "a midside node carries one or two faces");
}

#[test]
fn a_node_set_without_a_face_and_a_window_without_area_are_refused() {
    let mut mesh = block().0.clone();
    mesh.node_sets.insert("EDGE".into(), vec![0, 1, 2, 3]);
    let refused = |interface: Interface| interface_motions(&part("block", &[], vec![interface]), &mesh).err();
    let edge = refused(on("EDGE"));
    assert!(matches!(&edge, Some(SolidError::NoSurface { interface, .. }) if interface == "EDGE"), "{edge:?}");
    let window = refused(Interface { within: Some(slab(2, 3.0, 4.0)), ..on("YMAX") });
    let Some(SolidError::NoSurface { reason, .. }) = &window else { panic!("{window:?}") };
    assert!(reason.contains("2.0000") && reason.contains("2.5000"), "says what the set spans: {reason}");
    assert!(matches!(refused(on("NOWHERE")), Some(SolidError::UnknownSet { .. })));
    assert!(refused(on("YMAX")).is_none());
    assert!(refused(Interface { within: Some(slab(2, 2.2, 2.3)), ..on("YMAX") }).is_none());
}
