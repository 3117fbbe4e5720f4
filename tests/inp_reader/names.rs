//! Names in quotes, with blanks and with digits.

use super::*;
use stiffmap::mesh::inp::parse_deck;

#[test]
fn names_in_quotes_are_read_in_keyword_and_data_lines() {
    let text = TET
        .replace("ELSET=EALL", "ELSET=\"whole body\"")
        .replace("MATERIAL=STEEL", "MATERIAL=\"Steel C45, (1.0503)\"")
        .replace("NAME=STEEL", "NAME=\"Steel C45, (1.0503)\"")
        .replace("NSET=BASE", "NSET=\"base plate\"");
    let more = "*NSET, NSET=\"both, of them\"\n\"base plate\", 8\n*ELSET, ELSET=E\n\"whole body\"\n\
                *SURFACE, TYPE=ELEMENT, NAME=\"tip face\"\n\"whole body\", S1\n*BOUNDARY\n\"base plate\", 1, 3\n";
    let MeshFile { mesh, warnings } = accepted(&(text.clone() + more));
    assert_eq!(warnings, []);
    assert_eq!(mesh.node_set("both, of them").map(<[usize]>::len), Some(7));
    assert_eq!(mesh.element_set("E"), Some([0].as_slice()));
    assert_eq!(mesh.surface("tip face").map(<[_]>::len), Some(1));
    assert_eq!((mesh.supports.len(), mesh.materials[0].name.as_str()), (6, "Steel C45, (1.0503)"));
    // Case and blanks do not matter, and a reference may leave the quotes out.
    assert_eq!(accepted(&format!("{text}*BOUNDARY\nBASEPLATE, 1\n")).mesh.supports.len(), 6);
    refused(&format!("{text}*BOUNDARY\n\"base plat\", 1\n"), &["tet.inp:27", "\"base plat\"", "\"base plate\""]);
}

#[test]
fn names_that_abaqus_tells_apart_by_quotes_are_refused() {
    let said = ["tet.inp:27", "\"Base\" differs from BASE", "rename one"];
    refused(&format!("{TET}*NSET, NSET=\"Base\"\n8\n"), &said);
    refused(&format!("{TET}*ELSET, ELSET=\"a b\"\n7\n*ELSET, ELSET=\"a B\"\n7\n"), &["\"a B\" differs from \"a b\""]);
    refused(&format!("{TET}*MATERIAL, NAME=\"Steel\"\n"), &["tet.inp:26", "\"Steel\" differs from STEEL"]);
    // Without quotes blanks and case mean nothing, to Abaqus as to CalculiX: the pieces are one set.
    let mesh = accepted(&format!("{TET}*NSET, NSET=Ba se\n8\n")).mesh;
    assert_eq!(mesh.node_set("BASE").map(<[usize]>::len), Some(7));
}

#[test]
fn names_that_begin_with_a_digit_are_referred_to() {
    let text = TET.replace("NSET=BASE", "NSET=1_base").replace("ELSET=EALL", "ELSET=1_body");
    let more =
        "*NSET, NSET=both\n1_base, 8\n*NSET, NSET=2nd\n1_BASE\n*BOUNDARY\n1_base, 1, 3\n*SURFACE, NAME=3\n1_body, S2\n";
    let mesh = accepted(&format!("{text}{more}")).mesh;
    assert_eq!((mesh.node_set("both").map(<[usize]>::len), mesh.supports.len()), (Some(7), 6));
    assert_eq!((mesh.node_set("2nd").map(<[usize]>::len), mesh.surface("3").map(<[_]>::len)), (Some(6), Some(1)));
    for wrong in ["-5", "1.5", "99999999999999999999"] {
        refused(&format!("{text}*NSET, NSET=both\n{wrong}\n"), &["tet.inp:27", &format!("found \"{wrong}\"")]);
    }
    refused(&format!("{text}*NSET, NSET=both\n1_bass\n"), &["no node set above is called \"1_bass\"", "1_base"]);
    let deck = format!("{text}*BOUNDARY\n1_base, 1, 3\n*STEP\n*FREQUENCY\n3\n*END STEP\n");
    assert_eq!(parse_deck(deck.as_bytes(), Path::new("d.inp"), false, None).unwrap().mesh.supports.len(), 6);
}
