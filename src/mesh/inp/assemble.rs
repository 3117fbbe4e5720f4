//! Second pass: labels become indices, names become sets and materials, units become SI.

use super::materials::assign_materials;
use super::raw::{Raw, RawBoundary, RawKind, RawNode, RawSurface, Target};
use super::sets::{Kind, MOST_MEMBERS, MOST_MEMBERS_PER_LABEL, Resolver, Sets};
use super::source::Source;
use crate::machine::MeshUnits;
use crate::mesh::labels::Labels;
use crate::mesh::{Cell, CellFace, Mesh, MeshError, MeshFile, Warning};
use std::collections::BTreeMap;

type Result<T> = std::result::Result<T, MeshError>;

/// The mesh of what was collected.
pub fn assemble(mut raw: Raw, source: &Source, units: MeshUnits) -> Result<MeshFile> {
    let spot = |line: usize| source.spot(line);
    let file = || source.spot(1).file;
    if !raw.cells.iter().any(|cell| matches!(cell.kind, RawKind::Solid(_))) {
        return Err(MeshError::NoElements { file: file() });
    }
    let duplicate = |kind, label: u64, line: u32| MeshError::Duplicate {
        spot: spot(line as usize),
        kind,
        label: label.to_string(),
    };
    let node_labels = Labels::new(raw.nodes.iter().map(|node| node.label))
        .map_err(|i| duplicate("node", raw.nodes[i].label, raw.nodes[i].line))?;
    let cell_labels = Labels::new(raw.cells.iter().map(|cell| cell.label))
        .map_err(|i| duplicate("element", raw.cells[i].label, raw.cells[i].line))?;

    let mut elements = resolve_cells(&raw, &node_labels, source)?;
    let mut resolver = Resolver::new(source, std::mem::take(&mut raw.warnings));
    let element_kind = Kind { name: "element", labels: &cell_labels, elements: None };
    let element_sets = resolver.resolve(&raw.element_sets, &element_kind)?;
    let of_elements = Some((&elements, &element_sets));
    let node_kind = Kind { name: "node", labels: &node_labels, elements: of_elements };
    let mut node_sets = resolver.resolve(&raw.node_sets, &node_kind)?;
    node_sets.add_missing(carrier_sets(&raw, &elements, &element_sets));
    let materials = assign_materials(&raw, &mut elements, &element_sets, source, units)?;
    let boundaries = boundaries(&raw, &node_labels, &node_sets, source)?;

    // Solids keep their order; what only makes sets is left out.
    let mut place = vec![None; elements.len()];
    let mut cells = Vec::new();
    for (i, element) in elements.into_iter().enumerate() {
        if let RawKind::Solid(kind) = raw.cells[i].kind {
            place[i] = Some(cells.len());
            cells.push(Cell { kind, label: raw.cells[i].label, nodes: element.nodes, material: element.material });
        }
    }
    let surfaces = surfaces(&raw, &cells, &place, &cell_labels, &element_sets, source)?;
    let mut warnings = resolver.warnings;
    let kept = drop_unused_nodes(&raw, &mut cells, &mut warnings);
    let mut mesh = Mesh { cells, materials, surfaces, ..Mesh::default() };
    for (node, new) in raw.nodes.iter().zip(&kept) {
        if new.is_some() {
            mesh.nodes.push(node.at.map(|x| x * units.length));
            mesh.node_labels.push(node.label);
        }
    }
    for (node, directions) in boundaries {
        if let Some(node) = kept[node] {
            let held: &mut [bool; 3] = mesh.supports.entry(node).or_default();
            *held = std::array::from_fn(|c| held[c] || directions[c]);
        }
    }
    mesh.node_sets = node_sets.named(|index| kept[index]);
    mesh.element_sets = element_sets.named(|index| place[index]);
    warnings.sort_by_key(|warning| warning.line);
    let main = file();
    for warning in &mut warnings {
        // A line of an included file is named with its file.
        let at = source.spot(warning.line);
        if at.file != main {
            warning.text = format!("{at}: {}", warning.text);
        }
        warning.line = if at.file == main { at.line } else { 0 };
    }
    Ok(MeshFile { mesh, warnings })
}

/// An element with its nodes as indices.
pub struct Element {
    pub nodes: Vec<usize>,
    pub material: Option<usize>,
}

fn resolve_cells(raw: &Raw, labels: &Labels, source: &Source) -> Result<Vec<Element>> {
    let mut rest = raw.cell_nodes.as_slice();
    let mut elements = Vec::with_capacity(raw.cells.len());
    for cell in &raw.cells {
        let (own, others) = rest.split_at(cell.kind.node_count());
        rest = others;
        let mut nodes = Vec::with_capacity(own.len());
        for &label in own {
            nodes.push(labels.find(label).ok_or_else(|| MeshError::MissingLabel {
                spot: source.spot(cell.line as usize),
                by: format!("element {}", cell.label),
                kind: "node",
                label,
            })?);
        }
        elements.push(Element { nodes, material: None });
    }
    Ok(elements)
}

/// Node sets of the element sets that hold no solid: the surfaces and lines that Gmsh writes.
fn carrier_sets(raw: &Raw, elements: &[Element], sets: &Sets) -> Vec<(String, Vec<u32>)> {
    let carrier = |&&i: &&u32| matches!(raw.cells[i as usize].kind, RawKind::Carrier(..));
    let whole = sets.iter().filter(|(_, members)| !members.is_empty() && members.iter().all(|i| carrier(&i)));
    let nodes = |members: &[u32]| {
        let mut nodes: Vec<u32> =
            members.iter().flat_map(|&i| &elements[i as usize].nodes).map(|&node| node as u32).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    };
    whole.map(|(name, members)| (name.to_owned(), nodes(members))).collect()
}

/// Held displacements by node index.
fn boundaries(raw: &Raw, labels: &Labels, sets: &Sets, source: &Source) -> Result<Vec<(usize, [bool; 3])>> {
    let mut held = Vec::new();
    for RawBoundary { of, directions, line } in &raw.boundaries {
        let spot = || source.spot(*line);
        match of {
            Target::Label(label) => {
                let missing =
                    || MeshError::MissingLabel { spot: spot(), by: "*BOUNDARY".into(), kind: "node", label: *label };
                held.push((labels.find(*label).ok_or_else(missing)?, *directions));
            }
            Target::Set(name) => {
                let nearest = || sets.nearest(name);
                let unknown = || MeshError::UnknownName {
                    spot: spot(),
                    kind: "node set",
                    name: name.clone(),
                    nearest: nearest(),
                };
                held.extend(sets.get(name).ok_or_else(unknown)?.iter().map(|&n| (n as usize, *directions)));
            }
        }
        if held.len() > MOST_MEMBERS.max(MOST_MEMBERS_PER_LABEL * raw.nodes.len()) {
            return Err(MeshError::TooManyMembers { spot: spot(), limit: MOST_MEMBERS });
        }
    }
    Ok(held)
}

/// Surfaces by element faces.
fn surfaces(
    raw: &Raw,
    cells: &[Cell],
    place: &[Option<usize>],
    labels: &Labels,
    sets: &Sets,
    source: &Source,
) -> Result<BTreeMap<String, Vec<CellFace>>> {
    let mut spelling: BTreeMap<String, String> = BTreeMap::new();
    let mut found: BTreeMap<String, Vec<CellFace>> = BTreeMap::new();
    let mut count = 0;
    for RawSurface { name, of, face, line } in &raw.surfaces {
        let elements: Vec<u32> = match of {
            Target::Label(label) => {
                let by = format!("the surface {name:?}");
                let missing =
                    || MeshError::MissingLabel { spot: source.spot(*line), by, kind: "element", label: *label };
                vec![labels.find(*label).ok_or_else(missing)? as u32]
            }
            Target::Set(set) => {
                let members = sets.get(set).ok_or_else(|| MeshError::UnknownName {
                    spot: source.spot(*line),
                    kind: "element set",
                    name: set.clone(),
                    nearest: sets.nearest(set),
                })?;
                members.to_vec()
            }
        };
        count += elements.len();
        let limit = MOST_MEMBERS.max(MOST_MEMBERS_PER_LABEL * cells.len());
        if count > limit {
            return Err(MeshError::TooManyMembers { spot: source.spot(*line), limit });
        }
        let key = spelling.entry(name.to_uppercase()).or_insert_with(|| name.clone());
        let list = found.entry(key.clone()).or_default();
        for cell in elements.iter().filter_map(|&i| place[i as usize]) {
            let faces = cells[cell].kind.face_count();
            if *face >= faces {
                return Err(MeshError::Value {
                    spot: source.spot(*line),
                    keyword: "SURFACE",
                    seen: format!("S{} of element {}", face + 1, cells[cell].label),
                    allowed: format!("faces S1 to S{faces} of a {}", cells[cell].kind.name()),
                });
            }
            list.push(CellFace { cell, face: *face });
        }
    }
    for list in found.values_mut() {
        list.sort_unstable();
        list.dedup();
    }
    Ok(found)
}

/// Renumbers the cells' nodes without those that no cell uses; the new index of each node.
fn drop_unused_nodes(raw: &Raw, cells: &mut [Cell], warnings: &mut Vec<Warning>) -> Vec<Option<usize>> {
    let mut kept: Vec<Option<usize>> = vec![None; raw.nodes.len()];
    for &node in cells.iter().flat_map(|cell| &cell.nodes) {
        kept[node] = Some(0);
    }
    for (new, slot) in kept.iter_mut().flatten().enumerate() {
        *slot = new;
    }
    if let Some(first) = kept.iter().position(Option::is_none) {
        let RawNode { label, line, .. } = raw.nodes[first];
        let count = kept.iter().filter(|new| new.is_none()).count();
        let text = format!("{count} nodes that no element uses are dropped, node {label} first");
        warnings.push(Warning { line: line as usize, text });
    }
    for node in cells.iter_mut().flat_map(|cell| &mut cell.nodes) {
        *node = kept[*node].expect("every node of a cell is kept");
    }
    kept
}
