//! The skin of a part: its outer surface with few nodes, to be looked at.
//!
//! Vertex clustering: nodes in one cell of a cubic grid whose faces look the same ways (a set of the
//! six ways along the axes) become one, the node nearest to their mean; faces that lose a corner
//! vanish. The two sides of a thin wall stay apart, and edges and corners keep nodes of their own.
//! Nodes are never moved, so the reduced basis at them is exact. Source: Rossignac, Borrel,
//! Multi-resolution 3D approximations, 1993.

use crate::element::{face, faces};
use crate::mesh::Mesh;
use crate::solid::SecondOrder;
use nalgebra::{DMatrix, Vector3};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Nodes that a skin has at most.
pub const MOST_SKIN_NODES: usize = 900;

/// Halvings of the range of cell sizes.
const HALVINGS: usize = 24;

/// The thinned outer surface of a part in reduced coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct ReducedSkin {
    /// Node coordinates, m.
    pub nodes: Vec<[f64; 3]>,
    /// Triangles by local node number, outward by the right hand.
    pub triangles: Vec<[usize; 3]>,
    /// Displacements of the nodes, 3 n_nodes x n.
    pub basis: DMatrix<f64>,
}

/// The thinned outer surface of a mesh, by node number.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// Nodes of the mesh, ascending.
    pub nodes: Vec<usize>,
    /// Triangles by place in `nodes`, outward by the right hand.
    pub triangles: Vec<[usize; 3]>,
}

/// The outer surface of a mesh on at most `most` of its corner nodes, on fewer where a grid of cells
/// gives no number between; on more only if one cell round all of it still leaves more.
pub fn skin(mesh: &Mesh, most: usize) -> Skin {
    let faces = outer_faces(mesh);
    let ways = ways(mesh, &faces);
    let every: BTreeSet<usize> = faces.iter().flatten().copied().collect();
    if every.len() <= most {
        return collapse(&faces, |n| n);
    }
    let nodes: Vec<usize> = every.into_iter().collect();
    let extent = (0..3).map(|c| range(nodes.iter().map(|&n| mesh.nodes[n][c]))).fold(0.0, f64::max);
    let (mut fine, mut coarse) = (extent * 1e-4, extent * 2.0);
    for _ in 0..HALVINGS {
        let size = (fine * coarse).sqrt();
        if clusters(mesh, &nodes, &ways, size).len() > most { fine = size } else { coarse = size }
    }
    let mut chosen = HashMap::new();
    for members in clusters(mesh, &nodes, &ways, coarse).into_values() {
        let mean = members.iter().map(|&n| Vector3::from(mesh.nodes[n])).sum::<Vector3<f64>>() / members.len() as f64;
        let distance = |n: usize| (Vector3::from(mesh.nodes[n]) - mean).norm_squared();
        let nearest = members.iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        members.iter().for_each(|&n| {
            chosen.insert(n, nearest.unwrap_or(n));
        });
    }
    collapse(&faces, |n| chosen[&n])
}

/// The skin of a part with the reduced basis at its nodes.
pub(super) fn reduced_skin(system: &SecondOrder, mesh: &Mesh, vectors: &DMatrix<f64>) -> ReducedSkin {
    let skin = skin(mesh, MOST_SKIN_NODES);
    ReducedSkin {
        basis: system.displacements(&skin.nodes, vectors),
        nodes: skin.nodes.iter().map(|&n| mesh.nodes[n]).collect(),
        triangles: skin.triangles,
    }
}

/// Corners of the faces that belong to one element only, outward; quadrilaterals in two halves.
fn outer_faces(mesh: &Mesh) -> Vec<[usize; 3]> {
    let corners = || {
        mesh.cells.iter().flat_map(|cell| {
            let of_face = |local: &&[usize]| -> Vec<usize> {
                local[..face::corner_count(local.len())].iter().map(|&i| cell.nodes[i]).collect()
            };
            faces(cell.kind).iter().map(of_face)
        })
    };
    let key = |face: &[usize]| {
        let mut key = face.to_vec();
        key.sort_unstable();
        key
    };
    let mut seen: HashMap<Vec<usize>, usize> = HashMap::new();
    corners().for_each(|face| *seen.entry(key(&face)).or_default() += 1);
    let outer = corners().filter(|face| seen[&key(face)] == 1);
    outer.flat_map(|f| (1..f.len() - 1).map(|i| [f[0], f[i], f[i + 1]]).collect::<Vec<_>>()).collect()
}

/// The ways that the faces round each node look, a bit for each side of each axis.
fn ways(mesh: &Mesh, faces: &[[usize; 3]]) -> HashMap<usize, u8> {
    let mut ways: HashMap<usize, u8> = HashMap::new();
    for face in faces {
        let [a, b, c] = face.map(|n| Vector3::from(mesh.nodes[n]));
        let normal = (b - a).cross(&(c - a));
        let axis = normal.iamax();
        let bit = 1 << (2 * axis + usize::from(normal[axis] < 0.0));
        face.iter().for_each(|n| *ways.entry(*n).or_default() |= bit);
    }
    ways
}

/// Nodes by cell of a grid and by the ways that their faces look.
fn clusters(
    mesh: &Mesh,
    nodes: &[usize],
    ways: &HashMap<usize, u8>,
    size: f64,
) -> BTreeMap<([i64; 3], u8), Vec<usize>> {
    let mut found: BTreeMap<([i64; 3], u8), Vec<usize>> = BTreeMap::new();
    for &n in nodes {
        let cell = mesh.nodes[n].map(|c| (c / size).floor() as i64);
        found.entry((cell, ways[&n])).or_default().push(n);
    }
    found
}

/// The faces with every node replaced by its representative, without those that lost a corner and
/// without the second of two alike.
fn collapse(faces: &[[usize; 3]], representative: impl Fn(usize) -> usize) -> Skin {
    let mut seen = BTreeSet::new();
    let mut kept = Vec::new();
    for face in faces {
        let face = face.map(&representative);
        let mut key = face;
        key.sort_unstable();
        if key[0] != key[1] && key[1] != key[2] && seen.insert(key) {
            kept.push(face);
        }
    }
    let used: BTreeSet<usize> = kept.iter().flatten().copied().collect();
    let nodes: Vec<usize> = used.into_iter().collect();
    let place: HashMap<usize, usize> = nodes.iter().enumerate().map(|(i, &n)| (n, i)).collect();
    Skin { triangles: kept.iter().map(|face| face.map(|n| place[&n])).collect(), nodes }
}

fn range(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
}
