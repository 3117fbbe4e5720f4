//! Machines that are unusual and sound: a warning that cries wolf is worse than none.

use super::{mill, told};
use std::path::Path;
use stiffmap::machine::{MeshUnits, read_machine};
use stiffmap::pipeline;

/// Replacements that leave a machine somebody could have built.
const SOUND: &[&[(&str, &str)]] = &[
    // Soft aerostatic guides, stiff hydrostatic ones, magnetic bearings.
    &[("y = \"150 N/um\", z = \"250 N/um\"", "y = \"5 N/um\", z = \"8 N/um\"")],
    &[("y = \"150 N/um\", z = \"250 N/um\"", "y = \"9000 N/um\", z = \"12000 N/um\"")],
    &[("radial = \"200 N/um\", axial = \"100 N/um\"", "radial = \"2 N/um\", axial = \"0.05 N/um\"")],
    &[("radial = \"200 N/um\", axial = \"100 N/um\"", "radial = \"6000 N/um\", axial = \"4000 N/um\"")],
    // A joint that shall count as rigid.
    &[("x = \"1e9 N/m\"", "x = \"1e13 N/m\"")],
    // Strongly damped guides, a rubber part, a part without damping, friction of a box way.
    &[("y = \"2000 N s/m\"", "y = \"200 kN s/m\"")],
    &[(
        "young = \"70 GPa\", poisson = 0.34, density = \"2700 kg/m3\"",
        "young = \"5 MPa\", poisson = 0.49, density = \"1100 kg/m3\"",
    )],
    &[(
        "young = \"70 GPa\", poisson = 0.34, density = \"2700 kg/m3\"",
        "young = \"30 GPa\", poisson = 0.2, density = \"2300 kg/m3\"",
    )],
    &[(
        "young = \"70 GPa\", poisson = 0.34, density = \"2700 kg/m3\"",
        "young = \"630 GPa\", poisson = 0.22, density = \"15000 kg/m3\"",
    )],
    &[("loss_factor = 0.004", "loss_factor = 0.3")],
    &[("coulomb = \"50 N\", breakaway = \"80 N\"", "coulomb = \"5 kN\", breakaway = \"9 kN\"")],
    // One position alone, a long and a fine travel, a footprint of half and of thrice the carriage.
    &[("[\"0 mm\", \"400 mm\"]", "[\"0 mm\", \"0 mm\"]")],
    &[("travel = [\"0 mm\", \"400 mm\"]\nstep = \"20 mm\"", "travel = [\"0 mm\", \"100 mm\"]\nstep = \"0.1 mm\"")],
    &[("footprint = \"100 mm\"", "footprint = \"50 mm\"")],
    &[("footprint = \"100 mm\"", "footprint = \"300 mm\"")],
    // Thin and thick screws, one end, no length; a worn nut.
    &[("diameter = \"25 mm\"", "diameter = \"3 mm\"")],
    &[("diameter = \"25 mm\"", "diameter = \"250 mm\"")],
    &[("free_length = \"200 mm\"\nsupport = \"both-ends\"\nspan = \"900 mm\"\nbacklash = \"10 um\"", "")],
    &[("backlash = \"10 um\"", "backlash = \"0.3 mm\"")],
    // A bearing's point beside its seat, where the lines of contact of angular balls meet.
    &[("at = [\"350 mm\", \"75 mm\", \"250 mm\"]", "at = [\"350 mm\", \"20 mm\", \"250 mm\"]")],
    &[("axis = \"y\"\nat", "axis = [0.02, -1, 0]\nat")],
    // A linear motor's control in place of the screw; a fine and an ultrasonic grid; static flexibility alone.
    &[
        ("type = \"ball-screw\"", "type = \"spring-damper\""),
        (
            "axis = \"x\"\nyoung = \"210 GPa\"\ndiameter = \"25 mm\"\nfree_length = \"200 mm\"\nsupport = \"both-ends\"\nspan = \"900 mm\"\nbacklash = \"10 um\"\ndamping = \"500 N s/m\"",
            "direction = \"x\"\nstiffness = \"80 N/um\"\ndamping = \"20 kN s/m\"",
        ),
    ],
    &[("to = \"1500 Hz\", step = \"10 Hz\"", "to = \"18 kHz\", step = \"100 Hz\"")],
    &[("{ from = \"0 Hz\", to = \"1500 Hz\", step = \"10 Hz\" }", "[0]")],
    &[("{ from = \"0 Hz\", to = \"1500 Hz\", step = \"10 Hz\" }", "[0, 0.01]")],
    &[("{ from = \"0 Hz\", to = \"1500 Hz\", step = \"10 Hz\" }", "{ from = 1.2, to = 1.5, step = 0.001 }")],
    &[("ratio = 0.02", "ratio = 0")],
    &[("ratio = 0.02", "ratio = 0.15")],
    &[("ratio = 0.02", "rayleigh = { alpha = \"30 1/s\", beta = \"2e-5 s\" }")],
    // The rail on what moves, the carriage below it.
    &[
        ("moves = [\"slide\", \"head\", \"spindle\"]", "moves = [\"bed\"]"),
        (
            "between = [\"bed.mount\", \"head.foot\"]\ndirection = [0, 0, 1]\n",
            "between = [\"bed.mount\", \"head.foot\"]\ndirection = [1, 0, 1]\n",
        ),
    ],
];

#[test]
fn unusual_machines_get_no_warning() {
    let cries: Vec<String> = SOUND
        .iter()
        .filter_map(|edits| {
            let lines = told(mill(edits).path());
            (lines != Ok(Vec::new())).then(|| format!("{edits:?}: {lines:#?}"))
        })
        .collect();
    assert!(cries.is_empty(), "{}", cries.join("\n"));
}

#[test]
fn the_bundled_mill_gets_no_warning_and_one_of_its_values_off_by_a_million_does() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/vertical_mill");
    let mut machine = read_machine(&folder).unwrap();
    let meshes = pipeline::read_meshes(&machine).unwrap();
    assert_eq!(pipeline::plausibility(&machine, &meshes), Vec::<String>::new());
    let stiffness = &mut machine.joints[0].springs[0].stiffness;
    *stiffness = stiffmap::machine::SpringStiffness::Constant(77.0);
    assert_eq!(pipeline::plausibility(&machine, &meshes).len(), 1);
}

#[test]
fn a_mesh_file_in_other_units_than_the_machine_file_says_is_told_with_the_right_ones() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/vertical_mill");
    let machine = read_machine(&folder).unwrap();
    // The drive's mesh is in m, kg, s, its material of 70 GPa and 6000 kg/m3 too.
    for (units, right) in [
        (MeshUnits::MILLIMETRE_TONNE_SECOND, "units = \"m-kg-s\" makes its material a metal"),
        (MeshUnits { length: 0.0254, mass: 0.4536, time: 1.0 }, "units = \"m-kg-s\" makes it a metal"),
        (MeshUnits { length: 0.01, mass: 1e-3, time: 1.0 }, "4.874 mm across"),
    ] {
        let mut wrong = machine.clone();
        let drive = wrong.parts.iter_mut().find(|part| part.name == "drive").unwrap();
        drive.mesh_units = units;
        let told = pipeline::plausibility(&wrong, &pipeline::read_meshes(&wrong).unwrap());
        let of_drive: Vec<_> = told.iter().filter(|line| line.starts_with("parts.drive")).collect();
        assert!(of_drive.len() == 1 && of_drive[0].contains(right), "{told:#?}");
    }
}
