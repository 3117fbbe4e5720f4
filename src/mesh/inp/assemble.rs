//! Second pass: labels become indices, names become sets and materials, units become SI.

use super::lines::unquoted;
use super::materials::assign_materials;
use super::places::{AllSets, name_places};
use super::raw::{Raw, RawBoundary, RawKind, RawNode, Target};
use super::sets::{Kind, MOST_MEMBERS, MOST_MEMBERS_PER_LABEL, Resolver};
use super::source::Source;
use super::surfaces::surfaces;
use crate::machine::MeshUnits;
use crate::mesh::doubled::{Clash, merge};
use crate::mesh::labels::Labels;
use crate::mesh::{Cell, Mesh, MeshError, MeshFile, Warning};

type Result<T> = std::result::Result<T, MeshError>;

/// The mesh of what was collected; without its materials if the part has another one.
pub fn assemble(mut raw: Raw, source: &Source, units: MeshUnits, other_material: bool) -> Result<MeshFile> {
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
    let cell_labels = cell_labels(&raw).map_err(|i| duplicate("element", raw.cells[i].label, raw.cells[i].line))?;

    let mut elements = resolve_cells(&raw, &node_labels, source)?;
    let mut resolver = Resolver::new(source, std::mem::take(&mut raw.warnings));
    let element_kind = Kind { name: "element", labels: &cell_labels, elements: None };
    let element_sets = resolver.resolve(&raw.element_sets, &element_kind, None)?;
    let of_elements = Some((&elements, &element_sets));
    let node_kind = Kind { name: "node", labels: &node_labels, elements: of_elements };
    let node_sets = resolver.resolve(&raw.node_sets, &node_kind, None)?;
    let node_surfaces = resolver.resolve(&raw.node_surfaces, &node_kind, Some(&node_sets))?;
    let sets = AllSets { node_sets, node_surfaces, element_sets };
    let materials = assign_materials(&raw, &mut elements, &sets.element_sets, source, units, other_material)?;
    let boundaries = boundaries(&raw, &node_labels, &elements, &sets, source)?;

    let mut warnings = resolver.warnings;
    let (mut cells, places) = solids(&raw, &elements, source, &mut warnings)?;
    let surfaces = surfaces(&raw, &cells, &places, &cell_labels, &sets.element_sets, source)?;
    let kept = drop_unused_nodes(&raw, &mut cells, &mut warnings);
    let passed_over = std::mem::take(&mut raw.passed_over).into_iter().collect();
    let mut mesh = Mesh { cells, materials, passed_over, ..Mesh::default() };
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
    name_places(&mut mesh, &raw, &elements, &sets, surfaces, &places, &kept, &mut warnings);
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

/// The elements' labels; one that is written again with the same nodes stands for the first.
fn cell_labels(raw: &Raw) -> std::result::Result<Labels, usize> {
    let mut ends = Vec::with_capacity(raw.cells.len());
    let mut end = 0;
    for cell in &raw.cells {
        end += cell.kind.node_count();
        ends.push(end);
    }
    let nodes = |i: usize| &raw.cell_nodes[ends[i] - raw.cells[i].kind.node_count()..ends[i]];
    let twins = |first: usize, second: usize| {
        raw.cells[first].kind.name() == raw.cells[second].kind.name() && nodes(first) == nodes(second)
    };
    Labels::with_twins(raw.cells.iter().map(|cell| cell.label), twins)
}

/// Where the elements of the file are among the cells of the mesh.
pub struct Places {
    /// For each element its cell; `None` for one that is no solid.
    pub cell: Vec<Option<usize>>,
    /// For each element whether it is a cell that stands twice, with its nodes in another order.
    pub turned: Vec<bool>,
}

/// The solids in the order of the file, each once; what only makes sets is left out.
fn solids(
    raw: &Raw,
    elements: &[Element],
    source: &Source,
    warnings: &mut Vec<Warning>,
) -> Result<(Vec<Cell>, Places)> {
    let (mut cells, mut of_cell) = (Vec::new(), Vec::new());
    for (i, (own, element)) in raw.cells.iter().zip(elements).enumerate() {
        if let RawKind::Solid(kind) = own.kind {
            let nodes = element.nodes.clone();
            cells.push(Cell { kind, label: own.label, nodes, material: element.material });
            of_cell.push(i);
        }
    }
    let line = |cell: usize| raw.cells[of_cell[cell]].line as usize;
    let label = |cell: usize| raw.cells[of_cell[cell]].label;
    let merged = merge(cells, |_, _| false).map_err(|Clash { first, second, difference }| MeshError::Coincident {
        spot: source.spot(line(second)),
        first: label(first),
        second: label(second),
        difference,
    })?;
    warnings.extend(merged.warning.map(|(cell, text)| Warning { line: line(cell), text }));
    let mut places = Places { cell: vec![None; elements.len()], turned: vec![false; elements.len()] };
    for ((&i, &place), &turned) in of_cell.iter().zip(&merged.place).zip(&merged.turned) {
        (places.cell[i], places.turned[i]) = (Some(place), turned);
    }
    Ok((merged.cells, places))
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

/// Held displacements by node index.
fn boundaries(
    raw: &Raw,
    labels: &Labels,
    elements: &[Element],
    sets: &AllSets,
    source: &Source,
) -> Result<Vec<(usize, [bool; 3])>> {
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
                let unknown = || MeshError::UnknownName {
                    spot: spot(),
                    kind: "node set",
                    name: unquoted(name).to_owned(),
                    nearest: sets.node_sets.nearest(name),
                };
                let nodes = sets.nodes(name, raw, elements).ok_or_else(unknown)?;
                held.extend(nodes.into_iter().map(|n| (n as usize, *directions)));
            }
        }
        if held.len() > MOST_MEMBERS.max(MOST_MEMBERS_PER_LABEL * raw.nodes.len()) {
            return Err(MeshError::TooManyMembers { spot: spot(), limit: MOST_MEMBERS });
        }
    }
    Ok(held)
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
