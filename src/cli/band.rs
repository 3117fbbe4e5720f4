//! `stiffmap band`: the frequencies with distributing and with rigid interfaces.

use super::{at_least_one, cache_folder, machine_path, position, streams};
use anyhow::Result;
use clap::Args;
use serde_json::json;
use std::fmt::Write as _;
use std::path::PathBuf;
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::read_machine;
use stiffmap::pipeline::interface_band;
use stiffmap::reduction::Cache;

#[derive(Args, Debug)]
pub struct Arguments {
    /// Machine file, or the folder that holds machine.toml; the bundled vertical mill without it
    machine: Option<PathBuf>,
    /// Position in m; the first of the travel without it
    #[arg(long, allow_hyphen_values = true, value_name = "Z")]
    position: Option<f64>,
    /// Elastic modes
    #[arg(long, default_value_t = 20, value_name = "N")]
    modes: usize,
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
}

/// Prints both frequencies of every mode; a rigid interface bounds from above, a distributing one from below.
pub fn band(arguments: &Arguments, interrupt: &Interrupt) -> Result<()> {
    let (path, _bundled) = machine_path(arguments.machine.as_deref())?;
    let machine = read_machine(&path)?;
    let position = position(&machine, arguments.position)?;
    let modes = at_least_one(arguments.modes)?;
    let cache = cache_folder().map(Cache::in_folder);
    let [distributing, rigid] = interface_band(&machine, position, modes, cache.as_ref(), interrupt)?;
    let count = modes
        .min(distributing.modes.eigenvalues.len() - distributing.modes.free)
        .min(rigid.modes.eigenvalues.len() - rigid.modes.free);
    let rows: Vec<[f64; 2]> = (0..count)
        .map(|r| {
            [distributing.modes.frequency(distributing.modes.free + r), rigid.modes.frequency(rigid.modes.free + r)]
        })
        .collect();
    if arguments.json {
        let rows: Vec<_> = rows
            .iter()
            .enumerate()
            .map(|(r, [low, high])| json!({ "rank": r + 1, "distributing_hz": low, "rigid_hz": high }))
            .collect();
        streams::print_json(&json!({ "position_m": position, "elastic_modes": rows }))?;
        return Ok(());
    }
    let mut text = String::new();
    writeln!(text, "{} at {} = {position} m: elastic frequencies by rank, Hz", machine.name, machine.axis.name)?;
    writeln!(text, "rank  distributing       rigid   rigid above by %")?;
    for (r, [low, high]) in rows.iter().enumerate() {
        writeln!(text, "{:4}  {low:12.4} {high:11.4}   {:8.3}", r + 1, 100.0 * (high / low - 1.0))?;
    }
    writeln!(
        text,
        "Distributing interfaces bound the frequencies from below, rigid ones from above; a real contact lies between."
    )?;
    Ok(streams::print(&text)?)
}
