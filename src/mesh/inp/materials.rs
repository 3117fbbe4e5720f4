//! Materials in SI, and the elements that have them.

use super::assemble::Element;
use super::lines::{key, unquoted};
use super::raw::{Raw, RawCell, RawKind, RawMaterial};
use super::sets::Sets;
use super::source::Source;
use crate::machine::{Material, MeshUnits, nearest};
use crate::mesh::{MeshError, Spot};

type Result<T> = std::result::Result<T, MeshError>;

/// The material of each cell, from the solid sections; materials that no section uses are left out, and all of
/// them where the part has another material.
pub fn assign_materials(
    raw: &Raw,
    elements: &mut [Element],
    element_sets: &Sets,
    source: &Source,
    units: MeshUnits,
    other_material: bool,
) -> Result<Vec<Material>> {
    let mut materials: Vec<Material> = Vec::new();
    for section in &raw.sections {
        let spot = source.spot(section.line);
        let Some(members) = element_sets.get(&section.element_set) else {
            let nearest = element_sets.nearest(&section.element_set);
            return Err(MeshError::UnknownName {
                spot,
                kind: "element set",
                name: unquoted(&section.element_set).to_owned(),
                nearest,
            });
        };
        let solid = |member: &u32| matches!(raw.cells[*member as usize].kind, RawKind::Solid(_));
        if let Some(&member) = members.iter().find(|member| !solid(member)) {
            let RawCell { kind, label, .. } = raw.cells[member as usize];
            return Err(MeshError::NoSolid { spot, element: label, kind: kind.name().to_owned() });
        }
        if other_material {
            continue;
        }
        let wanted = unquoted(&section.material);
        let Some(material) = raw.materials.iter().find(|m| key(&m.name) == key(wanted)) else {
            let nearest = nearest(wanted, raw.materials.iter().map(|m| unquoted(&m.name))).map(str::to_owned);
            return Err(MeshError::UnknownName { spot, kind: "material", name: wanted.to_owned(), nearest });
        };
        let index = materials.iter().position(|m| m.name == unquoted(&material.name)).unwrap_or(materials.len());
        if index == materials.len() {
            materials.push(material_in_si(material, units, &spot)?);
        }
        for &member in members {
            let cell = &raw.cells[member as usize];
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
        let (spot, name) = (spot.clone(), unquoted(&material.name).to_owned());
        MeshError::IncompleteMaterial { spot, name, property, keyword }
    };
    let (young, poisson) = material.elastic.ok_or_else(|| lacks("Young's modulus", "*ELASTIC"))?;
    let density = material.density.ok_or_else(|| lacks("density", "*DENSITY"))?;
    Ok(Material {
        name: unquoted(&material.name).to_owned(),
        young: young * units.stress(),
        poisson,
        density: density * units.density(),
    })
}
