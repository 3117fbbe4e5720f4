//! A part given by matrices takes its interfaces from the faces that its mesh gives.

use super::support::{box_mesh, on, part};
use super::{by_matrices, files, folder, write_part};
use std::fmt::Write as _;
use std::path::Path;
use stiffmap::element::faces;
use stiffmap::machine::{InterfaceNodes, InterfaceWeights, Part};
use stiffmap::mesh::{Mesh, read_part_mesh};
use stiffmap::solid::{assemble, interface_motions};

/// A mesh as an input file, with its node sets.
fn inp(mesh: &Mesh) -> String {
    let list = |nodes: &[usize]| nodes.iter().map(|n| mesh.node_labels[*n].to_string()).collect::<Vec<_>>().join(",\n");
    let mut text = String::from("*NODE\n");
    for (label, [x, y, z]) in mesh.node_labels.iter().zip(&mesh.nodes) {
        writeln!(text, "{label},{x:.17e},{y:.17e},{z:.17e}").unwrap();
    }
    text += "*ELEMENT, TYPE=C3D10\n";
    mesh.cells.iter().for_each(|cell| writeln!(text, "{},{}", cell.label, list(&cell.nodes)).unwrap());
    for (name, nodes) in &mesh.node_sets {
        writeln!(text, "*NSET, NSET={name}\n{}", list(nodes)).unwrap();
    }
    text
}

/// The faces of a node set: cell, face, nodes.
fn faces_of(mesh: &Mesh, set: &str) -> Vec<(usize, usize, Vec<usize>)> {
    let on = mesh.node_set(set).unwrap();
    let cells = mesh.cells.iter().enumerate();
    let all = cells.flat_map(|(c, cell)| {
        faces(cell.kind)
            .iter()
            .enumerate()
            .map(move |(f, l)| (c, f, l.iter().map(|&i| cell.nodes[i]).collect::<Vec<_>>()))
    });
    all.filter(|(_, _, nodes)| nodes.iter().all(|n| on.contains(n))).collect()
}

fn read(folder: &Path, text: &str, block: &Part, sets: bool) -> Result<f64, String> {
    std::fs::write(folder.join("block.inp"), text).unwrap();
    let mut given = files(folder, block);
    given.with_mesh = true;
    given.sets = given.sets.filter(|_| sets);
    let part = Part { mesh: folder.join("block.inp"), ..by_matrices(block, given) };
    let mesh = read_part_mesh(&part).map_err(|e| e.to_string())?.mesh;
    assemble(&part, &mesh).map_err(|e| e.to_string())?;
    Ok(interface_motions(&part, &mesh).map_err(|e| e.to_string())?[0].1.area)
}

#[test]
fn surfaces_and_surface_elements_of_the_mesh_serve_a_part_by_matrices() {
    let mesh = box_mesh([0.0; 3], [0.2, 0.1, 0.1], [2, 1, 1]);
    let folder = folder();
    write_part(folder.path(), &part("block", &[], vec![on("XMAX")]), &mesh);
    let (end, side) = (faces_of(&mesh, "XMAX"), faces_of(&mesh, "YMAX"));
    let mut text = inp(&mesh) + "*SURFACE, NAME=END\n";
    end.iter().for_each(|(cell, face, _)| writeln!(text, "{}, S{}", mesh.cells[*cell].label, face + 1).unwrap());
    for (label, (_, _, nodes)) in (9001..).zip(&side) {
        let nodes: Vec<String> = nodes.iter().map(|n| mesh.node_labels[*n].to_string()).collect();
        writeln!(text, "*ELEMENT, TYPE=S6, ELSET=SIDE\n{label}, {}", nodes.join(", ")).unwrap();
    }
    let area = |set: &str| read(folder.path(), &text, &part("block", &[], vec![on(set)]), false).unwrap();
    assert!((area("end") / 0.01 - 1.0).abs() < 1e-12);
    assert!((area("SIDE") / 0.02 - 1.0).abs() < 1e-12);
    // A face that is left out is missed.
    let fewer = text.replacen(&format!("{}, S{}\n", mesh.cells[end[0].0].label, end[0].1 + 1), "", 1);
    let seen = read(folder.path(), &fewer, &part("block", &[], vec![on("END")]), false).unwrap();
    assert!((seen / 0.005 - 1.0).abs() < 1e-12, "control: {seen}");
    // Without faces of its own a surface has no nodes to weigh equally.
    let mut given = files(folder.path(), &part("block", &[], vec![on("END")]));
    (given.with_mesh, given.sets) = (true, None);
    given.interfaces[0] = InterfaceNodes { labels: None, weights: InterfaceWeights::Equal };
    let equal =
        Part { mesh: folder.path().join("block.inp"), ..by_matrices(&part("block", &[], vec![on("END")]), given) };
    let message = read_part_mesh(&equal).unwrap_err().to_string();
    assert!(message.contains("no node set \"END\"") && message.contains("END, SIDE"), "{message}");
}

#[test]
fn a_set_of_the_table_and_another_one_of_the_mesh_are_told_apart() {
    let mesh = box_mesh([0.0; 3], [0.2, 0.1, 0.1], [2, 1, 1]);
    let block = part("block", &[], vec![on("XMAX")]);
    let folder = folder();
    write_part(folder.path(), &block, &mesh);
    let text = inp(&mesh);
    assert!((read(folder.path(), &text, &block, true).unwrap() / 0.01 - 1.0).abs() < 1e-12, "they agree");
    let other = text.replace("*NSET, NSET=XMAX", "*NSET, NSET=XMAX\n1,\n*NSET, NSET=XMAX");
    let message = read(folder.path(), &other, &block, true).unwrap_err();
    for said in ["\"XMAX\" stands for different places", "the set of the mesh of", "the set of the table `sets` of"] {
        assert!(message.contains(said), "{message}");
    }
}
