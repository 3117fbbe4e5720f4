//! A superelement of master nodes and modal coordinates, made here by dense Craig-Bampton.

use super::support::dense::{eigenvalues, full};
use super::support::{box_mesh, craig_bampton, on, part, superelement, worst_ratio};
use super::{by_matrices, files, folder, write_part};
use nalgebra::{DMatrix, SymmetricEigen};
use std::collections::BTreeSet;
use std::path::Path;
use stiffmap::export::matrix_market::{DofRow, write_dofs};
use stiffmap::machine::Part;
use stiffmap::mesh::{Mesh, read_part_mesh};

/// Modal coordinates beside the masters.
const MODES: usize = 20;

fn arm() -> (Part, Mesh) {
    (part("arm", &[], vec![on("XMIN"), on("XMAX")]), box_mesh([0.1, 0.0, 0.3], [0.3, 0.1, 0.1], [4, 1, 1]))
}

/// Stiffness and mass over the nodes of both interfaces and fixed-interface modes.
fn reduce(folder: &Path, part: &Part, mesh: &Mesh) -> [DMatrix<f64>; 2] {
    let system = write_part(folder, part, mesh);
    let (k, m) = (full(&system.stiffness), full(&system.mass));
    let ends: BTreeSet<usize> = ["XMIN", "XMAX"].iter().flat_map(|s| mesh.node_sets[*s].clone()).collect();
    let labels = system.node_of_unknown();
    let (masters, inner): (Vec<usize>, Vec<usize>) =
        (0..labels.len()).partition(|u| labels[*u].is_some_and(|(node, _)| ends.contains(&node)));
    let pick = |a: &DMatrix<f64>, rows: &[usize], columns: &[usize]| a.select_rows(rows).select_columns(columns);
    let inside = pick(&k, &inner, &inner).cholesky().expect("positive definite");
    let constraint = -inside.solve(&pick(&k, &inner, &masters));
    // Lowest modes by the largest eigenvalues of L^-1 M L^-T.
    let l = inside.l();
    let half = l.solve_lower_triangular(&pick(&m, &inner, &inner)).unwrap();
    let c = l.solve_lower_triangular(&half.transpose()).unwrap();
    let eigen = SymmetricEigen::new(0.5 * (&c + c.transpose()));
    let mut order: Vec<usize> = (0..inner.len()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let shapes = l.transpose().solve_upper_triangular(&eigen.eigenvectors.select_columns(&order[..MODES])).unwrap();
    let n = masters.len() + MODES;
    let mut t = DMatrix::zeros(labels.len(), n);
    for (a, &u) in masters.iter().enumerate() {
        t[(u, a)] = 1.0;
    }
    for (a, &u) in inner.iter().enumerate() {
        (0..masters.len()).for_each(|b| t[(u, b)] = constraint[(a, b)]);
        (0..MODES).for_each(|b| t[(u, masters.len() + b)] = shapes[(a, b)]);
    }
    let reduced = [&k, &m].map(|a| {
        let a = t.transpose() * a * &t;
        0.5 * (&a + a.transpose())
    });
    for (name, a) in ["k.mtx", "m.mtx"].iter().zip(&reduced) {
        stiffmap::export::matrix_market::write_dense(&folder.join(name), a).unwrap();
    }
    let label = |u: &usize| labels[*u].map(|(node, d)| (mesh.node_labels[node], d, mesh.nodes[node]));
    let rows: Vec<DofRow> = masters.iter().map(label).chain(std::iter::repeat_n(None, MODES)).collect();
    write_dofs(&folder.join("dofs.csv"), &rows).unwrap();
    reduced
}

#[test]
fn a_superelement_of_masters_and_modes_is_read_and_free() {
    let ((part, mesh), folder) = (arm(), folder());
    let [k, m] = reduce(folder.path(), &part, &mesh);
    let given = by_matrices(&part, files(folder.path(), &part));
    let read = read_part_mesh(&given).unwrap_or_else(|e| panic!("{e}")).mesh;
    let reduced = superelement(&given, &read, craig_bampton(40));
    assert_eq!(reduced.eigenvalues.iter().filter(|l| **l == 0.0).count(), 6);
    // As the matrices themselves have it, by a dense solver.
    let own = eigenvalues(&k, &m, 1e6);
    let seen = worst_ratio(&reduced.eigenvalues[6..18], &own[6..18]);
    assert!(seen < 2e-6, "{seen:.1e}");
    // And close to the part that it was made from.
    let whole = superelement(&part, &mesh, craig_bampton(40));
    let near = worst_ratio(&reduced.eigenvalues[6..10], &whole.eigenvalues[6..10]);
    assert!(near < 2e-2, "{near:.1e}");
    assert!((reduced.mass / whole.mass - 1.0).abs() < 1e-9);
    assert!((reduced.inertia - whole.inertia).norm() < 1e-8 * whole.inertia.norm());
}

#[test]
fn a_small_superelement_is_kept_whole() {
    let ((part, mesh), folder) = (arm(), folder());
    let [k, m] = reduce(folder.path(), &part, &mesh);
    let given = by_matrices(&part, files(folder.path(), &part));
    let read = read_part_mesh(&given).expect("reads").mesh;
    let reduced = superelement(&given, &read, craig_bampton(k.nrows()));
    assert_eq!((reduced.n(), reduced.component_frequencies.len()), (k.nrows(), 0));
    let own = eigenvalues(&k, &m, 1e6);
    let seen = worst_ratio(&reduced.eigenvalues[6..40], &own[6..40]);
    assert!(seen < 1e-6, "{seen:.1e}");
}
