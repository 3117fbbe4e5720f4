//! Ports: where forces enter and motions are read.

use super::axis::GLOBAL_AXES;
use super::error::MachineError;
use super::interfaces::read_interface_ref;
use super::model::{Part, Port};
use super::table::{Item, Table};

type Result<T> = std::result::Result<T, MachineError>;

pub(super) fn read_ports(root: &Table<'_>, parts: &[Part]) -> Result<Vec<Port>> {
    let item = root.need("ports", "a [ports.NAME] section with interface and directions")?;
    let entries = item.table()?.entries()?;
    let ports = entries.iter().map(|(name, item)| read_port(name, item, parts)).collect::<Result<Vec<_>>>()?;
    let missing = if !ports.iter().any(|port| port.input) {
        "input, where a force acts"
    } else if !ports.iter().any(|port| port.output) {
        "output, where a motion is read"
    } else {
        return Ok(ports);
    };
    Err(item.refuse_seen(
        format!("{} ports without an {missing}", ports.len()),
        "at least one input and one output among the ports",
        "a port is both unless it says input = false or output = false; add one or remove that line",
    ))
}

fn read_port(name: &str, item: &Item<'_>, parts: &[Part]) -> Result<Port> {
    let table = item.table()?;
    let interface = read_interface_ref(&table.need("interface", "interface = \"PART.INTERFACE\"")?, parts)?;
    let directions = read_directions(&table.need("directions", "directions = [\"x\", \"y\", \"z\"]")?)?;
    let flag = |key| table.get(key).map_or(Ok(true), |item| item.boolean());
    let (input, output) = (flag("input")?, flag("output")?);
    table.finish()?;
    if !input && !output {
        return Err(item.refuse_seen(
            "a port that is neither input nor output",
            "input = true, output = true or both",
            "remove one of the two lines, or the port",
        ));
    }
    Ok(Port { name: name.to_owned(), interface, directions, input, output })
}

fn read_directions(item: &Item<'_>) -> Result<Vec<(String, [f64; 3])>> {
    const ALLOWED: &str = "a list of \"x\", \"y\" and \"z\"";
    let mut directions: Vec<(String, [f64; 3])> = Vec::new();
    for entry in item.list()? {
        let name = entry.text()?;
        let Some((_, vector)) = GLOBAL_AXES.iter().find(|(axis, _)| *axis == name) else {
            return Err(entry.refuse(ALLOWED, "write one of them"));
        };
        if directions.iter().any(|(other, _)| other == name) {
            let place = entry.place();
            return Err(MachineError::Duplicate { place, kind: "direction", name: name.to_owned() });
        }
        directions.push((name.to_owned(), *vector));
    }
    if directions.is_empty() {
        return Err(item.refuse(ALLOWED, "name at least one direction"));
    }
    Ok(directions)
}
