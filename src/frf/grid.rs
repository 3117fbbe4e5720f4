//! Frequency grids.

use std::f64::consts::PI;

use super::FrfError;
use super::request::check_grid;
use crate::machine::{logarithmic_frequencies, uniform_frequencies};

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
    /// its circle in the Nyquist plane: f_r (1 + zeta tan(theta_k)). Modes of several positions may be given together:
    /// where they crowd, frequencies are left out that lie closer than half the step that the modes there ask for.
    Clustered {
        /// First frequency, Hz.
        from: f64,
        /// Last frequency, Hz.
        to: f64,
        /// Natural frequency (Hz) and damping ratio (zeta + eta / 2) of each mode; modes outside the band, at 0 Hz or
        /// without damping are skipped.
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
    Ok(logarithmic_frequencies(from, to, count))
}

fn clustered(from: f64, to: f64, modes: &[(f64, f64)], points: usize, background: usize) -> Result<Vec<f64>, FrfError> {
    require(to > from && to.is_finite(), "the last frequency in Hz", to, "finite, above the first")?;
    require(background >= 2, "the number of background frequencies", background as f64, "at least 2")?;
    require(points >= 1, "the number of frequencies a mode", points as f64, "at least 1")?;
    let total = background as f64 + points as f64 * modes.len() as f64;
    require(total < LARGEST, "the number of frequencies", total, "below 1e9")?;
    for &(frequency, damping) in modes {
        require(
            frequency.is_finite() && frequency >= 0.0,
            "a mode's frequency in Hz",
            frequency,
            "finite, not below 0",
        )?;
        require(damping.is_finite() && damping >= 0.0, "a mode's damping ratio", damping, "finite, not below 0")?;
    }
    let circles = Circles::new(modes, points);
    let mut frequencies = circles.frequencies(points);
    frequencies.retain(|f| (from..=to).contains(f));
    frequencies.sort_by(f64::total_cmp);
    circles.thin(&mut frequencies);
    frequencies.extend(uniform_frequencies(from, to, background));
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup_by(|b, a| *b - *a <= 1e-12 * *b);
    Ok(frequencies)
}

/// Modes as circles in the Nyquist plane: (frequency, half band width) in Hz, ascending.
struct Circles {
    modes: Vec<(f64, f64)>,
    /// Angle between two frequencies of a mode, rad.
    step: f64,
}

impl Circles {
    /// Damped modes above 0 Hz; of those closer than a tenth of a half band one stands for all.
    fn new(modes: &[(f64, f64)], points: usize) -> Circles {
        let damped = modes.iter().filter(|(f, zeta)| *f > 0.0 && *zeta > 0.0);
        let mut modes: Vec<(f64, f64)> = damped.map(|(f, zeta)| (*f, f * zeta)).collect();
        modes.sort_by(|a, b| a.0.total_cmp(&b.0));
        modes.dedup_by(|b, a| b.0 - a.0 < 0.1 * a.1.min(b.1) && (0.9..1.1).contains(&(b.1 / a.1)));
        Circles { modes, step: PI / (points + 1) as f64 }
    }

    fn frequencies(&self, points: usize) -> Vec<f64> {
        let angles: Vec<f64> = (1..=points).map(|k| (self.step * k as f64 - 0.5 * PI).tan()).collect();
        self.modes.iter().flat_map(|(f, half)| angles.iter().map(move |tan| f + half * tan)).collect()
    }

    /// The smallest step that a mode asks for at a frequency at a distance d from it: step (half + d^2 / half), which is
    /// never below 2 step d, so that modes farther than what is found already need no look.
    fn wanted(&self, frequency: f64) -> f64 {
        let at = self.modes.partition_point(|(f, _)| *f < frequency);
        let mut wanted = f64::INFINITY;
        let mut look = |&(f, half): &(f64, f64)| {
            let distance = (frequency - f).abs();
            wanted = wanted.min(self.step * (half + distance * distance / half));
            2.0 * self.step * distance < wanted
        };
        let _ = self.modes[at..].iter().all(&mut look);
        let _ = self.modes[..at].iter().rev().all(&mut look);
        wanted
    }

    /// Leaves out frequencies that lie closer to the one before than half the smaller step wanted at either.
    fn thin(&self, frequencies: &mut Vec<f64>) {
        let mut kept = (f64::NEG_INFINITY, 0.0);
        frequencies.retain(|&f| {
            let wanted = self.wanted(f);
            let far = f - kept.0 >= 0.5 * wanted.min(kept.1);
            if far {
                kept = (f, wanted);
            }
            far
        });
    }
}
