//! `stiffmap run`: the main job.

use super::map::{Axes, Map, compute_map};
use super::memory::{check_disk, map_limit, parse_size};
use super::overrides::Overrides;
use super::progress::Progress;
use super::report::{Look, write_report};
use super::states::StateArguments;
use super::{
    UsageError, begin, cache_folder, finish, frequencies, machine_path, open_folder, record, streams, summary,
};
use anyhow::Result;
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};
use stiffmap::export::manifest::{Check, Manifest};
use stiffmap::export::response::safe;
use stiffmap::export::{eigenfrequencies, mat5};
use stiffmap::figures::report::admit_page;
use stiffmap::frf::metrics::{PairMetrics, direct_pairs};
use stiffmap::frf::{FrfRequest, ModalSystem, Selection, Truncation, modal_systems};
use stiffmap::gpu::{Backend, BackendOptions, BackendReport, Precision};
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::{Machine, read_machine};
use stiffmap::modal::{ModalError, ModeTableRow, mode_table};
use stiffmap::pipeline::{self, PipelineError, ReductionErrors, Solved};
use stiffmap::reduction::Cache;
use stiffmap::state_space::StateSpaceOptions;

/// Shapes in the fixed basis up to this many bytes are kept for all positions, however small the map's memory.
const KEPT_SHAPES: u64 = 256 << 20;

/// Tolerance of the truncation, relative to the Frobenius norm of the receptance.
const TRUNCATION: f64 = 1e-4;

#[derive(Args, Debug)]
pub struct Arguments {
    /// Machine file, or the folder that holds machine.toml; the bundled vertical mill without it
    machine: Option<PathBuf>,
    #[command(flatten)]
    pub(super) overrides: Overrides,
    /// Leave the constant residual out; sums exactly the state space's modes
    #[arg(long)]
    pub(super) no_residual: bool,
    #[command(flatten)]
    states: StateArguments,
    /// What computes the map: auto, cpu or gpu
    #[arg(long, default_value = "auto", value_name = "auto|cpu|gpu", value_parser = parse_backend)]
    backend: Backend,
    /// Precision on a device: f32 or f64 (the processor always uses f64)
    #[arg(long, default_value = "f32", value_name = "f32|f64", value_parser = parse_precision)]
    precision: Precision,
    /// Largest map held in memory, such as 512MB or 2GiB; a larger one is streamed to compliance.npy (0: always).
    /// Without it a quarter of the available memory, at most 2 GiB
    #[arg(long, value_name = "SIZE", value_parser = parse_size)]
    map_memory: Option<u64>,
    /// Output folder; results/<machine> without it
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Draw no pictures and write no report page
    #[arg(long)]
    no_figures: bool,
    /// Neither read nor write the cache of superelements
    #[arg(long)]
    no_cache: bool,
    /// Print the manifest to stdout and nothing else
    #[arg(long)]
    json: bool,
}

pub(super) fn parse_backend(text: &str) -> Result<Backend, String> {
    text.parse()
}

fn parse_precision(text: &str) -> Result<Precision, String> {
    match text {
        "f32" => Ok(Precision::F32),
        "f64" => Ok(Precision::F64),
        _ => Err(format!("precision {text:?}: allowed are f32, f64")),
    }
}

/// What the run found, for files and summary.
pub struct Outcome {
    pub machine: Machine,
    pub solved: Solved,
    pub table: Vec<ModeTableRow>,
    pub errors: ReductionErrors,
    pub free_motions: Vec<String>,
    pub truncation: Truncation,
    pub axes: Axes,
    pub map: Map,
    pub backend: BackendReport,
    /// `[position][direct pair]`.
    pub metrics: Vec<Vec<PairMetrics>>,
    pub out: PathBuf,
}

/// Runs the main job.
pub fn run(arguments: &Arguments, interrupt: &Interrupt) -> Result<()> {
    arguments.states.check()?;
    let mut progress = Progress::new(arguments.json);
    let (path, _bundled) = machine_path(arguments.machine.as_deref())?;
    let mut machine = read_machine(&path)?;
    let positions = arguments.overrides.apply(&mut machine)?;
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("results").join(slug(&machine.name)));
    let mut folder = open_folder(&out, "run")?;

    let parts = machine.parts.len();
    let meshes = progress.stage("read meshes", 0, |_| pipeline::read_meshes(&machine))?;
    let read = pipeline::inputs(&machine, &meshes)?;
    let mut warnings = pipeline::plausibility(&machine, &meshes);
    progress.warn(&warnings);
    warnings.extend(mesh_warnings(&machine, &meshes));
    let cache = if arguments.no_cache { None } else { cache_folder().map(Cache::in_folder) };
    let cached = progress.stage("reduce parts", parts, |step| {
        pipeline::reduce_parts(&machine, &meshes, cache.as_ref(), interrupt, step)
    })?;
    warnings.extend(pipeline::cache_warnings(&cached));
    let hits = cached.iter().filter(|c| c.hit).count();
    let superelements: Vec<_> = cached.into_iter().map(|c| c.superelement).collect();

    let highest = machine.analysis.frequencies.iter().copied().fold(0.0, f64::max);
    let reported = machine.analysis.modes;
    let pipeline::Built { mut model, error } =
        progress.stage("couple", 0, |_| pipeline::build_model(&machine, &superelements, reported, highest))?;
    warnings.extend(model.side_by_side.overhangs());
    let mut checks = Vec::new();
    checks.push(figure(
        "fixed basis against the superelements side by side, largest relative frequency difference",
        error,
        pipeline::BASIS_BOUND,
    ));
    let (outputs, inputs) = (model.output_names(), model.input_names());
    let (given, quantity) = (machine.analysis.frequencies.clone(), machine.analysis.quantity);
    let mut axes = Axes { positions, frequencies: given, outputs, inputs, quantity };
    check_state_space(axes.positions.len(), reported)?;
    let limit = map_limit(arguments.map_memory);
    let shapes = (axes.positions.len() * model.n() * model.n() * size_of::<f64>()) as u64;
    let few = shapes <= limit.max(KEPT_SHAPES);
    if !arguments.no_figures {
        admit_page(&model, &superelements, axes.positions.len(), !few)?;
    }
    let solve = if few { pipeline::solve_positions } else { pipeline::solve_many_positions };
    let solved = loop {
        let solved = progress.stage("modes", axes.positions.len(), |step| {
            solve(&machine, &model, &axes.positions, reported, interrupt, step)
        });
        match solved {
            Err(PipelineError::Modal(error @ ModalError::Missed { .. })) => {
                // The basis, not the machine, is to blame as long as it can be made larger.
                model = pipeline::wider(&machine, &superelements, &model)?.ok_or(error)?;
            }
            solved => break solved?,
        }
    };
    let first = solved.families.modes.iter().take(1).flatten().map(|mode| (mode.frequency, mode.damping_ratio));
    let of_modes = pipeline::modal_plausibility(axes.positions[0], first);
    progress.warn(&of_modes);
    warnings.extend(of_modes);
    checks.push(figure(
        "modes found minus modes counted by inertia, largest over the positions",
        solved.counts.iter().map(|c| c.found.abs_diff(c.counted)).max().unwrap_or(0) as f64,
        0.0,
    ));

    let errors = progress.stage("reduction's error", 0, |_| {
        pipeline::reduction_errors(&machine, &superelements, &model, &solved.modes, reported, highest)
    })?;
    warnings.extend(pipeline::few_component_modes(&machine, &superelements, highest));

    let exactly = arguments.overrides.modes.is_some() || arguments.no_residual;
    let selection = if exactly {
        Selection::Exactly { modes: reported, residual: !arguments.no_residual }
    } else {
        Selection::Controlled { tolerance: TRUNCATION }
    };
    let (systems, truncation) = modal_systems(&solved.modes, highest, selection)?;
    if !exactly {
        checks.push(figure(
            "truncation of the map against all modes of the basis, relative Frobenius norm",
            truncation.error,
            TRUNCATION,
        ));
    }
    let states = arguments.states.options(reported, !arguments.no_residual);
    let (simplified, what) = if machine.analysis.damping.projected {
        (pipeline::Simplified::Projected, "all results take")
    } else {
        (pipeline::Simplified::StateSpace(states), "state_space.mat takes")
    };
    let projection = progress.stage("state space's accuracy", 0, |_| {
        pipeline::projection_error(&machine, &model, &axes.positions, highest, simplified)
    })?;
    let projected = projection.as_ref().and_then(|p| p.warning(what));
    progress.warn(projected.as_slice());
    warnings.extend(projected);
    let map_error = errors.map(&axes.positions, &systems, highest)?;
    record::reduction(&mut checks, &mut warnings, &errors, &solved.modes, map_error);
    axes.frequencies = frequencies::around_modes(&machine.analysis, &systems)?;
    let request = axes.request(&systems);
    request.check_at_rest(&summary::felt_free_motions(&solved, &model))?;
    let options = BackendOptions {
        backend: arguments.backend,
        precision: arguments.precision,
        cache_dir: if arguments.no_cache { None } else { cache_folder() },
    };
    let streams = axes.bytes() > limit;
    let pairs = (axes.positions.len() * axes.frequencies.len()) as u64;
    check_disk(axes.bytes(), pairs, direct_pairs(&request).len() as u64, &out)?;
    let (map, backend) = progress.stage("compliance map", axes.positions.len(), |step| {
        compute_map(&request, &options, streams, &mut folder, interrupt, step)
    })?;
    let undamped = undamped_in_band(&request);
    let metrics = if undamped.is_none() { map.metrics(&request)? } else { Vec::new() };
    if let Some(frequency) = undamped {
        warnings
            .push(format!("the mode at {frequency:.3} Hz has no damping, so no smallest dynamic stiffness is given"));
    }

    let mut manifest = Manifest {
        name: machine.name.clone(),
        command: "run".into(),
        machine_file: arguments
            .machine
            .as_ref()
            .map_or_else(|| "bundled vertical mill".into(), |p| p.display().to_string()),
        backend: without_nulls(serde_json::to_value(&backend)?),
        checks,
        warnings,
        ..Manifest::default()
    };
    record::input(&mut manifest, &machine, &read);
    record::size(&mut manifest, &superelements, model.n(), &solved, &machine, &truncation);
    manifest.counts.push("frequencies", axes.frequencies.len() as u64);
    record::settings(&mut manifest, &machine, arguments, &truncation, model.frequency);
    record::damping(&mut manifest, &machine, projection.as_ref());
    record::map(&mut manifest, &axes, &map, limit);
    record::memory(&mut manifest);
    manifest.counts.push("parts_from_cache", hits as u64);
    let free_motions = summary::free_motions(&solved, &model);
    manifest.settings.push("free_motions", json!(free_motions));
    manifest.settings.push("veerings", json!(summary::veerings(&solved.families)));

    let mut table = mode_table(&solved.families);
    errors.fill(&mut table, &solved.families, &solved.modes);
    record::errors(&mut manifest, &errors, &solved.modes, map_error);
    let outcome =
        Outcome { table, errors, free_motions, machine, solved, truncation, axes, map, backend, metrics, out };
    record::extrema(&mut manifest, &outcome);
    let look = Look { systems: &systems, model: &model, superelements: &superelements };
    begin(&mut folder, &[], interrupt)?;
    write(&outcome, &look, states, arguments, &mut progress, &mut manifest, interrupt)?;
    finish(folder, &manifest)?;
    if arguments.json {
        streams::print_json(&manifest)?;
    } else {
        summary::print(&outcome, &manifest, &progress);
    }
    record::hold(&manifest)
}

/// Refuses before the long computation what `state_space.mat` could not hold after it.
fn check_state_space(positions: usize, modes: usize) -> Result<(), UsageError> {
    let bytes = positions as u64 * (2 * modes as u64).pow(2) * size_of::<f64>() as u64;
    if bytes <= mat5::LIMIT {
        return Ok(());
    }
    Err(UsageError(format!(
        "{positions} positions of {modes} modes make a state_space.mat of {:.1} GB, whose format holds 2.1 GB; \
         ask for fewer positions (--positions) or modes ([analysis] modes)",
        bytes as f64 * 1e-9
    )))
}

/// Frequency (Hz) of a mode inside the grid's range that nothing damps: its peak is unbounded.
fn undamped_in_band(request: &FrfRequest<'_>) -> Option<f64> {
    let (from, to) = (*request.frequencies.first()?, *request.frequencies.last()?);
    // A free motion adds a constant to an accelerance and peaks nowhere.
    let constant = |f: f64| f == 0.0 && request.quantity == stiffmap::frf::Quantity::Accelerance;
    let of_system = |s: &ModalSystem| {
        let damping = s.damping_ratios.iter().zip(&s.loss_factors).map(|(zeta, eta)| 2.0 * zeta + eta);
        s.frequencies.iter().copied().zip(damping).find(|(f, d)| (from..=to).contains(f) && *d <= 0.0 && !constant(*f))
    };
    request.systems.iter().find_map(of_system).map(|(f, _)| f)
}

/// Writes every file but the manifest, which lists them.
fn write(
    outcome: &Outcome,
    look: &Look<'_>,
    states: StateSpaceOptions,
    arguments: &Arguments,
    progress: &mut Progress,
    manifest: &mut Manifest,
    interrupt: &Interrupt,
) -> Result<()> {
    let go_on = || if interrupt.requested() { Err(PipelineError::Interrupted) } else { Ok(()) };
    let (out, axes) = (&outcome.out, &outcome.axes);
    let mut files: Vec<String> = Vec::new();
    progress.stage("write files", 0, |_| -> Result<()> {
        go_on()?;
        let solved = &outcome.solved;
        let errors = outcome.errors.by_rank(&solved.families, &solved.modes);
        eigenfrequencies::write_families(&out.join("eigenfrequencies.csv"), &solved.families, &errors)?;
        eigenfrequencies::write_mode_table(&out.join("mode_table.csv"), &outcome.table)?;
        go_on()?;
        let names = (&axes.outputs[..], &axes.inputs[..]);
        arguments.states.write(&out.join("state_space.mat"), &outcome.solved.modes, states, names, manifest)?;
        go_on()?;
        files.extend(["eigenfrequencies.csv", "mode_table.csv", "state_space.mat"].map(String::from));
        files.extend(outcome.map.write(out)?);
        Ok(())
    })?;
    if !arguments.no_figures {
        let shown = look.shown(outcome);
        let drawn = progress.stage("draw pictures", 0, |_| shown.draw(out, interrupt))?;
        files.extend(drawn.iter().map(|p| relative(p, out)));
        go_on()?;
        let surfaces = progress.stage("write surfaces", 0, |_| -> Result<Vec<PathBuf>> {
            let mut files = shown.write_surfaces(out, outcome.map.whole(), interrupt)?;
            files.extend(look.write_shapes(outcome)?);
            Ok(files)
        })?;
        files.extend(surfaces.iter().map(|p| relative(p, out)));
        go_on()?;
        let mut database = progress.stage("modal database", 0, |_| look.database(outcome))?;
        database.header.input_hashes = manifest.input_hashes.0.clone();
        record::seconds(manifest, progress);
        manifest.files = files.clone();
        go_on()?;
        let written = progress.stage("report page", 0, |_| write_report(out, &database, manifest))?;
        files.extend(written.iter().map(|p| relative(p, out)));
    }
    go_on()?;
    files.push("manifest.json".into());
    manifest.files = files;
    record::seconds(manifest, progress);
    Ok(())
}

pub(super) fn mesh_warnings(machine: &Machine, meshes: &[stiffmap::mesh::MeshFile]) -> Vec<String> {
    let of_part = |(part, file): (&stiffmap::machine::Part, &stiffmap::mesh::MeshFile)| {
        let name = part.mesh.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        file.warnings.iter().map(|w| format!("{name}, line {}: {}", w.line, w.text)).collect::<Vec<_>>()
    };
    machine.parts.iter().zip(meshes).flat_map(of_part).collect()
}

pub(super) fn figure(name: &str, figure: f64, bound: f64) -> Check {
    Check { name: name.into(), figure, bound, passed: figure <= bound }
}

pub(super) fn without_nulls(value: serde_json::Value) -> serde_json::Value {
    match value {
        serde_json::Value::Object(map) => {
            map.into_iter().filter(|(_, v)| !v.is_null()).map(|(k, v)| (k, without_nulls(v))).collect()
        }
        other => other,
    }
}

pub(super) fn relative(path: &Path, folder: &Path) -> String {
    path.strip_prefix(folder).unwrap_or(path).to_string_lossy().replace('\\', "/")
}

/// A name as a folder: `vertical mill` becomes `vertical_mill`.
pub(super) fn slug(name: &str) -> String {
    let slug = safe(name);
    let slug = slug.trim_matches('_').to_string();
    if slug.is_empty() { "machine".into() } else { slug }
}
