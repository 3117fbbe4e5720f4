//! Frequency grids.

use std::f64::consts::PI;

use super::FrfError;
use super::request::check_grid;

/// How the frequencies of a map are laid.
#[derive(Clone, Debug, PartialEq)]
pub enum FrequencyGrid {
    /// `from`, `from + step`, ... up to `to`, Hz.
    Uniform {
        /// First frequency, Hz.
        from: f64,
        /// Last frequency, Hz, kept where a whole number of steps reaches it.
        to: f64,
        /// Step, Hz.
        step: f64,
    },
    /// `count` frequencies at equal ratios from `from` to `to`, Hz, both kept.
    Logarithmic {
        /// First frequency, Hz, above 0.
        from: f64,
        /// Last frequency, Hz.
        to: f64,
        /// Number of frequencies, at least 2.
        count: usize,
    },
    /// A uniform background of `background` frequencies, and around each mode `points` frequencies at equal steps along
    /// its circle in the Nyquist plane: f_r (1 + zeta tan(theta_k)).
    Clustered {
        /// First frequency, Hz.
        from: f64,
        /// Last frequency, Hz.
        to: f64,
        /// Natural frequency (Hz) and damping ratio (zeta + eta / 2) of each mode; modes outside the band are skipped.
        modes: Vec<(f64, f64)>,
        /// Frequencies a mode; with 13, one is the mode's own and no point of its circle is farther than pi/28 from one.
        points: usize,
        /// Frequencies of the background, at least 2: `from` and `to` are among them.
        background: usize,
    },
    /// Any list, Hz, strictly ascending.
    Listed(Vec<f64>),
}

/// Frequencies of a grid at most.
const LARGEST: f64 = 1e9;

impl FrequencyGrid {
    /// The frequencies, Hz, strictly ascending.
    ///
    /// # Errors
    /// [`FrfError::BadGrid`] for an end, step or count that makes no grid, [`FrfError::BadFrequency`] and
    /// [`FrfError::NotAscending`] for a list that is none.
    pub fn frequencies(&self) -> Result<Vec<f64>, FrfError> {
        let frequencies = match self {
            FrequencyGrid::Uniform { from, to, step } => uniform(*from, *to, *step)?,
            FrequencyGrid::Logarithmic { from, to, count } => logarithmic(*from, *to, *count)?,
            FrequencyGrid::Clustered { from, to, modes, points, background } => {
                clustered(*from, *to, modes, *points, *background)?
            }
            FrequencyGrid::Listed(frequencies) => frequencies.clone(),
        };
        check_grid(&frequencies)?;
        Ok(frequencies)
    }
}

fn require(holds: bool, what: &'static str, value: f64, allowed: &'static str) -> Result<(), FrfError> {
    if holds { Ok(()) } else { Err(FrfError::BadGrid { what, value, allowed }) }
}

fn uniform(from: f64, to: f64, step: f64) -> Result<Vec<f64>, FrfError> {
    require(step > 0.0 && step.is_finite(), "the step in Hz", step, "above 0")?;
    require(to >= from && to.is_finite(), "the last frequency in Hz", to, "finite, not below the first")?;
    let intervals = (to - from) / step * (1.0 + 1e-12);
    require(intervals < LARGEST, "the number of frequencies", intervals, "below 1e9")?;
    Ok((0..=intervals as usize).map(|i| (from + step * i as f64).min(to)).collect())
}

fn logarithmic(from: f64, to: f64, count: usize) -> Result<Vec<f64>, FrfError> {
    require(from > 0.0, "the first frequency in Hz", from, "above 0 in a logarithmic grid")?;
    require(to > from && to.is_finite(), "the last frequency in Hz", to, "finite, above the first")?;
    require(count >= 2 && (count as f64) < LARGEST, "the number of frequencies", count as f64, "2 to 1e9")?;
    let ratio = (to / from).ln();
    let last = count - 1;
    Ok((0..count)
        .map(|i| match i {
            0 => from,
            i if i == last => to,
            i => from * (ratio * i as f64 / last as f64).exp(),
        })
        .collect())
}

fn clustered(from: f64, to: f64, modes: &[(f64, f64)], points: usize, background: usize) -> Result<Vec<f64>, FrfError> {
    require(to > from && to.is_finite(), "the last frequency in Hz", to, "finite, above the first")?;
    require(background >= 2, "the number of background frequencies", background as f64, "at least 2")?;
    require(points >= 1, "the number of frequencies a mode", points as f64, "at least 1")?;
    let total = background as f64 + points as f64 * modes.len() as f64;
    require(total < LARGEST, "the number of frequencies", total, "below 1e9")?;
    let step = (to - from) / (background - 1) as f64;
    let mut frequencies: Vec<f64> = (0..background).map(|i| (from + step * i as f64).min(to)).collect();
    for &(frequency, damping) in modes {
        require(
            frequency.is_finite() && frequency >= 0.0,
            "a mode's frequency in Hz",
            frequency,
            "finite, not below 0",
        )?;
        require(damping.is_finite() && damping >= 0.0, "a mode's damping ratio", damping, "finite, not below 0")?;
        frequencies.extend((1..=points).map(|k| {
            let theta = PI * (k as f64 / (points + 1) as f64 - 0.5);
            frequency * (1.0 + damping * theta.tan())
        }));
    }
    frequencies.retain(|f| (from..=to).contains(f));
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup_by(|b, a| *b - *a <= 1e-12 * *b);
    Ok(frequencies)
}
