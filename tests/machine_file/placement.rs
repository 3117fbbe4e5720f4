//! Units, orientation, origin, supports and bricks of a part.

use super::*;
use stiffmap::mesh::{CellKind, read_part_mesh};

const HEAD: &str = "mesh = \"head.inp\"";

#[test]
fn units_are_a_length_a_mass_and_a_time() {
    let units = |name: &str| accepted(HEAD, &format!("{HEAD}\nunits = \"{name}\"")).parts[1].mesh_units;
    assert_eq!(units("mm-t-s"), MeshUnits::MILLIMETRE_TONNE_SECOND);
    assert_eq!(units("mm-kg-ms"), MeshUnits { length: 1e-3, mass: 1.0, time: 1e-3 });
    // In mm, kg, ms stresses are GPa; in mm, t, s they are MPa.
    assert!(
        (units("mm-kg-ms").stress() / 1e9 - 1.0).abs() < 1e-14 && (units("mm-t-s").stress() / 1e6 - 1.0).abs() < 1e-14
    );
    // Steel in lbf, inch, second: 7.35e-4 slinch / in^3 and 30e6 psi.
    let inch = units("in-slinch-s");
    assert!(
        (7.35e-4 * inch.density() / 7855.0 - 1.0).abs() < 1e-3 && (30e6 * inch.stress() / 206.84e9 - 1.0).abs() < 1e-4
    );
    for bad in ["mm", "mm-t", "mm-t-s-K", "m-kg-h", "t-mm-s", ""] {
        refused_change(HEAD, &format!("{HEAD}\nunits = \"{bad}\""), &["parts.head.units", "LENGTH-MASS-TIME"]);
    }
}

#[test]
fn orientation_and_origin_place_the_mesh_in_the_machine() {
    let place = |text: &str| accepted(HEAD, &format!("{HEAD}\n{text}")).parts[1].placement;
    assert_eq!(place(""), Placement::IDENTITY);
    let turned = place("orientation = { x = [0, 2, 0], z = [0, 0, 1] }\norigin = [\"10 mm\", 0, 0]");
    assert_eq!(turned.apply([1.0, 0.0, 0.0]), [0.01, 1.0, 0.0]);
    assert_eq!(turned.apply([0.0, 1.0, 0.0]), [-0.99, 0.0, 0.0]);
    assert_eq!(turned.apply([0.0, 0.0, 3.0]), [0.01, 0.0, 3.0]);
    let refuse = |text: &str, fragments: &[&str]| refused_change(HEAD, &format!("{HEAD}\n{text}"), fragments);
    refuse("orientation = { x = [0, 1, 0] }", &["parts.head.orientation", "give two axes"]);
    refuse("orientation = { x = [0, 1, 0], y = [0, 1, 1] }", &["cosine is 7.1e-1"]);
    refuse("orientation = { x = [0, 0, 0], y = [0, 1, 1] }", &["orientation.x", "not zero"]);
    refuse("orientation = { x = [1, 0, 0], y = [0, 1, 0], z = [0, 0, 1] }", &["leave one of the three out"]);
    refuse("orientation = { u = [1, 0, 0] }", &["unknown key `u`"]);
    refuse("origin = [0, 0]", &["parts.head.origin", "3 values"]);
}

#[test]
fn supports_name_a_set_and_directions() {
    let text =
        format!("{HEAD}\nsupported = [{{ nodes = \"EDGE\", directions = [\"z\", \"x\"] }}]\nplain_bricks = true");
    let part = &accepted(HEAD, &text).parts[1];
    assert_eq!(part.supported, [Support { nodes: "EDGE".into(), directions: [true, false, true] }]);
    assert!(part.plain_bricks && !accepted(HEAD, HEAD).parts[1].plain_bricks);
    let refuse = |text: &str, fragments: &[&str]| refused_change(HEAD, &format!("{HEAD}\n{text}"), fragments);
    refuse("supported = [{ nodes = \"EDGE\", directions = [] }]", &["at least one"]);
    refuse("supported = [{ nodes = \"EDGE\", directions = [\"w\"] }]", &["\"x\", \"y\" or \"z\""]);
    refuse("supported = [{ nodes = \"EDGE\" }]", &["directions"]);
    refuse("supported = [{ nodes = \"\", directions = [\"x\"] }]", &["node set"]);
    refuse("plain_bricks = \"yes\"", &["true or false"]);
}

#[test]
fn a_placed_mesh_keeps_what_its_file_holds_only_along_parallel_axes() {
    let mesh = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 0, 1\n6, 1, 0, 1\n7, 1, 1, 1\n8, 0, 1, 1\n\
                *ELEMENT, TYPE=C3D8\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*BOUNDARY\n1, 1\n2, 1, 3\n";
    let placed = |text: &str| {
        let folder = folder_with(&changed(HEAD, &format!("{HEAD}\n{text}")));
        std::fs::write(folder.path().join("head.inp"), mesh).unwrap();
        let machine = read_machine(folder.path()).unwrap();
        read_part_mesh(&machine.parts[1]).map(|file| file.mesh).map_err(|error| error.to_string())
    };
    let drawn = placed("plain_bricks = true").unwrap();
    assert_eq!((drawn.supports[&0], drawn.cells[0].kind), ([true, false, false], CellKind::Hex8));
    let turned = placed("orientation = { x = [0, 1, 0], z = [0, 0, 1] }\norigin = [5, 0, 0]").unwrap();
    assert_eq!((turned.supports[&0], turned.supports[&1]), ([false, true, false], [true; 3]));
    assert_eq!(turned.nodes[1], [5.0, 1.0, 0.0]);
    let message = placed("orientation = { x = [1, 1, 0], z = [0, 0, 1] }").unwrap_err();
    assert!(message.contains("node 1") && message.contains("supported"), "{message}");
}
