//! One brick through the thickness of a thin cantilever.

use crate::bench::{elastic, modes};
use crate::support::grids::grid;
use crate::support::steel;
use std::f64::consts::TAU;
use stiffmap::mesh::CellKind;

#[test]
fn one_incompatible_brick_through_the_thickness_bends_as_a_beam_and_the_plain_one_does_not() {
    for (length, width, thickness, cells) in [(0.3, 0.02, 0.002, [30, 2, 1]), (0.5, 0.01, 0.01, [40, 1, 1])] {
        let m = steel();
        // Euler's beam, beta_1 L = 1.875104.
        let beam = 1.875_104_f64.powi(2) / (TAU * length * length)
            * (m.young * thickness * thickness / (12.0 * m.density)).sqrt();
        let first = |kind| {
            let mesh = grid(kind, [length, width, thickness], cells);
            elastic(&modes(&mesh, &[("XMIN", [true; 3])], 3))[0] / beam - 1.0
        };
        let (incompatible, plain) = (first(CellKind::Hex8Incompatible), first(CellKind::Hex8));
        println!("{length} x {width} x {thickness} m: C3D8I {incompatible:.2e}, C3D8 {plain:.2e}");
        assert!(incompatible.abs() < 1e-2, "{incompatible:.2e}");
        if thickness < 0.005 {
            assert!(plain > 0.2, "{plain:.2e}");
        } else {
            assert!(plain > 2.0 * incompatible.abs(), "{plain:.2e}");
        }
    }
}
