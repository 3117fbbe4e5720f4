//! What the checks must know of the parts: mass, size, and where the interfaces are.

use super::geometry::{Bore, bore, minus, norm, to_triangle};
use crate::machine::{Interface, InterfaceRef, Machine, Material, Part};
use crate::matrix::DofLabel;
use crate::mesh::{Mesh, MeshFile};
use crate::solid::{InterfaceMotion, Surface, interface_motions};
use std::collections::HashSet;

/// The parts of a machine, measured.
#[derive(Clone, Debug)]
pub struct Survey {
    /// One a part.
    pub parts: Vec<PartSurvey>,
    /// Corners of the box around all parts as drawn, m.
    pub bounds: [[f64; 3]; 2],
}

/// One part, measured.
#[derive(Clone, Debug)]
pub struct PartSurvey {
    /// Mass, kg; of straight-sided elements, which is within some per cent.
    pub mass: f64,
    /// Corners of the box around it, m.
    pub bounds: [[f64; 3]; 2],
    /// Materials in use, each with the place that gives it.
    pub materials: Vec<(String, Material)>,
    /// One an interface; `None` where one of them has no surface, which assembling the part refuses.
    pub interfaces: Option<Vec<Patch>>,
    /// Whether it is held to ground somewhere.
    pub held: bool,
}

/// The surface of an interface.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Area centroid of what the region leaves, m.
    pub centroid: [f64; 3],
    /// Triangles of the faces that the region touches; none for an interface of nodes alone.
    triangles: Vec<[[f64; 3]; 3]>,
    /// Triangles of the whole surface, without the region: what a rail offers.
    whole: Vec<[[f64; 3]; 3]>,
    /// Nodes of the interface, m.
    points: Vec<[f64; 3]>,
    /// Corners of the box around what the region leaves, m.
    pub bounds: [[f64; 3]; 2],
    /// Whether every node of it is fixed to ground.
    pub held: bool,
}

/// Diagonal of a box.
pub(super) fn diagonal([low, high]: [[f64; 3]; 2]) -> f64 {
    norm(minus(high, low))
}

impl Patch {
    /// Diagonal of the box around it, m.
    pub fn size(&self) -> f64 {
        diagonal(self.bounds)
    }

    /// Axis and radius, if it is a bore or a journal.
    pub(super) fn bore(&self) -> Option<Bore> {
        bore(&self.triangles, self.centroid)
    }

    /// Distance from a point, m.
    pub(super) fn distance(&self, p: [f64; 3]) -> f64 {
        distance(p, &self.triangles, &self.points)
    }

    /// Smallest distance to another patch, m.
    pub(super) fn gap(&self, other: &Patch) -> f64 {
        gap(&self.triangles, &self.points, other, [0.0; 3])
    }

    /// Smallest distance of a carriage that is moved by `shift` (m) from this rail, whose region does not matter.
    pub(super) fn rail_gap(&self, carriage: &Patch, shift: [f64; 3]) -> f64 {
        gap(&self.whole, &self.points, carriage, shift)
    }

    /// Mean length of the elements of the whole surface along a direction, m; 0 where it has none.
    pub(super) fn element_length(&self, direction: [f64; 3]) -> f64 {
        let length = |corners: &[[f64; 3]; 3]| {
            let along = corners.map(|x| super::geometry::dot(x, direction));
            along.into_iter().fold(f64::NEG_INFINITY, f64::max) - along.into_iter().fold(f64::INFINITY, f64::min)
        };
        self.whole.iter().map(length).sum::<f64>() / self.whole.len().max(1) as f64
    }

    /// Range along a direction of the whole surface, m.
    pub(super) fn extent(&self, direction: [f64; 3]) -> [f64; 2] {
        let points = self.whole.iter().flatten().chain(&self.points);
        let along = points.map(|x| super::geometry::dot(*x, direction));
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], s| [lo.min(s), hi.max(s)])
    }
}

/// Smallest distance from a surface (or its nodes) to a patch that is moved by `shift`, m.
fn gap(triangles: &[[[f64; 3]; 3]], points: &[[f64; 3]], other: &Patch, shift: [f64; 3]) -> f64 {
    // Some 60 places of the other are enough to tell near from far.
    let every = other.points.len().div_ceil(60).max(1);
    let places = other.points.iter().copied().step_by(every).chain([other.centroid]);
    let moved = places.map(|x| std::array::from_fn(|c| x[c] + shift[c]));
    moved.map(|x| distance(x, triangles, points)).fold(f64::INFINITY, f64::min)
}

fn distance(p: [f64; 3], triangles: &[[[f64; 3]; 3]], points: &[[f64; 3]]) -> f64 {
    let surface = triangles.iter().map(|t| to_triangle(p, *t)).fold(f64::INFINITY, f64::min);
    if triangles.is_empty() { points.iter().map(|x| norm(minus(p, *x))).fold(f64::INFINITY, f64::min) } else { surface }
}

impl Survey {
    /// Measures the parts of a machine.
    pub fn of(machine: &Machine, meshes: &[MeshFile]) -> Self {
        let measured = machine.parts.iter().zip(meshes).map(|(part, file)| PartSurvey::of(part, &file.mesh));
        let parts: Vec<PartSurvey> = measured.collect();
        Self { bounds: around(parts.iter().flat_map(|part| part.bounds)), parts }
    }

    /// Whether every interface has a surface.
    pub fn has_interfaces(&self) -> bool {
        self.parts.iter().all(|part| part.interfaces.is_some())
    }

    /// An interface, where [`Survey::has_interfaces`].
    pub(super) fn patch(&self, side: InterfaceRef) -> &Patch {
        match &self.parts[side.part].interfaces {
            Some(patches) => &patches[side.interface],
            None => unreachable!("a survey without interfaces is judged by its parts alone"),
        }
    }

    /// The same with each part's Young's modulus and density multiplied, as a design of a study does.
    pub fn scaled(&self, factors: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut scaled = self.clone();
        for (part, (young, density)) in scaled.parts.iter_mut().zip(factors) {
            part.mass *= density;
            for (_, material) in &mut part.materials {
                material.young *= young;
                material.density *= density;
            }
        }
        scaled
    }
}

/// The box around points; empty (infinite the wrong way round) without any.
fn around(points: impl IntoIterator<Item = [f64; 3]>) -> [[f64; 3]; 2] {
    let empty = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    points.into_iter().fold(empty, |[low, high], x| {
        [std::array::from_fn(|c| low[c].min(x[c])), std::array::from_fn(|c| high[c].max(x[c]))]
    })
}

impl PartSurvey {
    fn of(part: &Part, mesh: &Mesh) -> Self {
        let used: Vec<[f64; 3]> = if mesh.cells.is_empty() {
            mesh.nodes.clone()
        } else {
            mesh.cells.iter().flat_map(|cell| &cell.nodes).map(|&node| mesh.nodes[node]).collect()
        };
        let held = held_nodes(part, mesh);
        // The reason is not lost: the part is refused with it when it is assembled, right after the warnings.
        let motions = interface_motions(part, mesh).ok();
        let patch = |((surface, motion), interface): (&(Surface, InterfaceMotion), &Interface)| {
            patch(surface, motion, interface, mesh, &held)
        };
        Self {
            mass: mass(part, mesh),
            bounds: around(used),
            materials: materials(part, mesh),
            interfaces: motions.map(|motions| motions.iter().zip(&part.interfaces).map(patch).collect()),
            held: !part.clamped.is_empty() || !part.supported.is_empty() || !mesh.supports.is_empty(),
        }
    }

    /// Diagonal of the box around it, m.
    pub fn size(&self) -> f64 {
        diagonal(self.bounds)
    }
}

/// The nodes whose three displacements are fixed.
fn held_nodes(part: &Part, mesh: &Mesh) -> HashSet<usize> {
    let sets = part.clamped.iter().filter_map(|set| mesh.node_set(set)).flatten().copied();
    let own = mesh.supports.iter().filter(|(_, held)| **held == [true; 3]).map(|(node, _)| *node);
    sets.chain(own).collect()
}

/// Triangles of a face's corners.
fn triangles(corners: &[[f64; 3]]) -> impl Iterator<Item = [[f64; 3]; 3]> + '_ {
    (1..corners.len().saturating_sub(1)).map(|k| [corners[0], corners[k], corners[k + 1]])
}

fn patch(
    surface: &Surface,
    motion: &InterfaceMotion,
    interface: &Interface,
    mesh: &Mesh,
    held: &HashSet<usize>,
) -> Patch {
    let count = mesh.nodes.len();
    let own: HashSet<usize> = motion.rows.nodes.iter().copied().filter(|&node| node < count).collect();
    // A face that the region does not touch has a node without weight.
    let kept = surface.faces.iter().filter(|face| face.nodes.iter().all(|node| own.contains(node)));
    let kept: Vec<_> = kept.flat_map(|face| triangles(face.corners())).collect();
    let mut nodes: Vec<usize> = own.iter().copied().collect();
    nodes.sort_unstable();
    let points: Vec<[f64; 3]> = nodes.iter().map(|&node| mesh.nodes[node]).collect();
    let [mut low, mut high] = around(points.iter().copied());
    if let Some(region) = interface.within {
        for c in 0..3 {
            low[c] = low[c].max(region.min[c].min(high[c]));
            high[c] = high[c].min(region.max[c].max(low[c]));
        }
    }
    Patch {
        centroid: motion.centroid,
        triangles: kept,
        whole: surface.faces.iter().flat_map(|face| triangles(face.corners())).collect(),
        bounds: [low, high],
        held: !own.is_empty() && own.iter().all(|node| held.contains(node)),
        points,
    }
}

/// Materials of the cells, each once.
fn materials(part: &Part, mesh: &Mesh) -> Vec<(String, Material)> {
    if let Some(own) = &part.material {
        return vec![(format!("parts.{}.material", part.name), own.clone())];
    }
    let mut used: Vec<usize> = mesh.cells.iter().filter_map(|cell| cell.material).collect();
    used.sort_unstable();
    used.dedup();
    let name = part.mesh.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let one = |&i: &usize| {
        let material = &mesh.materials[i];
        (format!("parts.{} (material {:?} of {name})", part.name, material.name), material.clone())
    };
    used.iter().map(one).collect()
}

/// Mass of a part: of its elements, or of the matrices that stand in their place.
fn mass(part: &Part, mesh: &Mesh) -> f64 {
    if let Some(given) = &mesh.matrices {
        // A rigid translation along x moves the rows of direction 0 alone.
        let along_x: Vec<bool> =
            given.labels.iter().map(|label| matches!(label, DofLabel::Node { direction: 0, .. })).collect();
        let rows = (0..given.mass.n()).filter(|&i| along_x[i]);
        return rows.flat_map(|i| given.mass.row(i)).filter(|(j, _)| along_x[*j]).map(|(_, value)| value).sum();
    }
    let one = |cell: &crate::mesh::Cell| {
        let material = part.material.as_ref().or_else(|| cell.material.map(|m| &mesh.materials[m]));
        let corners: Vec<[f64; 3]> =
            cell.nodes[..cell.kind.corner_count()].iter().map(|&node| mesh.nodes[node]).collect();
        material.map_or(0.0, |m| m.density) * volume(&corners)
    };
    mesh.cells.iter().map(one).sum()
}

/// Volume of a tetrahedron, wedge or brick with straight sides, cut into tetrahedra.
fn volume(corners: &[[f64; 3]]) -> f64 {
    const WEDGE: [[usize; 4]; 3] = [[0, 1, 2, 5], [0, 1, 5, 4], [0, 4, 5, 3]];
    const BRICK: [[usize; 4]; 6] = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
    let pieces: &[[usize; 4]] = match corners.len() {
        4 => &[[0, 1, 2, 3]],
        6 => &WEDGE,
        _ => &BRICK,
    };
    let one = |t: &[usize; 4]| {
        let [a, b, c, d] = t.map(|i| corners[i]);
        let normal = super::geometry::twice_area([a, b, c]);
        super::geometry::dot(normal, minus(d, a)).abs() / 6.0
    };
    pieces.iter().map(one).sum()
}

#[cfg(test)]
mod tests {
    use super::volume;

    #[test]
    fn volumes_are_those_of_the_bodies() {
        let brick = [[0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0], [0, 0, 4], [2, 0, 4], [2, 3, 4], [0, 3, 4]];
        let brick = brick.map(|x| x.map(f64::from));
        assert!((volume(&brick) - 24.0).abs() < 1e-12);
        let wedge = [0, 1, 2, 4, 5, 6].map(|i| brick[i]);
        assert!((volume(&wedge) - 12.0).abs() < 1e-12);
        let tetrahedron = [0, 1, 3, 4].map(|i| brick[i]);
        assert!((volume(&tetrahedron) - 4.0).abs() < 1e-12);
    }
}
