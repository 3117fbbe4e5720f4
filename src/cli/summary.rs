//! What the terminal shows at the end of a run.

use super::map::Map;
use super::progress::Progress;
use super::run::Outcome;
use serde::Serialize;
use std::cmp::Ordering;
use stiffmap::coupling::CoupledModel;
use stiffmap::export::manifest::Manifest;
use stiffmap::export::response::unit;
use stiffmap::frf::metrics::{Extremum, PairMetrics};
use stiffmap::machine::Quantity;
use stiffmap::modal::ModeFamilies;
use stiffmap::pipeline::Solved;

/// The weakest point of a direction over positions and frequencies.
#[derive(Clone, Debug, Serialize)]
pub struct Weakest {
    /// Output and input, such as `x`.
    pub direction: String,
    /// Element-wise dynamic stiffness 1/|H|, N/m.
    pub stiffness_n_per_m: f64,
    /// Position, m.
    pub position_m: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
}

/// The extreme value of a direction over positions and frequencies.
#[derive(Clone, Debug, Serialize)]
pub struct Extreme {
    /// Output and input, such as `x`.
    pub direction: String,
    /// The value, in the map's unit.
    pub value: f64,
    /// Position, m.
    pub position_m: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
}

/// Of each direct response the extremum over the positions that comes first by `order`.
fn extremes(
    outcome: &Outcome,
    of: impl Fn(&PairMetrics) -> Extremum,
    order: impl Fn(f64, f64) -> Ordering,
) -> Vec<Extreme> {
    let pairs = outcome.metrics.first().map_or(0, Vec::len);
    (0..pairs)
        .filter_map(|k| {
            let at = |(metrics, &position): (&Vec<PairMetrics>, &f64)| {
                let pair = metrics[k];
                (of(&pair), (pair.output, pair.input), position)
            };
            let all = outcome.metrics.iter().zip(&outcome.axes.positions).map(at);
            let (extremum, (output, input), position_m) = all.min_by(|a, b| order(a.0.value, b.0.value))?;
            let (output, input) = (&outcome.axes.outputs[output], &outcome.axes.inputs[input]);
            let direction = if output == input { output.clone() } else { format!("{output} from {input}") };
            Some(Extreme { direction, value: extremum.value, position_m, frequency_hz: extremum.frequency })
        })
        .collect()
}

/// The largest magnitude of each direct response.
pub fn largest(outcome: &Outcome) -> Vec<Extreme> {
    extremes(outcome, |m| m.peak, |a, b| b.total_cmp(&a))
}

/// The most negative real part of each direct response.
pub fn most_negative_real(outcome: &Outcome) -> Vec<Extreme> {
    extremes(outcome, |m| m.most_negative_real, |a, b| a.total_cmp(&b))
}

/// The smallest element-wise dynamic stiffness of each direct response.
pub fn smallest_stiffness(outcome: &Outcome) -> Vec<Weakest> {
    let weakest = |e: Extreme| Weakest {
        direction: e.direction,
        stiffness_n_per_m: e.value.recip(),
        position_m: e.position_m,
        frequency_hz: e.frequency_hz,
    };
    largest(outcome).into_iter().map(weakest).collect()
}

/// The extrema in lines.
fn extrema_lines(outcome: &Outcome) -> Vec<String> {
    if outcome.metrics.is_empty() {
        return Vec::new();
    }
    let axis = &outcome.machine.axis.name;
    let place = |position: f64, frequency: f64| format!("at {axis} = {position:.3} m, {frequency:.1} Hz");
    match outcome.axes.quantity {
        Quantity::Receptance => {
            let line = |w: Weakest| {
                let stiffness = w.stiffness_n_per_m * 1e-6;
                format!("  {:<8} {stiffness:8.3} N/um   {}", w.direction, place(w.position_m, w.frequency_hz))
            };
            let heading = "\nsmallest dynamic stiffness 1/|H| (element-wise)".to_string();
            std::iter::once(heading).chain(smallest_stiffness(outcome).into_iter().map(line)).collect()
        }
        quantity => {
            let unit = unit(quantity);
            let line = |e: Extreme| {
                format!("  {:<8} {:10.3e} {unit}   {}", e.direction, e.value, place(e.position_m, e.frequency_hz))
            };
            let heading = format!("\nlargest {} |H|", quantity.name());
            std::iter::once(heading).chain(largest(outcome).into_iter().map(line)).collect()
        }
    }
}

/// Where the map went if it did not stay in memory.
fn streamed_line(outcome: &Outcome) -> Option<String> {
    let Map::Streamed(streamed) = &outcome.map else { return None };
    Some(format!(
        "the map of {:.2} GB was streamed to compliance.npy in {} tiles of at most {:.0} MB",
        outcome.axes.bytes() as f64 * 1e-9,
        streamed.tiles,
        streamed.tile_bytes as f64 * 1e-6
    ))
}

/// The names of the motions at 0 Hz at the first position, and how many more there are elsewhere.
pub fn free_motions(solved: &Solved, model: &CoupledModel) -> Vec<String> {
    solved.modes.first().map_or_else(Vec::new, |modes| modes.free_motions(model).into_iter().map(|m| m.name).collect())
}

/// The same of those that the ports feel.
pub fn felt_free_motions(solved: &Solved, model: &CoupledModel) -> Vec<String> {
    let felt = |modes: &stiffmap::modal::Modes| {
        let motions = modes.free_motions(model).into_iter().enumerate();
        motions.filter(|(r, _)| modes.is_felt(*r)).map(|(_, motion)| motion.name).collect()
    };
    solved.modes.first().map_or_else(Vec::new, felt)
}

/// The veerings in words.
pub fn veerings(families: &ModeFamilies) -> Vec<String> {
    let one = |v: &stiffmap::modal::Veering| {
        format!(
            "families {} and {} veer between {:.4} and {:.4} m (MAC {:.2})",
            v.families[0], v.families[1], v.from, v.to, v.mac
        )
    };
    families.veerings.iter().map(one).collect()
}

/// Prints the end of a run.
pub fn print(outcome: &Outcome, manifest: &Manifest, progress: &Progress) {
    let mut text = String::new();
    let mut line = |s: String| {
        text.push_str(&s);
        text.push('\n');
    };
    let axis = &outcome.machine.axis.name;
    line(format!(
        "\n{}: {} positions along {axis}, {} frequencies",
        outcome.machine.name,
        outcome.axes.positions.len(),
        outcome.axes.frequencies.len()
    ));
    for free in &outcome.free_motions {
        line(format!("free motion at 0 Hz: {free}"));
    }
    line(format!(
        "\nfamily    min Hz    max Hz   diff %   at {axis} (m) of min, max   extremum inside   reduction error"
    ));
    for row in outcome.table.iter().filter(|row| row.max > 0.0) {
        line(format!(
            "{:6} {:9.2} {:9.2} {:8.1}   {:9.3}  {:9.3}       {:<3}             {}",
            row.family,
            row.min,
            row.max,
            row.difference_percent,
            row.position_of_min,
            row.position_of_max,
            if row.interior_extremum { "yes" } else { "no" },
            row.reduction_error.map_or_else(String::new, |e| format!("{e:.0e}"))
        ));
    }
    for veering in veerings(&outcome.solved.families) {
        line(veering);
    }
    extrema_lines(outcome).into_iter().chain(streamed_line(outcome)).for_each(&mut line);
    let truncation = &outcome.truncation;
    let rest = truncation.degree.map_or_else(|| "no residual".into(), |d| format!("residual of degree {d} in j omega"));
    line(format!(
        "\nmap: {} to {} modes a position, {rest}, truncation {:.1e} of the norm",
        truncation.fewest_modes, truncation.most_modes, truncation.error
    ));
    let adapter = outcome.backend.adapter.as_ref().map_or_else(String::new, |a| format!(" on {}", a.name));
    line(format!(
        "back end: {}{adapter} ({}): {}",
        outcome.backend.backend,
        outcome.backend.precision.name(),
        outcome.backend.why
    ));
    for check in &manifest.checks {
        line(format!(
            "{}: {}, {:.1e} (bound {:.0e})",
            if check.passed { "passed" } else { "FAILED" },
            check.name,
            check.figure,
            check.bound
        ));
    }
    for warning in &manifest.warnings {
        line(format!("warning: {warning}"));
    }
    let total: f64 = progress.seconds().iter().map(|(_, s)| s).sum();
    line(format!("{total:.2} s in all; files in {}", outcome.out.display()));
    progress.say(text.trim_end());
}
