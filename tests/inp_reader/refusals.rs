//! What is refused in an `.inp` file.

use super::*;
use stiffmap::mesh::read_mesh;

#[test]
fn keywords_that_would_change_the_result_are_refused_with_what_to_do() {
    for (keyword, advice) in [
        ("*MPC", "joints in the machine file"),
        ("*EQUATION", "joints in the machine file"),
        ("*TIE, NAME=T", "joints in the machine file"),
        ("*TRANSFORM, NSET=BASE", "global Cartesian"),
        ("*PART, NAME=P", "flat input file"),
        ("*INSTANCE, NAME=P", "flat input file"),
        ("*PLASTIC", "*ELASTIC and *DENSITY"),
        ("*SHELL SECTION", "solid elements"),
        ("*RIGID BODY", "joints in the machine file"),
        ("*CYCLIC SYMMETRY MODEL", "whole body"),
        ("*NONSENSE", "remove it if it does not matter"),
    ] {
        let spelling = keyword.split(',').next().unwrap();
        refused(&format!("{TET}{keyword}\n"), &["tet.inp:26", &format!("the keyword {spelling} "), advice]);
    }
}

#[test]
fn parameters_and_types_that_are_not_supported_are_refused() {
    refused_change("TYPE=C3D10", "TYPE=C3D10M", &["tet.inp:15: *ELEMENT", "\"C3D10M\"", "C3D20R"]);
    refused_change("TYPE=C3D10, ", "", &["TYPE is missing"]);
    refused_change("*NODE, NSET=Nall", "*NODE, SYSTEM=C", &["tet.inp:4: *NODE", "SYSTEM", "NSET"]);
    refused_change("*ELASTIC", "*ELASTIC, TYPE=ORTHO", &["tet.inp:21: *ELASTIC: TYPE=ORTHO", "TYPE=ISO"]);
    refused_change("*NSET, NSET=BASE", "*NSET, NSET=BASE, INSTANCE=P", &["tet.inp:17: *NSET", "INSTANCE"]);
    refused_change("*NSET, NSET=BASE", "*NSET", &["NSET is missing"]);
    refused_change("ELSET=EALL, MATERIAL", "COMPOSITE, ELSET=EALL, MATERIAL", &["SOLID SECTION", "COMPOSITE"]);
}

#[test]
fn a_truncated_file_is_refused() {
    let cut = |at: &str| &TET[..TET.find(at).unwrap() + at.len()];
    refused(cut("7, 1, 2, 3, 4,"), &["tet.inp:16", "*ELEMENT ends too early", "lacks 6 of 10 nodes"]);
    refused_change("8, 9, 20\n", "8, 9\n", &["*ELEMENT ends too early", "lacks 1 of 10 nodes"]);
    refused(cut("8, 0, 0, 1\n"), &["no elements"]);
    refused(cut("8, 0,"), &["tet.inp:12", "found \"8, 0,\"", "three finite coordinates"]);
    refused("", &["no elements"]);
    refused(cut("*ELASTIC"), &["tet.inp:21", "*ELASTIC lacks its data line"]);
    refused(&format!("{TET}*STEP\n*STATIC\n"), &["tet.inp:27", "no *END STEP for the *STEP of line 26"]);
    refused_change("20, 0, 1, 1.0D+0\n", "", &["tet.inp:15", "element 7 refers to node 20", "cut off"]);
}

#[test]
fn every_line_cut_of_the_tetrahedron_is_refused_or_gives_its_one_element_whole() {
    for end in 0..TET.len() {
        if let Ok(MeshFile { mesh, .. }) = parse(&TET[..end]) {
            assert_eq!(mesh.cells.len(), 1, "cut at {end}");
            assert!(end >= TET.find("8, 9, 2").unwrap() + 7, "cut at {end}");
        }
    }
}

#[test]
fn labels_given_twice_or_missing_are_refused() {
    refused_change("2, 2, 0, 0", "1, 2, 0, 0", &["tet.inp:6", "node 1 is given twice"]);
    refused_change(
        "8, 9, 20\n",
        "8, 9, 20\n7, 1, 3, 2, 7, 6, 5, 8, 20, 9, 4\n",
        &["tet.inp:17", "element 7 is given twice"],
    );
    refused_change("5, 6, 7\n", "5, 6, 77\n", &["tet.inp:19", "node set \"BASE\" refers to node 77"]);
    refused_change("8, 9, 20\n", "8, 9, 9\n", &["tet.inp:16", "not node 9 twice"]);
    refused_change("8, 9, 20\n", "8, 9, 20, 1\n", &["tet.inp:16", "no more"]);
    refused_change("5, 6, 7\n", "TOP\n", &["tet.inp:19", "no node set above is called \"TOP\""]);
    refused_change("5, 6, 7\n", "-5\n", &["tet.inp:19", "found \"-5\""]);
    refused(&format!("{TET}*MATERIAL, NAME=Steel\n"), &["tet.inp:26", "material Steel is given twice"]);
}

#[test]
fn numbers_that_are_no_numbers_are_refused() {
    for (from, bad) in
        [("2, 2, 0, 0", "2, nan, 0, 0"), ("2, 2, 0, 0", "2, inf, 0, 0"), ("2, 2, 0, 0", "2, 1e999, 0, 0")]
    {
        refused_change(from, bad, &["tet.inp:6: *NODE", &format!("{bad:?}"), "finite coordinates"]);
    }
    refused_change("2, 2, 0, 0", "2, 2, 0, 0, 1", &["no more"]);
    refused_change("2, 2, 0, 0", "99999999999999999999, 2, 0, 0", &["tet.inp:6"]);
    refused_change("2, 2, 0, 0", "two, 2, 0, 0", &["\"two, 2, 0, 0\""]);
    refused_change("7, 1, 2,", "7, 1.5, 2,", &["tet.inp:16: *ELEMENT: found \"1.5\"", "whole numbers"]);
    refused_change("one tetrahedron", "one\0tetrahedron", &["tet.inp:3", "UTF-8"]);
    let latin = [b"*HEADING\nK", [0xf6].as_slice(), b"rper\n"].concat();
    let message = parse_inp(&latin, Path::new("tet.inp"), SI).unwrap_err().to_string();
    assert!(message.contains("tet.inp:2") && message.contains("UTF-8"), "{message}");
}

#[test]
fn materials_outside_physics_are_refused() {
    refused_change("7850", "-7850", &["tet.inp:24: *DENSITY", "\"-7850\"", "positive density"]);
    refused_change("7850", "nan", &["tet.inp:24: *DENSITY", "finite"]);
    refused_change("210e9, 0.3", "-210e9, 0.3", &["tet.inp:22: *ELASTIC", "positive Young's modulus"]);
    refused_change("210e9, 0.3", "210e9, 0.5", &["tet.inp:22: *ELASTIC", "less than 0.5"]);
    refused_change("210e9, 0.3", "210e9", &["Young's modulus and Poisson's ratio"]);
    refused_change("210e9, 0.3", "210e9, 0.3, 20\n200e9, 0.3, 100", &["tet.inp:23", "depend on temperature"]);
    refused_change("*DENSITY\n7850\n", "", &["tet.inp:23", "\"STEEL\" has no density", "*DENSITY"]);
    refused_change("*ELASTIC\n210e9, 0.3\n", "", &["\"STEEL\" has no Young's modulus"]);
    refused_change("*MATERIAL, NAME=STEEL\n", "", &["*ELASTIC: it stands before the first *MATERIAL"]);
    refused_change("*DENSITY", "*DENSITY\n1\n*DENSITY", &["\"STEEL\" has two"]);
    refused_change("MATERIAL=STEEL", "MATERIAL=STEAL", &["tet.inp:25", "no material is called \"STEAL\"", "\"STEEL\""]);
    refused_change("ELSET=EALL, MATERIAL", "ELSET=EAL, MATERIAL", &["no element set is called \"EAL\"", "\"EALL\""]);
    let second = "*MATERIAL, NAME=IRON\n*ELASTIC\n1, 0\n*DENSITY\n1\n*SOLID SECTION, ELSET=EALL, MATERIAL=IRON\n";
    refused(&format!("{TET}{second}"), &["tet.inp:31", "element 7 already has the material \"STEEL\""]);
}

#[test]
fn data_without_a_keyword_and_other_formats_are_refused() {
    refused("1, 2, 3\n*HEADING\n", &["tet.inp:1", "found \"1, 2, 3\" where a keyword is expected"]);
    let message = read_mesh(Path::new("part.stl"), SI).unwrap_err().to_string();
    assert!(message.contains("part.stl: unknown mesh format \"stl\"") && message.contains("\"inp\""), "{message}");
    let message = read_mesh(Path::new("no such part.inp"), SI).unwrap_err().to_string();
    assert!(message.contains("no such part.inp: cannot read"), "{message}");
}

#[test]
fn endless_ranges_cost_no_more_than_the_mesh_has_labels() {
    let ranges = "1, 18446744073709551615\n".repeat(20_000);
    let mesh = accepted(&format!("{TET}*NSET, NSET=S, GENERATE\n{ranges}")).mesh;
    assert_eq!(mesh.node_set("S").map(<[usize]>::len), Some(10));
}

#[test]
fn sets_that_would_fill_the_memory_are_refused() {
    let sets: String = (0..60_000).map(|set| format!("*NSET, NSET=S{set}\nNall, Nall\n")).collect();
    refused(&format!("{TET}{sets}"), &["more than 1000000 members", "not needed"]);
}
