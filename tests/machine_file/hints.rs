//! Every example in a message works when it is pasted.

use super::full::{FULL, read_full};
use super::*;

fn message(text: &str) -> String {
    read_full(text).map_or_else(|error| error.to_string(), |_| panic!("accepted: {text}"))
}

/// What stands for a missing key, and what its placeholder means in this machine.
const MISSING: &[(&str, &str, &str)] = &[
    ("name = \"full\"", "", ""),
    ("direction = [0, 0, 1]", "", ""),
    ("travel = [\"0 mm\", \"-100 mm\"]", "", ""),
    ("step = \"5 mm\"", "", ""),
    ("moves = [\"head\", \"tool\"]", "PART", "head\", \"tool"),
    ("mesh = \"column.inp\"", "FILE", "column"),
    ("young = \"115 GPa\"", "", ""),
    ("poisson = 0.26", "", ""),
    ("density = \"7200 kg/m3\"", "", ""),
    ("nodes = \"EDGE\"", "NODE_SET", "EDGE"),
    ("directions = [\"z\"]", "", ""),
    ("nodes = \"NUT\"", "NODE_SET", "NUT"),
    ("stiffness = \"k.mtx\"", "FILE", "k"),
    ("mass = \"m.mtx\"", "FILE", "m"),
    ("name = \"guide\"", "", ""),
    ("type = \"linear-guide\"", "", ""),
    ("rail = \"column.rail\"", "PART.INTERFACE", "column.rail"),
    ("carriage = \"head.carriage\"", "PART.INTERFACE", "head.carriage"),
    ("footprint = \"90 mm\"", "", ""),
    ("coulomb = \"50 N\"", "", ""),
    ("axis = \"z\"\nyoung", "", "\nyoung"),
    ("young = \"210 GPa\"", "", ""),
    ("diameter = \"40 mm\"", "", ""),
    ("span = \"1300 mm\"", "", ""),
    ("axis = \"y\"", "", ""),
    ("interface = \"tool.journal\"", "PART.INTERFACE", "tool.journal"),
    ("directions = [\"x\"]", "", ""),
    ("frequencies = { grid = \"uniform\", from = \"0 Hz\", to = \"900 Hz\", step = \"1 Hz\" }", "", ""),
    ("from = \"0 Hz\"", "", ""),
    ("to = \"900 Hz\"", "", ""),
    ("step = \"1 Hz\"", "", ""),
    ("damping = { ratio = 0.02, rayleigh = { alpha = 1, beta = 1e-6 }, loss_factor = 0.01 }", "", ""),
    ("alpha = 1", "", ""),
    ("beta = 1e-6", "", ""),
    ("stiffness = { x = \"77 N/um\", y = 77e6 }\ndamping = { x = \"100 N s/m\" }", "", ""),
    ("stiffness = { radial = \"120 N/um\", axial = \"60 N/um\" }\ndamping = { radial = \"10 N s/m\" }", "", ""),
    ("stiffness = { x = 1e9, y = 1e9, z = 1e9, rx = 1e7, ry = 1e7, rz = 1e7 }\ndamping = { x = 1 }", "", ""),
    ("stiffness = \"1 N/um\"\ndamping = \"10 N s/m\"", "", ""),
    ("direction = \"x\"\nstiffness = \"1 N/um\"\ndamping = \"10 N s/m\"", "", ""),
];

#[test]
fn the_full_machine_is_in_order() {
    read_full(FULL).unwrap();
}

#[test]
fn the_example_for_a_missing_key_works_as_it_stands() {
    let full = FULL;
    for (given, placeholder, own) in MISSING {
        assert!(full.contains(given), "{given:?} is not in the full machine");
        let (given, tail) = match given.split_once("\nyoung") {
            Some((first, _)) => (first.to_owned(), "\nyoung"),
            None => ((*given).to_owned(), ""),
        };
        let at = format!("{given}{tail}");
        // An inline table has no use for a comma without a value before it.
        let inside = [format!(", {at}"), format!("{at}, ")];
        let inline = inside.iter().find(|text| full.contains(*text)).cloned();
        let removed = full.replacen(inline.as_ref().unwrap_or(&at), tail, 1);
        let said = message(&removed);
        let (_, example) = said.split_once("; add ").unwrap_or_else(|| panic!("no example: {said}"));
        let example = if placeholder.is_empty() { example.to_owned() } else { example.replace(placeholder, own) };
        let pasted = full.replacen(&at, &format!("{example}{tail}"), 1);
        if let Err(error) = read_full(&pasted) {
            panic!("{example:?} was told in\n{said}\nand gives\n{error}");
        }
    }
}

/// What is written, in place of what; words of the message that can be pasted; and what then stands there.
const REFUSED: &[(&str, &str, &str, &str)] = &[
    ("direction = [0, 0, 1]", "direction = \"up\"", "[0, 0, 1]", "direction = [0, 0, 1]"),
    ("units = \"mm-t-s\"\n\n", "units = \"mm\"\n\n", "\"m-kg-s\"", "units = \"m-kg-s\"\n\n"),
    ("units = \"mm-t-s\"\n\n", "units = \"mm\"\n\n", "\"mm-t-s\"", "units = \"mm-t-s\"\n\n"),
    (
        "{ x = [0, 1, 0], z = [0, 0, 1] }",
        "{ x = [0, 1, 0] }",
        "{ x = [0, 1, 0], z = [0, 0, 1] }",
        "{ x = [0, 1, 0], z = [0, 0, 1] }",
    ),
    (
        "{ axis = \"z\", from = \"10 mm\", to = \"30 mm\" }",
        "{ axis = \"z\" }",
        "{ axis = \"z\", from = \"10 mm\", to = \"30 mm\" }",
        "{ axis = \"z\", from = \"10 mm\", to = \"30 mm\" }",
    ),
    (
        "{ axis = \"z\", from = \"10 mm\", to = \"30 mm\" }",
        "{ }",
        "{ x = [\"0 mm\", \"50 mm\"], z = [\"10 mm\", \"30 mm\"] }",
        "{ x = [\"0 mm\", \"50 mm\"], z = [\"10 mm\", \"30 mm\"] }",
    ),
    ("loss_factor = 0.02", "loss_factor = 20", "\"2 %\"", "loss_factor = \"2 %\""),
    ("loss_factor = 0.02", "loss_factor = 20", "0.02", "loss_factor = 0.02"),
    ("ratio = 0.02", "ratio = 2", "\"2 %\"", "ratio = \"2 %\""),
    ("footprint = \"90 mm\"", "footprint = true", "\"1 m\"", "footprint = \"1 m\""),
    (
        ", breakaway = \"80 N\", stribeck = \"1 mm/s\"",
        ", breakaway = \"80 N\"",
        "stribeck = \"1 mm/s\"",
        ", breakaway = \"80 N\", stribeck = \"1 mm/s\"",
    ),
    (
        "coulomb = \"50 N\", breakaway = \"80 N\"",
        "coulomb = \"500 N\"",
        "breakaway = \"750 N\"",
        "coulomb = \"500 N\", breakaway = \"750 N\"",
    ),
    ("support = \"both-ends\"\n", "", "support = \"both-ends\"", "support = \"both-ends\"\n"),
    ("support = \"both-ends\"\n", "support = \"both\"\n", "\"both-ends\"", "support = \"both-ends\"\n"),
    ("coupling = \"distributing\"", "coupling = \"soft\"", "\"distributing\"", "coupling = \"distributing\""),
    ("weights = \"equal\"", "weights = \"mass\"", "\"equal\"", "weights = \"equal\""),
    ("method = \"craig-bampton\"", "method = \"guyan\"", "\"free-interface\"", "method = \"free-interface\""),
    ("quantity = \"receptance\"", "quantity = \"h\"", "\"mobility\"", "quantity = \"mobility\""),
    (
        "frequencies = { grid = \"uniform\", from = \"0 Hz\", to = \"900 Hz\", step = \"1 Hz\" }",
        "frequencies = 900",
        "{ from = \"0 Hz\", to = \"900 Hz\", step = \"1 Hz\" }",
        "frequencies = { from = \"0 Hz\", to = \"900 Hz\", step = \"1 Hz\" }",
    ),
    (
        "frequencies = { grid = \"uniform\", from = \"0 Hz\", to = \"900 Hz\", step = \"1 Hz\" }",
        "frequencies = 900",
        "[5, \"25 Hz\"]",
        "frequencies = [5, \"25 Hz\"]",
    ),
    (
        "damping = { ratio = 0.02, rayleigh = { alpha = 1, beta = 1e-6 }, loss_factor = 0.01 }",
        "damping = {}",
        "{ ratio = 0 }",
        "damping = { ratio = 0 }",
    ),
    (
        "stiffness = { x = \"77 N/um\", y = 77e6 }",
        "damping = {}\nstiffness = {}",
        "stiffness = { x = \"150 N/um\", y = \"150 N/um\" }",
        "stiffness = { x = \"150 N/um\", y = \"150 N/um\" }",
    ),
];

#[test]
fn the_example_in_a_refusal_works_as_it_stands() {
    let full = FULL;
    for (given, wrong, example, pasted) in REFUSED {
        assert!(full.contains(given), "{given:?} is not in the full machine");
        let broken = full.replacen(given, wrong, 1);
        let broken = if wrong.contains("damping = {}\n") {
            broken.replacen("damping = { x = \"100 N s/m\" }\n", "", 1)
        } else {
            broken
        };
        let said = message(&broken);
        assert!(said.contains(example), "{example:?} is not in: {said}");
        if let Err(error) = read_full(&full.replacen(given, pasted, 1)) {
            panic!("{pasted:?} was told in\n{said}\nand gives\n{error}");
        }
    }
}

#[test]
fn a_bearing_without_a_point_stands_at_its_seats_centroid() {
    let bearing = |text: &str| {
        let machine = read_full(text).unwrap();
        machine.joints.into_iter().find(|joint| joint.name == "bearing").unwrap().at
    };
    let full = FULL;
    assert_eq!(bearing(full), JointPoint::Point([0.0, 0.0, 0.001]));
    let at = "axis = \"y\"\nat = [\"0 mm\", \"0 mm\", \"1 mm\"]";
    assert_eq!(bearing(&full.replacen(at, "axis = \"y\"", 1)), JointPoint::Centroid(0));
}
