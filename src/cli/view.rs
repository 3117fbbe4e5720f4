//! `stiffmap view`: the report page in the browser, from its file; `serve.rs` serves it.

use super::serve::serve;
use super::{UsageError, streams};
use anyhow::{Context, Result};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use stiffmap::figures::report::PAGE_FILE;
use stiffmap::interrupt::Interrupt;

#[derive(Args, Debug)]
pub struct Arguments {
    /// Result folder of a run, or its report.html
    result: PathBuf,
    /// Serve the folder on 127.0.0.1 until Ctrl-C, and print the address
    #[arg(long)]
    serve: bool,
    /// Port for --serve; a free one without it
    #[arg(long, default_value_t = 0, value_name = "PORT", requires = "serve")]
    port: u16,
}

/// Opens the page, or serves it.
pub fn view(arguments: &Arguments, interrupt: &Interrupt) -> Result<()> {
    let given = &arguments.result;
    let page = if given.is_dir() { given.join(PAGE_FILE) } else { given.clone() };
    if given.is_dir() && page.is_file() {
        stiffmap::files::ResultFolder::check_finished(
            given,
            "run again, or name its report.html to see what is there",
        )?;
    }
    if !page.is_file() {
        let text =
            format!("{}: there is no {PAGE_FILE}; `stiffmap run` and `stiffmap figures` write it", given.display());
        return Err(UsageError(text).into());
    }
    let page = page.canonicalize().with_context(|| page.display().to_string())?;
    if arguments.serve {
        return serve(&page, arguments.port, interrupt);
    }
    streams::say(&page.display().to_string());
    open(&page).with_context(|| format!("no browser was started; open {} in one", page.display()))
}

/// Hands a file to the desktop's opener.
fn open(page: &Path) -> Result<()> {
    let (program, arguments): (&str, &[&str]) = if cfg!(target_os = "windows") {
        ("cmd", &["/C", "start", ""])
    } else if cfg!(target_os = "macos") {
        ("open", &[])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(arguments).arg(page).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let status = command.status().with_context(|| format!("cannot run {program}"))?;
    anyhow::ensure!(status.success(), "{program} ended with {status}");
    Ok(())
}
