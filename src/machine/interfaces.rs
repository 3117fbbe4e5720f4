//! Interfaces of a part, and references to them.

use super::axis::GLOBAL_AXES;
use super::error::MachineError;
use super::matrices::{InterfaceNodes, InterfaceWeights};
use super::model::{Interface, InterfaceRef, Part, Region, SurfaceCoupling};
use super::quantity::Dimension;
use super::table::{Bound, Item, find_name};

type Result<T> = std::result::Result<T, MachineError>;

/// The interfaces of a part, and for one given by matrices what is said of their nodes.
pub(super) fn read_interfaces(item: &Item<'_>, by_matrices: bool) -> Result<Vec<(Interface, InterfaceNodes)>> {
    item.table()?.entries()?.iter().map(|(name, item)| read_interface(name, item, by_matrices)).collect()
}

fn read_interface(name: &str, item: &Item<'_>, by_matrices: bool) -> Result<(Interface, InterfaceNodes)> {
    let table = item.table()?;
    let nodes_item = table.need("nodes", "nodes = \"NODE_SET\"")?;
    let mut chosen = InterfaceNodes::default();
    let nodes = if by_matrices && !nodes_item.is_text() {
        let labels = read_labels(&nodes_item)?;
        let text = labels.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
        chosen.labels = Some(labels);
        format!("nodes {text}")
    } else {
        nodes_item.text()?.to_owned()
    };
    if nodes.trim().is_empty() {
        return Err(nodes_item.refuse("the name of a node set or surface of the mesh", "name one"));
    }
    if by_matrices && let Some(item) = table.get("weights") {
        chosen.weights = read_weights(&item)?;
    }
    let within = table.get("within").map(|item| read_region(&item)).transpose()?;
    let coupling = table.get("coupling").map(|item| read_coupling(&item)).transpose()?;
    table.finish()?;
    let coupling = coupling.unwrap_or(SurfaceCoupling::Distributing);
    Ok((Interface { name: name.to_owned(), nodes, within, coupling }, chosen))
}

/// A node label or a list of them.
fn read_labels(item: &Item<'_>) -> Result<Vec<u64>> {
    let items = if item.is_list() { item.list()? } else { vec![item.clone()] };
    if items.is_empty() {
        return Err(item.refuse("a node label, a list of them, or the name of a node set", "name at least one node"));
    }
    items.iter().map(|item| Ok(item.count()? as u64)).collect()
}

fn read_weights(item: &Item<'_>) -> Result<InterfaceWeights> {
    if item.is_list() {
        let weights = item.list()?.iter().map(Item::plain_number).collect::<Result<Vec<_>>>()?;
        if weights.iter().sum::<f64>() <= 0.0 {
            return Err(item.refuse("weights with a positive sum", "correct them"));
        }
        return Ok(InterfaceWeights::Given(weights));
    }
    match item.text()? {
        "area" => Ok(InterfaceWeights::Area),
        "equal" => Ok(InterfaceWeights::Equal),
        _ => Err(item.refuse("\"area\" (of the mesh's faces), \"equal\", or a list of numbers", "write one of them")),
    }
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
    const ALLOWED: &str = "{ axis = \"z\", from = \"10 mm\", to = \"30 mm\" }, or a box { x = [\"0 mm\", \"50 mm\"], z = [\"10 mm\", \"30 mm\"] }";
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
