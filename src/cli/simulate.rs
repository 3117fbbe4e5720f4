//! `stiffmap simulate`: time histories.

use super::overrides::Overrides;
use super::progress::Progress;
use super::run::{figure, mesh_warnings, slug};
use super::simulate_files::{self, Found, Outcome};
use super::simulate_forces::sample;
use super::{UsageError, begin, cache_folder, finish, machine_path, open_folder, record, streams};
use anyhow::Result;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use stiffmap::coupling::CoupledModel;
use stiffmap::export::manifest::Manifest;
use stiffmap::files::Inputs;
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::{Machine, read_machine};
use stiffmap::modal::{Modes, modes_at};
use stiffmap::pipeline::{self, Simplified};
use stiffmap::reduction::Cache;
use stiffmap::response::contact::{elements, simulate_contact};
use stiffmap::response::moving::{PathModel, PathOptions, TravelOptions, travel};
use stiffmap::response::spectrum::{difference_less_folding, difference_to_modes, spectra};
use stiffmap::response::{
    Forces, Path, Plant, Recording, ResponseError, acceleration_share_above, read_path_file, simulate_all,
};
use stiffmap::state_space::{StateSpaceOptions, state_space};

#[derive(Args, Debug)]
pub struct Arguments {
    /// Machine file, or the folder that holds machine.toml; the bundled vertical mill without it
    machine: Option<PathBuf>,
    /// The paper's study: one pulse at all inputs at once, at every position, with spectra and
    /// surfaces; keys of the force `impulse` may follow, such as --impulse=shape=triangle
    #[arg(long, value_name = "KEYS", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    pub(super) impulse: Option<String>,
    /// A force, INPUT:KIND,key=value,..: impulse, step, sine, chirp or random at an input (or `all`), in
    /// N, s, Hz; may be repeated
    #[arg(long = "force", value_name = "INPUT:KIND,..")]
    pub(super) forces: Vec<String>,
    /// Forces from a CSV file with the headings time_s and names of inputs, in N
    #[arg(long, value_name = "CSV")]
    pub(super) force_file: Option<PathBuf>,
    /// A milling cut: teeth=4,speed=3000,feed=0.1,depth=2,kt=2000,kr=0.3,exit=60 (1/min, mm a tooth, mm, N/mm^2,
    /// degrees); port=, along= and across= where the spindle's bearings do not say the directions
    #[arg(long, value_name = "KEYS")]
    pub(super) milling: Option<String>,
    /// Travel from one position to another, m, at --feed-rate
    #[arg(long, value_name = "FROM:TO", allow_hyphen_values = true, conflicts_with = "path_file")]
    path: Option<String>,
    /// Speed along --path, m/min
    #[arg(long, value_name = "M/MIN", requires = "path", allow_hyphen_values = true)]
    feed_rate: Option<f64>,
    /// Travel after a CSV file with the headings time_s,position_m
    #[arg(long, value_name = "CSV")]
    path_file: Option<PathBuf>,
    /// Length of the history, s; without it that of the path, or 1 s and at least that of the force file
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    pub(super) duration: Option<f64>,
    /// Samples a second
    #[arg(long, value_name = "HZ", default_value_t = 20_000.0, allow_hyphen_values = true)]
    pub(super) rate: f64,
    /// Record the outputs' velocities
    #[arg(long)]
    velocity: bool,
    /// Record the outputs' accelerations
    #[arg(long)]
    acceleration: bool,
    #[command(flatten)]
    overrides: Overrides,
    /// With --modes: leave the constant residual out
    #[arg(long)]
    no_residual: bool,
    /// Leave the friction and backlash of the machine file out
    #[arg(long)]
    pub(super) linear: bool,
    /// Output folder; results/<machine>_simulation without it
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Draw no pictures
    #[arg(long)]
    pub(super) no_figures: bool,
    /// Neither read nor write the cache of superelements
    #[arg(long)]
    no_cache: bool,
    /// Print the manifest to stdout and nothing else
    #[arg(long)]
    json: bool,
}

/// The fixed basis is made for this many times the highest frequency: a history holds all of them, and on
/// the bundled mill the basis then differs from the superelements side by side by 1e-7 of the peak.
const BASIS: f64 = 1.5;

/// Positions between the tabulated ones of a path at which its machine is compared with the modes there.
const PROBES: usize = 8;
/// Share of an acceleration from modes that the basis is not made for, above which it is told.
const ACCELERATION: f64 = 0.05;
/// Spectra by way of time may differ by this share of each output's peak from the modes.
const SPECTRA: f64 = 1e-3;
/// From this frequency up, Hz.
const LOWEST: f64 = 5.0;

/// Runs a simulation.
pub fn simulate(arguments: &Arguments, interrupt: &Interrupt) -> Result<()> {
    let mut progress = Progress::new(arguments.json);
    let (file, _bundled) = machine_path(arguments.machine.as_deref())?;
    let mut machine = read_machine(&file)?;
    let mut positions = arguments.overrides.apply(&mut machine)?;
    let mut of_path = Inputs::default();
    let path = arguments.path(&machine, &mut of_path)?;
    if arguments.impulse.is_none() && !arguments.overrides.gives_positions() {
        positions.truncate(1);
    }
    arguments.check(&machine, path.as_ref())?;
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| std::path::Path::new("results").join(format!("{}_simulation", slug(&machine.name))));
    let sampled = sample(arguments, &machine, path.as_ref(), positions.len(), &out)?;
    let forces = sampled.forces;
    let mut folder = open_folder(&out, "simulate")?;

    let (name, command) = (machine.name.clone(), "simulate".into());
    let mut manifest = Manifest { name, command, machine_file: arguments.named(), ..Manifest::default() };
    progress.warn(&sampled.warnings);
    let (model, inputs) = arguments.model(&machine, &mut manifest, &mut progress, interrupt)?;
    manifest.warnings.extend(sampled.warnings);
    let result = match &path {
        Some(path) => arguments.along(&machine, &model, path, &forces, &mut manifest, &mut progress, interrupt)?,
        None => arguments.fixed(&machine, &model, &positions, &forces, &mut manifest, &mut progress, interrupt)?,
    };
    record::input(&mut manifest, &machine, &inputs);
    record::named_input(&mut manifest, "--path-file", &of_path);
    record::named_input(&mut manifest, "--force-file", &sampled.inputs);
    let settings = &mut manifest.settings;
    settings.push("samples_a_second", json!(arguments.rate));
    settings.push("samples", json!(forces.samples()));
    settings.push("forces", json!(sampled.described));
    settings.push("damping_ratios", json!(machine.analysis.damping.ratios));
    // A loss factor of a history is a viscous ratio of half its size; contacts are stepped mode by mode.
    let mut told = machine.clone();
    let contacts = !arguments.linear && machine.joints.iter().any(|j| j.contact.is_some());
    told.analysis.damping.projected |= contacts;
    let highest = arguments.highest(&machine);
    let where_to = path.as_ref().map_or_else(|| positions.clone(), |p| p.range().to_vec());
    let simplified = if told.analysis.damping.projected { Simplified::Projected } else { Simplified::Viscous };
    let projection = pipeline::projection_error(&machine, &model, &where_to, highest, simplified)?;
    let projected = projection.as_ref().and_then(|p| p.warning("histories take"));
    progress.warn(projected.as_slice());
    manifest.warnings.extend(projected);
    record::damping(&mut manifest, &told, projection.as_ref());
    let outcome = Outcome { machine: &machine, outputs: model.output_names(), forces: &forces, result, out };
    begin(&mut folder, &[], interrupt)?;
    simulate_files::write(&outcome, arguments, &mut progress, &mut manifest, interrupt)?;
    finish(folder, &manifest)?;
    if arguments.json {
        streams::print_json(&manifest)?;
    } else {
        simulate_files::print(&outcome, &manifest, &progress);
    }
    record::hold(&manifest)
}

impl Arguments {
    fn named(&self) -> String {
        self.machine.as_ref().map_or_else(|| "bundled vertical mill".into(), |p| p.display().to_string())
    }

    pub(super) fn recording(&self) -> Recording {
        Recording { velocity: self.velocity, acceleration: self.acceleration }
    }

    fn path(&self, machine: &Machine, inputs: &mut Inputs) -> Result<Option<Path>> {
        let path = match (&self.path, &self.path_file) {
            (Some(text), _) => {
                let ends: Option<Vec<f64>> = text.split(':').map(|t| t.trim().parse().ok()).collect();
                let Some([from, to]) = ends.as_deref() else {
                    return Err(UsageError(format!("--path: {text:?} is not FROM:TO, two positions in m")).into());
                };
                let speed = self.feed_rate.ok_or_else(|| UsageError("--path needs --feed-rate, in m/min".into()))?;
                Path::constant_speed(*from, *to, speed / 60.0)?
            }
            (None, Some(file)) => read_path_file(file, inputs)?,
            (None, None) => return Ok(None),
        };
        let [low, high] = path.range();
        let [from, to] = machine.axis.travel;
        if low < from.min(to) - 1e-9 || high > from.max(to) + 1e-9 {
            let axis = &machine.axis.name;
            return Err(UsageError(format!(
                "the path runs from {low} to {high} m, outside the travel of axis \"{axis}\", {from} to {to} m"
            ))
            .into());
        }
        Ok(Some(path))
    }

    /// Refuses what does not go together.
    fn check(&self, machine: &Machine, path: Option<&Path>) -> Result<(), UsageError> {
        let nonlinear = machine.joints.iter().any(|j| j.contact.is_some()) && !self.linear;
        let refused = if path.is_some() && self.overrides.gives_positions() {
            "--positions and a path exclude each other: a history is at fixed positions or along a path"
        } else if path.is_some() && self.overrides.modes.is_some() {
            "--modes is for fixed positions; along a path the basis spans the modes up to twice the highest frequency"
        } else if self.no_residual && self.overrides.modes.is_none() {
            "--no-residual needs --modes N: without it all modes of the basis are there and nothing is left out"
        } else if nonlinear && path.is_some() {
            "the machine file has friction or backlash, which act at fixed positions only; --linear leaves them out"
        } else if nonlinear && self.overrides.modes.is_some() {
            "the machine file has friction or backlash, which need all modes; leave --modes out or say --linear"
        } else if nonlinear && self.impulse.is_some() {
            "the machine file has friction or backlash, for which a spectrum has no meaning; say --linear with --impulse"
        } else {
            return Ok(());
        };
        Err(UsageError(refused.into()))
    }

    fn model(
        &self,
        machine: &Machine,
        manifest: &mut Manifest,
        progress: &mut Progress,
        interrupt: &Interrupt,
    ) -> Result<(CoupledModel, Inputs)> {
        let meshes = progress.stage("read meshes", 0, |_| pipeline::read_meshes(machine))?;
        let inputs = pipeline::inputs(machine, &meshes)?;
        manifest.warnings = pipeline::plausibility(machine, &meshes);
        progress.warn(&manifest.warnings);
        manifest.warnings.extend(mesh_warnings(machine, &meshes));
        let cache = if self.no_cache { None } else { cache_folder().map(Cache::in_folder) };
        let cached = progress.stage("reduce parts", machine.parts.len(), |step| {
            pipeline::reduce_parts(machine, &meshes, cache.as_ref(), interrupt, step)
        })?;
        manifest.warnings.extend(pipeline::cache_warnings(&cached));
        let parts: Vec<_> = cached.into_iter().map(|c| c.superelement).collect();
        let basis = BASIS * self.highest(machine);
        let model = progress
            .stage("couple", 0, |_| pipeline::build_model(machine, &parts, machine.analysis.modes, basis))?
            .model;
        manifest.warnings.extend(model.side_by_side.overhangs());
        manifest.counts.push("fixed_basis_coordinates", model.n() as u64);
        manifest.settings.push("fixed_basis_for_hz", json!(model.frequency));
        Ok((model, inputs))
    }

    /// The highest frequency of interest, Hz.
    pub(super) fn highest(&self, machine: &Machine) -> f64 {
        machine.analysis.frequencies.iter().copied().fold(0.0, f64::max)
    }

    #[expect(clippy::too_many_arguments, reason = "one stage of simulate, with its locals")]
    fn along(
        &self,
        machine: &Machine,
        model: &CoupledModel,
        path: &Path,
        forces: &Forces,
        manifest: &mut Manifest,
        progress: &mut Progress,
        interrupt: &Interrupt,
    ) -> Result<Found> {
        let options = PathOptions::default();
        let damping = &machine.analysis.damping;
        let along = progress.stage("stations of the path", PathModel::reported_steps(path, options), |step| {
            PathModel::new(model, damping, path, options, interrupt, step)
        })?;
        let between = along.difference(model, damping, self.highest(machine), PROBES)?;
        let stepping =
            TravelOptions { recording: self.recording(), highest: self.highest(machine), ..TravelOptions::default() };
        let holds = forces.samples().div_ceil(stepping.hold);
        let result = progress.stage("travel", holds, |step| travel(&along, path, forces, stepping, interrupt, step))?;
        manifest.counts.push("path_coordinates", along.n() as u64);
        manifest.counts.push("path_stations", along.stations() as u64);
        let name = "energy balance along the path, share of the largest energy";
        manifest.checks.push(figure(name, result.energy.closure(), 1e-6));
        let name = "machine of the path against modes at its own positions, share of an eigenvalue";
        manifest.checks.push(figure(name, between, 1e-4));
        let name = "frequencies along the path, share by which the step shifts them";
        manifest.checks.push(figure(name, result.frequency_error, 1e-4));
        Ok(Found::Along(Box::new(result)))
    }

    #[expect(clippy::too_many_arguments, reason = "one stage of simulate, with its locals")]
    fn fixed(
        &self,
        machine: &Machine,
        model: &CoupledModel,
        positions: &[f64],
        forces: &Forces,
        manifest: &mut Manifest,
        progress: &mut Progress,
        interrupt: &Interrupt,
    ) -> Result<Found> {
        let damping = &machine.analysis.damping;
        let modes: Vec<Modes> = progress.stage("modes", positions.len(), |step| {
            use rayon::prelude::*;
            let one = |p: &f64| {
                if interrupt.requested() {
                    return Err(ResponseError::Interrupted);
                }
                let modes = modes_at(model, damping, *p)?;
                step();
                Ok(modes)
            };
            positions.par_iter().map(one).collect::<Result<Vec<_>, ResponseError>>()
        })?;
        let there = modes.iter().map(|m| m.eigenvalues.len() - m.free).min().unwrap_or(0);
        if let Some(asked) = self.overrides.modes.filter(|n| *n > there) {
            let problem = format!("--modes: {asked} is not allowed; the machine's basis has {there} elastic modes");
            return Err(UsageError(problem).into());
        }
        let plant = |m: &Modes| match self.overrides.modes {
            None => Plant::whole(m),
            Some(n) => {
                let residual = !self.no_residual;
                let options = StateSpaceOptions { modes: n, velocity: false, acceleration: false, residual };
                Plant::of_state_space(&state_space(m, options))
            }
        };
        let plants: Vec<Plant> = modes.iter().map(plant).collect();
        manifest.counts.push("positions", plants.len() as u64);
        manifest.counts.push("modes_most", plants.iter().map(|p| p.omega.len()).max().unwrap_or(0) as u64);
        let faster = |p: &Plant| p.omega.iter().filter(|w| **w > std::f64::consts::PI * self.rate).count() as u64;
        manifest.counts.push("modes_above_half_the_rate", plants.iter().map(faster).max().unwrap_or(0));
        if !self.linear && machine.joints.iter().any(|j| j.contact.is_some()) {
            return self.with_contacts(model, &modes, &plants, forces, progress, interrupt);
        }
        let histories = progress.stage("time histories", plants.len(), |step| {
            simulate_all(&plants, forces, self.recording(), interrupt, step)
        })?;
        let top = self.highest(machine);
        if let Some(share) = acceleration_share_above(top, &plants[0], &histories[0], forces) {
            manifest.settings.push("acceleration_share_above_highest_frequency", json!(share));
            if share > ACCELERATION {
                let warning = format!(
                    "accelerations: modes above {top} Hz, the highest frequency that the basis is made for, give up to \
                     {:.0} % of the largest; another mesh or reduction would give another share",
                    100.0 * share
                );
                progress.warn(std::slice::from_ref(&warning));
                manifest.warnings.push(warning);
            }
        }
        let mut map = None;
        let only_pulses = self.forces.iter().all(|f| f.split(':').nth(1).is_some_and(|k| k.starts_with("impulse")));
        if self.impulse.is_some() || only_pulses && self.force_file.is_none() && self.milling.is_none() {
            let highest = self.highest(machine).min(0.45 * self.rate);
            let outputs = model.output_names();
            let found = progress.stage("spectra", 0, |_| spectra(&plants, &histories, forces, &outputs, highest))?;
            let name = "spectra of the time histories against the modes from 5 Hz up, share of each peak";
            let off = difference_to_modes(&found, &plants, forces, LOWEST)?;
            if off <= SPECTRA {
                manifest.checks.push(figure(name, off, SPECTRA));
            } else {
                let [off, folded] = difference_less_folding(&found, &plants, forces, LOWEST)?;
                let name = format!("{name}, less what the sampling folds down");
                manifest.checks.push(figure(&name, off, SPECTRA));
                let warning = format!(
                    "spectra: the force is so short that it moves modes above half the sampling rate, whose motion shows \
                     in the spectra as up to {:.2} % of a peak; raise --rate",
                    100.0 * folded
                );
                progress.warn(std::slice::from_ref(&warning));
                manifest.warnings.push(warning);
            }
            map = Some(found);
        }
        Ok(Found::Fixed { positions: positions.to_vec(), histories, map })
    }

    fn with_contacts(
        &self,
        model: &CoupledModel,
        modes: &[Modes],
        plants: &[Plant],
        forces: &Forces,
        progress: &mut Progress,
        interrupt: &Interrupt,
    ) -> Result<Found> {
        let runs = progress.stage("time histories", plants.len(), |step| {
            let one = |(modes, plant): (&Modes, &Plant)| {
                let stiffness = model.stiffness(plant.position)?;
                let joints = elements(model, &model.at(plant.position)?, &stiffness, modes)?;
                let run = simulate_contact(plant, &joints, forces, self.recording(), None, interrupt)?;
                step();
                Ok((run, joints.into_iter().map(|j| j.joint).collect()))
            };
            modes.iter().zip(plants).map(one).collect::<Result<Vec<_>, ResponseError>>()
        })?;
        Ok(Found::Contact { positions: plants.iter().map(|p| p.position).collect(), runs })
    }
}
