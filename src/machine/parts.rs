//! Parts: mesh, units, material, clamped node sets, interfaces.

use super::error::MachineError;
use super::interfaces::read_interfaces;
use super::matrices::read_matrix_files;
use super::model::{Material, MeshUnits, Part, Placement};
use super::nearest::nearest;
use super::placement::{read_placement, read_supports};
use super::quantity::Dimension;
use super::table::{Bound, Item, Table};
use super::units::read_units;
use std::path::{Path, PathBuf};

type Result<T> = std::result::Result<T, MachineError>;

/// Largest loss factor accepted; rubber reaches about 1.
const LARGEST_LOSS_FACTOR: f64 = 2.0;

/// Closest that Poisson's ratio may come to -1 and 0.5, where a stiffness becomes infinite.
const CLOSEST: f64 = 1e-6;

pub(super) fn read_parts(root: &Table<'_>, file: &Path) -> Result<Vec<Part>> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let units = root.get("units").map(|item| read_units(&item)).transpose()?;
    let default_units = units.unwrap_or(MeshUnits::METRE_KILOGRAM_SECOND);
    let parts = root.need("parts", "at least one [parts.NAME] section")?;
    let entries = parts.table()?.entries()?;
    if entries.is_empty() {
        return Err(parts.refuse_seen("no part", "at least one part", "add a [parts.NAME] section"));
    }
    entries.iter().map(|(name, item)| read_part(name, item, folder, default_units)).collect()
}

fn read_part(name: &str, item: &Item<'_>, folder: &Path, default_units: MeshUnits) -> Result<Part> {
    let table = item.table()?;
    let matrices = table.get("matrices");
    let mesh = match (&matrices, table.get("mesh")) {
        (_, Some(mesh)) => Some(read_mesh_path(&mesh, folder)?),
        (Some(_), None) => None,
        (None, None) => Some(read_mesh_path(&table.need("mesh", "mesh = \"FILE.inp\"")?, folder)?),
    };
    let units = table.get("units").map(|item| read_units(&item)).transpose()?;
    let material = table.get("material").map(|item| read_material(&item, name)).transpose()?;
    let clamped = table.get("clamped").map(|item| read_set_names(&item)).transpose()?;
    let interfaces = table.get("interfaces").map(|item| read_interfaces(&item, matrices.is_some())).transpose()?;
    let (interfaces, nodes): (Vec<_>, Vec<_>) = interfaces.unwrap_or_default().into_iter().unzip();
    let matrices = matrices.map(|item| read_matrix_files(&item, folder, mesh.is_some(), nodes)).transpose()?;
    if let (Some(_), Some(item)) = (&matrices, table.get("material")) {
        return Err(
            item.refuse("a material of a part with a mesh alone", "remove it; the matrices hold stiffness and mass")
        );
    }
    let loss_factor = table.get("loss_factor").map(|item| read_loss_factor(&item)).transpose()?;
    let supported = table.get("supported").map(|item| read_supports(&item)).transpose()?;
    let plain_bricks = table.get("plain_bricks").map(|item| item.boolean()).transpose()?;
    let placement = read_placement(&table)?;
    if matrices.is_some() && placement.rotation != Placement::IDENTITY.rotation {
        let advice = "write the matrices in the machine's directions; only an origin may be given";
        return Err(item.refuse_seen("a turned part by matrices", "matrices along x, y, z of the machine", advice));
    }
    table.finish()?;
    Ok(Part {
        name: name.to_owned(),
        mesh: mesh.or_else(|| matrices.as_ref().map(|m| m.stiffness.clone())).unwrap_or_default(),
        matrices,
        material,
        clamped: clamped.unwrap_or_default(),
        interfaces,
        loss_factor,
        mesh_units: units.unwrap_or(default_units),
        supported: supported.unwrap_or_default(),
        plain_bricks: plain_bricks.unwrap_or(false),
        placement,
    })
}

pub(super) fn read_mesh_path(item: &Item<'_>, folder: &Path) -> Result<PathBuf> {
    let name = item.text()?;
    if name.trim().is_empty() {
        return Err(item.refuse("the name of a mesh file", "name one, relative to the machine file"));
    }
    let path = folder.join(name);
    if path.is_file() {
        return Ok(path);
    }
    let listing = path.parent().map(Path::to_path_buf).unwrap_or_default();
    let listing = if listing.as_os_str().is_empty() { PathBuf::from(".") } else { listing };
    // The listing only feeds a hint; a folder that cannot be listed gives none.
    let neighbours: Vec<String> = std::fs::read_dir(listing)
        .map(|entries| entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect())
        .unwrap_or_default();
    let last = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let nearest = nearest(&last, neighbours.iter().map(String::as_str)).map(str::to_owned);
    Err(MachineError::MissingMesh { place: item.place(), path, nearest })
}

fn read_material(item: &Item<'_>, part: &str) -> Result<Material> {
    let table = item.table()?;
    let young = table.need("young", "young = \"210 GPa\"")?.quantity(Dimension::Pressure, Bound::Positive)?;
    let poisson_item = table.need("poisson", "poisson = 0.3")?;
    let poisson = poisson_item.plain_number()?;
    if !(poisson > -1.0 + CLOSEST && poisson < 0.5 - CLOSEST) {
        let allowed = format!("more than -1 and less than 0.5, by {CLOSEST:e} at least");
        return Err(poisson_item.refuse(allowed, "correct Poisson's ratio; 0.3 for steel"));
    }
    let density = table.need("density", "density = \"7850 kg/m3\"")?.quantity(Dimension::Density, Bound::Positive)?;
    table.finish()?;
    Ok(Material { name: part.to_owned(), young, poisson, density })
}

/// A list of node sets, each named once.
fn read_set_names(item: &Item<'_>) -> Result<Vec<String>> {
    let mut names: Vec<String> = Vec::new();
    for entry in item.list()? {
        let name = entry.text()?;
        if name.trim().is_empty() {
            return Err(entry.refuse("the name of a node set of the mesh", "name one or remove the entry"));
        }
        if names.iter().any(|other| other.eq_ignore_ascii_case(name)) {
            let place = entry.place();
            return Err(MachineError::Duplicate { place, kind: "node set", name: name.to_owned() });
        }
        names.push(name.to_owned());
    }
    Ok(names)
}

/// A structural loss factor.
pub(super) fn read_loss_factor(item: &Item<'_>) -> Result<f64> {
    let eta = item.quantity(Dimension::Ratio, Bound::NotNegative)?;
    if eta > LARGEST_LOSS_FACTOR {
        let allowed = format!("a loss factor from 0 to {LARGEST_LOSS_FACTOR}");
        return Err(item.refuse(allowed, "write 0.02 or \"2 %\" for two per cent"));
    }
    Ok(eta)
}
