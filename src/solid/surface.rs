//! Surfaces of a part: faces that the mesh file gives, or element faces whose nodes all lie in a set; whole or
//! clipped.

use crate::element::{face, faces, quadrature::tri_degree_5};
use crate::machine::Region;
use crate::mesh::{CellFace, FaceElement, Mesh};
use std::collections::{BTreeSet, HashMap, HashSet};

/// A face of one element: a triangle of three or six nodes, a quadrilateral of four or eight.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Indices of its nodes: the corners, then the midsides 12, 23, ..
    pub nodes: Vec<usize>,
    /// Their coordinates, m.
    pub coordinates: Vec<[f64; 3]>,
}

impl Face {
    fn of_cell(mesh: &Mesh, cell: usize, local: &[usize]) -> Self {
        let nodes: Vec<usize> = local.iter().map(|&i| mesh.cells[cell].nodes[i]).collect();
        let coordinates = nodes.iter().map(|&n| mesh.nodes[n]).collect();
        Self { nodes, coordinates }
    }

    /// Its corners, ascending: the same for the two sides of a face.
    fn corner_set(&self) -> Vec<usize> {
        let mut corners = self.nodes[..face::corner_count(self.nodes.len())].to_vec();
        corners.sort_unstable();
        corners
    }

    /// Coordinates of the corners, m.
    pub fn corners(&self) -> &[[f64; 3]] {
        &self.coordinates[..face::corner_count(self.nodes.len())]
    }
}

/// A half-space of points with normal . x <= bound.
#[derive(Clone, Copy, Debug)]
struct HalfSpace {
    normal: [f64; 3],
    bound: f64,
}

/// A surface made of element faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Its faces.
    pub faces: Vec<Face>,
}

impl Surface {
    /// The faces whose nodes all lie in a set and that belong to one element only.
    pub fn of_node_set(mesh: &Mesh, set: &[usize]) -> Self {
        let mut inside = vec![false; mesh.nodes.len()];
        for &node in set {
            inside[node] = true;
        }
        let mut found: HashMap<Vec<usize>, (usize, Face)> = HashMap::new();
        let mut order = Vec::new();
        for (c, cell) in mesh.cells.iter().enumerate() {
            for local in faces(cell.kind) {
                let corners = &local[..face::corner_count(local.len())];
                if !corners.iter().all(|&i| inside[cell.nodes[i]]) {
                    continue;
                }
                let mut key: Vec<usize> = corners.iter().map(|&i| cell.nodes[i]).collect();
                key.sort_unstable();
                let entry = found.entry(key.clone()).or_insert_with(|| {
                    order.push(key);
                    (0, Face::of_cell(mesh, c, local))
                });
                entry.0 += 1;
            }
        }
        let mut kept = Vec::new();
        for key in order {
            if let Some((1, face)) = found.remove(&key)
                && face.nodes.iter().all(|&n| inside[n])
            {
                kept.push(face);
            }
        }
        Self { faces: kept }
    }

    /// The given element faces. One that is given from both sides counts once.
    pub fn of_cell_faces(mesh: &Mesh, listed: &[CellFace]) -> Self {
        let mut seen = HashSet::new();
        let one = |at: &CellFace| Face::of_cell(mesh, at.cell, faces(mesh.cells[at.cell].kind)[at.face]);
        Self { faces: listed.iter().map(one).filter(|face| seen.insert(face.corner_set())).collect() }
    }

    /// The faces of solids that two-dimensional elements mark by their corners. A face that is marked twice, or that
    /// lies between two solids, counts once.
    ///
    /// # Errors
    /// The label of the first element that is no face of a solid.
    pub fn of_face_elements(mesh: &Mesh, marks: &[FaceElement]) -> Result<Self, u64> {
        let mut inside = vec![false; mesh.nodes.len()];
        marks.iter().filter_map(|mark| mark.corners.as_ref()).flatten().for_each(|&node| inside[node] = true);
        let mut found: HashMap<Vec<usize>, Face> = HashMap::new();
        for (c, cell) in mesh.cells.iter().enumerate() {
            for local in faces(cell.kind) {
                if local[..face::corner_count(local.len())].iter().all(|&i| inside[cell.nodes[i]]) {
                    let face = Face::of_cell(mesh, c, local);
                    found.entry(face.corner_set()).or_insert(face);
                }
            }
        }
        let mut seen = HashSet::new();
        let mut kept = Vec::new();
        for mark in marks {
            let mut corners = mark.corners.clone().ok_or(mark.label)?;
            corners.sort_unstable();
            let face = found.get(&corners).ok_or(mark.label)?;
            if seen.insert(corners) {
                kept.push(face.clone());
            }
        }
        Ok(Self { faces: kept })
    }

    /// Its nodes.
    pub fn nodes(&self) -> BTreeSet<usize> {
        self.faces.iter().flat_map(|face| &face.nodes).copied().collect()
    }

    /// The corners of each face; equal for surfaces that are the same faces.
    pub(super) fn corner_sets(&self) -> BTreeSet<Vec<usize>> {
        self.faces.iter().map(Face::corner_set).collect()
    }

    /// Integrals w_i of the shape functions over the part of the surface inside a region, by node
    /// (ascending), m^2.
    ///
    /// A face that the region cuts counts with the part inside; the cut is straight in the face's own
    /// coordinates, between the corners' values.
    pub fn weights_within(&self, region: &Region) -> Vec<(usize, f64)> {
        let mut cuts = Vec::new();
        for axis in 0..3 {
            let mut normal = [0.0; 3];
            normal[axis] = 1.0;
            if region.max[axis].is_finite() {
                cuts.push(HalfSpace { normal, bound: region.max[axis] });
            }
            if region.min[axis].is_finite() {
                cuts.push(HalfSpace { normal: normal.map(|c: f64| -c), bound: -region.min[axis] });
            }
        }
        self.weights(&cuts)
    }

    /// The same over the slab |direction . x - centre| <= length / 2.
    pub fn weights_in_slab(&self, direction: [f64; 3], centre: f64, length: f64) -> Vec<(usize, f64)> {
        let back = direction.map(|c| -c);
        self.weights(&[
            HalfSpace { normal: direction, bound: centre + 0.5 * length },
            HalfSpace { normal: back, bound: 0.5 * length - centre },
        ])
    }

    /// Range of direction . x over the corners of the faces, m.
    pub fn extent(&self, direction: [f64; 3]) -> (f64, f64) {
        let corners = self.faces.iter().flat_map(|f| f.corners()).map(|x| dot(&direction, x));
        corners.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), s| (lo.min(s), hi.max(s)))
    }

    /// Range of each face's corners along a direction, m.
    pub fn face_ranges(&self, direction: [f64; 3]) -> Vec<(f64, f64)> {
        let of_face = |face: &Face| {
            let along = face.corners().iter().map(|x| dot(&direction, x));
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), s| (lo.min(s), hi.max(s)))
        };
        self.faces.iter().map(of_face).collect()
    }

    /// Mean length of the faces along a direction, m; 0 without faces.
    pub fn element_length(&self, direction: [f64; 3]) -> f64 {
        let ranges = self.face_ranges(direction);
        ranges.iter().map(|(lo, hi)| hi - lo).sum::<f64>() / ranges.len().max(1) as f64
    }

    fn weights(&self, cuts: &[HalfSpace]) -> Vec<(usize, f64)> {
        let mut total: std::collections::BTreeMap<usize, f64> = std::collections::BTreeMap::new();
        for face in &self.faces {
            if let Some(weights) = face_weights(face, cuts) {
                for (node, w) in face.nodes.iter().zip(weights) {
                    *total.entry(*node).or_insert(0.0) += w;
                }
            }
        }
        total.into_iter().collect()
    }
}

/// Integrals of a face's shape functions over its part inside all half-spaces, m^2.
fn face_weights(of: &Face, cuts: &[HalfSpace]) -> Option<[f64; face::MAX_NODES]> {
    let (n, corners) = (of.nodes.len(), of.corners());
    let mut polygon = face::corners(n).to_vec();
    for cut in cuts {
        // Linear (on a quadrilateral bilinear) between the corners: s(r, s) <= 0 is inside.
        let mut at = [0.0; 4];
        for (at, x) in at.iter_mut().zip(corners) {
            *at = dot(&cut.normal, x) - cut.bound;
        }
        let value = |p: [f64; 2]| face::shape(corners.len(), p).0.iter().zip(at).map(|(n, at)| n * at).sum::<f64>();
        polygon = clip(&polygon, value);
        if polygon.len() < 3 {
            return None;
        }
    }
    let mut weights = [0.0; face::MAX_NODES];
    for k in 1..polygon.len() - 1 {
        let [a, b, c] = [polygon[0], polygon[k], polygon[k + 1]];
        let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let twice_area = (u[0] * v[1] - u[1] * v[0]).abs();
        for point in tri_degree_5() {
            let [r, s] = point.at;
            let at = [a[0] + r * u[0] + s * v[0], a[1] + r * u[1] + s * v[1]];
            let w = point.weight * twice_area * face::area_element(&of.coordinates, at);
            for (weight, n) in weights.iter_mut().zip(face::shape(n, at).0) {
                *weight += w * n;
            }
        }
    }
    Some(weights)
}

/// Sutherland and Hodgman's clipping of a convex polygon by value <= 0.
fn clip(polygon: &[[f64; 2]], value: impl Fn([f64; 2]) -> f64) -> Vec<[f64; 2]> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (k, &a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()];
        let (va, vb) = (value(a), value(b));
        if va <= 0.0 {
            out.push(a);
        }
        if (va < 0.0 && vb > 0.0) || (va > 0.0 && vb < 0.0) {
            let t = va / (va - vb);
            out.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
        }
    }
    out
}

pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
