//! Faces that a file gives, and names that stand for several places.

use super::groove::{FIRST, FLOOR, WALLS, bar, inp, msh, nodes_of, nset, walls};
use super::support::{on, part, slab};
use super::{MeshFile, SI, parse};
use std::path::Path;
use stiffmap::element::{face, faces};
use stiffmap::mesh::msh::parse_msh;
use stiffmap::mesh::{CellKind, Mesh};
use stiffmap::solid::{held_displacements, interface_motions};

/// Area of an interface, or why there is none.
fn area(mesh: &Mesh, set: &str) -> Result<f64, String> {
    let motions = interface_motions(&part("bar", &[], vec![on(set)]), mesh).map_err(|error| error.to_string())?;
    Ok(motions[0].1.area)
}

fn near(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-12
}

fn read_inp(text: &str) -> Mesh {
    parse(text).unwrap_or_else(|message| panic!("{message}")).mesh
}

fn read_msh(text: &str) -> MeshFile {
    parse_msh(text.as_bytes(), Path::new("bar.msh"), SI, false).unwrap_or_else(|error| panic!("{error}"))
}

/// Types of two-dimensional elements by their number of nodes.
const TYPES: [[&str; 4]; 4] = [
    ["CPS3", "CPS4", "CPS6", "CPS8"],
    ["S3", "S4R", "STRI65", "S8R"],
    ["M3D3", "M3D4R", "M3D6", "M3D8R"],
    ["SFM3D3", "SFM3D4", "SFM3D6", "SFM3D8"],
];

fn named(types: [&'static str; 4]) -> impl Fn(usize) -> &'static str {
    move |nodes| types[[3, 4, 6, 8].iter().position(|n| *n == nodes).unwrap()]
}

#[test]
fn the_walls_of_a_groove_do_not_bring_its_floor_with_them() {
    for (i, kind) in CellKind::ALL.into_iter().enumerate() {
        let mesh = bar(kind);
        let marks = walls(&mesh);
        let linear = kind.node_count() == kind.corner_count();
        let text = inp(&mesh, &marks, named(TYPES[i % 4])) + &nset("GUESSED", &nodes_of(&marks));
        let mut read = vec![(read_inp(&text), "inp")];
        for four in [false, true] {
            read.push((read_msh(&msh(&mesh, &marks, "body", four)).mesh, "msh"));
        }
        for (mesh, format) in &read {
            let seen = area(mesh, "walls").unwrap();
            assert!(near(seen, WALLS), "{kind:?}, {format}: {seen}");
            let mut half = on("Walls");
            half.within = Some(slab(2, 0.05, 0.15));
            let motion = &interface_motions(&part("bar", &[], vec![half]), mesh).unwrap()[0].1;
            assert!(near(motion.area, 0.25 * WALLS) && near(motion.centroid[2], 0.1), "{kind:?}, {format}: clipped");
        }
        // Control: the same nodes as a node set bring the floor, where it has no node of its own.
        let guessed = area(&read[0].0, "GUESSED").unwrap();
        assert!(near(guessed, WALLS + if linear { FLOOR } else { 0.0 }), "{kind:?}: {guessed}");
    }
}

#[test]
fn a_clamp_on_faces_holds_all_of_their_nodes() {
    for kind in [CellKind::Hex8, CellKind::Tet10] {
        let mesh = bar(kind);
        let marks = walls(&mesh);
        // Linear triangles mark the faces of quadratic tetrahedra as well.
        let corners: Vec<Vec<usize>> =
            marks.iter().map(|nodes| nodes[..face::corner_count(nodes.len())].to_vec()).collect();
        let by_corners = read_inp(&inp(&mesh, &corners, named(TYPES[0])));
        assert!(near(area(&by_corners, "Walls").unwrap(), WALLS));
        let held = held_displacements(&part("bar", &["Walls"], vec![]), &by_corners).unwrap();
        assert_eq!(held.len(), nodes_of(&marks).len());
        let surface = read_inp(&format!("{}*SURFACE, NAME=END\nBODY, S1\n", inp(&mesh, &[], named(TYPES[0]))));
        let held = held_displacements(&part("bar", &["end"], vec![]), &surface).unwrap();
        let own: Vec<Vec<usize>> =
            mesh.cells.iter().map(|c| faces(kind)[0].iter().map(|&i| c.nodes[i]).collect()).collect();
        assert_eq!(held.len(), nodes_of(&own).len());
    }
}

#[test]
fn a_face_that_belongs_to_no_solid_is_told_and_refused_with_its_label() {
    let mesh = bar(CellKind::Hex8);
    let mut marks = walls(&mesh);
    let diagonal = vec![marks[0][0], marks[0][1], marks[5][2], marks[5][3]];
    marks.push(diagonal);
    let loose = FIRST + marks.len() - 1;
    for mesh in [read_inp(&inp(&mesh, &marks, named(TYPES[0]))), read_msh(&msh(&mesh, &marks, "body", true)).mesh] {
        for message in [
            area(&mesh, "Walls").unwrap_err(),
            held_displacements(&part("bar", &["Walls"], vec![]), &mesh).unwrap_err().to_string(),
        ] {
            assert!(message.contains(&format!("element {loose} of \"Walls\" is no face")), "{message}");
        }
    }
    // A node that no solid has is said when the file is read.
    let far = inp(&mesh, &walls(&mesh), named(TYPES[0]))
        + "*NODE\n7777, 9, 9, 9\n*ELEMENT, TYPE=S3, ELSET=LOOSE\n8888, 1, 2, 7777\n";
    let warnings = parse(&far).unwrap().warnings;
    assert!(
        warnings.iter().any(|w| w.text.contains("1 surface elements of \"LOOSE\", element 8888 first")),
        "{warnings:?}"
    );
}

#[test]
fn a_face_between_two_solids_or_given_twice_counts_once() {
    let mesh = bar(CellKind::Hex8);
    let marks = walls(&mesh);
    let twice: Vec<Vec<usize>> = marks.iter().chain(&marks).cloned().collect();
    assert!(near(area(&read_inp(&inp(&mesh, &twice, named(TYPES[0]))), "Walls").unwrap(), WALLS));
    // The plane z = 0.1 between the first two layers, from both sides.
    let text = inp(&mesh, &[], named(TYPES[0])) + "*SURFACE, NAME=SECTION\n1, S2\n2, S2\n3, S2\n6, S1\n7, S1\n";
    assert!(near(area(&read_inp(&text), "SECTION").unwrap(), 3.0 * 0.1 * 0.1));
}

#[test]
fn names_that_agree_are_one_place_and_others_are_refused_with_both() {
    let mesh = bar(CellKind::Hex8);
    let marks = walls(&mesh);
    let text = inp(&mesh, &marks, named(TYPES[0]));
    let own = nodes_of(&marks);
    // Gmsh writes the element set of a surface and a node set of the same name.
    let agreeing = read_inp(&(text.clone() + &nset("WALLS", &own)));
    assert!(near(area(&agreeing, "walls").unwrap(), WALLS));
    let said = |text: &str, name: &str, both: [&str; 2]| {
        let mesh = read_inp(text);
        let clamp = held_displacements(&part("bar", &[name], vec![]), &mesh).unwrap_err().to_string();
        for message in [area(&mesh, name).unwrap_err(), clamp] {
            assert!(message.contains("stands for different places in bar.inp"), "{message}");
            assert!(both.iter().all(|part| message.contains(part)), "{both:?} in {message}");
        }
        // It matters only where it is used.
        assert!(area(&mesh, "OTHER").is_ok());
    };
    let other = nset("OTHER", &(0..mesh.nodes.len()).collect::<Vec<_>>());
    let fewer = text.clone() + &other + &nset("WALLS", &own[1..]);
    said(&fewer, "Walls", ["the node set (*NSET) of", "the surface elements of 8 faces"]);
    let surface = text.clone() + &other + &nset("TOP", &own) + "*SURFACE, NAME=TOP\nBODY, S1\n";
    said(&surface, "TOP", ["the node set (*NSET) of", "the surface (*SURFACE) of"]);
    let of_nodes = text.clone() + &other + &nset("TOP", &own) + "*SURFACE, NAME=Top, TYPE=NODE\n1,\n2,\n3,\n";
    said(&of_nodes, "TOP", ["the node set (*NSET) of", "(*SURFACE, TYPE=NODE) of 3 nodes"]);
    let mixed = text.clone() + &other + "*ELSET, ELSET=WALLS\n1, 2, 3\n";
    said(&mixed, "WALLS", ["the solid elements of the element set", "the surface elements"]);
    let end: Vec<usize> = (0..mesh.nodes.len()).filter(|&n| mesh.nodes[n][2] == 0.0).collect();
    let solids = text.clone() + &other + &nset("END", &end) + "*ELSET, ELSET=END\nBODY\n";
    said(&solids, "END", ["the node set (*NSET)", "the solid elements of the element set"]);
    // Abaqus/CAE writes the solids behind a set of nodes under the same name.
    let has = |cell: &stiffmap::mesh::Cell| marks.iter().any(|mark| mark.iter().all(|n| cell.nodes.contains(n)));
    let behind: Vec<usize> = (0..mesh.cells.len()).filter(|&c| has(&mesh.cells[c])).collect();
    assert_eq!(behind.len(), marks.len());
    let elements = nset("END", &behind).replace("NSET", "ELSET");
    assert!(area(&read_inp(&(text + &nset("END", &own) + &elements)), "END").is_ok());
}

#[test]
fn physical_groups_of_one_name_and_two_dimensions_are_refused() {
    let mesh = bar(CellKind::Hex8);
    for four in [false, true] {
        let mesh = read_msh(&msh(&mesh, &walls(&mesh), "Walls", four)).mesh;
        let message = area(&mesh, "Walls").unwrap_err();
        for part in ["different places", "the physical volume of", "the surface elements of 8 faces"] {
            assert!(message.contains(part), "{message}");
        }
        // Names that differ in case are two groups; one that is neither is refused with both.
    }
    for four in [false, true] {
        let mesh = read_msh(&msh(&mesh, &walls(&mesh), "WALLS", four)).mesh;
        assert!(near(area(&mesh, "Walls").unwrap(), WALLS));
        assert!(area(&mesh, "WALLS").unwrap() > 2.0 * WALLS);
        let message = area(&mesh, "walls").unwrap_err();
        assert!(message.contains("WALLS; Walls"), "{message}");
    }
}

#[test]
fn a_mesh_without_names_says_what_to_do() {
    let text = msh(&bar(CellKind::Hex8), &[], "body", false).replace(" 2 8 6", " 2 0 6");
    let message = area(&read_msh(&text).mesh, "Walls").unwrap_err();
    assert!(message.contains("it has no set at all") && message.contains("physical groups"), "{message}");
    // A surface that is passed over is told as that.
    let text = inp(&bar(CellKind::Hex8), &[], named(TYPES[0])) + "*SURFACE, NAME=\"Tip face\"\nBODY, SPOS\n";
    let message = area(&read_inp(&text), "tip face").unwrap_err();
    assert!(
        message.contains("is passed over") && message.contains("SPOS") && message.contains("tet.inp:"),
        "{message}"
    );
}
