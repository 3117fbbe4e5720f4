//! What stands in a Gmsh file, and the mesh that it makes.

use super::elements::Kind;
use crate::machine::MeshUnits;
use crate::mesh::labels::Labels;
use crate::mesh::{Cell, CellKind, Mesh, MeshError, MeshFile, Spot, Warning};
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
}

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
        let mut sets: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        let mut mesh = Mesh::default();
        // A volume in several groups stands several times in a file of version 2.2.
        let mut seen: HashMap<Vec<usize>, usize> = HashMap::new();
        let mut used = vec![false; self.nodes.len()];
        let mut rest = self.element_nodes.as_slice();
        for element in &self.elements {
            let count = match element.kind {
                Kind::Solid(kind, _) => kind.node_count(),
                Kind::Carrier(count) => count,
            };
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
                sets.entry(self.name(*group)).or_default().extend(&nodes);
            }
            let Kind::Solid(kind, order) = element.kind else { continue };
            let kind = if kind == CellKind::Hex8 && !plain_bricks { CellKind::Hex8Incompatible } else { kind };
            if let Some(text) = remark(kind).filter(|_| said.insert(kind)) {
                warnings.push(Warning { line: element.line, text: text.to_owned() });
            }
            let nodes: Vec<usize> = order.iter().map(|&k| nodes[k]).collect();
            let next = mesh.cells.len();
            let cell = *seen.entry(nodes.clone()).or_insert(next);
            for group in &element.groups {
                let members = mesh.element_sets.entry(self.name(*group)).or_default();
                if members.last() != Some(&cell) {
                    members.push(cell);
                }
            }
            if cell == next {
                nodes.iter().for_each(|&node| used[node] = true);
                mesh.cells.push(Cell { kind, label: element.label, nodes, material: None });
            }
        }
        if mesh.cells.is_empty() {
            return Err(MeshError::NoElements { file: file.to_path_buf() });
        }
        self.keep_used_nodes(&mut mesh, sets, &used, units, &mut warnings);
        for members in mesh.element_sets.values_mut() {
            members.sort_unstable();
            members.dedup();
        }
        Ok(MeshFile { mesh, warnings })
    }

    fn keep_used_nodes(
        &self,
        mesh: &mut Mesh,
        sets: BTreeMap<String, Vec<usize>>,
        used: &[bool],
        units: MeshUnits,
        warnings: &mut Vec<Warning>,
    ) {
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
        for (name, members) in sets {
            let mut members: Vec<usize> = members.into_iter().filter_map(|node| place[node]).collect();
            members.sort_unstable();
            members.dedup();
            mesh.node_sets.insert(name, members);
        }
    }

    fn name(&self, group: Group) -> String {
        let kinds = ["Point", "Curve", "Surface", "Volume"];
        let unnamed = || format!("Physical{}{}", kinds[usize::from(group.0.min(3))], group.1);
        self.names.get(&group).cloned().unwrap_or_else(unnamed)
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
