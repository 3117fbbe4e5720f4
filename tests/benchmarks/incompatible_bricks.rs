//! C3D8I on coarse meshes: the incompatible modes carry mass, as in CalculiX, and what that is worth.

use crate::bench::{elastic, modes};
use crate::support::dense::{eigenvalues, full};
use crate::support::grids::grid;
use crate::support::part;
use std::f64::consts::TAU;
use stiffmap::machine::Support;
use stiffmap::mesh::{CellKind, Mesh};
use stiffmap::solid::assemble;

/// A cantilever of 200 x 20 x 30 mm held at x = 0.
fn bar(kind: CellKind, cells: [usize; 3]) -> Mesh {
    grid(kind, [0.2, 0.02, 0.03], cells)
}

/// An angle, 200 x 200 mm, 50 mm thick and 100 mm wide, held at x = 0.
fn angle(kind: CellKind, cells: [usize; 3]) -> Mesh {
    let mut mesh = grid(kind, [0.2, 0.1, 0.2], cells);
    let nodes = mesh.nodes.clone();
    mesh.cells.retain(|cell| {
        let middle = |c: usize| cell.nodes[..8].iter().map(|&n| nodes[n][c]).sum::<f64>() / 8.0;
        middle(0) < 0.05 || middle(2) < 0.05
    });
    mesh
}

/// A bar bent to a quarter of a ring, 60 to 90 mm, 50 mm wide, held at one end: its bricks are no parallelepipeds.
fn quarter_ring(kind: CellKind, cells: [usize; 3]) -> Mesh {
    let mut mesh = grid(kind, [1.0, 0.03, 0.05], cells);
    for x in &mut mesh.nodes {
        let (turn, radius) = (0.25 * TAU * x[0], 0.06 + x[1]);
        *x = [radius * turn.sin(), radius * turn.cos(), x[2]];
    }
    mesh
}

/// The frequencies if the incompatible modes had no mass: their parameters follow from the nodes.
fn without_their_mass(mesh: &Mesh) -> Vec<f64> {
    let mut body = part("body", &[], vec![]);
    body.supported = vec![Support { nodes: "XMIN".into(), directions: [true; 3] }];
    let system = assemble(&body, mesh).expect("assembles");
    let (stiffness, mass) = (full(&system.stiffness), full(&system.mass));
    let own = 3 * mesh.cells.len();
    let nodal = system.n_dof() - own;
    let of_modes = stiffness.view((nodal, nodal), (own, own)).into_owned().cholesky().expect("held by the element");
    let coupling = stiffness.view((nodal, 0), (own, nodal)).into_owned();
    let condensed = stiffness.view((0, 0), (nodal, nodal)) - coupling.transpose() * of_modes.solve(&coupling);
    let mass = mass.view((0, 0), (nodal, nodal)).into_owned();
    eigenvalues(&condensed, &mass, 1e8).into_iter().map(|l| l.sqrt() / TAU).collect()
}

fn held(mesh: &Mesh) -> Vec<f64> {
    elastic(&modes(mesh, &[("XMIN", [true; 3])], 10))
}

#[test]
fn a_coarse_bar_has_calculixs_frequencies() {
    // CalculiX 2.20 on the same 40 C3D8I, E = 210 GPa, nu = 0.3, 7850 kg/m^3.
    const CALCULIX: [f64; 10] =
        [421.7227, 626.2407, 2568.570, 3636.928, 3725.934, 6499.803, 6906.445, 9237.675, 11167.03, 12829.02];
    let off = |found: &[f64]| found.iter().zip(CALCULIX).map(|(f, c)| (f / c - 1.0).abs()).fold(0.0, f64::max);
    let mesh = bar(CellKind::Hex8Incompatible, [10, 2, 2]);
    assert!(off(&held(&mesh)) < 1e-6, "{:?}", held(&mesh));
    let massless = without_their_mass(&mesh);
    assert!(off(&massless) > 0.07, "control, without the modes' mass: {massless:?}");
}

/// Mean error of the first ten frequencies.
fn mean_error(found: &[f64], fine: &[f64]) -> f64 {
    found.iter().zip(fine).take(10).map(|(f, r)| (f / r - 1.0).abs()).sum::<f64>() / 10.0
}

#[test]
fn the_modes_mass_brings_the_frequencies_nearer_to_those_of_a_fine_mesh_of_quadratic_bricks() {
    type Piece = (&'static str, fn(CellKind, [usize; 3]) -> Mesh, [usize; 3], [[usize; 3]; 3]);
    let pieces: [Piece; 3] = [
        ("bar", bar, [30, 4, 4], [[8, 2, 2], [12, 2, 2], [20, 2, 3]]),
        ("angle", angle, [12, 4, 12], [[4, 2, 4], [4, 3, 4], [8, 3, 8]]),
        ("quarter of a ring", quarter_ring, [20, 3, 4], [[6, 1, 2], [8, 2, 2], [12, 2, 3]]),
    ];
    for (name, piece, fine, sizes) in pieces {
        let fine = held(&piece(CellKind::Hex20Reduced, fine));
        let mut before = f64::INFINITY;
        for size in sizes {
            let mesh = piece(CellKind::Hex8Incompatible, size);
            let (with, without) = (mean_error(&held(&mesh), &fine), mean_error(&without_their_mass(&mesh), &fine));
            println!("{name}, {size:?}: mean error {with:.2e} with the modes' mass, {without:.2e} without");
            assert!(with < 0.85 * without, "{name}, {size:?}: {with:.2e} with, {without:.2e} without");
            assert!(with < 1.05 * before, "{name}, {size:?}: {with:.2e} on the finer mesh, {before:.2e} before");
            before = with;
        }
        let plain = mean_error(&held(&piece(CellKind::Hex8, sizes[2])), &fine);
        assert!(plain > 1.5 * before, "{name}, control: plain bricks are told apart, {plain:.2e}");
    }
}
