//! The command line: one file a subcommand.

mod bench;
mod check;
mod devices;
mod init;
mod overrides;
mod progress;
mod record;
mod run;
mod simulate;
mod simulate_files;
mod states;
mod summary;

use anyhow::Result;
use clap::{Parser, Subcommand};
use std::path::{Path, PathBuf};
use stiffmap::export::ExportError;
use stiffmap::frf::FrfError;
use stiffmap::gpu::GpuError;
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::{MachineError, bundled_vertical_mill};
use stiffmap::mesh::MeshError;
use stiffmap::pipeline::PipelineError;
use stiffmap::response::ResponseError;

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
    /// Print what is understood of a machine, without solving
    Check(check::Arguments),
    /// Write the bundled vertical mill into a folder, as a start for a machine of your own
    Init(init::Arguments),
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
        Command::Check(arguments) => check::check(&arguments),
        Command::Init(arguments) => init::init(&arguments),
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
        || error.is::<MeshError>()
        || error.downcast_ref::<PipelineError>().is_some_and(PipelineError::is_input)
        || error.downcast_ref::<ResponseError>().is_some_and(ResponseError::is_input)
        || error
            .downcast_ref::<FrfError>()
            .is_some_and(|e| !matches!(e, FrfError::Sink { .. } | FrfError::Truncation { .. }))
        || matches!(error.downcast_ref::<GpuError>(), Some(GpuError::Request(_)));
    if input && !error.is::<ExportError>() { Exit::BadInput } else { Exit::Failed }
}

/// An error with its causes, each said once.
pub fn describe(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |said, cause| {
        if said.is_empty() {
            cause
        } else if said.contains(&cause) {
            said
        } else {
            format!("{said}: {cause}")
        }
    })
}

/// The machine file that a command means: the one named, or the bundled mill in a folder of its own.
fn machine_path(named: Option<&Path>) -> Result<(PathBuf, Option<tempfile::TempDir>)> {
    if let Some(path) = named {
        return Ok((path.to_path_buf(), None));
    }
    let folder = tempfile::Builder::new().prefix("stiffmap").tempdir()?;
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
