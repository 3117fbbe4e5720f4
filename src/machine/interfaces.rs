//! Interfaces of a part, and references to them.

use super::axis::GLOBAL_AXES;
use super::error::MachineError;
use super::model::{Interface, InterfaceRef, Part, Region, SurfaceCoupling};
use super::quantity::Dimension;
use super::table::{Bound, Item, find_name};

type Result<T> = std::result::Result<T, MachineError>;

pub(super) fn read_interfaces(item: &Item<'_>) -> Result<Vec<Interface>> {
    item.table()?.entries()?.iter().map(|(name, item)| read_interface(name, item)).collect()
}

fn read_interface(name: &str, item: &Item<'_>) -> Result<Interface> {
    let table = item.table()?;
    let nodes_item = table.need("nodes", "nodes = \"NODE_SET\"")?;
    let nodes = nodes_item.text()?.to_owned();
    if nodes.trim().is_empty() {
        return Err(nodes_item.refuse("the name of a node set of the mesh", "name one"));
    }
    let within = table.get("within").map(|item| read_region(&item)).transpose()?;
    let coupling = table.get("coupling").map(|item| read_coupling(&item)).transpose()?;
    table.finish()?;
    let coupling = coupling.unwrap_or(SurfaceCoupling::Distributing);
    Ok(Interface { name: name.to_owned(), nodes, within, coupling })
}

fn read_coupling(item: &Item<'_>) -> Result<SurfaceCoupling> {
    match item.text()? {
        "distributing" => Ok(SurfaceCoupling::Distributing),
        "rigid" => Ok(SurfaceCoupling::Rigid),
        _ => Err(item.refuse(
            "\"distributing\" (the surface stays deformable) or \"rigid\"",
            "write one of them, or leave the key out for \"distributing\"",
        )),
    }
}

/// A range along one axis, `{ axis = "z", from = .., to = .. }`, or a box, `{ x = [from, to], .. }`;
/// what is left out is not bounded.
fn read_region(item: &Item<'_>) -> Result<Region> {
    const ALLOWED: &str = "{ axis = \"z\", from = \"10 mm\", to = \"30 mm\" }, or a box { x = [from, to], y = .. }";
    let table = item.table()?;
    let mut region = Region { min: [f64::NEG_INFINITY; 3], max: [f64::INFINITY; 3] };
    let mut bounded = false;
    if let Some(axis_item) = table.get("axis") {
        let name = axis_item.text()?;
        let axis = GLOBAL_AXES.iter().position(|(axis, _)| *axis == name);
        let axis = axis.ok_or_else(|| axis_item.refuse("\"x\", \"y\" or \"z\"", "write one of them"))?;
        for (key, bound) in [("from", &mut region.min[axis]), ("to", &mut region.max[axis])] {
            if let Some(item) = table.get(key) {
                *bound = item.quantity(Dimension::Length, Bound::Any)?;
                bounded = true;
            }
        }
    } else {
        for (axis, (key, _)) in GLOBAL_AXES.into_iter().enumerate() {
            let Some(range) = table.get(key) else {
                continue;
            };
            let [from, to] = range.array()?;
            region.min[axis] = from.quantity(Dimension::Length, Bound::Any)?;
            region.max[axis] = to.quantity(Dimension::Length, Bound::Any)?;
            bounded = true;
        }
    }
    table.finish()?;
    if !bounded {
        return Err(item.refuse(ALLOWED, "give a range, or remove `within` to take the whole surface"));
    }
    if region.min.iter().zip(region.max).any(|(min, max)| *min >= max) {
        return Err(item.refuse("a smaller length, then a larger one", "put the two in that order"));
    }
    Ok(region)
}

/// The interface that a text such as `"column.rail_left"` names.
pub(super) fn read_interface_ref(item: &Item<'_>, parts: &[Part]) -> Result<InterfaceRef> {
    let text = item.text()?;
    let Some((part_name, interface_name)) = text.split_once('.') else {
        return Err(item.refuse("\"PART.INTERFACE\", such as \"column.rail_left\"", "name both, with a dot between"));
    };
    let part_names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
    let part = find_name(item, "part", part_name, &part_names)?;
    let interfaces = &parts[part].interfaces;
    let interface_names: Vec<&str> = interfaces.iter().map(|interface| interface.name.as_str()).collect();
    let kind = format!("interface of the part {part_name:?}");
    let interface = find_name(item, &kind, interface_name, &interface_names)?;
    Ok(InterfaceRef { part, interface })
}
