//! Materials in SI, and the elements that have them.

use super::assemble::Element;
use super::raw::{Raw, RawKind, RawMaterial};
use super::sets::Sets;
use super::source::Source;
use crate::machine::{Material, MeshUnits, nearest};
use crate::mesh::{MeshError, Spot};

type Result<T> = std::result::Result<T, MeshError>;

/// The material of each cell, from the solid sections; materials that no section uses are left out.
pub fn assign_materials(
    raw: &Raw,
    elements: &mut [Element],
    element_sets: &Sets,
    source: &Source,
    units: MeshUnits,
) -> Result<Vec<Material>> {
    let mut materials: Vec<Material> = Vec::new();
    for section in &raw.sections {
        let spot = source.spot(section.line);
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
            let cell = &raw.cells[member as usize];
            if let RawKind::Carrier(kind, _) = cell.kind {
                return Err(MeshError::NoSolid { spot, element: cell.label, kind: kind.to_owned() });
            }
            if let Some(first) = elements[member as usize].material.replace(index).filter(|first| *first != index) {
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
