//! Motions of reduced elements that nothing restrains.
//!
//! The stiffness of C3D20R, summed at 2 x 2 x 2 points, does not see six motions of the element beside the rigid
//! ones, and its mass, summed at the same points, does not see them either. Neighbours restrain them, but not where
//! elements stand in a single row: around each face across the row a motion is left that moves the midside nodes of
//! that face and beside it. The stiffness of the part is then singular, and what is computed from it is rounding.

use super::SolidError;
use super::numbering::NodeMap;
use crate::element::{ElementMatrices, faces};
use crate::machine::Part;
use crate::mesh::{CellKind, Mesh};
use nalgebra::DMatrix;
use std::collections::{BTreeMap, BTreeSet};

/// A stiffness below this share of the largest is none. Elements that are not parallelepipeds are far above it.
const NONE: f64 = 1e-10;

/// Refuses a mesh in which reduced elements can move nodes of their own without any stiffness.
///
/// # Errors
/// [`SolidError::Hourglass`] with the first such element and their number.
pub(super) fn check(
    part: &Part,
    mesh: &Mesh,
    maps: &[NodeMap],
    elements: &[ElementMatrices],
) -> Result<(), SolidError> {
    let mut users = vec![0_u32; mesh.nodes.len()];
    mesh.cells.iter().flat_map(|cell| &cell.nodes).for_each(|&node| users[node] += 1);
    // Faces across a row: no element beside the one or two that meet there has their midside nodes.
    let mut across: BTreeMap<Vec<usize>, Vec<usize>> = BTreeMap::new();
    for (c, cell) in mesh.cells.iter().enumerate().filter(|(_, cell)| cell.kind == CellKind::Hex20Reduced) {
        for face in faces(cell.kind) {
            let mut middles: Vec<usize> = face[4..].iter().map(|&k| cell.nodes[k]).collect();
            if middles.iter().all(|&node| users[node] <= 2 && matches!(maps[node], NodeMap::Free(_))) {
                middles.sort_unstable();
                across.entry(middles).or_default().push(c);
            }
        }
    }
    let mut loose = BTreeSet::new();
    for (middles, cells) in across {
        if middles.iter().all(|&node| users[node] as usize == cells.len())
            && moves(mesh, maps, elements, &users, &cells)
        {
            loose.extend(cells);
        }
    }
    match loose.first() {
        None => Ok(()),
        Some(&first) => {
            Err(SolidError::Hourglass { part: part.name.clone(), count: loose.len(), element: mesh.cells[first].label })
        }
    }
}

/// Whether the nodes that only these cells have can move without stiffness, other than as a rigid body.
fn moves(mesh: &Mesh, maps: &[NodeMap], elements: &[ElementMatrices], users: &[u32], cells: &[usize]) -> bool {
    let mut inside: BTreeMap<usize, u32> = BTreeMap::new();
    cells.iter().flat_map(|&c| &mesh.cells[c].nodes).for_each(|&node| *inside.entry(node).or_default() += 1);
    let own = |(node, count): (&usize, &u32)| {
        (users[*node] == *count && matches!(maps[*node], NodeMap::Free(_))).then_some(*node)
    };
    let own: Vec<usize> = inside.iter().filter_map(own).collect();
    let mut block: DMatrix<f64> = DMatrix::zeros(3 * own.len(), 3 * own.len());
    for &c in cells {
        let place = |k: usize| own.binary_search(&mesh.cells[c].nodes[k]).ok();
        for (a, i) in (0..elements[c].nodes()).filter_map(|a| Some((a, place(a)?))) {
            for (b, j) in (0..elements[c].nodes()).filter_map(|b| Some((b, place(b)?))) {
                let stiffness = elements[c].stiffness(a, b);
                (0..9).for_each(|k| block[(3 * i + k / 3, 3 * j + k % 3)] += stiffness[k / 3][k % 3]);
            }
        }
    }
    let values = block.symmetric_eigenvalues();
    let free = values.iter().filter(|value| **value < NONE * values.max()).count();
    // Cells that are the whole part may move as a rigid body.
    free > if own.len() == inside.len() { 6 } else { 0 }
}
