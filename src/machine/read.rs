//! Reading a machine file from top to bottom.

use super::analysis::read_analysis;
use super::axis::read_axis;
use super::error::MachineError;
use super::joints::{Surroundings, read_joints};
use super::model::{Joint, Machine, Part};
use super::parts::read_parts;
use super::ports::read_ports;
use super::table::{Source, Table};
use crate::files::Inputs;
use std::path::Path;
use toml::de::DeTable;

/// The machine that a machine file describes.
///
/// `path` is the file itself, or a folder that holds `machine.toml`. Mesh files are looked for
/// beside the machine file; they are not read.
///
/// # Errors
/// [`MachineError`] for the first thing that is wrong: the file cannot be read or is not TOML, a key is
/// unknown or missing, a value is not allowed, a name does not exist or is given twice, a mesh file
/// does not exist.
pub fn read_machine(path: &Path) -> Result<Machine, MachineError> {
    let is_folder = path.is_dir();
    let file = if is_folder { path.join("machine.toml") } else { path.to_path_buf() };
    let mut inputs = Inputs::default();
    let text = inputs.read_text(&file).map_err(|source| MachineError::Unreadable {
        file: file.clone(),
        source,
        advice: if is_folder {
            "name a machine file, or a folder that holds machine.toml (`stiffmap init DIR` writes one)"
        } else {
            "name a machine file in UTF-8 of at most 16 MiB, or the folder of one (`stiffmap init DIR` writes one)"
        },
    })?;
    let source = Source { path: &file, text: &text };
    let document = DeTable::parse(&text).map_err(|error| {
        let (line, column) = source.line_column(error.span().map_or(0, |span| span.start));
        MachineError::Syntax { file: file.clone(), line, column, message: error.message().to_owned() }
    })?;
    read_document(Table::root(&source, document.get_ref()), &file, inputs)
}

fn read_document(root: Table<'_>, file: &Path, inputs: Inputs) -> Result<Machine, MachineError> {
    let name = read_title(&root)?;
    let parts = read_parts(&root, file)?;
    let axis = read_axis(&root, &parts)?;
    let joints = read_joints(&root, &Surroundings { parts: &parts, axis: &axis })?;
    let ports = read_ports(&root, &parts)?;
    let analysis = read_analysis(&root)?;
    check_every_part_is_joined(&root, &parts, &joints)?;
    root.finish()?;
    Ok(Machine { name, file: file.to_path_buf(), parts, joints, axis, ports, analysis, inputs })
}

fn read_title(root: &Table<'_>) -> Result<String, MachineError> {
    let item = root.need("name", "name = \"my machine\"")?;
    let name = item.text()?;
    item.check_name(name)?;
    Ok(name.to_owned())
}

/// A part without any joint is a slip of the file; one part alone needs none.
fn check_every_part_is_joined(root: &Table<'_>, parts: &[Part], joints: &[Joint]) -> Result<(), MachineError> {
    if parts.len() == 1 {
        return Ok(());
    }
    let is_joined = |part| joints.iter().any(|joint| joint.between.iter().any(|side| side.part == part));
    let Some(part) = (0..parts.len()).find(|&part| !is_joined(part)) else {
        return Ok(());
    };
    let name = &parts[part].name;
    let item = root.need("parts", "[parts.NAME]")?.table()?.get_named(name);
    Err(item.unwrap_or_else(|| root.item.clone()).refuse_seen(
        format!("the part {name:?} without any joint"),
        "parts that at least one joint connects to another part",
        "add a joint in a [[joints]] section, or remove the part",
    ))
}
