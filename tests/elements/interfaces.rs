//! Interfaces on faces of every kind: area weights, clipping, surfaces by element faces.

use crate::support::grids::grid;
use crate::support::{on, part, slab};
use stiffmap::mesh::{CellFace, CellKind};
use stiffmap::solid::{Surface, assemble, interface_motions};

const SIZE: [f64; 3] = [0.3, 0.2, 0.5];

#[test]
fn weights_of_a_face_are_the_integrals_of_its_shape_functions() {
    // Of a rectangle and of a triangle of area A, from integrating by hand: corner and midside shares of A.
    for (kind, corner, midside) in [
        (CellKind::Hex8, 1.0 / 4.0, 0.0),
        (CellKind::Hex20, -1.0 / 12.0, 1.0 / 3.0),
        (CellKind::Tet4, 1.0 / 3.0, 0.0),
        (CellKind::Tet10, 0.0, 1.0 / 3.0),
    ] {
        let mesh = grid(kind, SIZE, [1; 3]);
        let surface = Surface::of_node_set(&mesh, mesh.node_set("ZMAX").expect("a face"));
        let one = Surface { faces: surface.faces[..1].to_vec() };
        let weights = one.weights_within(&slab(0, -1.0, 1.0));
        let area: f64 = weights.iter().map(|(_, w)| w).sum();
        assert!((area * surface.faces.len() as f64 - SIZE[0] * SIZE[1]).abs() < 1e-15);
        for (node, w) in weights {
            let place = one.faces[0].nodes.iter().position(|n| *n == node).expect("a node of the face");
            let share = if place < one.faces[0].corners().len() { corner } else { midside };
            assert!((w / area - share).abs() < 1e-14, "{kind:?}, node {place}: {} and {share}", w / area);
        }
    }
}

#[test]
fn every_kind_gives_an_interface_its_area_centroid_and_rigid_motion() {
    for kind in CellKind::ALL {
        let mesh = grid(kind, SIZE, [3, 2, 4]);
        let mut clipped = on("YMAX");
        (clipped.name, clipped.within) = ("clipped".into(), Some(slab(2, 0.21, 0.33)));
        let body = part("box", &[], vec![on("YMAX"), clipped]);
        let motions = interface_motions(&body, &mesh).expect("surfaces");
        for ((_, motion), (height, middle)) in motions.iter().zip([(0.5, 0.25), (0.12, 0.27)]) {
            assert!((motion.area / (SIZE[0] * height) - 1.0).abs() < 1e-12, "{kind:?}: {}", motion.area);
            let centroid = [0.15, 0.2, middle];
            assert!(motion.centroid.iter().zip(centroid).all(|(a, b)| (a - b).abs() < 1e-12), "{kind:?}");
            let system = assemble(&body, &mesh).expect("assembles");
            let q = system.columns(&motion.rows).transpose() * &system.rigid;
            // Translations of the whole are translations of the interface, rotations its rotations.
            for i in 0..6 {
                for j in 0..6 {
                    let same = f64::from(u8::from(i == j));
                    if j < 3 || i >= 3 {
                        assert!((q[(i, j)] - same).abs() < 1e-10, "{kind:?}: {q}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_surface_of_element_faces_serves_as_an_interface_when_no_node_set_has_its_name() {
    let mut mesh = grid(CellKind::Hex20Reduced, SIZE, [1, 1, 2]);
    mesh.surfaces.insert("LID".into(), vec![CellFace { cell: 1, face: 1 }]);
    let motions = interface_motions(&part("box", &[], vec![on("lid"), on("ZMAX")]), &mesh).expect("surfaces");
    assert_eq!(motions[0].0, motions[1].0);
    mesh.surfaces.insert("LID".into(), vec![CellFace { cell: 1, face: 3 }]);
    let motions = interface_motions(&part("box", &[], vec![on("LID"), on("ZMAX")]), &mesh).expect("surfaces");
    assert_ne!(motions[0].0, motions[1].0, "control: another face");
    let message = interface_motions(&part("box", &[], vec![on("LIT")]), &mesh).expect_err("unknown").to_string();
    assert!(message.contains("LID") && message.contains("ZMAX"), "{message}");
}
