//! `stiffmap modes`: the frequencies of one deck.

use super::{UsageError, streams};
use anyhow::{Context, Result};
use clap::Args;
use serde_json::json;
use std::fmt::Write as _;
use std::path::PathBuf;
use stiffmap::interrupt::Interrupt;
use stiffmap::linalg::{FreeSpectrum, LinalgError, shift_invert_modes};
use stiffmap::machine::{Part, Placement};
use stiffmap::mesh::inp::{Deck, FrequencyStep, read_deck};
use stiffmap::pipeline::PipelineError;
use stiffmap::reduction::{admit_assembly, admit_modes};
use stiffmap::solid::{SecondOrder, assemble};

#[derive(Args, Debug)]
pub struct Arguments {
    /// CalculiX or Abaqus deck whose first step is *FREQUENCY, or a mesh with --modes
    deck: PathBuf,
    /// Modes to compute, in place of the number in the deck; a deck without a step needs it
    #[arg(long, value_name = "N")]
    modes: Option<usize>,
    /// Keep C3D8 as it is, in place of C3D8I
    #[arg(long)]
    plain_bricks: bool,
    /// Write the frequencies to stdout as JSON
    #[arg(long)]
    json: bool,
}

/// Computes the modes of a deck at rest and prints their frequencies, in cycles a time unit of the deck.
pub fn modes(arguments: &Arguments, interrupt: &Interrupt) -> Result<()> {
    if arguments.modes == Some(0) {
        return Err(UsageError("--modes 0: found 0, allowed: at least 1; ask for a mode".into()).into());
    }
    let Deck { mesh, frequency, warnings } = read_deck(&arguments.deck, arguments.plain_bricks, arguments.modes)?;
    for warning in &warnings {
        let at = if warning.line > 0 { format!(":{}", warning.line) } else { String::new() };
        streams::say(&format!("warning: {}{at}: {}", arguments.deck.display(), warning.text));
    }
    let part = whole(&arguments.deck);
    admit_assembly(&part.name, &mesh)?;
    let system = assemble(&part, &mesh).map_err(PipelineError::from)?;
    // Incompatible modes of C3D8I are unknowns of no node; they move alone where every node is held.
    if system.node_of_unknown().iter().all(Option::is_none) {
        let text = format!("{}: every displacement is held; release some", arguments.deck.display());
        return Err(UsageError(text).into());
    }
    let spectrum = solve(&part.name, &system, frequency, interrupt)?;
    let hertz = |l: &f64| l.max(0.0).sqrt() / std::f64::consts::TAU;
    let listed: Vec<(usize, f64)> = spectrum
        .eigenvalues
        .iter()
        .enumerate()
        .map(|(k, l)| (k + 1, if k < spectrum.rigid { 0.0 } else { hertz(l) }))
        .filter(|(_, f)| *f >= frequency.from && *f <= frequency.to)
        .take(frequency.modes)
        .collect();
    if arguments.json {
        let frequencies: Vec<f64> = listed.iter().map(|(_, f)| *f).collect();
        let report = json!({
            "deck": arguments.deck,
            "nodes": mesh.nodes.len(),
            "elements": mesh.cells.len(),
            "unknowns": system.n_dof(),
            "mass": system.total_mass,
            "rigid": spectrum.rigid,
            "frequencies": frequencies,
            "counted": spectrum.counted,
            "residual": spectrum.residual,
            "warnings": warnings.iter().map(|w| json!({"line": w.line, "text": w.text})).collect::<Vec<_>>(),
        });
        streams::print_json(&report)?;
        return Ok(());
    }
    streams::print(&table(arguments, &system, &mesh, &spectrum, &listed)?)?;
    Ok(())
}

/// The deck as a part that holds nothing but what the deck holds.
fn whole(deck: &std::path::Path) -> Part {
    Part {
        matrices: None,
        name: deck.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        mesh: deck.to_path_buf(),
        material: None,
        clamped: Vec::new(),
        interfaces: Vec::new(),
        loss_factor: None,
        mesh_units: stiffmap::machine::MeshUnits::METRE_KILOGRAM_SECOND,
        supported: Vec::new(),
        plain_bricks: false,
        placement: Placement::IDENTITY,
    }
}

/// As many modes as lie in the step's range, up to its number.
fn solve(name: &str, system: &SecondOrder, step: FrequencyStep, interrupt: &Interrupt) -> Result<FreeSpectrum> {
    let failed = |error: LinalgError| match error {
        LinalgError::Interrupted => anyhow::Error::from(PipelineError::Interrupted),
        error => anyhow::Error::from(error).context("the modes could not be computed"),
    };
    let ordering = system.ordering().map_err(failed)?;
    let mut wanted = step.modes;
    loop {
        admit_modes(name, system, &ordering, wanted)?;
        let found = shift_invert_modes(
            &system.stiffness,
            &system.mass,
            &ordering,
            system.rigid.ncols(),
            wanted,
            Some(interrupt),
        )
        .map_err(failed)?;
        let low = found.eigenvalues.iter().filter(|l| l.max(0.0).sqrt() / std::f64::consts::TAU < step.from).count();
        if found.eigenvalues.len() - low >= step.modes || found.eigenvalues.len() < wanted || step.from <= 0.0 {
            return Ok(found);
        }
        wanted = (step.modes + low).max(2 * wanted - low);
    }
}

fn table(
    arguments: &Arguments,
    system: &SecondOrder,
    mesh: &stiffmap::mesh::Mesh,
    spectrum: &FreeSpectrum,
    listed: &[(usize, f64)],
) -> Result<String> {
    let mut out = String::new();
    let name = arguments.deck.file_name().context("the deck has a name")?.to_string_lossy();
    writeln!(
        out,
        "{name}: {} nodes, {} elements, {} unknowns, mass {:.6e} in the deck's units",
        mesh.nodes.len(),
        mesh.cells.len(),
        system.n_dof(),
        system.total_mass
    )?;
    writeln!(out, "\nmode  frequency (cycles a time unit of the deck)")?;
    for (rank, frequency) in listed {
        let rigid = if *rank <= spectrum.rigid { "  rigid motion" } else { "" };
        writeln!(out, "{rank:4}  {frequency:.6e}{rigid}")?;
    }
    writeln!(out, "\n{} modes counted by inertia, residual {:.1e}", spectrum.counted, spectrum.residual)?;
    Ok(out)
}
