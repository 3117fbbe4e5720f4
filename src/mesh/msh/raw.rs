//! What stands in a Gmsh file, and the mesh that it makes.

use super::elements::Kind;
use crate::machine::MeshUnits;
use crate::mesh::doubled::{Clash, merge};
use crate::mesh::labels::Labels;
use crate::mesh::named::loose_faces;
use crate::mesh::{Cell, CellKind, FaceElement, Mesh, MeshError, MeshFile, Namesake, Spot, Warning};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

type Result<T> = std::result::Result<T, MeshError>;

/// A physical group: dimension and number.
pub type Group = (u8, u64);

/// Everything of a file that the mesh is made from.
#[derive(Default)]
pub struct Raw {
    /// Label, coordinates and line of each node.
    pub nodes: Vec<(u64, [f64; 3], usize)>,
    pub elements: Vec<RawElement>,
    /// Node labels of all elements, one after the other.
    pub element_nodes: Vec<u64>,
    pub names: BTreeMap<Group, String>,
    /// Physical groups of each entity: dimension and number.
    pub entities: HashMap<(u8, u64), Vec<u64>>,
}

pub struct RawElement {
    pub kind: Kind,
    pub label: u64,
    pub line: usize,
    pub groups: Vec<Group>,
    /// Number of the geometrical entity that it belongs to, if the file says it.
    pub entity: Option<i64>,
}

/// What the physical groups of one name and one dimension hold.
#[derive(Default)]
struct Members {
    /// Nodes by their place in the file, in any order.
    nodes: Vec<usize>,
    /// Labels of triangles and quadrilaterals, with their corners by place in the file.
    faces: Vec<(u64, Vec<usize>)>,
    /// Volumes, by their place among those of the file.
    cells: Vec<usize>,
}

/// Groups by their name and dimension.
type Groups = BTreeMap<(String, u8), Members>;

impl Raw {
    /// The mesh, in metres.
    pub fn assemble(self, file: &Path, units: MeshUnits, plain_bricks: bool) -> Result<MeshFile> {
        let spot = |line| Spot { file: file.to_path_buf(), line };
        let labels = Labels::new(self.nodes.iter().map(|node| node.0)).map_err(|i| MeshError::Duplicate {
            spot: spot(self.nodes[i].2),
            kind: "node",
            label: self.nodes[i].0.to_string(),
        })?;
        let mut warnings = Vec::new();
        let mut said = HashSet::new();
        let mut groups = Groups::new();
        let (mut cells, mut of_cell) = (Vec::new(), Vec::new());
        let mut rest = self.element_nodes.as_slice();
        for element in &self.elements {
            let count = element.kind.node_count();
            let (own, others) = rest.split_at(count);
            rest = others;
            let mut nodes = Vec::with_capacity(count);
            for &label in own {
                nodes.push(labels.find(label).ok_or_else(|| MeshError::MissingLabel {
                    spot: spot(element.line),
                    by: format!("element {}", element.label),
                    kind: "node",
                    label,
                })?);
            }
            if let Some(i) = (0..count).find(|&i| nodes[..i].contains(&nodes[i])) {
                return Err(MeshError::Gmsh {
                    spot: spot(element.line),
                    section: "Elements",
                    seen: format!("element {} with node {} twice", element.label, own[i]),
                    allowed: format!("{count} different nodes; mesh again"),
                });
            }
            for group in &element.groups {
                let members = groups.entry((self.name(*group), group.0)).or_default();
                members.nodes.extend(&nodes);
                if let Some(corners) = element.kind.face_corners() {
                    members.faces.push((element.label, nodes[..corners].to_vec()));
                }
                if let Kind::Solid(..) = element.kind {
                    members.cells.push(cells.len());
                }
            }
            let Kind::Solid(kind, order) = element.kind else { continue };
            let kind = if kind == CellKind::Hex8 && !plain_bricks { CellKind::Hex8Incompatible } else { kind };
            if let Some(text) = remark(kind).filter(|_| said.insert(kind)) {
                warnings.push(Warning { line: element.line, text: text.to_owned() });
            }
            let nodes: Vec<usize> = order.iter().map(|&k| nodes[k]).collect();
            cells.push(Cell { kind, label: element.label, nodes, material: None });
            of_cell.push(element);
        }
        if cells.is_empty() {
            return Err(MeshError::NoElements { file: file.to_path_buf() });
        }
        // Version 2.2 writes a volume that is in several groups several times: in one place, once for each group.
        let expected = |second: usize, first: usize| {
            let (first, second): (&RawElement, &RawElement) = (of_cell[first], of_cell[second]);
            let apart = !second.groups.is_empty() && !second.groups.iter().any(|group| first.groups.contains(group));
            first.entity == second.entity && apart
        };
        let merged = merge(cells, expected).map_err(|Clash { first, second, difference }| MeshError::Coincident {
            spot: spot(of_cell[second].line),
            first: of_cell[first].label,
            second: of_cell[second].label,
            difference,
        })?;
        warnings.extend(merged.warning.map(|(cell, text)| Warning { line: of_cell[cell].line, text }));
        let mut mesh = Mesh { cells: merged.cells, ..Mesh::default() };
        let place = self.keep_used_nodes(&mut mesh, units, &mut warnings);
        name_groups(&mut mesh, groups, &place, &merged.place, &mut warnings);
        Ok(MeshFile { mesh, warnings })
    }

    /// Renumbers the nodes of the cells without those that no cell uses; the new place of each node of the file.
    fn keep_used_nodes(&self, mesh: &mut Mesh, units: MeshUnits, warnings: &mut Vec<Warning>) -> Vec<Option<usize>> {
        let mut used = vec![false; self.nodes.len()];
        mesh.cells.iter().flat_map(|cell| &cell.nodes).for_each(|&node| used[node] = true);
        let mut place = vec![None; used.len()];
        for (node, (label, at, _)) in self.nodes.iter().enumerate().filter(|(node, _)| used[*node]) {
            place[node] = Some(mesh.nodes.len());
            mesh.nodes.push(at.map(|x| x * units.length));
            mesh.node_labels.push(*label);
        }
        if let Some(first) = used.iter().position(|used| !used) {
            let count = used.iter().filter(|used| !**used).count();
            let (label, _, line) = self.nodes[first];
            let text = format!("{count} nodes that no solid element uses are dropped, node {label} first");
            warnings.push(Warning { line, text });
        }
        for node in mesh.cells.iter_mut().flat_map(|cell| &mut cell.nodes) {
            *node = place[*node].expect("every node of a cell is used");
        }
        place
    }

    fn name(&self, group: Group) -> String {
        let unnamed = || format!("Physical{}{}", DIMENSIONS[usize::from(group.0.min(3))], group.1);
        self.names.get(&group).cloned().unwrap_or_else(unnamed)
    }
}

/// What Gmsh calls points, curves, surfaces and volumes.
const DIMENSIONS: [&str; 4] = ["Point", "Curve", "Surface", "Volume"];

/// Puts the physical groups into the mesh. Groups of one name and several dimensions stay apart.
fn name_groups(
    mesh: &mut Mesh,
    groups: Groups,
    place: &[Option<usize>],
    place_of_cell: &[usize],
    warnings: &mut Vec<Warning>,
) {
    let unique = |mut list: Vec<usize>| {
        list.sort_unstable();
        list.dedup();
        list
    };
    let mut of_name: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    for (name, dimension) in groups.keys() {
        of_name.entry(name.clone()).or_default().push(*dimension);
    }
    for ((name, dimension), Members { nodes, faces, cells }) in groups {
        let nodes = unique(nodes.into_iter().filter_map(|node| place[node]).collect());
        let set = mesh.node_sets.entry(name.clone()).or_default();
        *set = unique([std::mem::take(set), nodes.clone()].concat());
        if dimension != 2 && of_name[&name].len() > 1 {
            let what = format!("the physical {}", DIMENSIONS[usize::from(dimension.min(3))].to_lowercase());
            mesh.namesakes.entry(name.clone()).or_default().push(Namesake { what, nodes });
        }
        if dimension == 3 {
            let cells = unique(cells.into_iter().map(|cell| place_of_cell[cell]).collect());
            mesh.element_sets.insert(name.clone(), cells);
        }
        if dimension == 2 {
            let corners = |nodes: Vec<usize>| nodes.into_iter().map(|node| place[node]).collect();
            let face = |(label, nodes)| FaceElement { label, corners: corners(nodes) };
            let faces: Vec<FaceElement> = faces.into_iter().map(face).collect();
            warnings.extend(loose_faces(&name, &faces).map(|text| Warning { line: 0, text }));
            mesh.face_sets.insert(name, faces);
        }
    }
}

fn remark(kind: CellKind) -> Option<&'static str> {
    match kind {
        CellKind::Tet4 => Some("four-node tetrahedra (C3D4) are far too stiff in bending; set Mesh.ElementOrder = 2"),
        CellKind::Hex8Incompatible => Some("eight-node bricks are read as C3D8I, the brick with incompatible modes"),
        CellKind::Hex8 => Some("plain eight-node bricks (C3D8) are far too stiff in bending"),
        _ => None,
    }
}
