//! Meshes of every kind: patch test, rigid motions, mass and inertia, mixed meshes.

use crate::support::dense::{full, symmetric_values};
use crate::support::grids::{distort, grid, mixed_grid};
use crate::support::part;
use nalgebra::{DMatrix, Matrix3, Vector3};
use stiffmap::machine::Support;
use stiffmap::mesh::{CellKind, Mesh};
use stiffmap::solid::{SolidError, assemble};

/// Largest force on the nodes inside, relative to those on the surface, under a given field.
fn inner_force(mesh: &Mesh, field: &dyn Fn(Vector3<f64>) -> Vector3<f64>) -> f64 {
    let system = assemble(&part("cube", &[], vec![]), mesh).expect("assembles");
    let outside: std::collections::BTreeSet<usize> = mesh.node_sets.values().flatten().copied().collect();
    // Incompatible modes, whose unknowns stand behind those of the nodes, take no part in a linear field.
    let u =
        DMatrix::from_fn(system.n_dof(), 1, |i, _| mesh.nodes.get(i / 3).map_or(0.0, |x| field((*x).into())[i % 3]));
    let f = system.stiffness.multiply(&u);
    let inner = (0..system.n_dof()).filter(|i| !outside.contains(&(i / 3)));
    inner.map(|i| f[(i, 0)].abs()).fold(0.0, f64::max) / f.amax()
}

fn patch_test(name: &str, mesh: &Mesh) {
    let gradient = Matrix3::new(1.0, 0.4, -0.3, 0.2, -0.7, 0.5, 0.1, 0.6, 0.8);
    let linear = inner_force(mesh, &|x| gradient * x);
    assert!(linear < 1e-12, "{name}: {linear:.1e} of the surface forces");
    let quadratic = inner_force(mesh, &|x| gradient * x + Vector3::new(x.x * x.x, x.y * x.z, 0.0));
    assert!(quadratic > 1e-4, "{name}, control: a field of varying stress leaves forces inside: {quadratic:.1e}");
}

#[test]
fn distorted_meshes_of_every_kind_pass_the_patch_test() {
    for kind in CellKind::ALL {
        let mut mesh = grid(kind, [1.0; 3], [3; 3]);
        distort(&mut mesh, 0.06);
        patch_test(kind.name(), &mesh);
    }
}

#[test]
fn a_mesh_of_bricks_and_wedges_passes_the_patch_test() {
    for (brick, wedge) in [
        (CellKind::Hex20, CellKind::Wedge15),
        (CellKind::Hex20Reduced, CellKind::Wedge15),
        (CellKind::Hex8, CellKind::Wedge6),
        (CellKind::Hex8Incompatible, CellKind::Wedge6),
    ] {
        // Columns of wedges and of bricks share quadrilateral faces.
        let mut mesh = mixed_grid([1.0; 3], [3; 3], |[i, j, _]| if (i + j) % 2 == 0 { brick } else { wedge });
        distort(&mut mesh, 0.05);
        patch_test(&format!("{} and {}", brick.name(), wedge.name()), &mesh);
    }
}

#[test]
fn distorted_meshes_have_six_rigid_motions_and_the_mass_and_inertia_of_their_box() {
    let size = [0.3, 0.2, 0.5];
    for kind in CellKind::ALL {
        let mut mesh = grid(kind, size, [2; 3]);
        distort(&mut mesh, 0.01);
        let system = assemble(&part("box", &[], vec![]), &mesh).expect("assembles");
        assert_eq!(system.rigid.ncols(), 6);
        let scale = system.stiffness.values().iter().fold(0.0f64, |m, v| m.max(v.abs()));
        assert!(system.stiffness.multiply(&system.rigid).amax() < 1e-12 * scale, "{kind:?}");
        let values = symmetric_values(&full(&system.stiffness));
        let last = values[values.len() - 1];
        assert!(values[5].abs() < 1e-13 * last && values[6] > 1e-6 * last, "{kind:?}: {:?}", &values[..8]);

        let mass = 7850.0 * size.iter().product::<f64>();
        assert!((system.total_mass / mass - 1.0).abs() < 1e-12, "{kind:?}");
        // x^2 det J is beyond the two points a side of the bricks where the mesh is distorted, by this little.
        let bound = if kind.corner_count() == 8 && kind != CellKind::Hex20 { 2e-5 } else { 1e-11 };
        for c in 0..3 {
            assert!((system.centre_of_mass[c] - 0.5 * size[c]).abs() < 1e-5 * size[c], "{kind:?}");
            let across: f64 = (0..3).filter(|k| *k != c).map(|k| size[k] * size[k]).sum();
            let off = (system.inertia[(c, c)] / (mass * across / 12.0) - 1.0).abs();
            assert!(off < bound, "{kind:?}: inertia {c} off by {off:.1e}");
            assert!((system.inertia[(c, c)] / (mass * across / 11.0) - 1.0).abs() > 1e-2, "control");
        }
        let gram = system.rigid.transpose() * full(&system.mass) * &system.rigid;
        assert!((gram[(0, 0)] / mass - 1.0).abs() < 1e-12);
        assert!((gram[(5, 5)] / system.inertia[(2, 2)] - 1.0).abs() < 1e-10);
    }
}

#[test]
fn single_directions_are_held_and_the_motions_left_are_rigid() {
    let mesh = grid(CellKind::Hex20, [0.4, 0.4, 0.1], [2, 2, 1]);
    let held = |supports: &[(&str, [bool; 3])]| {
        let mut body = part("plate", &[], vec![]);
        body.supported = supports.iter().map(|(set, d)| Support { nodes: set.to_string(), directions: *d }).collect();
        assemble(&body, &mesh)
    };
    for (supports, left) in [
        (vec![("ZMIN", [false, false, true])], 3),
        (vec![("ZMIN", [false, false, true]), ("XMIN", [true, false, false])], 1),
        (vec![("ZMIN", [true, true, false])], 3),
        (vec![("ZMIN", [true, true, false]), ("ZMAX", [true, true, false])], 1),
        (vec![("ZMIN", [true; 3])], 0),
        (vec![("XMIN", [true, false, false]), ("YMIN", [false, true, false]), ("ZMIN", [false, false, true])], 0),
    ] {
        let system = held(&supports).expect("assembles");
        let fixed: usize = {
            let mut all = std::collections::BTreeSet::new();
            for (set, d) in &supports {
                let nodes = mesh.node_set(set).expect("a face");
                all.extend(nodes.iter().flat_map(|&n| (0..3).filter(|&c| d[c]).map(move |c| (n, c))));
            }
            all.len()
        };
        assert_eq!(system.n_dof(), 3 * mesh.nodes.len() - fixed, "{supports:?}");
        assert_eq!(system.rigid.ncols(), left, "{supports:?}");
        let scale = system.stiffness.values().iter().fold(0.0f64, |m, v| m.max(v.abs()));
        assert!(system.stiffness.multiply(&system.rigid).iter().all(|f| f.abs() < 1e-12 * scale));
        let values = symmetric_values(&full(&system.stiffness));
        assert!(values[left] > 1e-9 * values[values.len() - 1], "{supports:?}: no motion more is free");
        // Held directions stay at rest in what is given back for the nodes.
        let nodes: Vec<usize> = (0..mesh.nodes.len()).collect();
        let u = system.displacements(&nodes, &DMatrix::from_element(system.n_dof(), 1, 1.0));
        assert_eq!(u.iter().filter(|u| **u == 0.0).count(), fixed);
    }
    assert!(matches!(held(&[("FLOOR", [true; 3])]), Err(SolidError::UnknownSet { .. })));
}

#[test]
fn a_part_on_single_supports_is_reduced_with_the_motions_that_are_left() {
    let mesh = grid(CellKind::Hex20, [0.4, 0.4, 0.1], [3, 3, 1]);
    let mut body = part("plate", &[], vec![crate::support::on("ZMAX")]);
    body.supported = vec![Support { nodes: "ZMIN".into(), directions: [false, false, true] }];
    let system = assemble(&body, &mesh).expect("assembles");
    let exact = crate::support::dense::frequencies(&full(&system.stiffness), &full(&system.mass), 1e8);
    for component in [crate::support::craig_bampton(20), crate::support::free_interface(20)] {
        let reduced = crate::support::superelement(&body, &mesh, component);
        let found: Vec<f64> = reduced.eigenvalues.iter().map(|l| l.max(0.0).sqrt() / std::f64::consts::TAU).collect();
        assert!(found[2] < 1e-3 * exact[3], "three motions in the plane: {:?}", &found[..4]);
        let off = crate::support::worst_ratio(&found[3..8], &exact[3..8]);
        assert!(off < 1e-4, "{:?}: {off:.1e} of {:?} {:?}", component.method, &found[..8], &exact[..8]);
        assert!(crate::support::worst_ratio(&found[4..8], &exact[3..7]) > 1e-3, "control: a mode is lost");
    }
}
