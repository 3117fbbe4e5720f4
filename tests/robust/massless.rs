//! Coordinates without mass: a beam whose rotations have no inertia, as Nastran and Ansys lump it.

use crate::{machine, reduced, solved};

#[test]
fn rotations_without_inertia_answer_statically_however_many_modes_are_kept() {
    // SciPy by shift and invert, by QZ and by condensation: the seventh and eighth are 278.958 Hz.
    for modes in ["6", "12", "20", "28", "30", "34", "36"] {
        let machine =
            machine("massless.toml", &[("component = { modes = 20 }", &format!("component = {{ modes = {modes} }}"))]);
        let (_, parts) = reduced(&machine);
        let found = &solved(&machine, &parts).expect("solves").1.modes[0];
        for r in [6, 7] {
            let f = found.frequency(found.free + r);
            assert!((f / 278.958 - 1.0).abs() < 2e-5, "{modes} modes: {f} Hz");
            // Control: the value with those rotations locked is seen.
            assert!((f / 288.08 - 1.0).abs() > 0.02);
        }
    }
}

#[test]
fn a_whole_given_part_agrees_with_its_condensed_matrices() {
    let machine = machine("massless.toml", &[("component = { modes = 20 }", "component = { modes = 36 }")]);
    let (meshes, parts) = reduced(&machine);
    let (_, found) = solved(&machine, &parts).expect("solves");
    // The unreduced machine with a trace of inertia where there is none, by nalgebra.
    let exact = crate::unreduced(&machine, &meshes, 100.0);
    let modes = &found.modes[0];
    for (r, value) in exact.iter().enumerate().take(8) {
        let f = value.max(0.0).sqrt() / std::f64::consts::TAU;
        assert!((modes.frequency(r) / f - 1.0).abs() < 1e-6, "mode {}: {} {f}", r + 1, modes.frequency(r));
    }
}
