//! Boxes meshed with any kind of element, and their distortion.

use super::steel;
use std::collections::{BTreeMap, BTreeSet};
use stiffmap::mesh::{Cell, CellKind, Mesh};

/// Corners of a brick in lattice steps, and the corner pairs of its midsides (Abaqus manual).
const BRICK: [[usize; 3]; 8] = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]];
const BRICK_SIDES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
const WEDGES: [[usize; 6]; 2] = [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]];
const WEDGE_SIDES: [[usize; 2]; 9] = [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]];
const TETS: [[usize; 4]; 6] = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
const TET_SIDES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Corners of each element that a brick is cut into.
fn pieces(kind: CellKind) -> Vec<Vec<usize>> {
    match kind.corner_count() {
        4 => TETS.iter().map(|t| t.to_vec()).collect(),
        6 => WEDGES.iter().map(|w| w.to_vec()).collect(),
        _ => vec![(0..8).collect()],
    }
}

fn sides(kind: CellKind) -> &'static [[usize; 2]] {
    match kind {
        CellKind::Tet10 => &TET_SIDES,
        CellKind::Wedge15 => &WEDGE_SIDES,
        CellKind::Hex20 | CellKind::Hex20Reduced => &BRICK_SIDES,
        _ => &[],
    }
}

/// A box of steel with its near lower corner at the origin, `cells` bricks along each axis, each a brick or
/// cut into two wedges or six tetrahedra. Its faces are the node sets XMIN, XMAX, YMIN, YMAX, ZMIN, ZMAX.
pub fn grid(kind: CellKind, size: [f64; 3], cells: [usize; 3]) -> Mesh {
    mixed_grid(size, cells, |_| kind)
}

/// The same with a kind for each brick.
pub fn mixed_grid(size: [f64; 3], cells: [usize; 3], kind: impl Fn([usize; 3]) -> CellKind) -> Mesh {
    let mut mesh = Mesh { materials: vec![steel()], ..Mesh::default() };
    let mut places: BTreeMap<[usize; 3], usize> = BTreeMap::new();
    let ends = cells.map(|n| 2 * n);
    let mut node = |mesh: &mut Mesh, p: [usize; 3]| {
        *places.entry(p).or_insert_with(|| {
            let index = mesh.nodes.len();
            mesh.nodes.push(std::array::from_fn(|c| size[c] * p[c] as f64 / ends[c] as f64));
            mesh.node_labels.push(index as u64 + 1);
            for c in 0..3 {
                for (end, at) in [("MIN", 0), ("MAX", ends[c])] {
                    if p[c] == at {
                        let name = format!("{}{end}", ["X", "Y", "Z"][c]);
                        mesh.node_sets.entry(name).or_default().push(index);
                    }
                }
            }
            index
        })
    };
    for cell in 0..cells.iter().product::<usize>() {
        let at = [cell % cells[0], cell / cells[0] % cells[1], cell / (cells[0] * cells[1])];
        let kind = kind(at);
        let corners = BRICK.map(|b| std::array::from_fn::<usize, 3, _>(|c| 2 * at[c] + b[c]));
        for piece in pieces(kind) {
            let own: Vec<[usize; 3]> = piece.iter().map(|&k| corners[k]).collect();
            let middle = |[a, b]: &[usize; 2]| std::array::from_fn(|c| (own[*a][c] + own[*b][c]) / 2);
            let all: Vec<[usize; 3]> = own.iter().copied().chain(sides(kind).iter().map(middle)).collect();
            let nodes = all.into_iter().map(|p| node(&mut mesh, p)).collect();
            let label = mesh.cells.len() as u64 + 1;
            mesh.cells.push(Cell { kind, label, nodes, material: Some(0) });
        }
    }
    mesh
}

/// Moves the corner nodes inside the mesh by up to `amplitude` (m) and keeps its sides straight.
pub fn distort(mesh: &mut Mesh, amplitude: f64) {
    let outside: BTreeSet<usize> = mesh.node_sets.values().flatten().copied().collect();
    let corners: BTreeSet<usize> = mesh.cells.iter().flat_map(|c| c.nodes[..c.kind.corner_count()].to_vec()).collect();
    for &node in corners.difference(&outside) {
        for c in 0..3 {
            mesh.nodes[node][c] += amplitude * (12.9898 * (3 * node + c) as f64 + 1.0).sin();
        }
    }
    for cell in &mesh.cells {
        for (k, [a, b]) in sides(cell.kind).iter().enumerate() {
            let (xa, xb) = (mesh.nodes[cell.nodes[*a]], mesh.nodes[cell.nodes[*b]]);
            mesh.nodes[cell.nodes[cell.kind.corner_count() + k]] = std::array::from_fn(|c| 0.5 * (xa[c] + xb[c]));
        }
    }
}

/// One distorted element: reference nodes moved by up to 0.1, midsides curved.
pub fn one(kind: CellKind) -> Vec<[f64; 3]> {
    let reference = stiffmap::element::reference_nodes(kind);
    let amount = if kind.corner_count() == 8 { 0.12 } else { 0.06 };
    let moved = |(k, x): (usize, &[f64; 3])| std::array::from_fn(|c| x[c] + amount * (7.3 * (3 * k + c) as f64).sin());
    reference.iter().enumerate().map(moved).collect()
}
