//! Included files, surfaces, held displacements, other elements, decks.

use super::*;
use stiffmap::mesh::inp::{FrequencyStep, parse_deck, read_inp_file};
use stiffmap::mesh::{CellFace, CellKind};

fn brick(from: &str, to: &str) -> String {
    assert!(BRICK.contains(from), "{from:?}");
    BRICK.replacen(from, to, 1)
}

#[test]
fn bricks_get_incompatible_modes_unless_asked_otherwise_and_it_is_said() {
    let MeshFile { mesh, warnings } = accepted(&brick("C3D8I", "C3D8"));
    assert_eq!(mesh.cells[0].kind, CellKind::Hex8Incompatible);
    assert!(warnings[0].line == 10 && warnings[0].text.contains("C3D8 is read as C3D8I"), "{warnings:?}");
    assert_eq!(accepted(BRICK).warnings, []);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("brick.inp");
    std::fs::write(&file, brick("C3D8I", "C3D8")).unwrap();
    assert_eq!(read_inp_file(&file, SI, true).unwrap().mesh.cells[0].kind, CellKind::Hex8);
    let surplus = accepted(&brick("6, 7, 8\n", "6, 7, 8, 1, 2\n"));
    assert!(surplus.mesh.cells[0].nodes.len() == 8 && surplus.warnings[0].text.contains("more than eight"));
    let tets = "*ELEMENT, TYPE=C3D4, ELSET=T\n7, 1, 2, 3, 5\n";
    let MeshFile { mesh, warnings } = accepted(&format!("{BRICK}{tets}"));
    assert_eq!(mesh.cells[1].kind, CellKind::Tet4);
    assert!(warnings[0].text.contains("far too stiff"), "{warnings:?}");
}

#[test]
fn included_files_stand_in_their_place_and_are_named_in_messages() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let (nodes, rest) = BRICK.split_once("*ELEMENT").unwrap();
    std::fs::create_dir(folder.path().join("more")).unwrap();
    write("more/nodes.inp", nodes.strip_prefix("*NODE\n").unwrap());
    write("main.inp", &format!("*NODE\n*INCLUDE, INPUT=more/nodes.inp\n*ELEMENT{rest}"));
    let file = folder.path().join("main.inp");
    let read = || read_inp_file(&file, SI, false);
    let [mut parts, mut whole] = [read().unwrap(), accepted(BRICK)];
    let [inputs, _] = [&mut parts, &mut whole].map(|file| std::mem::take(&mut file.mesh.inputs));
    assert_eq!(format!("{parts:?}"), format!("{whole:?}"));
    let expected = ["main.inp", "more/nodes.inp"].map(|name| {
        let hash = blake3::hash(&std::fs::read(folder.path().join(name)).unwrap());
        (name.to_owned(), hash.to_hex().to_string())
    });
    assert_eq!(inputs.named(folder.path()), expected);

    write("more/nodes.inp", &nodes.replace("*NODE\n", "").replace("5, 0, 0, 1", "5, 0, nan, 1"));
    let message = read().unwrap_err().to_string();
    assert!(message.contains("nodes.inp:5: *NODE"), "{message}");
    write("more/nodes.inp", &nodes.replace("*NODE\n", ""));
    write("main.inp", &format!("*NODE\n*INCLUDE, INPUT=more/nodes.inp\n*ELEMENT{}", rest.replace("1, 0.3", "1, 0.7")));
    let message = read().unwrap_err().to_string();
    assert!(message.contains("main.inp:9: *ELASTIC"), "{message}");

    write("main.inp", "*INCLUDE, INPUT=main.inp\n");
    let message = read().unwrap_err().to_string();
    assert!(message.contains("main.inp:1") && message.contains("includes itself"), "{message}");
    write("main.inp", "*HEADING\n*INCLUDE, INPUT=nowhere.inp\n");
    let message = read().unwrap_err().to_string();
    assert!(message.contains("main.inp:2") && message.contains("nowhere.inp"), "{message}");
    refused("*INCLUDE\n", &["tet.inp:1", "INPUT is missing"]);
    refused("*INCLUDE, INPUT=/dev/zero\n", &["not a plain file"]);
}

#[test]
fn surfaces_are_read_by_faces_and_by_nodes() {
    let surfaces = "*SURFACE, NAME=Lid\n1, S2\n*SURFACE, NAME=SIDES, TYPE=ELEMENT\nE, S3\nE, s4\n\
                    *SURFACE, NAME=BASE, TYPE=NODE\nFLOOR,\n5, 1.\n";
    let MeshFile { mesh, warnings } = accepted(&format!("{BRICK}{surfaces}"));
    assert_eq!(warnings, []);
    assert_eq!(mesh.surface("LID"), Some([CellFace { cell: 0, face: 1 }].as_slice()));
    let sides = [CellFace { cell: 0, face: 2 }, CellFace { cell: 0, face: 3 }];
    assert_eq!(mesh.surface("sides"), Some(sides.as_slice()));
    assert_eq!(mesh.node_set("BASE"), Some([0, 1, 2, 3, 4].as_slice()));
    let strange = accepted(&format!("{BRICK}*SURFACE, NAME=X\nE, SPOS\n"));
    assert!(strange.mesh.surface("X").is_none() && strange.warnings[0].text.contains("passed over"));
    refused(&format!("{BRICK}*SURFACE, NAME=X\n9, S1\n"), &["tet.inp:21", "element 9"]);
    refused(&format!("{BRICK}*SURFACE, NAME=X\nEE, S1\n"), &["no element set is called \"EE\""]);
    refused(&format!("{TET}*SURFACE, NAME=X\n7, S5\n"), &["S5 of element 7", "S1 to S4 of a C3D10"]);
}

#[test]
fn held_displacements_are_read_and_nonsense_is_refused() {
    let with = |lines: &str| format!("{BRICK}*BOUNDARY\n{lines}\n");
    let mesh = accepted(&with("FLOOR, 3\n1, 1, 2\n7, 2, 2, 0.0\n8, XSYMM")).mesh;
    let held = |n: usize| mesh.supports.get(&n).copied().unwrap_or_default();
    assert_eq!((held(0), held(1)), ([true; 3], [false, false, true]));
    assert_eq!((held(6), held(7), held(4)), ([false, true, false], [true, false, false], [false; 3]));
    assert_eq!(accepted(&with("FLOOR, 1, 6")).mesh.supports.len(), 4);
    for (line, fragment) in [
        ("FLOOR, 3, 3, 0.1", "no value but 0"),
        ("FLOOR, 3, 1", "no value but 0"),
        ("FLOOR, 11", "directions 1 to 3"),
        ("FLOOR, 0", "directions 1 to 3"),
        ("FLOOR", "directions 1 to 3"),
        ("FLOR, 3", "no node set is called \"FLOR\" (did you mean \"FLOOR\"?)"),
        ("99, 3", "node 99"),
    ] {
        refused(&with(line), &["tet.inp:21", fragment]);
    }
    refused(&format!("{BRICK}*BOUNDARY, SUBMODEL\n"), &["tet.inp:20", "SUBMODEL"]);
}

#[test]
fn elements_that_are_no_solids_make_node_sets_and_may_not_have_a_section() {
    let lines = "*ELEMENT, TYPE=CPS4, ELSET=Surface1\n11, 5, 6, 7, 8\n*ELEMENT, TYPE=T3D2, ELSET=Line1\n12, 5, 6\n";
    let MeshFile { mesh, warnings } = accepted(&format!("{BRICK}{lines}"));
    assert_eq!(mesh.cells.len(), 1);
    assert_eq!(mesh.node_set("SURFACE1"), Some([4, 5, 6, 7].as_slice()));
    assert_eq!(mesh.node_set("line1"), Some([4, 5].as_slice()));
    assert_eq!(warnings.len(), 2);
    let section = format!("{BRICK}{lines}*SOLID SECTION, ELSET=Surface1, MATERIAL=M\n");
    refused(&section, &["tet.inp:24", "element 11, a CPS4"]);
    refused(&format!("{BRICK}*SHELL SECTION, ELSET=E, MATERIAL=M\n"), &["*SHELL SECTION", "solid elements"]);
    let set = "*NSET, NSET=ALL, ELSET=E\n";
    assert_eq!(accepted(&format!("{BRICK}{set}")).mesh.node_set("all").map(<[usize]>::len), Some(8));
}

fn deck(text: &str) -> Result<FrequencyStep, String> {
    parse_deck(text.as_bytes(), Path::new("tet.inp"), false, None).map(|d| d.frequency).map_err(|e| e.to_string())
}

#[test]
fn a_deck_gives_its_frequency_step_and_every_other_first_step_is_refused() {
    let step = |inside: &str| format!("{BRICK}*STEP\n{inside}\n*END STEP\n");
    let plain = FrequencyStep { modes: 7, from: f64::NEG_INFINITY, to: f64::INFINITY };
    assert_eq!(deck(&step("*FREQUENCY\n7")), Ok(plain));
    assert_eq!(
        deck(&step("*FREQUENCY, SOLVER=ARPACK, STORAGE=YES\n7, 1., 2e3")),
        Ok(FrequencyStep { from: 1.0, to: 2e3, ..plain })
    );
    let held =
        parse_deck(step("*FREQUENCY\n7\n*BOUNDARY\nFLOOR, 1, 3").as_bytes(), Path::new("d.inp"), false, None).unwrap();
    assert_eq!(held.mesh.supports.len(), 4);
    let later =
        format!("{}*STEP\n*STATIC\n*CLOAD\n1, 1, 1.\n*BOUNDARY\nFLOOR, 1, 3\n*END STEP\n", step("*FREQUENCY\n7"));
    let later = parse_deck(later.as_bytes(), Path::new("d.inp"), false, None).unwrap();
    assert!(later.mesh.supports.is_empty() && later.warnings[0].text.contains("later step"));
    let free = parse_deck(BRICK.as_bytes(), Path::new("d.inp"), false, Some(9)).unwrap();
    assert_eq!(free.frequency, FrequencyStep { modes: 9, ..plain });
    for (text, fragments) in [
        (step("*STATIC"), ["tet.inp:21", "first step is *STATIC"]),
        (step("*NODE PRINT, NSET=FLOOR\nU"), ["tet.inp:20", "no *FREQUENCY"]),
        (step("*FREQUENCY\n7\n*TEMPERATURE\nFLOOR, 1."), ["tet.inp:23", "*TEMPERATURE"]),
        (step("*FREQUENCY\n0"), ["tet.inp:22", "number of modes"]),
        (step("*FREQUENCY\n5, 3., 2."), ["tet.inp:22", "number of modes"]),
        (step("*FREQUENCY, CYCMPC=ACTIVE\n5"), ["tet.inp:21", "CYCMPC"]),
        (format!("{BRICK}*STEP, NLGEOM\n*FREQUENCY\n5\n*END STEP\n"), ["tet.inp:20", "NLGEOM"]),
        (format!("{BRICK}*STEP\n*FREQUENCY\n5\n"), ["tet.inp:", "no *END STEP"]),
        (BRICK.to_owned(), ["tet.inp:1", "no *STEP"]),
    ] {
        let message = deck(&text).unwrap_err();
        assert!(fragments.iter().all(|f| message.contains(f)), "{fragments:?} in {message}");
    }
}
