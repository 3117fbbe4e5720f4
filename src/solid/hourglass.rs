//! Motions of reduced elements that nothing restrains.
//!
//! The stiffness of C3D20R, summed at 2 x 2 x 2 points, does not see six motions of the element beside the rigid
//! ones, and its mass, summed at the same points, does not see them either. Neighbours restrain them, but not where
//! elements stand in a single row: there a motion is left that moves midside nodes alone, which no other element
//! has. The stiffness of the part is then singular, and what is computed from it is rounding.

use super::SolidError;
use super::numbering::NodeMap;
use crate::element::ElementMatrices;
use crate::machine::Part;
use crate::mesh::{CellKind, Mesh};
use nalgebra::DMatrix;

/// A stiffness below this share of the largest is none. Elements that are not parallelepipeds are far above it.
const NONE: f64 = 1e-10;

/// Refuses a mesh in which a reduced element can move nodes of its own without any stiffness.
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
    let moves = |(cell, element): (&crate::mesh::Cell, &ElementMatrices)| {
        let own = |k: &usize| users[cell.nodes[*k]] == 1 && matches!(maps[cell.nodes[*k]], NodeMap::Free(_));
        let own: Vec<usize> = (0..cell.nodes.len()).filter(own).collect();
        // An element that is the whole part may move as a rigid body.
        let rigid = if own.len() == cell.nodes.len() { 6 } else { 0 };
        cell.kind == CellKind::Hex20Reduced && !own.is_empty() && loose_motions(element, &own) > rigid
    };
    let loose: Vec<u64> =
        mesh.cells.iter().zip(elements).filter(|pair| moves(*pair)).map(|(cell, _)| cell.label).collect();
    match loose.first() {
        None => Ok(()),
        Some(&element) => Err(SolidError::Hourglass { part: part.name.clone(), count: loose.len(), element }),
    }
}

/// How many combinations of the displacements of some nodes of an element cost nothing.
fn loose_motions(element: &ElementMatrices, nodes: &[usize]) -> usize {
    let block = DMatrix::from_fn(3 * nodes.len(), 3 * nodes.len(), |i, j| {
        element.stiffness(nodes[i / 3], nodes[j / 3])[i % 3][j % 3]
    });
    let values = block.symmetric_eigenvalues();
    values.iter().filter(|value| **value < NONE * values.max()).count()
}
