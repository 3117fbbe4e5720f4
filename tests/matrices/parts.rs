//! A part read from its own matrices is the part.

use super::support::{box_mesh, craig_bampton, on, part, superelement, worst_ratio};
use super::{by_matrices, files, folder, write_part};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::path::Path;
use stiffmap::export::matrix_market::write_sparse;
use stiffmap::linalg::SparseBuilder;
use stiffmap::machine::{InterfaceNodes, InterfaceWeights, MeshUnits, Part, SurfaceCoupling};
use stiffmap::mesh::{Mesh, read_part_mesh};
use stiffmap::reduction::Superelement;

/// A free arm with interfaces at both ends.
fn arm() -> (Part, Mesh) {
    (part("arm", &[], vec![on("XMIN"), on("XMAX")]), box_mesh([0.1, 0.0, 0.3], [0.3, 0.1, 0.1], [4, 1, 1]))
}

/// Static flexibility between all interface motions on the elastic modes.
fn flexibility(s: &Superelement) -> DMatrix<f64> {
    let rows: Vec<_> = s.interfaces.iter().flat_map(|i| i.rows.row_iter().map(|r| r.into_owned())).collect();
    let rows = DMatrix::from_rows(&rows);
    let inverse = DVector::from_iterator(s.n(), s.eigenvalues.iter().map(|l| if *l > 0.0 { 1.0 / l } else { 0.0 }));
    &rows * DMatrix::from_diagonal(&inverse) * rows.transpose()
}

/// Largest relative difference of modes and flexibility, and whether both are free.
fn difference(a: &Superelement, b: &Superelement) -> f64 {
    let free = |s: &Superelement| s.eigenvalues.iter().take_while(|l| **l == 0.0).count();
    assert_eq!(free(a), free(b));
    let first = free(a);
    // Of those beyond the component modes the last digits depend on rounding.
    let modes = worst_ratio(&a.eigenvalues[first..first + 12], &b.eigenvalues[first..first + 12]);
    eprintln!(
        "modes {modes:.1e}, flexibility {:.1e}",
        (flexibility(a) - flexibility(b)).norm() / flexibility(a).norm()
    );
    let (fa, fb) = (flexibility(a), flexibility(b));
    let inertia = (a.inertia - b.inertia).norm() / a.inertia.norm();
    let centre = (0..3).map(|c| (a.centre_of_mass[c] - b.centre_of_mass[c]).abs()).sum::<f64>();
    modes.max((&fa - &fb).norm() / fa.norm()).max((a.mass / b.mass - 1.0).abs()).max(inertia).max(centre)
}

fn read(part: &Part) -> Superelement {
    let mesh = read_part_mesh(part).unwrap_or_else(|e| panic!("{e}")).mesh;
    superelement(part, &mesh, craig_bampton(20))
}

#[test]
fn matrices_with_weighted_node_sets_are_the_part() {
    let ((part, mesh), folder) = (arm(), folder());
    let whole = superelement(&part, &mesh, craig_bampton(20));
    write_part(folder.path(), &part, &mesh);
    let given = read(&by_matrices(&part, files(folder.path(), &part)));
    let seen = difference(&whole, &given);
    assert!(seen < 1e-8, "{seen:.1e}");
    // Negative control: equal weights in place of areas are another interface.
    let mut equal = files(folder.path(), &part);
    equal.interfaces[1].weights = InterfaceWeights::Equal;
    assert!(difference(&whole, &read(&by_matrices(&part, equal))) > 1e-4);
}

#[test]
fn a_clamped_part_and_one_that_is_clamped_in_the_machine_file_agree() {
    let (free, mesh) = arm();
    let clamped = part("arm", &["XMIN"], vec![on("XMAX")]);
    let whole = superelement(&clamped, &mesh, craig_bampton(20));
    let (held, loose) = (folder(), folder());
    write_part(held.path(), &clamped, &mesh);
    let given = read(&by_matrices(&clamped, files(held.path(), &clamped)));
    let seen = difference_of_modes(&whole, &given);
    assert!(seen < 1e-8, "{seen:.1e}");
    // The free part's matrices, with the set of one interface clamped.
    write_part(loose.path(), &free, &mesh);
    let mut again = by_matrices(&clamped, files(loose.path(), &clamped));
    again.clamped = vec!["XMIN".into()];
    let seen = difference_of_modes(&whole, &read(&again));
    assert!(seen < 1e-8, "{seen:.1e}");
}

fn difference_of_modes(a: &Superelement, b: &Superelement) -> f64 {
    assert!(a.eigenvalues[0] > 0.0 && b.eigenvalues[0] > 0.0);
    let (fa, fb) = (flexibility(a), flexibility(b));
    worst_ratio(&a.eigenvalues[..20], &b.eigenvalues[..20]).max((&fa - &fb).norm() / fa.norm())
}

#[test]
fn with_a_mesh_the_faces_weigh_and_rigid_interfaces_are_rigid() {
    let ((mut part, mesh), folder) = (arm(), folder());
    write_part(folder.path(), &part, &mesh);
    part.interfaces[0].coupling = SurfaceCoupling::Rigid;
    let whole = superelement(&part, &mesh, craig_bampton(20));
    let mut given = files(folder.path(), &part);
    given.sets = None;
    given.with_mesh = true;
    let given = by_matrices(&part, given);
    // The mesh as its file would give it, and the matrices as read for a part without a mesh.
    let mut both = mesh.clone();
    let sets = files(folder.path(), &part);
    let mut matrices = read_part_mesh(&by_matrices(&part, sets)).expect("reads").mesh.matrices.expect("matrices");
    matrices.interfaces = vec![stiffmap::matrix::GivenNodes::Faces; 2];
    both.matrices = Some(matrices);
    let seen = difference(&whole, &superelement(&given, &both, craig_bampton(20)));
    assert!(seen < 1e-8, "{seen:.1e}");
    part.interfaces[0].coupling = SurfaceCoupling::Distributing;
    let loose = superelement(&part, &mesh, craig_bampton(20));
    assert!(worst_ratio(&loose.eigenvalues[6..26], &whole.eigenvalues[6..26]) > 1e-4);
}

#[test]
fn millimetres_and_tonnes_are_converted() {
    let ((part, mesh), folder) = (arm(), folder());
    let whole = superelement(&part, &mesh, craig_bampton(20));
    let system = write_part(folder.path(), &part, &mesh);
    // N/mm, t, mm.
    let ones = vec![1.0; system.n_dof()];
    write_sparse(&folder.path().join("k.mtx"), &system.stiffness.clone().scaled(1e-3, &ones)).unwrap();
    write_sparse(&folder.path().join("m.mtx"), &system.mass.clone().scaled(1e-3, &ones)).unwrap();
    let table = std::fs::read_to_string(folder.path().join("dofs.csv")).unwrap();
    let in_mm = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let x: Vec<String> =
            fields[2..].iter().map(|f| f.parse::<f64>().map_or((*f).into(), |v| (1e3 * v).to_string())).collect();
        format!("{},{},{}\n", fields[0], fields[1], x.join(","))
    };
    std::fs::write(folder.path().join("dofs.csv"), table.lines().map(in_mm).collect::<String>()).unwrap();
    let mut given = by_matrices(&part, files(folder.path(), &part));
    given.mesh_units = MeshUnits::MILLIMETRE_TONNE_SECOND;
    let seen = difference(&whole, &read(&given));
    assert!(seen < 1e-8, "{seen:.1e}");
    given.mesh_units = MeshUnits::METRE_KILOGRAM_SECOND;
    let wrong = std::panic::catch_unwind(|| difference(&whole, &read(&given)));
    assert!(wrong.is_err() || wrong.is_ok_and(|d| d > 1e-3));
}

/// Stiffness and mass of a cantilever's tip, of one Euler beam with six degrees of freedom at each of two
/// nodes, along x; the mass is lumped with rotary inertia.
#[test]
fn a_single_node_moves_by_itself_with_its_rotations() {
    let (length, ea, ei, gj, mass, inertia) = (0.5, 4e8, 3e4, 2e4, 7.0, 0.02);
    let mut k = [[0.0; 12]; 12];
    let mut pair = |i: usize, j: usize, v: f64| {
        k[i][j] += v;
        if i != j {
            k[j][i] += v;
        }
    };
    for (dof, v) in [(0, ea / length), (3, gj / length)] {
        for (i, j, v) in [(dof, dof, v), (dof + 6, dof + 6, v), (dof, dof + 6, -v)] {
            pair(i, j, v);
        }
    }
    let (a, b, c) = (12.0 * ei / length.powi(3), 6.0 * ei / length.powi(2), ei / length);
    // Bending in y turns about z, bending in z about -y.
    for (w, t, s) in [(1, 5, 1.0), (2, 4, -1.0)] {
        for (i, j, v) in [
            (w, w, a),
            (w, w + 6, -a),
            (w + 6, w + 6, a),
            (t, t, 4.0 * c),
            (t + 6, t + 6, 4.0 * c),
            (t, t + 6, 2.0 * c),
        ] {
            pair(i, j, v);
        }
        for (i, j, v) in [(w, t, s * b), (w, t + 6, s * b), (t, w + 6, -s * b), (w + 6, t + 6, -s * b)] {
            pair(i, j, v);
        }
    }
    let folder = folder();
    let pattern: Vec<Vec<usize>> = vec![(0..12).collect(); 12];
    let (mut stiffness, mut masses) = (SparseBuilder::new(&pattern), SparseBuilder::new(&pattern));
    let mut table = String::from("node,direction,x,y,z\n");
    for (i, row) in k.iter().enumerate() {
        row.iter().enumerate().for_each(|(j, v)| stiffness.add(i, j, *v));
        masses.add(i, i, if i % 6 < 3 { mass } else { inertia });
        table += &format!("{},{},{},0,0\n", 1 + i / 6, 1 + i % 6, length * (i / 6) as f64);
    }
    write_sparse(&folder.path().join("k.mtx"), &stiffness.finish()).unwrap();
    write_sparse(&folder.path().join("m.mtx"), &masses.finish()).unwrap();
    std::fs::write(folder.path().join("dofs.csv"), table).unwrap();
    std::fs::write(folder.path().join("sets.csv"), "set,node\nfoot,1\n").unwrap();
    let beam = part("beam", &["foot"], vec![on("tip")]);
    let mut given = files(folder.path(), &beam);
    given.interfaces[0] = InterfaceNodes { labels: Some(vec![2]), weights: InterfaceWeights::Unsaid };
    // A foot of one node has no line to be on: it holds by its rotations.
    let held = Part { clamped: vec!["foot".into()], ..by_matrices(&beam, given.clone()) };
    let mesh = read_part_mesh(&held).unwrap_or_else(|e| panic!("{e}")).mesh;
    let reduced = superelement(&held, &mesh, craig_bampton(20));
    let frequencies: Vec<f64> = reduced.eigenvalues.iter().map(|l| l.sqrt() / TAU).collect();
    assert!(frequencies.len() == 6 && reduced.interfaces[0].rows.shape() == (6, 6));
    let has = |lambda: f64| frequencies.iter().any(|f| (f * TAU / lambda.sqrt() - 1.0).abs() < 1e-9);
    assert!(has(ea / length / mass) && has(gj / length / inertia), "{frequencies:?}");
    // Bending: both roots of the tip's 2 x 2 problem.
    let (p, q) = (a / mass, 4.0 * c / inertia);
    let root = ((p - q).powi(2) + 4.0 * b * b / (mass * inertia)).sqrt();
    assert!(has(0.5 * (p + q - root)) && has(0.5 * (p + q + root)), "{frequencies:?}");
    let tip = flexibility(&reduced);
    assert!((tip[(1, 1)] / (length.powi(3) / (3.0 * ei)) - 1.0).abs() < 1e-9);
    assert!((tip[(5, 5)] / (length / ei) - 1.0).abs() < 1e-9 && tip[(1, 5)] > 0.0);

    // The same beam free.
    given.interfaces.truncate(1);
    let free = superelement(
        &by_matrices(&beam, given.clone()),
        &read_part_mesh(&by_matrices(&beam, given)).unwrap().mesh,
        craig_bampton(20),
    );
    assert_eq!(free.eigenvalues.iter().filter(|l| **l == 0.0).count(), 6);
    assert!((free.mass / (2.0 * mass) - 1.0).abs() < 1e-12 && (free.centre_of_mass[0] - 0.5 * length).abs() < 1e-12);
}

#[test]
fn the_cache_sees_every_file_of_the_part() {
    let ((part, mesh), folder) = (arm(), folder());
    write_part(folder.path(), &part, &mesh);
    let part = by_matrices(&part, files(folder.path(), &part));
    let cache = stiffmap::reduction::Cache::in_folder(folder.path().join("cache"));
    let request =
        stiffmap::reduction::ReductionRequest { part, component: craig_bampton(5), reach: 0.0, rails: Vec::new() };
    let key = || cache.file(&request, &read_part_mesh(&request.part).unwrap().mesh).expect("read from files");
    let before = key();
    for name in ["k.mtx", "m.mtx", "dofs.csv", "sets.csv"] {
        let file: &Path = &folder.path().join(name);
        let kept = std::fs::read(file).unwrap();
        std::fs::write(file, [&kept[..], b"\n"].concat()).unwrap();
        assert_ne!(key(), before, "{name}");
        std::fs::write(file, kept).unwrap();
    }
    assert_eq!(key(), before);
}
