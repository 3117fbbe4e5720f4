//! Which displacements of which nodes are held to ground.

use super::SolidError;
use super::numbering::rigid_rows;
use super::places::nodes_of;
use crate::machine::Part;
use crate::mesh::Mesh;
use nalgebra::{DMatrix, Matrix6, SymmetricEigen, Vector3};
use std::collections::BTreeMap;

/// Held displacements by node: those of the machine file and those of the mesh file itself.
#[derive(Clone, Debug, Default)]
pub(super) struct Held(BTreeMap<usize, [bool; 3]>);

impl Held {
    /// Which of a node's displacements are held.
    pub fn of(&self, node: usize) -> [bool; 3] {
        self.0.get(&node).copied().unwrap_or_default()
    }

    /// Every node with held displacements, and which.
    pub fn nodes(&self) -> impl Iterator<Item = (usize, [bool; 3])> + '_ {
        self.0.iter().map(|(node, directions)| (*node, *directions))
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn add(&mut self, node: usize, directions: [bool; 3]) {
        let held = self.0.entry(node).or_default();
        *held = std::array::from_fn(|c| held[c] || directions[c]);
    }

    /// Orthonormal combinations, 6 x k, of the rigid motions about `centre` that move no held displacement.
    pub fn free_motions(&self, mesh: &Mesh, centre: [f64; 3]) -> DMatrix<f64> {
        // Rotations are scaled by the body's size, so that the six are comparable.
        let far = mesh.nodes.iter().map(|x| (Vector3::from(*x) - Vector3::from(centre)).norm()).fold(0.0, f64::max);
        let scale = |q: usize| if q < 3 || far == 0.0 { 1.0 } else { 1.0 / far };
        let mut gram = Matrix6::zeros();
        let mut count = 0.0;
        for (&node, directions) in &self.0 {
            for row in (0..3).filter(|&c| directions[c]).map(|c| rigid_rows(mesh.nodes[node], centre)[c]) {
                let row = nalgebra::Vector6::from_fn(|q, _| row[q] * scale(q));
                gram += row * row.transpose();
                count += 1.0;
            }
        }
        let eigen = SymmetricEigen::new(gram);
        let free: Vec<usize> = (0..6).filter(|&k| eigen.eigenvalues[k] < 1e-12 * count).collect();
        DMatrix::from_fn(6, free.len(), |q, k| eigen.eigenvectors[(q, free[k])] * scale(q))
    }
}

/// What the machine file and the mesh file hold of a part.
///
/// # Errors
/// [`SolidError::UnknownSet`], [`SolidError::TwoPlaces`], [`SolidError::NoFace`]; [`SolidError::EmptySupport`]; [`SolidError::ClampOnLine`] where clamped nodes
/// are all there is and they lie on one line.
pub(super) fn held(part: &Part, mesh: &Mesh) -> Result<Held, SolidError> {
    let mut held = Held::default();
    for set in &part.clamped {
        for &node in nodes_of(part, mesh, set, "clamped")?.iter() {
            held.add(node, [true; 3]);
        }
    }
    let clamped: Vec<Vector3<f64>> = held.0.keys().map(|&n| Vector3::from(mesh.nodes[n])).collect();
    for support in &part.supported {
        let nodes = nodes_of(part, mesh, &support.nodes, "supported")?;
        if nodes.is_empty() {
            return Err(SolidError::EmptySupport { part: part.name.clone(), set: support.nodes.clone() });
        }
        nodes.iter().for_each(|&node| held.add(node, support.directions));
    }
    mesh.supports.iter().for_each(|(&node, directions)| held.add(node, *directions));
    // Nodes of given matrices may have rotations; whether those hold the part is seen in the stiffness.
    let plain = part.supported.is_empty() && mesh.supports.is_empty() && mesh.matrices.is_none();
    if plain && on_one_line(&clamped) {
        return Err(SolidError::ClampOnLine { part: part.name.clone() });
    }
    Ok(held)
}

/// The nodes of a part whose displacements along x, y or z are held to ground, and which of them.
///
/// # Errors
/// [`SolidError::UnknownSet`], [`SolidError::EmptySupport`], [`SolidError::ClampOnLine`].
pub fn held_displacements(part: &Part, mesh: &Mesh) -> Result<Vec<(usize, [bool; 3])>, SolidError> {
    Ok(held(part, mesh)?.nodes().collect())
}

fn on_one_line(points: &[Vector3<f64>]) -> bool {
    let Some(first) = points.first() else { return false };
    let far = points.iter().map(|p| p - first).max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
    !points.iter().any(|p| (p - first).cross(&far).norm() > 1e-6 * far.norm_squared())
}
