//! What the terminal shows at the end of a run.

use super::progress::Progress;
use super::run::Outcome;
use serde::Serialize;
use stiffmap::coupling::CoupledModel;
use stiffmap::export::manifest::Manifest;
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

/// The smallest element-wise dynamic stiffness of each direct response.
pub fn smallest_stiffness(outcome: &Outcome) -> Vec<Weakest> {
    let pairs = outcome.metrics.first().map_or(0, Vec::len);
    (0..pairs)
        .filter_map(|k| {
            let weakest = outcome.metrics.iter().zip(&outcome.map.positions).min_by(|(a, _), (b, _)| {
                a[k].smallest_dynamic_stiffness().total_cmp(&b[k].smallest_dynamic_stiffness())
            });
            let (metrics, &position_m) = weakest?;
            Some(Weakest {
                direction: outcome.map.outputs[metrics[k].output].clone(),
                stiffness_n_per_m: metrics[k].smallest_dynamic_stiffness(),
                position_m,
                frequency_hz: metrics[k].peak.frequency,
            })
        })
        .collect()
}

/// The names of the motions at 0 Hz at the first position, and how many more there are elsewhere.
pub fn free_motions(solved: &Solved, model: &CoupledModel) -> Vec<String> {
    solved.modes.first().map_or_else(Vec::new, |modes| modes.free_motions(model).into_iter().map(|m| m.name).collect())
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
        outcome.map.positions.len(),
        outcome.map.frequencies.len()
    ));
    for free in &outcome.free_motions {
        line(format!("free motion at 0 Hz: {free}"));
    }
    line(format!("\nfamily    min Hz    max Hz   diff %   at {axis} (m) of min, max   extremum inside"));
    for row in outcome.table.iter().filter(|row| row.max > 0.0) {
        line(format!(
            "{:6} {:9.2} {:9.2} {:8.1}   {:9.3}  {:9.3}       {}",
            row.family,
            row.min,
            row.max,
            row.difference_percent,
            row.position_of_min,
            row.position_of_max,
            if row.interior_extremum { "yes" } else { "no" }
        ));
    }
    for veering in veerings(&outcome.solved.families) {
        line(veering);
    }
    if !outcome.metrics.is_empty() {
        line("\nsmallest dynamic stiffness 1/|H| (element-wise)".into());
    }
    for weakest in smallest_stiffness(outcome) {
        line(format!(
            "  {:<8} {:8.3} N/um   at {axis} = {:.3} m, {:.1} Hz",
            weakest.direction,
            weakest.stiffness_n_per_m * 1e-6,
            weakest.position_m,
            weakest.frequency_hz
        ));
    }
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
