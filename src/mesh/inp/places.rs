//! What the names of an input file stand for: node sets, element sets, surfaces, and names that several have.

use super::assemble::{Element, Places};
use super::raw::{Raw, RawKind};
use super::sets::Sets;
use crate::mesh::named::loose_faces;
use crate::mesh::{CellFace, FaceElement, Mesh, Namesake, Warning};
use std::collections::{BTreeMap, BTreeSet};

/// The sets of a file.
pub struct AllSets {
    pub node_sets: Sets,
    /// Surfaces made of nodes.
    pub node_surfaces: Sets,
    pub element_sets: Sets,
}

impl AllSets {
    /// The nodes that a name stands for in `*BOUNDARY`: a node set or, for sets as Gmsh writes them, the nodes of
    /// an element set without solids.
    pub fn nodes(&self, name: &str, raw: &Raw, elements: &[Element]) -> Option<Vec<u32>> {
        let own = self.node_sets.get(name).or_else(|| self.node_surfaces.get(name)).map(<[u32]>::to_vec);
        own.or_else(|| {
            let members = self.element_sets.get(name).filter(|members| !members.is_empty())?;
            let solid = |i: &u32| matches!(raw.cells[*i as usize].kind, RawKind::Solid(_));
            (!members.iter().any(solid)).then(|| nodes_of(members.iter().copied(), elements))
        })
    }
}

/// The nodes of some elements, ascending, no duplicates.
fn nodes_of(members: impl Iterator<Item = u32>, elements: &[Element]) -> Vec<u32> {
    let mut nodes: Vec<u32> = members.flat_map(|i| &elements[i as usize].nodes).map(|&node| node as u32).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// What one name stands for; nodes by their number in the file, cells by their number in the mesh.
#[derive(Default)]
struct Meanings<'a> {
    spelling: &'a str,
    node_set: Option<&'a [u32]>,
    node_surface: Option<&'a [u32]>,
    /// Members of an element set.
    elements: Option<&'a [u32]>,
    surface: Option<Vec<CellFace>>,
}

/// Puts the named places of a file into its mesh.
#[expect(clippy::too_many_arguments, reason = "everything of the file that has a name or says what became of it")]
pub fn name_places(
    mesh: &mut Mesh,
    raw: &Raw,
    elements: &[Element],
    sets: &AllSets,
    surfaces: BTreeMap<String, (String, Vec<CellFace>)>,
    places: &Places,
    kept: &[Option<usize>],
    warnings: &mut Vec<Warning>,
) {
    let mut names: BTreeMap<&str, Meanings<'_>> = BTreeMap::new();
    for (key, spelling, nodes) in sets.node_sets.iter() {
        names.insert(key, Meanings { spelling, node_set: Some(nodes), ..Meanings::default() });
    }
    for (key, spelling, nodes) in sets.node_surfaces.iter() {
        names.entry(key).or_insert_with(|| Meanings { spelling, ..Meanings::default() }).node_surface = Some(nodes);
    }
    for (key, spelling, members) in sets.element_sets.iter() {
        names.entry(key).or_insert_with(|| Meanings { spelling, ..Meanings::default() }).elements = Some(members);
    }
    for (key, (spelling, faces)) in &surfaces {
        names.entry(key.as_str()).or_insert_with(|| Meanings { spelling, ..Meanings::default() }).surface =
            Some(faces.clone());
    }
    let file = File { raw, elements, places, kept };
    for meanings in names.into_values() {
        file.name(mesh, meanings, warnings);
    }
}

/// What names are resolved with.
struct File<'a> {
    raw: &'a Raw,
    elements: &'a [Element],
    places: &'a Places,
    /// For each node of the file its place in the mesh.
    kept: &'a [Option<usize>],
}

impl File<'_> {
    /// Puts one name into the mesh.
    fn name(&self, mesh: &mut Mesh, meanings: Meanings<'_>, warnings: &mut Vec<Warning>) {
        let Meanings { spelling, node_set, node_surface, elements, surface } = meanings;
        let name = spelling.to_owned();
        let members = elements.unwrap_or_default().iter().copied();
        let of_kind =
            |wanted: fn(RawKind) -> bool| members.clone().filter(move |&i| wanted(self.raw.cells[i as usize].kind));
        let solids: Vec<u32> = of_kind(|kind| matches!(kind, RawKind::Solid(_))).collect();
        let faces: Vec<FaceElement> =
            of_kind(|kind| kind.face_corners().is_some()).filter_map(|i| self.face(i)).collect();
        let lines = self.kept_nodes(&nodes_of(of_kind(|kind| matches!(kind, RawKind::Line(..))), self.elements));
        let marked = self.kept_nodes(&nodes_of(of_kind(|kind| kind.face_corners().is_some()), self.elements));

        let mut sources: Vec<Namesake> = Vec::new();
        let source = |what: &str, nodes: Vec<usize>| Namesake { what: what.to_owned(), nodes };
        if let Some(nodes) = node_set {
            sources.push(source("the node set (*NSET)", self.kept_nodes(nodes)));
        }
        if let Some(nodes) = node_surface {
            sources.push(source("the surface of nodes (*SURFACE, TYPE=NODE)", self.kept_nodes(nodes)));
        }
        let inside = |nodes: &[usize], others: &[usize]| nodes.iter().all(|n| others.binary_search(n).is_ok());
        if !lines.is_empty() && (faces.is_empty() || !inside(&lines, &marked)) {
            sources.push(source("the line elements of the element set (*ELSET)", lines.clone()));
        }
        let of_faces = usize::from(!faces.is_empty()) + usize::from(surface.is_some());
        if sources.len() + of_faces > 0 && !solids.is_empty() {
            // A set of solids beside a set of nodes is usual: all of a body, or the solids behind a surface.
            let cells: BTreeSet<usize> = solids.iter().filter_map(|&i| self.places.cell[i as usize]).collect();
            let behind = faces.is_empty()
                && sources.iter().all(|other| self.touch(&solids, &other.nodes))
                && surface.as_ref().is_none_or(|faces| faces.iter().all(|face| cells.contains(&face.cell)));
            if !behind {
                let nodes = self.kept_nodes(&nodes_of(solids.iter().copied(), self.elements));
                sources.push(source("the solid elements of the element set (*ELSET)", nodes));
            }
        }

        if elements.is_some() {
            let mut cells: Vec<usize> = solids.iter().filter_map(|&i| self.places.cell[i as usize]).collect();
            cells.sort_unstable();
            cells.dedup();
            mesh.element_sets.insert(name.clone(), cells);
        }
        let mut carried = marked;
        carried.extend(lines);
        carried.sort_unstable();
        carried.dedup();
        let carriers_alone = solids.is_empty() && elements.is_some_and(|members| !members.is_empty());
        if let Some(nodes) = node_set.or(node_surface) {
            mesh.node_sets.insert(name.clone(), self.kept_nodes(nodes));
        } else if carriers_alone {
            mesh.node_sets.insert(name.clone(), carried);
        }
        warnings.extend(loose_faces(spelling, &faces).map(|text| Warning { line: 0, text }));
        if sources.len() + of_faces > 1 && !sources.is_empty() {
            mesh.namesakes.insert(name.clone(), sources);
        }
        if !faces.is_empty() {
            mesh.face_sets.insert(name.clone(), faces);
        }
        if let Some(faces) = surface {
            mesh.surfaces.insert(name, faces);
        }
    }

    fn face(&self, element: u32) -> Option<FaceElement> {
        let own = &self.raw.cells[element as usize];
        let nodes = &self.elements[element as usize].nodes[..own.kind.face_corners()?];
        Some(FaceElement { label: own.label, corners: nodes.iter().map(|&node| self.kept[node]).collect() })
    }

    fn kept_nodes(&self, nodes: &[u32]) -> Vec<usize> {
        nodes.iter().filter_map(|&node| self.kept[node as usize]).collect()
    }

    /// Whether each of some solids has one of the nodes, and each of the nodes belongs to one of the solids.
    fn touch(&self, solids: &[u32], nodes: &[usize]) -> bool {
        let has = |i: &u32| {
            let mut own = self.elements[*i as usize].nodes.iter().filter_map(|&node| self.kept[node]);
            own.any(|node| nodes.binary_search(&node).is_ok())
        };
        let all = self.kept_nodes(&nodes_of(solids.iter().copied(), self.elements));
        solids.iter().all(has) && nodes.iter().all(|node| all.binary_search(node).is_ok())
    }
}
