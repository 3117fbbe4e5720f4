//! What a simulation writes and prints.

use super::progress::Progress;
use super::record;
use super::run::relative;
use super::simulate::Arguments;
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};
use stiffmap::export::history::{Contacts, write_csv, write_mat};
use stiffmap::export::manifest::Manifest;
use stiffmap::export::response::{Response, safe};
use stiffmap::export::{atomic, mat, surface};
use stiffmap::figures::{HeightScale, draw_history, draw_spectrum, draw_surfaces};
use stiffmap::frf::ComplianceMap;
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::Machine;
use stiffmap::pipeline::PipelineError;
use stiffmap::response::contact::{ContactHistory, EventKind};
use stiffmap::response::moving::Travel;
use stiffmap::response::spectrum::smoothed;
use stiffmap::response::{Forces, History};

/// What was simulated.
pub enum Found {
    /// Linear, at fixed positions; with spectra where the forces are one pulse.
    Fixed { positions: Vec<f64>, histories: Vec<History>, map: Option<ComplianceMap> },
    /// With friction and backlash, at fixed positions; the joints' names.
    Contact { positions: Vec<f64>, runs: Vec<(ContactHistory, Vec<String>)> },
    /// Along a path.
    Along(Box<Travel>),
}

/// A simulation's result and where it goes.
pub struct Outcome<'a> {
    pub machine: &'a Machine,
    pub outputs: Vec<String>,
    pub forces: &'a Forces,
    pub result: Found,
    pub out: PathBuf,
}

/// Samples averaged in pictures of spectra, as in the paper.
const AVERAGE: usize = 5;

/// Writes every file but the manifest, which lists them.
pub fn write(
    outcome: &Outcome<'_>,
    arguments: &Arguments,
    progress: &mut Progress,
    manifest: &mut Manifest,
    interrupt: &Interrupt,
) -> Result<()> {
    let go_on = || if interrupt.requested() { Err(PipelineError::Interrupted) } else { Ok(()) };
    let (out, forces, outputs) = (&outcome.out, outcome.forces, &outcome.outputs);
    let mut files = progress.stage("write files", 0, |_| -> Result<Vec<PathBuf>> {
        go_on()?;
        let (csv, whole) = (out.join("time_history.csv"), out.join("time_history.mat"));
        let mut files = vec![csv.clone(), whole.clone()];
        match &outcome.result {
            Found::Fixed { positions, histories, map } => {
                write_csv(&csv, &histories[0], forces, outputs, None, None)?;
                go_on()?;
                write_mat(&whole, positions, histories, forces, outputs, None, &[])?;
                go_on()?;
                if let Some(map) = map {
                    files.push(out.join("spectra.mat"));
                    mat::write_compliance(&out.join("spectra.mat"), map)?;
                    for (output, name) in map.outputs.iter().enumerate() {
                        go_on()?;
                        let label = safe(name);
                        let file = out.join(format!("spectrum_{label}.csv"));
                        surface::write_surface(&file, map, &Response { output, input: 0, label })?;
                        files.push(file);
                    }
                }
            }
            Found::Contact { positions, runs } => {
                let contacts: Vec<Contacts<'_>> = runs.iter().map(contacts).collect();
                write_csv(&csv, &runs[0].0.history, forces, outputs, None, contacts.first())?;
                let histories: Vec<History> = runs.iter().map(|(run, _)| run.history.clone()).collect();
                write_mat(&whole, positions, &histories, forces, outputs, None, &contacts)?;
                files.push(out.join("joint_events.csv"));
                write_events(&out.join("joint_events.csv"), positions, runs)?;
            }
            Found::Along(travel) => {
                write_csv(&csv, &travel.history, forces, outputs, Some(&travel.positions), None)?;
                go_on()?;
                let history = std::slice::from_ref(&travel.history);
                write_mat(&whole, &travel.positions, history, forces, outputs, Some(&travel.energy), &[])?;
            }
        }
        Ok(files)
    })?;
    if !arguments.no_figures {
        files.extend(progress.stage("draw pictures", 0, |_| {
            go_on()?;
            draw(outcome)
        })?);
    }
    go_on()?;
    files.push(out.join("manifest.json"));
    manifest.files = files.iter().map(|p| relative(p, out)).collect();
    record::seconds(manifest, progress);
    Ok(())
}

fn draw(outcome: &Outcome<'_>) -> Result<Vec<PathBuf>> {
    let folder = outcome.out.join("figures");
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let (machine, axis) = (&outcome.machine.name, &outcome.machine.axis.name);
    let (history, place) = match &outcome.result {
        Found::Fixed { positions, histories, .. } => (&histories[0], at(axis, positions[0])),
        Found::Contact { positions, runs } => (&runs[0].0.history, at(axis, positions[0])),
        Found::Along(travel) => {
            let ends = [travel.positions[0], travel.positions[travel.positions.len() - 1]];
            (&travel.history, format!("{axis} from {} to {:.0} mm", 1e3 * ends[0], 1e3 * ends[1]))
        }
    };
    let heading = format!("{machine}: response at {place}");
    let mut files = draw_history(&folder.join("time_history.png"), &heading, history, &outcome.outputs)?.to_vec();
    if let Found::Fixed { map: Some(map), .. } = &outcome.result {
        let smooth = smoothed(map, AVERAGE);
        let heading = format!("{machine}: spectrum at {place}, forces in {}", map.inputs[0]);
        files.extend(draw_spectrum(&folder.join("spectrum.png"), &heading, &smooth, 0)?);
        if map.positions.len() > 1 {
            files.extend(draw_surfaces(machine, axis, &smooth, HeightScale::Linear, &folder)?);
        }
    }
    Ok(files)
}

fn at(axis: &str, position: f64) -> String {
    format!("{axis} = {} mm", (1e6 * position).round() / 1e3)
}

fn contacts((run, joints): &(ContactHistory, Vec<String>)) -> Contacts<'_> {
    Contacts { joints, slip: &run.relative, speed: &run.speed, force: &run.force }
}

fn write_events(path: &Path, positions: &[f64], runs: &[(ContactHistory, Vec<String>)]) -> Result<()> {
    let mut text = String::from("position_m,time_s,joint,event\n");
    for (position, (run, joints)) in positions.iter().zip(runs) {
        for event in &run.events {
            let kind = match event.kind {
                EventKind::Stops => "stops",
                EventKind::Slides => "slides",
                EventKind::Touches => "touches",
                EventKind::Leaves => "leaves",
            };
            text += &format!("{position},{},{},{kind}\n", event.time, joints[event.element]);
        }
    }
    Ok(atomic::write_bytes(path, text.as_bytes())?)
}

/// Prints the end of a simulation.
pub fn print(outcome: &Outcome<'_>, manifest: &Manifest, progress: &Progress) {
    let mut text = format!("\n{}: ", outcome.machine.name);
    let peaks = |text: &mut String, history: &History| {
        for (i, name) in outcome.outputs.iter().enumerate() {
            let peak = history.output(i).iter().fold(0.0f64, |m, v| m.max(v.abs()));
            *text += &format!("  {name:<8} largest displacement {:.4} um\n", 1e6 * peak);
        }
    };
    let samples = outcome.forces.samples();
    match &outcome.result {
        Found::Fixed { positions, histories, map } => {
            text += &format!("{samples} samples at {} positions; at {} m:\n", positions.len(), positions[0]);
            peaks(&mut text, &histories[0]);
            if let Some(map) = map {
                text += &format!(
                    "spectra: {} lines to {} Hz\n",
                    map.frequencies.len(),
                    map.frequencies[map.frequencies.len() - 1]
                );
            }
        }
        Found::Contact { positions, runs } => {
            let events: usize = runs.iter().map(|(run, _)| run.events.len()).sum();
            text += &format!(
                "{samples} samples at {} positions, {events} joint events; at {} m:\n",
                positions.len(),
                positions[0]
            );
            peaks(&mut text, &runs[0].0.history);
        }
        Found::Along(travel) => {
            text +=
                &format!("{samples} samples from {} to {:.4} m:\n", travel.positions[0], travel.positions[samples - 1]);
            peaks(&mut text, &travel.history);
            let last = |list: &[f64]| list.last().copied().unwrap_or(0.0);
            let e = &travel.energy;
            text += &format!(
                "energy: stored {:.4e} J, force {:.4e} J, dissipated {:.4e} J, through the change of stiffness {:.4e} J\n",
                last(&e.kinetic) + last(&e.potential),
                last(&e.force),
                last(&e.dissipated),
                last(&e.travel)
            );
        }
    }
    for check in &manifest.checks {
        let word = if check.passed { "passed" } else { "FAILED" };
        text += &format!("{word}: {}, {:.1e} (bound {:.0e})\n", check.name, check.figure, check.bound);
    }
    for warning in &manifest.warnings {
        text += &format!("warning: {warning}\n");
    }
    let total: f64 = progress.seconds().iter().map(|(_, s)| s).sum();
    text += &format!("{total:.2} s in all; files in {}", outcome.out.display());
    progress.say(&text);
}
