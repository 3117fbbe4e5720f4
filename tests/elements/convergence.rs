//! How the error of a frequency falls with the size of the elements.

use crate::support::grids::grid;
use crate::support::{part, steel};
use nalgebra::DMatrix;
use stiffmap::linalg::shift_invert_modes;
use stiffmap::mesh::CellKind;
use stiffmap::solid::assemble;

// Lame's equivoluminal modes of a free cube, as in `tests/solids.rs`: exact at f = c_s / (sqrt 2 a).
fn error(kind: CellKind, n: usize) -> f64 {
    let (side, m) = (0.1, steel());
    let exact = (m.young / (2.0 * (1.0 + m.poisson)) / m.density).sqrt() / (2f64.sqrt() * side);
    let body = assemble(&part("cube", &[], vec![]), &grid(kind, [side; 3], [n; 3])).expect("assembles");
    let ordering = body.ordering().expect("METIS orders it");
    let found =
        shift_invert_modes(&body.stiffness, &body.mass, &ordering, body.rigid.ncols(), 30, None).expect("converges");
    assert_eq!(found.rigid, 6, "{kind:?}: {:?}", found.eigenvalues);
    // The mode that resembles u = (sin kx cos ky, -cos kx sin ky, 0) about the centre most.
    let mesh_nodes = &body.nodes;
    let k = std::f64::consts::PI / side;
    let shape = DMatrix::from_fn(body.n_dof(), 1, |i, _| {
        // Incompatible modes stand behind the nodes.
        let Some(node) = mesh_nodes.get(i / 3) else { return 0.0 };
        let [x, y, _] = node.map(|x| k * (x - 0.5 * side));
        [x.sin() * y.cos(), -x.cos() * y.sin(), 0.0][i % 3]
    });
    let likeness = found.shapes.transpose() * body.mass.multiply(&shape);
    let best =
        (6..found.eigenvalues.len()).max_by(|&a, &b| likeness[a].abs().total_cmp(&likeness[b].abs())).expect("a mode");
    found.eigenvalues[best].sqrt() / std::f64::consts::TAU / exact - 1.0
}

#[test]
fn the_error_of_lames_mode_falls_with_the_second_power_of_h_for_linear_and_the_fourth_for_quadratic_elements() {
    for (kind, sizes, order) in [
        (CellKind::Tet4, [8, 12], 2.0),
        (CellKind::Wedge6, [5, 8], 2.0),
        (CellKind::Hex8, [5, 8], 2.0),
        (CellKind::Hex8Incompatible, [5, 8], 2.0),
        (CellKind::Tet10, [4, 6], 4.0),
        (CellKind::Wedge15, [3, 5], 4.0),
        (CellKind::Hex20, [3, 5], 4.0),
        (CellKind::Hex20Reduced, [3, 5], 4.0),
    ] {
        let errors = sizes.map(|n| error(kind, n));
        let slope = (errors[0] / errors[1]).ln() / (sizes[1] as f64 / sizes[0] as f64).ln();
        println!("{}: errors {errors:?}, order {slope:.2}", kind.name());
        // Tetrahedra split the triple root and come to their order late: 1.2, 1.5, .. of four nodes, 3.2, 3.6, .. of ten.
        let room = if kind.corner_count() == 4 { 0.7 } else { 0.35 };
        assert!((slope - order).abs() < room, "{}: order {slope:.2} of {errors:?}", kind.name());
    }
}
