//! `--frequencies`: a list, a range, or a grid by its name; and the grid around the modes once they are known.

use super::UsageError;
use super::overrides::numbers;
use stiffmap::frf::{FrequencyGrid, FrfError, ModalSystem};
use stiffmap::machine::{
    Analysis, DEFAULT_BACKGROUND, DEFAULT_POINTS, Grid, logarithmic_frequencies, uniform_frequencies,
};

const FORMS: &str = "a list `5,25,55`, a range `0:900:1`, `logarithmic:1:900:500` (from, to, count) or \
                     `clustered:0:900` (from, to, and if wanted frequencies a mode and of the background)";
/// Most frequencies that a grid may be asked for.
const MOST: f64 = 1e6;

/// The frequencies that a text means, Hz (of a clustered grid its background), and how they are laid.
pub fn parse(text: &str) -> Result<(Vec<f64>, Grid), UsageError> {
    let begins_with_name = text.trim_start().starts_with(|c: char| c.is_alphabetic());
    let (kind, rest) = text.split_once(':').filter(|_| begins_with_name).unwrap_or(("", text));
    let refuse = |why: String| UsageError(format!("--frequencies: {why}; write {FORMS}"));
    let (frequencies, grid) = match kind.trim() {
        "" => {
            let grid = if text.contains(':') { Grid::Uniform } else { Grid::Listed };
            (numbers("--frequencies", text)?, grid)
        }
        "uniform" if rest.contains(':') => (numbers("--frequencies", rest)?, Grid::Uniform),
        "logarithmic" => {
            let values = parts(rest)?;
            let [from, to, count] = values[..] else {
                return Err(refuse(format!(
                    "\"{text}\" has {} of the three numbers of a logarithmic grid",
                    values.len()
                )));
            };
            let count = whole("count", count, 2.0, MOST)?;
            if from <= 0.0 || to <= from {
                return Err(refuse(format!("a logarithmic grid from {from} to {to} Hz needs 0 < from < to")));
            }
            (logarithmic_frequencies(from, to, count), Grid::Logarithmic)
        }
        "clustered" => {
            let values = parts(rest)?;
            let (from, to, more) = match values[..] {
                [from, to, ref more @ ..] if more.len() <= 2 => (from, to, more),
                _ => return Err(refuse(format!("\"{text}\" has {} numbers, a clustered grid 2 to 4", values.len()))),
            };
            if from < 0.0 || to <= from {
                return Err(refuse(format!("a clustered grid from {from} to {to} Hz needs 0 <= from < to")));
            }
            let points = more.first().map_or(Ok(DEFAULT_POINTS), |n| whole("frequencies a mode", *n, 1.0, 1000.0))?;
            let background = more.get(1).map_or(Ok(DEFAULT_BACKGROUND), |n| whole("background", *n, 2.0, MOST))?;
            (uniform_frequencies(from, to, background), Grid::Clustered { points })
        }
        other => return Err(refuse(format!("\"{other}\" is no grid"))),
    };
    if let Some(bad) = frequencies.iter().find(|f| **f < 0.0) {
        return Err(UsageError(format!("--frequencies: {bad} Hz is negative; 0 Hz and above are allowed")));
    }
    if let Some(pair) = frequencies.windows(2).find(|p| p[1] <= p[0]) {
        return Err(UsageError(format!("--frequencies: {} Hz follows {} Hz; they must ascend", pair[1], pair[0])));
    }
    Ok((frequencies, grid))
}

fn parts(text: &str) -> Result<Vec<f64>, UsageError> {
    numbers("--frequencies", &text.replace(':', ","))
}

fn whole(what: &str, value: f64, least: f64, most: f64) -> Result<usize, UsageError> {
    if (least..=most).contains(&value) && value.fract() == 0.0 {
        return Ok(value as usize);
    }
    Err(UsageError(format!("--frequencies: {what} is {value}; allowed: a whole number from {least} to {most}")))
}

/// The frequencies of the analysis, Hz: of a clustered grid those around the modes of every position too.
///
/// # Errors
/// [`FrfError`] for a grid that is none.
pub fn around_modes(analysis: &Analysis, systems: &[ModalSystem]) -> Result<Vec<f64>, FrfError> {
    let frequencies = &analysis.frequencies;
    let (Grid::Clustered { points }, &[from, .., to]) = (analysis.grid, &frequencies[..]) else {
        return Ok(frequencies.clone());
    };
    let of_system = |s: &ModalSystem| {
        let damping = s.damping_ratios.iter().zip(&s.loss_factors).map(|(zeta, eta)| zeta + 0.5 * eta);
        s.frequencies.iter().copied().zip(damping).collect::<Vec<_>>()
    };
    let modes = systems.iter().flat_map(of_system).collect();
    FrequencyGrid::Clustered { from, to, modes, points, background: frequencies.len() }.frequencies()
}
