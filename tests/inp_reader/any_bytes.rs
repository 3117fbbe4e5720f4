//! Any bytes at all: reading never panics, and what is accepted is consistent.

use super::*;
use proptest::prelude::*;

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
    "*ELEMENT, TYPE=C3D8, ELSET=B",
    "*ELEMENT, TYPE=CPS6, ELSET=C",
    "*SURFACE, NAME=S",
    "*SURFACE, NAME=S, TYPE=NODE",
    "*BOUNDARY",
    "*FREQUENCY",
    "*INCLUDE, INPUT=none",
    "*ELEMENT, TYPE=S3, ELSET=A",
    "*BOUNDARY, OP=NEW",
    "*NSET, NSET=\"A\"",
    "\"EALL\", S2",
    "8, 1, 2, 3, 4, 5, 6, 7, 8, 9, 20",
    "*NSET, NSET=B, ELSET=EALL",
    "EALL, S1",
    "7, S9",
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
    if let Ok(deck) = stiffmap::mesh::inp::parse_deck(bytes, Path::new("tet.inp"), false, None) {
        assert!(deck.frequency.modes > 0 && deck.frequency.from < deck.frequency.to);
    }
    let Ok(MeshFile { mesh, .. }) = parse_inp(bytes, Path::new("tet.inp"), SI) else {
        return;
    };
    assert!(!mesh.cells.is_empty());
    assert_eq!(mesh.nodes.len(), mesh.node_labels.len());
    assert!(mesh.nodes.iter().flatten().all(|x| x.is_finite()));
    for cell in &mesh.cells {
        assert_eq!(cell.nodes.len(), cell.kind.node_count());
        assert!(cell.nodes.iter().all(|&node| node < mesh.nodes.len()));
        assert!(cell.material.is_none_or(|material| material < mesh.materials.len()));
    }
    assert!(mesh.supports.keys().all(|&node| node < mesh.nodes.len()));
    for face in mesh.surfaces.values().flatten() {
        assert!(face.cell < mesh.cells.len() && face.face < mesh.cells[face.cell].kind.face_count());
    }
    let marks = mesh.face_sets.values().flatten().filter_map(|face| face.corners.as_ref());
    assert!(marks.flatten().all(|&node| node < mesh.nodes.len()));
    for nodes in mesh.namesakes.values().flatten().map(|namesake| &namesake.nodes) {
        assert!(nodes.windows(2).all(|pair| pair[0] < pair[1]) && nodes.iter().all(|&node| node < mesh.nodes.len()));
    }
    for (sets, count) in [(&mesh.node_sets, mesh.nodes.len()), (&mesh.element_sets, mesh.cells.len())] {
        for set in sets.values() {
            assert!(set.windows(2).all(|pair| pair[0] < pair[1]));
            assert!(set.last().is_none_or(|&last| last < count));
        }
    }
}
