//! What is read from an `.inp` file, and what is passed over.

use super::*;
use stiffmap::mesh::{Warning, read_mesh_file};

#[test]
fn one_tetrahedron_is_read_with_sets_and_material() {
    let MeshFile { mesh, warnings } = accepted(TET);
    assert_eq!(warnings, []);
    assert_eq!((mesh.nodes.len(), mesh.nodes[9], mesh.node_labels[9]), (10, [0.0, 1.0, 1.0], 20));
    let cell = &mesh.cells[0];
    assert_eq!((cell.label, cell.material), (7, Some(0)));
    assert_eq!(cell.nodes, (0..10).collect::<Vec<_>>());
    assert_eq!(mesh.node_set("BASE"), Some([0, 1, 2, 4, 5, 6].as_slice()));
    assert_eq!(mesh.node_set("nALL").map(<[usize]>::len), Some(10));
    assert!(mesh.node_sets.contains_key("Nall"), "the spelling is kept");
    assert_eq!(mesh.element_set("eall"), Some([0].as_slice()));
    assert_eq!((mesh.node_set("BAES"), mesh.nearest_node_set("BAES")), (None, Some("BASE")));
    let steel = &mesh.materials[0];
    assert_eq!((steel.name.as_str(), steel.young, steel.poisson, steel.density), ("STEEL", 210e9, 0.3, 7850.0));
}

#[test]
fn the_bundled_meshes_are_read_whole_and_without_a_warning() {
    // Nodes from the meshes' description; elements and sets counted in the files.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/vertical_mill");
    for (name, nodes, cells, sets) in [
        ("column", 13_039, 6_629, 6),
        ("headstock", 6_629, 3_450, 8),
        ("spindle", 7_338, 3_991, 4),
        ("drive", 1_744, 862, 2),
        ("magazine", 1_882, 941, 2),
    ] {
        let MeshFile { mesh, warnings } = read_mesh_file(&folder.join(format!("{name}.inp")), SI).unwrap();
        assert_eq!(warnings, [], "{name}");
        let counts = (mesh.nodes.len(), mesh.cells.len(), mesh.node_sets.len());
        assert_eq!(counts, (nodes, cells, sets), "{name}");
        assert!(mesh.cells.iter().all(|cell| cell.material == Some(0)), "{name}");
    }
}

#[test]
fn case_spaces_line_ends_and_broken_lines_do_not_matter() {
    let plain = format!("{:?}", accepted(TET));
    let other = TET
        .replace("*ELEMENT, TYPE=C3D10, ELSET=EALL", "*Element ,\n type = c3d10,\n elset = EALL")
        .replace("7, 1, 2, 3, 4, 5, 6, 7, 8, 9, 20", "7, 1, 2, 3,\n** between\n\n 4, 5,6,7, 8\n9, 20,")
        .replace("*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL", "*solid section, material=steel, elset=eall\n,")
        .replace("*NODE, NSET=Nall", "*node, nset=\"Nall\"")
        .replace('\n', "\r\n");
    assert_eq!(format!("{:?}", accepted(&other)), plain);
    assert_ne!(format!("{:?}", accepted(&other.replace("0.3", "0.31"))), plain);
}

#[test]
fn sets_are_made_of_ranges_other_sets_and_several_sections() {
    let sets =
        "*NSET, NSET=A, GENERATE\n1, 9, 2\n2, 3\n*NSET, NSET=a\n 20, 1\n*NSET, NSET=B\nA, 4\n*ELSET, ELSET=E\nEALL\n";
    let mesh = accepted(&format!("{TET}{sets}")).mesh;
    assert_eq!(mesh.node_set("A"), Some([0, 1, 2, 4, 6, 8, 9].as_slice()));
    assert_eq!(mesh.node_set("b"), Some([0, 1, 2, 3, 4, 6, 8, 9].as_slice()));
    assert_eq!(mesh.element_set("E"), Some([0].as_slice()));
}

#[test]
fn millimetre_tonne_second_becomes_si() {
    let units = MeshUnits::MILLIMETRE_TONNE_SECOND;
    let text = changed("210e9", "210e3").replace("7850", "7.85e-9");
    let mesh = parse_inp(text.as_bytes(), Path::new("tet.inp"), units).unwrap().mesh;
    assert_eq!(mesh.nodes[1], [0.002, 0.0, 0.0]);
    let steel = &mesh.materials[0];
    assert!((steel.young / 210e9 - 1.0).abs() < 1e-15 && (steel.density / 7850.0 - 1.0).abs() < 1e-15);
}

#[test]
fn a_mesh_without_a_solid_section_has_no_material() {
    let mesh = accepted(&changed("*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL\n", "")).mesh;
    assert_eq!((mesh.cells[0].material, mesh.materials.len()), (None, 0));
}

#[test]
fn labels_far_apart_are_read() {
    let text = TET.replace("20, 0, 1, 1.0D+0", "900000000000, 0, 1, 1").replace("9, 20", "9, 900000000000");
    assert_eq!(accepted(&text).mesh.node_labels[9], 900_000_000_000);
}

#[test]
fn harmless_keywords_and_steps_are_passed_over_with_their_line() {
    let text = format!("{TET}*PREPRINT, ECHO=NO\n*STEP\n*BOUNDARY\nBASE, 1, 3\n*STATIC\n*END STEP\n*EL PRINT\nS\n");
    let lines: Vec<_> = accepted(&text).warnings.into_iter().map(|warning| (warning.line, warning.text)).collect();
    let [(26, preprint), (27, step), (32, print)] = lines.as_slice() else { panic!("{lines:?}") };
    assert!(preprint.contains("*PREPRINT") && step.contains("*END STEP") && print.contains("*EL PRINT"));
}

#[test]
fn unused_nodes_are_dropped_from_mesh_and_sets_with_a_warning() {
    let text = changed("1, 0, 0, 0\n", "100, 5, 5, 5\n1, 0, 0, 0\n");
    let MeshFile { mesh, warnings } = accepted(&text);
    assert_eq!((mesh.nodes.len(), mesh.node_labels[0]), (10, 1));
    assert_eq!(mesh.node_set("NALL").map(<[usize]>::len), Some(10));
    assert_eq!(mesh.cells[0].nodes[0], 0);
    let text = "1 nodes that no element uses are dropped, node 100 first".to_owned();
    assert_eq!(warnings, [Warning { line: 5, text }]);
}

#[test]
fn gaps_in_a_generated_range_are_warned_of_and_an_empty_range_is_refused() {
    let with = |range: &str| format!("{TET}*NSET, NSET=G, GENERATE\n{range}\n");
    let MeshFile { mesh, warnings } = accepted(&with("8, 18446744073709551615"));
    assert_eq!(mesh.node_set("G"), Some([7, 8, 9].as_slice()));
    assert!(warnings[0].line == 27 && warnings[0].text.contains("do not exist"), "{warnings:?}");
    refused(&with("100, 200, 1"), &["tet.inp:27", "node set \"G\" refers to node 100", "does not exist"]);
    refused(&with("3, 1"), &["tet.inp:27", "last label (not smaller)"]);
    refused(&with("1, 9, 0"), &["tet.inp:27", "step (at least 1)"]);
}

#[test]
fn a_file_without_a_last_line_end_is_read_with_a_warning() {
    let MeshFile { warnings, .. } = accepted(TET.trim_end());
    assert!(warnings[0].line == 25 && warnings[0].text.contains("cut off"), "{warnings:?}");
}
