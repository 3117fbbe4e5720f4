//! Second pass: labels become indices, names become sets and materials, units become SI.

use super::labels::Labels;
use super::raw::{Raw, RawMaterial, RawNode};
use super::sets::{Kind, Resolver, Sets};
use crate::machine::{Material, MeshUnits, nearest};
use crate::mesh::{Cell, Mesh, MeshError, MeshFile, Spot, Warning};
use std::path::Path;

type Result<T> = std::result::Result<T, MeshError>;

/// The mesh of what was collected.
pub fn assemble(mut raw: Raw, file: &Path, units: MeshUnits) -> Result<MeshFile> {
    let spot = |line: usize| Spot { file: file.to_path_buf(), line };
    if raw.cells.is_empty() {
        return Err(MeshError::NoElements { file: file.to_path_buf() });
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

    let mut cells = resolve_cells(&raw, &node_labels, file)?;
    let mut resolver = Resolver::new(file, std::mem::take(&mut raw.warnings));
    let node_sets = resolver.resolve(&raw.node_sets, &Kind { name: "node", labels: &node_labels })?;
    let element_sets = resolver.resolve(&raw.element_sets, &Kind { name: "element", labels: &cell_labels })?;
    let materials = assign_materials(&raw, &mut cells, &element_sets, file, units)?;

    let mut warnings = resolver.warnings;
    let kept = drop_unused_nodes(&raw, &mut cells, &mut warnings);
    let mut mesh = Mesh { cells, materials, ..Mesh::default() };
    for (node, new) in raw.nodes.iter().zip(&kept) {
        if new.is_some() {
            mesh.nodes.push(node.at.map(|x| x * units.length));
            mesh.node_labels.push(node.label);
        }
    }
    mesh.node_sets = node_sets.named(|index| kept[index]);
    mesh.element_sets = element_sets.named(Some);
    warnings.sort_by_key(|warning| warning.line);
    Ok(MeshFile { mesh, warnings })
}

fn resolve_cells(raw: &Raw, labels: &Labels, file: &Path) -> Result<Vec<Cell>> {
    let mut rest = raw.cell_nodes.as_slice();
    let mut cells = Vec::with_capacity(raw.cells.len());
    for cell in &raw.cells {
        let (own, others) = rest.split_at(cell.kind.node_count());
        rest = others;
        let mut nodes = Vec::with_capacity(own.len());
        for &label in own {
            nodes.push(labels.find(label).ok_or_else(|| MeshError::MissingLabel {
                spot: Spot { file: file.to_path_buf(), line: cell.line as usize },
                by: format!("element {}", cell.label),
                kind: "node",
                label,
            })?);
        }
        cells.push(Cell { kind: cell.kind, label: cell.label, nodes, material: None });
    }
    Ok(cells)
}

/// The material of each cell, from the solid sections; materials that no section uses are left out.
fn assign_materials(
    raw: &Raw,
    cells: &mut [Cell],
    element_sets: &Sets,
    file: &Path,
    units: MeshUnits,
) -> Result<Vec<Material>> {
    let mut materials: Vec<Material> = Vec::new();
    for section in &raw.sections {
        let spot = Spot { file: file.to_path_buf(), line: section.line };
        let Some(members) = element_sets.get(&section.element_set) else {
            let nearest = element_sets.nearest(&section.element_set);
            return Err(MeshError::UnknownName {
                spot,
                kind: "element set",
                name: section.element_set.clone(),
                nearest,
            });
        };
        let known = |m: &&RawMaterial| m.name.eq_ignore_ascii_case(&section.material);
        let Some(material) = raw.materials.iter().find(known) else {
            let nearest = nearest(&section.material, raw.materials.iter().map(|m| m.name.as_str()));
            let nearest = nearest.map(str::to_owned);
            return Err(MeshError::UnknownName { spot, kind: "material", name: section.material.clone(), nearest });
        };
        let index = materials.iter().position(|m| m.name == material.name).unwrap_or(materials.len());
        if index == materials.len() {
            materials.push(material_in_si(material, units, &spot)?);
        }
        for &member in members {
            let cell = &mut cells[member as usize];
            if let Some(first) = cell.material.replace(index).filter(|first| *first != index) {
                let (element, first) = (cell.label, materials[first].name.clone());
                return Err(MeshError::TwoMaterials { spot, element, first });
            }
        }
    }
    Ok(materials)
}

fn material_in_si(material: &RawMaterial, units: MeshUnits, spot: &Spot) -> Result<Material> {
    let lacks = |property, keyword| {
        let (spot, name) = (spot.clone(), material.name.clone());
        MeshError::IncompleteMaterial { spot, name, property, keyword }
    };
    let (young, poisson) = material.elastic.ok_or_else(|| lacks("Young's modulus", "*ELASTIC"))?;
    let density = material.density.ok_or_else(|| lacks("density", "*DENSITY"))?;
    Ok(Material {
        name: material.name.clone(),
        young: young * units.stress(),
        poisson,
        density: density * units.density(),
    })
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
