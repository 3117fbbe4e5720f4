//! Free bodies with repeated frequencies: six rigid motions, no partner lost.

use crate::bench::{elastic, modes};
use crate::support::dense::{eigenvalues, full};
use crate::support::grids::grid;
use crate::support::{part, steel};
use std::f64::consts::TAU;
use stiffmap::mesh::{CellKind, Mesh};
use stiffmap::solid::assemble;

/// A ring about z: a bar of bricks bent round, its two ends joined.
fn ring(radius: f64, width: f64, around: usize) -> Mesh {
    let mut mesh = grid(CellKind::Hex20, [1.0, width, width], [around, 2, 2]);
    let lattice: Vec<[f64; 3]> = mesh.nodes.clone();
    let first = |x: &[f64; 3]| lattice.iter().position(|y| y[0] == 0.0 && y[1..] == x[1..]).expect("the other end");
    let joined: Vec<usize> = lattice.iter().enumerate().map(|(n, x)| if x[0] == 1.0 { first(x) } else { n }).collect();
    for (x, [t, y, z]) in mesh.nodes.iter_mut().zip(&lattice) {
        let r = radius + 0.5 * width - y; // y points inward, so that the bricks stay right-handed
        *x = [r * (TAU * t).cos(), r * (TAU * t).sin(), *z];
    }
    for cell in &mut mesh.cells {
        cell.nodes.iter_mut().for_each(|n| *n = joined[*n]);
    }
    mesh.node_sets.clear();
    mesh
}

#[test]
fn a_free_ring_has_six_rigid_motions_and_pairs_at_the_frequencies_of_the_closed_form() {
    let (radius, width) = (0.25, 0.01);
    let found = modes(&ring(radius, width, 60), &[], 26);
    assert_eq!(found.rigid, 6);
    assert_eq!(found.eigenvalues.len(), 26);
    let frequencies = elastic(&found);
    let m = steel();
    let second = width.powi(4) / 12.0;
    let scale = (m.young * second / (m.density * width * width * radius.powi(4))).sqrt() / TAU;
    // Love, Mathematical Theory of Elasticity, art. 293: n (n^2 - 1) / sqrt(n^2 + 1) in the plane (Hoppe 1871) and
    // n (n^2 - 1) / sqrt(n^2 + E I / C) out of it (Michell 1890), each twice; C = 0.1406 w^4 G for a square.
    for n in [2.0, 3.0, 4.0, 5.0] {
        let inside = scale * n * (n * n - 1.0) / (n * n + 1.0_f64).sqrt();
        let ratio = 2.0 * (1.0 + m.poisson) * second / (0.140_577 * width.powi(4));
        let across = scale * n * (n * n - 1.0) / (n * n + ratio).sqrt();
        for f in [inside, across] {
            let mut off: Vec<f64> = frequencies.iter().map(|g| (g / f - 1.0).abs()).collect();
            off.sort_by(f64::total_cmp);
            assert!(off[1] < 0.012, "n = {n}: {f:.2} Hz twice in {frequencies:?}");
        }
    }
    // Partner beside partner, none lost.
    for pair in frequencies[..16].chunks(2) {
        assert!((pair[1] / pair[0] - 1.0).abs() < 1e-7, "{frequencies:?}");
    }
    assert!((frequencies[2] / frequencies[1] - 1.0).abs() > 1e-3, "control: pairs differ from each other");
}

#[test]
fn free_cubes_of_every_kind_have_six_rigid_motions_and_the_dense_solvers_list() {
    for kind in CellKind::ALL {
        let mesh = grid(kind, [0.1; 3], [2; 3]);
        let system = assemble(&part("cube", &[], vec![]), &mesh).expect("assembles");
        let mut reference = eigenvalues(&full(&system.stiffness), &full(&system.mass), 1e8);
        // Reduced integration leaves motions without mass, whose eigenvalues are infinite up to rounding.
        reference.retain(|l| l.abs() < 1e18);
        let found = modes(&mesh, &[], 24);
        assert_eq!(found.rigid, 6, "{kind:?}");
        for (k, (a, b)) in found.eigenvalues.iter().zip(&reference).enumerate().skip(6) {
            assert!((a / b - 1.0).abs() < 1e-8, "{kind:?}, mode {k}: {a} {b}");
        }
        assert_eq!(found.counted, reference.iter().filter(|l| **l < found.counted_below).count());
        let mut lost = found.eigenvalues.clone();
        lost.remove(7);
        let shifted = lost.iter().zip(&reference).skip(6).any(|(a, b)| (a / b - 1.0).abs() > 1e-3);
        assert!(shifted, "control: a lost mode is seen");
    }
}
