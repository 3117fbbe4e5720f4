//! Reduced elements in a single row, whose midside nodes nothing restrains.

use super::support::grids::grid;
use super::support::{on, part};
use stiffmap::mesh::{CellKind, Mesh};
use stiffmap::solid::assemble;

fn assembled(mesh: &Mesh, clamped: &[&str]) -> Result<usize, String> {
    assemble(&part("bar", clamped, vec![on("XMAX")]), mesh).map(|s| s.n_dof()).map_err(|error| error.to_string())
}

/// The stiffness that CalculiX 2.20 stores (`*FREQUENCY, SOLVER=MATRIXSTORAGE`) of a row of n parallelepipeds, clamped
/// at one end, has n zero eigenvalues; of two rows side by side, and of a row of C3D20, none.
#[test]
fn a_single_row_of_c3d20r_is_refused_with_cause_and_remedy() {
    let size = [0.1, 0.01, 0.01];
    for (n, clamped) in [(10, &["XMIN"][..]), (3, &[]), (2, &[]), (3, &["XMIN", "XMAX"]), (1, &["XMIN"]), (1, &[])] {
        let row = grid(CellKind::Hex20Reduced, size, [n, 1, 1]);
        let message = assembled(&row, clamped).unwrap_err();
        for said in
            [&format!("in {n} elements of type C3D20R (element 1 first)"), "hourglass", "as C3D20", "side by side"]
        {
            assert!(message.contains(said), "{said} in {message}");
        }
        assert!(assembled(&grid(CellKind::Hex20, size, [n, 1, 1]), clamped).is_ok());
    }
    for cells in [[10, 2, 1], [1, 2, 2], [2, 3, 1]] {
        assert!(assembled(&grid(CellKind::Hex20Reduced, size, cells), &["XMIN"]).is_ok(), "{cells:?}");
    }
    // Bent into elements that are no parallelepipeds, the row has a stiffness against every motion.
    let mut bent = grid(CellKind::Hex20Reduced, size, [10, 1, 1]);
    bent.nodes.iter_mut().for_each(|x| x[1] *= 1.0 + 5.0 * x[0] + 30.0 * x[2] + 100.0 * x[0] * x[2]);
    assert!(assembled(&bent, &["XMIN"]).is_ok(), "control");
}
