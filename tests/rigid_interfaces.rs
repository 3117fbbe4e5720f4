//! Rigid coupling of a surface beside the distributing one.

mod support;

use nalgebra::{DMatrix, DVector};
use stiffmap::machine::{Interface, SurfaceCoupling};
use stiffmap::solid::{SolidError, assemble};
use support::dense::{eigenvalues, full};
use support::{box_mesh, on, part};

/// Frequencies of a clamped block whose far face hangs on springs, the face being rigid or not.
fn on_springs(coupling: SurfaceCoupling, stiffness: f64) -> Vec<f64> {
    let mesh = box_mesh([0.0; 3], [0.1, 0.1, 0.1], [1, 1, 2]);
    let face = Interface { coupling, ..on("ZMAX") };
    let system = assemble(&part("block", &["ZMIN"], vec![face]), &mesh).expect("assembles");
    let w = system.columns(&system.interfaces[0].rows);
    let scale = DVector::from_vec(vec![1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3]) * stiffness;
    let k = full(&system.stiffness) + &w * DMatrix::from_diagonal(&scale) * w.transpose();
    eigenvalues(&k, &full(&system.mass), 0.0)
}

// A rigid face is the distributing model restricted to displacements that keep it rigid, so by the
// minimax principle each of its eigenvalues is at least the distributing one.
#[test]
fn rigid_coupling_bounds_each_frequency_from_above_and_distributing_from_below() {
    let stiffness = 1e10;
    let (soft, hard) =
        (on_springs(SurfaceCoupling::Distributing, stiffness), on_springs(SurfaceCoupling::Rigid, stiffness));
    assert!(hard.len() < soft.len());
    for (r, (s, h)) in soft.iter().zip(&hard).enumerate() {
        assert!(h >= &(s * (1.0 - 1e-10)), "mode {r}: {s} {h}");
    }
    assert!(hard[0] > 1.001 * soft[0], "and the bound is not empty: {} {}", soft[0], hard[0]);
    let without = on_springs(SurfaceCoupling::Rigid, 1.0);
    assert!(without[0] < soft[0], "control: a rigid face without its springs lies below");
}

#[test]
fn a_rigid_face_and_a_distributing_one_read_the_same_rigid_motion() {
    let mesh = box_mesh([0.0; 3], [0.1, 0.1, 0.3], [1, 1, 2]);
    for coupling in [SurfaceCoupling::Distributing, SurfaceCoupling::Rigid] {
        let face = Interface { coupling, ..on("ZMAX") };
        let system = assemble(&part("block", &[], vec![face]), &mesh).expect("assembles");
        let motion = &system.interfaces[0];
        let read = system.columns(&motion.rows).transpose() * &system.rigid;
        // The face's centroid lies 0.15 m above the centre of mass: turning about x moves it along -y, about y along x.
        let mut expected = DMatrix::identity(6, 6);
        (expected[(0, 4)], expected[(1, 3)]) = (0.15, -0.15);
        assert!((read - &expected).amax() < 1e-12);
        let strain = system.stiffness.multiply(&system.rigid).amax();
        let scale = system.stiffness.values().iter().fold(0.0f64, |m, v| m.max(v.abs()));
        assert!(strain < 1e-12 * scale, "rigid motions strain nothing: {strain:.1e} of {scale:.1e}");
    }
}

#[test]
fn two_rigid_faces_that_share_a_node_are_refused() {
    let mesh = box_mesh([0.0; 3], [0.1; 3], [1; 3]);
    let rigid = |set: &str| Interface { coupling: SurfaceCoupling::Rigid, ..on(set) };
    let refused = |clamped: &[&str], list: Vec<Interface>| assemble(&part("block", clamped, list), &mesh).err();
    assert!(matches!(refused(&[], vec![rigid("ZMAX"), rigid("XMAX")]), Some(SolidError::RigidOverlap { .. })));
    assert!(matches!(refused(&["XMIN"], vec![rigid("ZMAX")]), Some(SolidError::RigidOverlap { .. })));
    assert!(refused(&[], vec![rigid("ZMAX"), rigid("ZMIN")]).is_none());
}
