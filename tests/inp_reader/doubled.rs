//! Elements that stand twice in a file.

use super::groove::{bar, inp, msh, walls};
use super::support::{on, part};
use super::{BRICK, SI, TET, accepted, changed, parse, refused};
use std::path::Path;
use stiffmap::mesh::msh::parse_msh;
use stiffmap::mesh::{CellKind, MeshFile};
use stiffmap::solid::assemble;

/// Mass and area of an interface.
fn figures(file: &MeshFile, set: &str) -> (f64, f64) {
    let mut bar = part("bar", &[], vec![on(set)]);
    bar.material = Some(super::support::steel());
    let system = assemble(&bar, &file.mesh).unwrap_or_else(|error| panic!("{error}"));
    (system.total_mass, system.interfaces[0].area)
}

#[test]
fn an_element_that_stands_twice_counts_once_and_is_named() {
    let mesh = bar(CellKind::Hex20);
    let marks = walls(&mesh);
    let once = inp(&mesh, &marks, |_| "CPS8");
    let single = parse(&once).unwrap();
    assert!(!single.warnings.iter().any(|w| w.text.contains("twice")), "control: {:?}", single.warnings);
    // Element 4, which has a wall, is written again as 999.
    let elements = once.find("*ELEMENT").unwrap();
    let start = elements + once[elements..].find("\n4, ").unwrap() + 1;
    let line = &once[start..][..once[start..].find('\n').unwrap()];
    let again = format!("{once}*ELEMENT, TYPE=C3D20\n{}\n*NSET, NSET=N, ELSET=BODY\n", line.replacen("4,", "999,", 1));
    let double = parse(&again).unwrap();
    let said: Vec<_> = double.warnings.iter().filter(|w| w.text.contains("twice")).collect();
    assert!(said.len() == 1 && said[0].text.contains("1 element stands twice"), "{said:?}");
    assert!(said[0].text.contains("999 is 4 again"), "{said:?}");
    assert_eq!(double.mesh.cells.len(), single.mesh.cells.len());
    assert_eq!(figures(&double, "Walls"), figures(&single, "Walls"));
    // The same label again is the same element; sets that name it do not mind.
    let same = format!("{once}*ELEMENT, TYPE=C3D20, ELSET=AGAIN\n{line}\n*SURFACE, NAME=S\nAGAIN, S1\n");
    let same = parse(&same).unwrap();
    assert!(same.warnings.iter().any(|w| w.text.contains("4 is 4 again")), "{:?}", same.warnings);
    assert_eq!(figures(&same, "Walls"), figures(&single, "Walls"));
    assert_eq!(same.mesh.surface("S").map(|faces| faces[0].cell), Some(3));
    // Without the file's faces too: those of a doubled element are outer faces.
    let mass = 7850.0 * 0.4 * (0.3 * 0.2 - 0.1 * 0.1);
    assert!((figures(&double, "N").0 / mass - 1.0).abs() < 1e-12);
    assert_eq!(figures(&double, "N"), figures(&parse(&(once + "*NSET, NSET=N, ELSET=BODY\n")).unwrap(), "N"));
}

#[test]
fn a_volume_in_two_physical_groups_is_no_doubled_one() {
    let mesh = bar(CellKind::Hex8);
    let text = msh(&mesh, &[], "body", false);
    let read = |text: &str| parse_msh(text.as_bytes(), Path::new("bar.msh"), SI, false).unwrap();
    let count = mesh.cells.len();
    let more = |extra: &str| {
        let text = text.replace(&format!("$Elements\n{count}\n"), &format!("$Elements\n{}\n", count + 1));
        text.replace("$EndElements", &format!("{extra}$EndElements"))
    };
    let line = text.lines().find(|line| line.starts_with("4 5 2 8 6 ")).unwrap();
    let twice = |file: &MeshFile| file.warnings.iter().filter(|w| w.text.contains("twice")).count();
    // Version 2.2 writes an element of an entity once for each group.
    let other_group = read(&more(&format!("{}\n", line.replacen("4 5 2 8 6", "999 5 2 9 6", 1))));
    assert_eq!((twice(&other_group), other_group.mesh.cells.len()), (0, count));
    assert_eq!(other_group.mesh.element_set("PhysicalVolume9"), Some([3].as_slice()));
    let same_group = read(&more(&format!("{}\n", line.replacen("4 5 2 8 6", "999 5 2 8 6", 1))));
    assert_eq!((twice(&same_group), same_group.mesh.cells.len()), (1, count));
    let other_volume = read(&more(&format!("{}\n", line.replacen("4 5 2 8 6", "999 5 2 9 7", 1))));
    assert_eq!((twice(&other_volume), other_volume.mesh.cells.len()), (1, count));
}

#[test]
fn elements_in_one_place_that_differ_are_refused() {
    // Four corners of the tetrahedron again, with a midside node of its own.
    let text = changed("20, 0, 1, 1.0D+0\n", "20, 0, 1, 1.0D+0\n21, 0, 1, 1\n");
    let text = text.replace("8, 9, 20\n", "8, 9, 20\n8, 1, 2, 3, 4, 5, 6, 7, 8, 9, 21\n");
    refused(&text, &["tet.inp:18", "element 8 has the corners of element 7, but other midside nodes"]);
    let iron = "*ELEMENT, TYPE=C3D10, ELSET=IRON\n8, 1, 2, 3, 4, 5, 6, 7, 8, 9, 20\n*MATERIAL, NAME=IRON\n*ELASTIC\n1, 0\n\
                *DENSITY\n1\n*SOLID SECTION, ELSET=IRON, MATERIAL=IRON\n";
    refused(&format!("{TET}{iron}"), &["tet.inp:27", "element 8", "element 7", "other materials"]);
    // Without a section of its own it has that of the other; with its nodes in another order no face is named.
    let turned = "*ELEMENT, TYPE=C3D8I, ELSET=T\n2, 2, 3, 4, 1, 6, 7, 8, 5\n";
    let MeshFile { mesh, warnings } = accepted(&format!("{BRICK}{turned}*SURFACE, NAME=S\nE, S1\n"));
    assert!(mesh.cells.len() == 1 && warnings[0].text.contains("2 is 1 again"), "{warnings:?}");
    refused(&format!("{BRICK}{turned}*SURFACE, NAME=S\nT, S3\n"), &["S3 of element 2", "same nodes in another order"]);
}
