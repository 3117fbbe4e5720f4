//! The command line: one file a subcommand.

mod band;
mod bench;
mod check;
mod converge;
mod devices;
mod evaluator;
mod export;
pub mod fault;
mod figures;
mod frequencies;
mod init;
pub mod leave;
mod map;
mod memory;
mod modes;
mod optimise;
mod overrides;
mod pictures;
mod progress;
mod record;
mod report;
mod run;
mod serve;
mod simulate;
mod simulate_files;
mod simulate_forces;
mod simulate_size;
mod states;
pub mod streams;
mod summary;
mod sweep;
mod sweep_figures;
mod sweep_files;
mod sweep_progress;
mod sweep_rates;
mod view;

use anyhow::Result;
use clap::{Parser, Subcommand};
use std::path::{Path, PathBuf};
use stiffmap::coupling::CouplingError;
use stiffmap::export::ExportError;
use stiffmap::export::manifest::Manifest;
use stiffmap::figures::report::ReportError;
use stiffmap::files::{FolderError, MANIFEST, ResultFolder};
use stiffmap::frf::FrfError;
use stiffmap::gpu::GpuError;
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::{Machine, MachineError, bundled_vertical_mill};
use stiffmap::mesh::MeshError;
use stiffmap::pipeline::PipelineError;
use stiffmap::response::ResponseError;
use stiffmap::sweep::{StudyError, SweepError, TableError};

/// Dynamic stiffness of a machine tool over its whole work volume.
#[derive(Parser, Debug)]
#[command(version, about, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// The main job: from the machine file to modes, state space, compliance map and pictures
    Run(run::Arguments),
    /// Time histories: forces in, motions out, at fixed positions or along a path
    Simulate(Box<simulate::Arguments>),
    /// Evaluate the designs of a study: a table with one row a design
    Sweep(sweep::Arguments),
    /// Look for the best design of a study under its bounds
    Optimise(optimise::Arguments),
    /// Print what is understood of a machine, without solving
    Check(check::Arguments),
    /// Write the bundled vertical mill into a folder, as a start for a machine of your own
    Init(init::Arguments),
    /// Draw the pictures and the report page of a result folder again
    Figures(figures::Arguments),
    /// Open the report page of a result folder in the browser, or serve it on this machine alone
    View(view::Arguments),
    /// Write the assembled machine at a position for another program: a CalculiX deck or matrices
    Export(export::Arguments),
    /// Frequencies with distributing and with rigid interfaces: how much the contacts' modelling matters
    Band(band::Arguments),
    /// How far the frequencies are from those of an infinitely fine mesh
    Converge(converge::Arguments),
    /// Compute the frequencies of one CalculiX or Abaqus deck
    Modes(modes::Arguments),
    /// List the adapters that could compute a map
    Devices(devices::Arguments),
    /// Measure the compliance kernel on the processor and on each adapter
    Bench(bench::Arguments),
}

/// The program's exit codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Done.
    Done = 0,
    /// Failed.
    Failed = 1,
    /// Bad input or usage.
    BadInput = 2,
    /// Interrupted.
    Interrupted = 130,
}

/// Bad input that is found on the command line itself.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);

/// Runs a parsed command line.
///
/// # Errors
/// Whatever the subcommand says.
pub fn execute(cli: Cli, interrupt: &Interrupt) -> Result<()> {
    match cli.command {
        Command::Run(arguments) => run::run(&arguments, interrupt),
        Command::Simulate(arguments) => simulate::simulate(&arguments, interrupt),
        Command::Sweep(arguments) => sweep::sweep(&arguments, interrupt),
        Command::Optimise(arguments) => optimise::optimise(&arguments, interrupt),
        Command::Check(arguments) => check::check(&arguments),
        Command::Init(arguments) => init::init(&arguments),
        Command::Figures(arguments) => figures::figures(&arguments, interrupt),
        Command::View(arguments) => view::view(&arguments, interrupt),
        Command::Export(arguments) => export::export(&arguments, interrupt),
        Command::Band(arguments) => band::band(&arguments, interrupt),
        Command::Converge(arguments) => converge::converge(&arguments, interrupt),
        Command::Modes(arguments) => modes::modes(&arguments, interrupt),
        Command::Devices(arguments) => devices::devices(&arguments),
        Command::Bench(arguments) => bench::bench(&arguments),
    }
}

/// The exit code that an error stands for.
pub fn exit_code(error: &anyhow::Error, interrupt: &Interrupt) -> Exit {
    if interrupt.requested() {
        return Exit::Interrupted;
    }
    let input = error.is::<UsageError>()
        || error.is::<MachineError>()
        || error.downcast_ref::<MeshError>().is_some_and(|e| !matches!(e, MeshError::Memory(_)))
        || error.is::<StudyError>()
        || error.downcast_ref::<FolderError>().is_some_and(FolderError::is_input)
        || error.downcast_ref::<TableError>().is_some_and(TableError::is_input)
        || error.downcast_ref::<SweepError>().is_some_and(is_design_input)
        || error.downcast_ref::<PipelineError>().is_some_and(PipelineError::is_input)
        || matches!(error.downcast_ref(), Some(ReportError::NoDatabase { .. } | ReportError::Missing { .. }))
        || error.downcast_ref::<ResponseError>().is_some_and(ResponseError::is_input)
        || match (error.downcast_ref::<FrfError>(), error.downcast_ref::<GpuError>()) {
            (Some(e), _) | (_, Some(GpuError::Request(e))) => {
                !matches!(e, FrfError::Sink { .. } | FrfError::Truncation { .. })
            }
            _ => false,
        };
    if input && !error.is::<ExportError>() { Exit::BadInput } else { Exit::Failed }
}

/// Whether a study asks for what its machine or the route cannot be.
fn is_design_input(error: &SweepError) -> bool {
    match error {
        SweepError::Coupling(error) => !matches!(error, CouplingError::Basis(_)),
        SweepError::NeedsModes | SweepError::Value { .. } => true,
        _ => false,
    }
}

/// An error with its causes, each said once.
pub fn describe(error: &anyhow::Error) -> String {
    let said = error.chain().map(ToString::to_string).fold(String::new(), |said, cause| {
        if said.is_empty() {
            cause
        } else if said.contains(&cause) {
            said
        } else {
            format!("{said}: {cause}")
        }
    });
    streams::shortened(said)
}

/// Locks the result folder of a command; a job that writes it already is told with what is known of it.
fn open_folder(out: &Path, command: &str) -> Result<ResultFolder> {
    let words: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    match ResultFolder::open(out, command, &format!("stiffmap {}", words.join(" "))) {
        Err(error @ FolderError::Io { .. }) => Err(anyhow::Error::from(error).context("the result folder (--out)")),
        opened => Ok(opened?),
    }
}

/// Takes the old result away but for the files to keep, unless someone asked to stop.
fn begin(folder: &mut ResultFolder, keep: &[&str], interrupt: &Interrupt) -> Result<()> {
    if interrupt.requested() {
        return Err(PipelineError::Interrupted.into());
    }
    Ok(folder.begin(keep)?)
}

/// Puts the files that a manifest lists on the disk, writes it as the last, and gives the folder back.
fn finish(folder: ResultFolder, manifest: &Manifest) -> Result<()> {
    folder.sync(&manifest.files)?;
    manifest.write(&folder.path().join(MANIFEST))?;
    Ok(folder.finish()?)
}

/// The position asked for, or the first of the travel.
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

/// The number of modes asked for, which must be one at least.
fn at_least_one(modes: usize) -> Result<usize, UsageError> {
    if modes == 0 { Err(UsageError("--modes: 0 is not allowed; at least 1".into())) } else { Ok(modes) }
}

/// The machine file that a command means: the one named, or the bundled mill in a folder of its own.
fn machine_path(named: Option<&Path>) -> Result<(PathBuf, Option<tempfile::TempDir>)> {
    if let Some(path) = named {
        return Ok((path.to_path_buf(), None));
    }
    let folder = tempfile::Builder::new().prefix("stiffmap").tempdir()?;
    leave::remove_too(folder.path());
    for (name, content) in bundled_vertical_mill() {
        std::fs::write(folder.path().join(name), content)?;
    }
    Ok((folder.path().join("machine.toml"), Some(folder)))
}

/// Where superelements and measurements are kept: `STIFFMAP_CACHE`, or the user's cache folder.
fn cache_folder() -> Option<PathBuf> {
    let from = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    from("STIFFMAP_CACHE")
        .or_else(|| from("XDG_CACHE_HOME").map(|p| p.join("stiffmap")))
        .or_else(|| from("LOCALAPPDATA").map(|p| p.join("stiffmap")))
        .or_else(|| from("HOME").map(|p| p.join(".cache").join("stiffmap")))
}
