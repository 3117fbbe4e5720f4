//! `stiffmap export`: the assembled machine at a position, for another program.

use super::{UsageError, machine_path};
use anyhow::Result;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use stiffmap::export::deck::write_deck;
use stiffmap::machine::{Machine, read_machine};
use stiffmap::mesh::Mesh;
use stiffmap::pipeline;

#[derive(Args, Debug)]
pub struct Arguments {
    /// Machine file, or the folder that holds machine.toml; the bundled vertical mill without it
    machine: Option<PathBuf>,
    /// inp: one CalculiX deck
    #[arg(long, value_name = "inp")]
    format: Format,
    /// Position in m; the first of the travel without it
    #[arg(long, allow_hyphen_values = true, value_name = "Z")]
    position: Option<f64>,
    /// Frequencies that the deck asks for
    #[arg(long, default_value_t = 30, value_name = "N")]
    modes: usize,
    /// File to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

/// What to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// One CalculiX deck.
    Inp,
}

/// Writes the machine in the format asked for.
pub fn export(arguments: &Arguments) -> Result<()> {
    let (path, _bundled) = machine_path(arguments.machine.as_deref())?;
    let machine = read_machine(&path)?;
    let position = position(&machine, arguments.position)?;
    if arguments.modes == 0 {
        return Err(UsageError("--modes: 0 is not allowed; at least 1".into()).into());
    }
    let files = pipeline::read_meshes(&machine)?;
    let meshes: Vec<&Mesh> = files.iter().map(|f| &f.mesh).collect();
    match arguments.format {
        Format::Inp => {
            let springs = pipeline::unreduced_springs(&machine, &files, position)?;
            write_deck(&arguments.out, &machine, &meshes, &springs, arguments.modes)?;
        }
    }
    eprintln!("wrote {} at {} = {position} m to {}", machine.name, machine.axis.name, arguments.out.display());
    Ok(())
}

fn position(machine: &Machine, asked: Option<f64>) -> Result<f64, UsageError> {
    let [from, to] = machine.axis.travel;
    let position = asked.unwrap_or(from);
    if (from.min(to) - 1e-9..=from.max(to) + 1e-9).contains(&position) {
        return Ok(position);
    }
    Err(UsageError(format!(
        "--position: {position} m is outside the travel of axis \"{}\", {from} to {to} m",
        machine.axis.name
    )))
}
