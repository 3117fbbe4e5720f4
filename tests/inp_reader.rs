//! The reader of `.inp` files: what is read, and what is refused with which words.

use proptest::prelude::*;
use std::path::Path;
use stiffmap::machine::MeshUnits;
use stiffmap::mesh::inp::parse_inp;
use stiffmap::mesh::{MeshFile, Warning, read_mesh, read_mesh_file};

const SI: MeshUnits = MeshUnits::METRE_KILOGRAM_SECOND;

/// One tetrahedron with everything that a part needs; the tests change a line of it.
const TET: &str = "** a comment
*HEADING
one tetrahedron, label 7
*NODE, NSET=Nall
1, 0, 0, 0
2, 2, 0, 0
3, 0, 2, 0
4, 0, 0, 2
5, 1, 0, 0
6, 1, 1, 0
7, 0, 1, 0
8, 0, 0, 1
9, 1, 0, 1
20, 0, 1, 1.0D+0
*ELEMENT, TYPE=C3D10, ELSET=EALL
7, 1, 2, 3, 4, 5, 6, 7, 8, 9, 20
*NSET, NSET=BASE
1, 2, 3,
5, 6, 7
*MATERIAL, NAME=STEEL
*ELASTIC
210e9, 0.3
*DENSITY
7850
*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL
";

fn parse(text: &str) -> Result<MeshFile, String> {
    parse_inp(text.as_bytes(), Path::new("tet.inp"), SI).map_err(|error| error.to_string())
}

fn changed(from: &str, to: &str) -> String {
    assert!(TET.contains(from), "{from:?} is not in the tetrahedron");
    TET.replacen(from, to, 1)
}

#[track_caller]
fn accepted(text: &str) -> MeshFile {
    parse(text).unwrap_or_else(|message| panic!("{message}"))
}

/// Checks that a file is refused, and that the message names the file and holds every fragment.
#[track_caller]
fn refused(text: &str, fragments: &[&str]) {
    let message = match parse(text) {
        Ok(_) => panic!("accepted; expected a refusal with {fragments:?}"),
        Err(message) => message,
    };
    for fragment in ["tet.inp:"].iter().chain(fragments) {
        assert!(
            message.contains(fragment),
            "{fragment:?} is not in: {message}"
        );
    }
}

#[track_caller]
fn refused_change(from: &str, to: &str, fragments: &[&str]) {
    refused(&changed(from, to), fragments);
}

// ---- What is read ---------------------------------------------------------------------------------

#[test]
fn one_tetrahedron_is_read_with_sets_and_material() {
    let MeshFile { mesh, warnings } = accepted(TET);
    assert_eq!(warnings, []);
    assert_eq!(
        (mesh.nodes.len(), mesh.nodes[9], mesh.node_labels[9]),
        (10, [0.0, 1.0, 1.0], 20)
    );
    let cell = &mesh.cells[0];
    assert_eq!((cell.label, cell.material), (7, Some(0)));
    assert_eq!(cell.nodes, (0..10).collect::<Vec<_>>());
    assert_eq!(mesh.node_set("BASE"), Some([0, 1, 2, 4, 5, 6].as_slice()));
    assert_eq!(mesh.node_set("nALL").map(<[usize]>::len), Some(10));
    assert!(mesh.node_sets.contains_key("Nall"), "the spelling is kept");
    assert_eq!(mesh.element_set("eall"), Some([0].as_slice()));
    assert_eq!(
        (mesh.node_set("BAES"), mesh.nearest_node_set("BAES")),
        (None, Some("BASE"))
    );
    let steel = &mesh.materials[0];
    assert_eq!(
        (
            steel.name.as_str(),
            steel.young,
            steel.poisson,
            steel.density
        ),
        ("STEEL", 210e9, 0.3, 7850.0)
    );
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
        let MeshFile { mesh, warnings } =
            read_mesh_file(&folder.join(format!("{name}.inp")), SI).unwrap();
        assert_eq!(warnings, [], "{name}");
        let counts = (mesh.nodes.len(), mesh.cells.len(), mesh.node_sets.len());
        assert_eq!(counts, (nodes, cells, sets), "{name}");
        assert!(
            mesh.cells.iter().all(|cell| cell.material == Some(0)),
            "{name}"
        );
    }
}

#[test]
fn case_spaces_line_ends_and_broken_lines_do_not_matter() {
    let plain = format!("{:?}", accepted(TET));
    let other = TET
        .replace(
            "*ELEMENT, TYPE=C3D10, ELSET=EALL",
            "*Element ,\n type = c3d10,\n elset = EALL",
        )
        .replace(
            "7, 1, 2, 3, 4, 5, 6, 7, 8, 9, 20",
            "7, 1, 2, 3,\n** between\n\n 4, 5,6,7, 8\n9, 20,",
        )
        .replace(
            "*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL",
            "*solid section, material=steel, elset=eall\n,",
        )
        .replace("*NODE, NSET=Nall", "*node, nset=\"Nall\"")
        .replace('\n', "\r\n");
    assert_eq!(format!("{:?}", accepted(&other)), plain);
    assert_ne!(
        format!("{:?}", accepted(&other.replace("0.3", "0.31"))),
        plain
    );
}

#[test]
fn sets_are_made_of_ranges_other_sets_and_several_sections() {
    let sets = "*NSET, NSET=A, GENERATE\n1, 9, 2\n2, 3\n*NSET, NSET=a\n 20, 1\n*NSET, NSET=B\nA, 4\n*ELSET, ELSET=E\nEALL\n";
    let mesh = accepted(&format!("{TET}{sets}")).mesh;
    assert_eq!(mesh.node_set("A"), Some([0, 1, 2, 4, 6, 8, 9].as_slice()));
    assert_eq!(
        mesh.node_set("b"),
        Some([0, 1, 2, 3, 4, 6, 8, 9].as_slice())
    );
    assert_eq!(mesh.element_set("E"), Some([0].as_slice()));
}

#[test]
fn millimetre_tonne_second_becomes_si() {
    let units = MeshUnits::MILLIMETRE_TONNE_SECOND;
    let text = changed("210e9", "210e3").replace("7850", "7.85e-9");
    let mesh = parse_inp(text.as_bytes(), Path::new("tet.inp"), units)
        .unwrap()
        .mesh;
    assert_eq!(mesh.nodes[1], [0.002, 0.0, 0.0]);
    let steel = &mesh.materials[0];
    assert!(
        (steel.young / 210e9 - 1.0).abs() < 1e-15 && (steel.density / 7850.0 - 1.0).abs() < 1e-15
    );
}

#[test]
fn a_mesh_without_a_solid_section_has_no_material() {
    let mesh = accepted(&changed("*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL\n", "")).mesh;
    assert_eq!((mesh.cells[0].material, mesh.materials.len()), (None, 0));
}

#[test]
fn labels_far_apart_are_read() {
    let text = TET
        .replace("20, 0, 1, 1.0D+0", "900000000000, 0, 1, 1")
        .replace("9, 20", "9, 900000000000");
    assert_eq!(accepted(&text).mesh.node_labels[9], 900_000_000_000);
}

// ---- What is passed over --------------------------------------------------------------------------

#[test]
fn harmless_keywords_and_steps_are_passed_over_with_their_line() {
    let text = format!(
        "{TET}*PREPRINT, ECHO=NO\n*STEP\n*BOUNDARY\nBASE, 1, 3\n*STATIC\n*END STEP\n*EL PRINT\nS\n"
    );
    let lines: Vec<_> = accepted(&text)
        .warnings
        .into_iter()
        .map(|warning| (warning.line, warning.text))
        .collect();
    let [(26, preprint), (27, step), (32, print)] = lines.as_slice() else {
        panic!("{lines:?}")
    };
    assert!(
        preprint.contains("*PREPRINT") && step.contains("*END STEP") && print.contains("*EL PRINT")
    );
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
    assert!(
        warnings[0].line == 27 && warnings[0].text.contains("do not exist"),
        "{warnings:?}"
    );
    refused(
        &with("100, 200, 1"),
        &[
            "tet.inp:27",
            "node set \"G\" refers to node 100",
            "does not exist",
        ],
    );
    refused(&with("3, 1"), &["tet.inp:27", "last label (not smaller)"]);
    refused(&with("1, 9, 0"), &["tet.inp:27", "step (at least 1)"]);
}

#[test]
fn a_file_without_a_last_line_end_is_read_with_a_warning() {
    let MeshFile { warnings, .. } = accepted(TET.trim_end());
    assert!(
        warnings[0].line == 25 && warnings[0].text.contains("cut off"),
        "{warnings:?}"
    );
}

// ---- What is refused ------------------------------------------------------------------------------

#[test]
fn keywords_that_would_change_the_result_are_refused_with_what_to_do() {
    for (keyword, advice) in [
        ("*BOUNDARY", "clamped"),
        ("*MPC", "joints in the machine file"),
        ("*EQUATION", "joints in the machine file"),
        ("*TIE, NAME=T", "joints in the machine file"),
        ("*TRANSFORM, NSET=BASE", "global Cartesian"),
        ("*ORIENTATION, NAME=O", "isotropic"),
        ("*INCLUDE, INPUT=more.inp", "in its place"),
        ("*PART, NAME=P", "flat input file"),
        ("*INSTANCE, NAME=P", "flat input file"),
        ("*PLASTIC", "*ELASTIC and *DENSITY"),
        ("*SHELL SECTION", "remove it if it does not matter"),
        ("*NONSENSE", "remove it if it does not matter"),
    ] {
        let spelling = keyword.split(',').next().unwrap();
        refused(
            &format!("{TET}{keyword}\n"),
            &["tet.inp:26", &format!("the keyword {spelling} "), advice],
        );
    }
}

#[test]
fn parameters_and_types_that_are_not_supported_are_refused() {
    refused_change(
        "TYPE=C3D10",
        "TYPE=C3D4",
        &["tet.inp:15: *ELEMENT", "\"C3D4\"", "TYPE=C3D10"],
    );
    refused_change("TYPE=C3D10, ", "", &["TYPE is missing"]);
    refused_change(
        "*NODE, NSET=Nall",
        "*NODE, SYSTEM=C",
        &["tet.inp:4: *NODE", "SYSTEM", "NSET"],
    );
    refused_change(
        "*ELASTIC",
        "*ELASTIC, TYPE=ORTHO",
        &["tet.inp:21: *ELASTIC: TYPE=ORTHO", "TYPE=ISO"],
    );
    refused_change(
        "*NSET, NSET=BASE",
        "*NSET, NSET=BASE, INSTANCE=P",
        &["tet.inp:17: *NSET", "INSTANCE"],
    );
    refused_change("*NSET, NSET=BASE", "*NSET", &["NSET is missing"]);
    refused_change(
        "ELSET=EALL, MATERIAL",
        "ORIENTATION=O, ELSET=EALL, MATERIAL",
        &["SOLID SECTION", "ORIENTATION"],
    );
}

#[test]
fn a_truncated_file_is_refused() {
    let cut = |at: &str| &TET[..TET.find(at).unwrap() + at.len()];
    refused(
        cut("7, 1, 2, 3, 4,"),
        &[
            "tet.inp:16",
            "*ELEMENT ends too early",
            "lacks 6 of 10 nodes",
        ],
    );
    refused_change(
        "8, 9, 20\n",
        "8, 9\n",
        &["*ELEMENT ends too early", "lacks 1 of 10 nodes"],
    );
    refused(cut("8, 0, 0, 1\n"), &["no elements"]);
    refused(
        cut("8, 0,"),
        &["tet.inp:12", "found \"8, 0,\"", "three finite coordinates"],
    );
    refused("", &["no elements"]);
    refused(
        cut("*ELASTIC"),
        &["tet.inp:21", "*ELASTIC lacks its data line"],
    );
    refused(
        &format!("{TET}*STEP\n*STATIC\n"),
        &["tet.inp:27", "no *END STEP for the *STEP of line 26"],
    );
    refused_change(
        "20, 0, 1, 1.0D+0\n",
        "",
        &["tet.inp:15", "element 7 refers to node 20", "cut off"],
    );
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
    refused_change(
        "2, 2, 0, 0",
        "1, 2, 0, 0",
        &["tet.inp:6", "node 1 is given twice"],
    );
    refused_change(
        "8, 9, 20\n",
        "8, 9, 20\n7, 1, 2, 3, 4, 5, 6, 7, 8, 9, 20\n",
        &["tet.inp:17", "element 7 is given twice"],
    );
    refused_change(
        "5, 6, 7\n",
        "5, 6, 77\n",
        &["tet.inp:19", "node set \"BASE\" refers to node 77"],
    );
    refused_change(
        "8, 9, 20\n",
        "8, 9, 9\n",
        &["tet.inp:16", "not node 9 twice"],
    );
    refused_change("8, 9, 20\n", "8, 9, 20, 1\n", &["tet.inp:16", "no more"]);
    refused_change(
        "5, 6, 7\n",
        "TOP\n",
        &["tet.inp:19", "no node set above is called \"TOP\""],
    );
    refused_change("5, 6, 7\n", "-5\n", &["tet.inp:19", "found \"-5\""]);
    refused(
        &format!("{TET}*MATERIAL, NAME=Steel\n"),
        &["tet.inp:26", "material Steel is given twice"],
    );
}

#[test]
fn numbers_that_are_no_numbers_are_refused() {
    for (from, bad) in [
        ("2, 2, 0, 0", "2, nan, 0, 0"),
        ("2, 2, 0, 0", "2, inf, 0, 0"),
        ("2, 2, 0, 0", "2, 1e999, 0, 0"),
    ] {
        refused_change(
            from,
            bad,
            &[
                "tet.inp:6: *NODE",
                &format!("{bad:?}"),
                "finite coordinates",
            ],
        );
    }
    refused_change("2, 2, 0, 0", "2, 2, 0, 0, 1", &["no more"]);
    refused_change(
        "2, 2, 0, 0",
        "99999999999999999999, 2, 0, 0",
        &["tet.inp:6"],
    );
    refused_change("2, 2, 0, 0", "two, 2, 0, 0", &["\"two, 2, 0, 0\""]);
    refused_change(
        "7, 1, 2,",
        "7, 1.5, 2,",
        &["tet.inp:16: *ELEMENT: found \"1.5\"", "whole numbers"],
    );
    refused_change(
        "one tetrahedron",
        "one\0tetrahedron",
        &["tet.inp:3", "UTF-8"],
    );
    let latin = [b"*HEADING\nK", [0xf6].as_slice(), b"rper\n"].concat();
    let message = parse_inp(&latin, Path::new("tet.inp"), SI)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("tet.inp:2") && message.contains("UTF-8"),
        "{message}"
    );
}

#[test]
fn materials_outside_physics_are_refused() {
    refused_change(
        "7850",
        "-7850",
        &["tet.inp:24: *DENSITY", "\"-7850\"", "positive density"],
    );
    refused_change("7850", "nan", &["tet.inp:24: *DENSITY", "finite"]);
    refused_change(
        "210e9, 0.3",
        "-210e9, 0.3",
        &["tet.inp:22: *ELASTIC", "positive Young's modulus"],
    );
    refused_change(
        "210e9, 0.3",
        "210e9, 0.5",
        &["tet.inp:22: *ELASTIC", "less than 0.5"],
    );
    refused_change(
        "210e9, 0.3",
        "210e9",
        &["Young's modulus and Poisson's ratio"],
    );
    refused_change(
        "210e9, 0.3",
        "210e9, 0.3, 20\n200e9, 0.3, 100",
        &["tet.inp:23", "depend on temperature"],
    );
    refused_change(
        "*DENSITY\n7850\n",
        "",
        &["tet.inp:23", "\"STEEL\" has no density", "*DENSITY"],
    );
    refused_change(
        "*ELASTIC\n210e9, 0.3\n",
        "",
        &["\"STEEL\" has no Young's modulus"],
    );
    refused_change(
        "*MATERIAL, NAME=STEEL\n",
        "",
        &["*ELASTIC: it stands before the first *MATERIAL"],
    );
    refused_change("*DENSITY", "*DENSITY\n1\n*DENSITY", &["\"STEEL\" has two"]);
    refused_change(
        "MATERIAL=STEEL",
        "MATERIAL=STEAL",
        &["tet.inp:25", "no material is called \"STEAL\"", "\"STEEL\""],
    );
    refused_change(
        "ELSET=EALL, MATERIAL",
        "ELSET=EAL, MATERIAL",
        &["no element set is called \"EAL\"", "\"EALL\""],
    );
    let second = "*MATERIAL, NAME=IRON\n*ELASTIC\n1, 0\n*DENSITY\n1\n*SOLID SECTION, ELSET=EALL, MATERIAL=IRON\n";
    refused(
        &format!("{TET}{second}"),
        &["tet.inp:31", "element 7 already has the material \"STEEL\""],
    );
}

#[test]
fn data_without_a_keyword_and_other_formats_are_refused() {
    refused(
        "1, 2, 3\n*HEADING\n",
        &["tet.inp:1", "found \"1, 2, 3\" where a keyword is expected"],
    );
    let message = read_mesh(Path::new("part.stl"), SI)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("part.stl: unknown mesh format \"stl\"") && message.contains("\"inp\""),
        "{message}"
    );
    let message = read_mesh(Path::new("no such part.inp"), SI)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("no such part.inp: cannot read"),
        "{message}"
    );
}

#[test]
fn sets_that_would_fill_the_memory_are_refused() {
    // 1,000 sets of all nodes, again and again by name: 64 MB of text would ask for terabytes.
    let mut text = TET.to_owned();
    let range = "1, 18446744073709551615\n".repeat(100);
    for set in 0..1000 {
        text.push_str(&format!("*NSET, NSET=S{set}, GENERATE\n{range}"));
    }
    let mesh = accepted(&text).mesh;
    assert_eq!(mesh.node_set("S999").map(<[usize]>::len), Some(10));
}

// ---- Any bytes at all -----------------------------------------------------------------------------

proptest! {
    /// Reading never panics, and what is accepted is consistent.
    #[test]
    fn any_mutation_of_a_file_is_read_or_refused(
        edits in prop::collection::vec((0..TET.len(), any::<u8>(), 0usize..4), 1..6)
    ) {
        let mut bytes = TET.as_bytes().to_vec();
        for (at, byte, action) in edits {
            let at = at.min(bytes.len().saturating_sub(1));
            match action {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, b"*,=\n0-E "[byte as usize % 8]),
                2 => bytes.truncate(at + 1),
                _ => { bytes.remove(at); if bytes.is_empty() { bytes.push(byte) } }
            }
        }
        check(&bytes);
    }

    /// Words of the language in any order.
    #[test]
    fn any_sequence_of_words_is_read_or_refused(words in prop::collection::vec(0..WORDS.len(), 0..60)) {
        let text: String = words.into_iter().map(|word| WORDS[word]).collect();
        check(text.as_bytes());
        check(format!("{TET}{text}").as_bytes());
    }

    /// Any bytes.
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        check(&bytes);
    }
}

const WORDS: &[&str] = &[
    "*",
    "**",
    "*NODE",
    "*ELEMENT, TYPE=C3D10",
    "*NSET, NSET=A",
    "*ELSET, ELSET=A",
    ", GENERATE",
    "*MATERIAL, NAME=M",
    "*ELASTIC",
    "*DENSITY",
    "*SOLID SECTION, ELSET=A, MATERIAL=M",
    "*STEP",
    "*END STEP",
    "*HEADING",
    "\n",
    "\n",
    "\n",
    ",",
    ", ",
    "=",
    "1",
    "2",
    "18446744073709551615",
    "-1",
    "1e308",
    "A",
    "\u{e9}",
    "\"",
    "\r",
    "\t",
];

fn check(bytes: &[u8]) {
    let Ok(MeshFile { mesh, .. }) = parse_inp(bytes, Path::new("tet.inp"), SI) else {
        return;
    };
    assert!(!mesh.cells.is_empty());
    assert_eq!(mesh.nodes.len(), mesh.node_labels.len());
    assert!(mesh.nodes.iter().flatten().all(|x| x.is_finite()));
    for cell in &mesh.cells {
        assert_eq!(cell.nodes.len(), cell.kind.node_count());
        assert!(cell.nodes.iter().all(|&node| node < mesh.nodes.len()));
        assert!(
            cell.material
                .is_none_or(|material| material < mesh.materials.len())
        );
    }
    for (sets, count) in [
        (&mesh.node_sets, mesh.nodes.len()),
        (&mesh.element_sets, mesh.cells.len()),
    ] {
        for set in sets.values() {
            assert!(set.windows(2).all(|pair| pair[0] < pair[1]));
            assert!(set.last().is_none_or(|&last| last < count));
        }
    }
}
