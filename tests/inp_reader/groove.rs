//! A bar with a groove one element wide, in every kind of element, as text in both formats.
//!
//! The walls of the groove are what an interface would be on. All corners of the floor between them are corners of
//! the walls, so their nodes alone do not tell walls from floor.

use super::support::grids::grid;
use std::fmt::Write as _;
use stiffmap::element::{face, faces};
use stiffmap::mesh::{CellKind, Mesh};

/// Size of the bar; the groove is the middle third along x and the upper half along y.
pub const SIZE: [f64; 3] = [0.3, 0.2, 0.4];
/// Area of the two walls.
pub const WALLS: f64 = 2.0 * 0.1 * 0.4;
/// Area of the floor between them.
pub const FLOOR: f64 = 0.1 * 0.4;
/// Labels of the two-dimensional elements begin here.
pub const FIRST: usize = 9001;

/// The bar, four elements deep along z.
pub fn bar(kind: CellKind) -> Mesh {
    let mut mesh = grid(kind, SIZE, [3, 2, 4]);
    let middle = |mesh: &Mesh, cell: usize, c: usize| {
        let corners = &mesh.cells[cell].nodes[..kind.corner_count()];
        corners.iter().map(|&n| mesh.nodes[n][c]).sum::<f64>() / corners.len() as f64
    };
    let groove = |mesh: &Mesh, cell: usize| (middle(mesh, cell, 0) - 0.15).abs() < 0.05 && middle(mesh, cell, 1) > 0.1;
    let kept: Vec<_> = (0..mesh.cells.len()).filter(|&c| !groove(&mesh, c)).map(|c| mesh.cells[c].clone()).collect();
    mesh.cells = kept;
    mesh
}

/// The faces of the walls: nodes, corners first.
pub fn walls(mesh: &Mesh) -> Vec<Vec<usize>> {
    let mut found = Vec::new();
    for cell in &mesh.cells {
        for local in faces(cell.kind) {
            let nodes: Vec<usize> = local.iter().map(|&i| cell.nodes[i]).collect();
            let corners = &nodes[..face::corner_count(nodes.len())];
            let on = |x: f64| corners.iter().all(|&n| (mesh.nodes[n][0] - x).abs() < 1e-9);
            let high = corners.iter().all(|&n| mesh.nodes[n][1] > 0.1 - 1e-9);
            let outside = cell.nodes.iter().all(|&n| !(0.1 + 1e-9..0.2 - 1e-9).contains(&mesh.nodes[n][0]));
            if (on(0.1) || on(0.2)) && high && outside {
                found.push(nodes);
            }
        }
    }
    found
}

/// The nodes of faces, ascending.
pub fn nodes_of(faces: &[Vec<usize>]) -> Vec<usize> {
    let mut nodes: Vec<usize> = faces.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

fn labels(nodes: &[usize]) -> String {
    nodes.iter().map(|n| (n + 1).to_string()).collect::<Vec<_>>().join(", ")
}

/// The bar as an Abaqus file, with two-dimensional elements in the element set Walls.
pub fn inp(mesh: &Mesh, marks: &[Vec<usize>], mark: impl Fn(usize) -> &'static str) -> String {
    let mut text = String::from("*NODE\n");
    for (n, [x, y, z]) in (1..).zip(&mesh.nodes) {
        writeln!(text, "{n}, {x}, {y}, {z}").unwrap();
    }
    writeln!(text, "*ELEMENT, TYPE={}, ELSET=BODY", mesh.cells[0].kind.name()).unwrap();
    for (label, cell) in (1..).zip(&mesh.cells) {
        writeln!(text, "{label}, {}", labels(&cell.nodes)).unwrap();
    }
    for (label, nodes) in (FIRST..).zip(marks) {
        writeln!(text, "*ELEMENT, TYPE={}, ELSET=Walls\n{label}, {}", mark(nodes.len()), labels(nodes)).unwrap();
    }
    text
}

/// A node set.
pub fn nset(name: &str, nodes: &[usize]) -> String {
    format!("*NSET, NSET={name}\n{}\n", labels(nodes).replace(", ", ",\n"))
}

/// Gmsh's number of a kind, and the corner pairs of its midsides in its order (reference manual).
fn gmsh(kind: CellKind) -> (usize, &'static [[usize; 2]]) {
    const BRICK: [[usize; 2]; 12] =
        [[0, 1], [0, 3], [0, 4], [1, 2], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 7], [5, 6], [6, 7]];
    const WEDGE: [[usize; 2]; 9] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 4], [2, 5], [3, 4], [3, 5], [4, 5]];
    const TET: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [2, 3], [1, 3]];
    match kind {
        CellKind::Tet4 => (4, &[]),
        CellKind::Hex8 | CellKind::Hex8Incompatible => (5, &[]),
        CellKind::Wedge6 => (6, &[]),
        CellKind::Tet10 => (11, &TET),
        CellKind::Hex20 | CellKind::Hex20Reduced => (17, &BRICK),
        CellKind::Wedge15 => (18, &WEDGE),
    }
}

/// The nodes of a cell in Gmsh's order.
fn gmsh_nodes(mesh: &Mesh, cell: usize) -> Vec<usize> {
    let own = &mesh.cells[cell];
    let corners = &own.nodes[..own.kind.corner_count()];
    let middle = |[a, b]: &[usize; 2]| {
        let at: [f64; 3] = std::array::from_fn(|c| 0.5 * (mesh.nodes[corners[*a]][c] + mesh.nodes[corners[*b]][c]));
        let far = |n: usize| (0..3).map(|c| (mesh.nodes[n][c] - at[c]).abs()).fold(0.0, f64::max);
        *own.nodes.iter().min_by(|a, b| far(**a).total_cmp(&far(**b))).unwrap()
    };
    corners.iter().copied().chain(gmsh(own.kind).1.iter().map(middle)).collect()
}

/// The bar as a Gmsh file of version 2.2 or 4.1: physical surface 7 "Walls", physical volume 8 of the given name.
pub fn msh(mesh: &Mesh, marks: &[Vec<usize>], volume: &str, four: bool) -> String {
    let mut text = format!(
        "$MeshFormat\n{} 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 7 \"Walls\"\n3 8 \"{volume}\"\n$EndPhysicalNames\n",
        if four { "4.1" } else { "2.2" }
    );
    let join = |nodes: &[usize]| nodes.iter().map(|n| format!(" {}", n + 1)).collect::<String>();
    let kind = |count: usize| [(3, 2), (4, 3), (6, 9), (8, 16)].iter().find(|k| k.0 == count).unwrap().1;
    let count = mesh.nodes.len();
    if four {
        text += "$Entities\n0 0 1 1\n5 0 0 0 1 1 1 1 7 0\n6 0 0 0 1 1 1 1 8 0\n$EndEntities\n";
        write!(text, "$Nodes\n1 {count} 1 {count}\n3 6 0 {count}\n").unwrap();
        (1..=count).for_each(|n| writeln!(text, "{n}").unwrap());
        mesh.nodes.iter().for_each(|[x, y, z]| writeln!(text, "{x} {y} {z}").unwrap());
    } else {
        writeln!(text, "$Nodes\n{count}").unwrap();
        (1..).zip(&mesh.nodes).for_each(|(n, [x, y, z])| writeln!(text, "{n} {x} {y} {z}").unwrap());
    }
    text += "$EndNodes\n$Elements\n";
    let all = marks.len() + mesh.cells.len();
    writeln!(text, "{}", if four { format!("{all} {all} 1 99999") } else { all.to_string() }).unwrap();
    for (label, nodes) in (FIRST..).zip(marks) {
        let kind = kind(nodes.len());
        let head = if four { format!("2 5 {kind} 1\n{label}") } else { format!("{label} {kind} 2 7 5") };
        writeln!(text, "{head}{}", join(nodes)).unwrap();
    }
    for (label, cell) in (1..).zip(0..mesh.cells.len()) {
        let kind = gmsh(mesh.cells[cell].kind).0;
        let head = if four { format!("3 6 {kind} 1\n{label}") } else { format!("{label} {kind} 2 8 6") };
        writeln!(text, "{head}{}", join(&gmsh_nodes(mesh, cell))).unwrap();
    }
    text + "$EndElements\n"
}
