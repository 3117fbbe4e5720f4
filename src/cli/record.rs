//! What a run writes into its manifest.

use super::map::{Axes, Map};
use super::progress::Progress;
use super::run::{Arguments, Outcome, figure};
use super::summary;
use anyhow::Result;
use serde_json::json;
use std::path::Path;
use stiffmap::export::manifest::{Check, Manifest};
use stiffmap::export::response::unit;
use stiffmap::files::Inputs;
use stiffmap::frf::Truncation;
use stiffmap::machine::{Machine, Quantity};
use stiffmap::modal::{Modes, ReductionEstimate};
use stiffmap::pipeline::{FREQUENCY_BOUND, MAP_BOUND, ProjectionError, ReductionErrors, Solved, acting_damping};
use stiffmap::reduction::Superelement;

/// What was read, by path relative to the machine file.
pub fn input(manifest: &mut Manifest, machine: &Machine, inputs: &Inputs) {
    let folder = machine.file.parent().unwrap_or(Path::new(""));
    manifest.input_hashes.0.extend(inputs.named(folder));
    manifest.warnings.extend(edited(inputs));
}

/// A file that an option of the command line names.
pub fn named_input(manifest: &mut Manifest, option: &str, inputs: &Inputs) {
    let named = inputs.named(Path::new("")).into_iter();
    manifest.input_hashes.0.extend(named.map(|(name, hash)| (format!("{option} {name}"), hash)));
    manifest.warnings.extend(edited(inputs));
}

/// What the reader of a result must know of files that were edited while it was computed.
pub fn edited(inputs: &Inputs) -> Vec<String> {
    let said = |path: &Path| {
        format!(
            "{}: it has been changed since it was read; the result is that of the file as it was then",
            path.display()
        )
    };
    inputs.changed().into_iter().map(said).collect()
}

/// Sizes before and after each step.
pub fn size(
    manifest: &mut Manifest,
    superelements: &[Superelement],
    basis: usize,
    solved: &Solved,
    machine: &Machine,
    truncation: &Truncation,
) {
    let sum = |of: fn(&Superelement) -> usize| superelements.iter().map(of).sum::<usize>() as u64;
    let counts = &mut manifest.counts;
    counts.push("nodes", sum(|s| s.n_nodes));
    counts.push("elements", sum(|s| s.n_elements));
    counts.push("unknowns", sum(|s| s.n_dof));
    counts.push("superelement_coordinates", sum(|s| s.n()));
    counts.push("fixed_basis_coordinates", basis as u64);
    counts.push("springs", machine.joints.iter().map(|j| j.springs.len()).sum::<usize>() as u64);
    counts.push("positions", solved.modes.len() as u64);
    counts.push("elastic_modes_reported", machine.analysis.modes as u64);
    counts.push("modes_in_map_fewest", truncation.fewest_modes as u64);
    counts.push("modes_in_map_most", truncation.most_modes as u64);
}

/// What memory was expected to be taken by the reductions, and what was, bytes; a figure that the system does not give
/// is left out.
pub fn memory(manifest: &mut Manifest) {
    let foreseen = Some(stiffmap::resources::foreseen()).filter(|bytes| *bytes > 0);
    let value = json!({"foreseen_bytes": foreseen, "peak_bytes": stiffmap::resources::peak()});
    manifest.settings.push("memory", super::run::without_nulls(value));
}

/// What was asked for.
pub fn settings(manifest: &mut Manifest, machine: &Machine, arguments: &Arguments, truncation: &Truncation, band: f64) {
    let settings = &mut manifest.settings;
    let damping = &machine.analysis.damping;
    settings.push("axis", json!(machine.axis.name));
    settings.push("frequency_grid", json!(machine.analysis.grid.name()));
    settings.push("component_modes", json!(machine.analysis.component.modes));
    settings.push("component_modes_follow_frequency", json!(machine.analysis.component.follows));
    settings.push("reduction", json!(format!("{:?}", machine.analysis.component.method)));
    settings.push("second_moment", json!(machine.analysis.component.second_moment));
    settings.push("fixed_basis_for_hz", json!(band));
    settings.push("damping_ratios", json!(damping.ratios));
    settings.push("loss_factor", json!(damping.loss_factor));
    settings.push("exactly_n_modes", json!(arguments.overrides.modes.is_some() || arguments.no_residual));
    if let Some(degree) = truncation.degree {
        settings.push("residual_degree", json!(degree));
    }
    settings.push("truncation_error", json!(truncation.error));
}

/// Which damping acted, how it was solved for, and what projecting it on the modes would leave out.
pub fn damping(manifest: &mut Manifest, machine: &Machine, projection: Option<&ProjectionError>) {
    let solution = if machine.analysis.damping.projected { "projected" } else { "exact" };
    let acting = acting_damping(machine);
    let value = json!({"acting": acting, "solution": solution, "projection_error": projection});
    manifest.settings.push("damping", super::run::without_nulls(value));
}

/// A failed check is a failed command, once all files are written.
pub fn hold(manifest: &Manifest) -> Result<()> {
    let failed: Vec<String> = manifest.checks.iter().filter(|c| !c.passed).map(in_words).collect();
    if failed.is_empty() { Ok(()) } else { Err(anyhow::anyhow!("{}", failed.join("; "))) }
}

fn in_words(check: &Check) -> String {
    let advice = [
        ("fixed basis", "ask for fewer elastic `modes` or a lower highest frequency, and report the machine"),
        ("modes found", "ask for fewer elastic `modes`, and report the machine"),
        ("truncation", "give [analysis] component more `modes`"),
        ("reduction", "give [analysis] component more `modes`, or leave `modes` and `band` out"),
        ("energy", "raise the sampling rate with --rate"),
        ("spectra", "raise the sampling rate with --rate, or make the record longer with --duration"),
    ];
    let advice =
        advice.iter().find(|(begins, _)| check.name.starts_with(begins)).map_or("see the manifest", |(_, a)| *a);
    format!(
        "check failed: {}, {:.1e} where {:.0e} is allowed; all files are written; {advice}",
        check.name, check.figure, check.bound
    )
}

/// The checks of the reduction's error, and what to change where one fails.
pub fn reduction(
    checks: &mut Vec<Check>,
    warnings: &mut Vec<String>,
    errors: &ReductionErrors,
    modes: &[Modes],
    map: Option<f64>,
) {
    let worst = errors.worst(modes);
    let frequency = worst.map_or(0.0, |w| w.error);
    let frequencies = "reduction of the parts, largest estimate of a frequency's relative error";
    checks.push(figure(frequencies, frequency, FREQUENCY_BOUND));
    if let Some(map) = map {
        let name = "reduction of the parts, largest estimate of the map's error, relative Frobenius norm";
        checks.push(figure(name, map, MAP_BOUND));
    }
    if let Some(w) = worst.filter(|_| checks.iter().rev().take(2).any(|c| !c.passed)) {
        warnings.push(format!(
            "the reduction of the parts is too coarse: elastic mode {} at {:.1} Hz lies some {:.1e} of itself too high \
             at {} m; give [analysis] component more `modes`, or leave `modes` and `band` out, so that they follow the \
             highest frequency, or ask for fewer elastic `modes`",
            w.rank, w.frequency, w.error, w.position
        ));
    }
}

/// The estimates of the reduction's error.
pub fn errors(manifest: &mut Manifest, errors: &ReductionErrors, modes: &[Modes], map: Option<f64>) {
    let worst = errors.worst(modes).map(|w| {
        json!({"relative_error": w.error, "elastic_rank": w.rank, "frequency_hz": w.frequency, "position_m": w.position})
    });
    let of_position =
        |e: &ReductionEstimate| json!({"position_m": e.position, "relative_error_by_rank": e.frequencies});
    let all: Vec<_> = errors.estimates.iter().map(of_position).collect();
    manifest
        .settings
        .push("reduction_error", super::run::without_nulls(json!({"worst": worst, "map": map, "elastic_modes": all})));
}

/// What the map holds, and whether it was streamed.
pub fn map(manifest: &mut Manifest, axes: &Axes, map: &Map, limit: u64) {
    let settings = &mut manifest.settings;
    settings.push("quantity", json!(axes.quantity.name()));
    settings.push("unit", json!(unit(axes.quantity)));
    settings.push("map_bytes", json!(axes.bytes()));
    settings.push("map_memory_bytes", json!(limit));
    settings.push("map_streamed", json!(matches!(map, Map::Streamed(_))));
    if let Map::Streamed(streamed) = map {
        settings.push("map_tiles", json!(streamed.tiles));
        settings.push("map_tile_bytes", json!(streamed.tile_bytes));
    }
}

/// The extrema over positions and frequencies, under the name that they have for the quantity.
pub fn extrema(manifest: &mut Manifest, outcome: &Outcome) {
    let settings = &mut manifest.settings;
    match outcome.axes.quantity {
        Quantity::Receptance => {
            settings.push("smallest_dynamic_stiffness", json!(summary::smallest_stiffness(outcome)));
        }
        quantity => settings.push(format!("largest_{}", quantity.name()), json!(summary::largest(outcome))),
    }
    settings.push("most_negative_real_part", json!(summary::most_negative_real(outcome)));
}

/// The stages' times so far, after what else was timed.
pub fn seconds(manifest: &mut Manifest, progress: &Progress) {
    for (stage, seconds) in progress.seconds() {
        manifest.seconds.0.retain(|(known, _)| known != stage);
        manifest.seconds.push(stage.clone(), round(*seconds));
    }
}

/// A time or rate to four digits behind the point.
pub fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
