//! How many component modes are wanted, and the check that none of them was missed.

use super::basis::side_by_side;
use crate::interrupt::Interrupt;
use crate::linalg::{LinalgError, Spectrum};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// The estimate of the error looks at least at so many vectors beyond the modes.
const LEAST_BEYOND: usize = 40;

/// How many component modes are wanted.
#[derive(Clone, Copy, Debug)]
pub(super) struct ComponentModes<'a> {
    pub modes: usize,
    pub band: f64,
    /// Modes are kept at least up to this frequency, Hz.
    pub reach: f64,
    pub second_moment: bool,
    pub interrupt: Option<&'a Interrupt>,
}

/// Blocks of basis vectors of a reduction, the component modes first.
pub(super) struct Vectors {
    /// Frequencies of the component modes kept, Hz.
    pub frequencies: Vec<f64>,
    pub blocks: Vec<DMatrix<f64>>,
    /// Vectors above them that hold the interfaces still.
    pub beyond: DMatrix<f64>,
}

impl ComponentModes<'_> {
    /// Vectors beyond the modes that the estimate of the error looks at.
    pub fn beyond(self) -> usize {
        self.modes + LEAST_BEYOND
    }

    /// The same with as many modes as lie below its reach, if these are more.
    ///
    /// # Errors
    /// As of the count.
    pub fn reaching(self, count_below: impl Fn(f64) -> Result<usize, LinalgError>) -> Result<Self, LinalgError> {
        if self.reach <= 0.0 {
            return Ok(self);
        }
        let counted = count_below((TAU * self.reach).powi(2))?;
        Ok(Self { modes: self.modes.max(counted), ..self })
    }

    /// A few modes more than wanted, so that the inertia count finds a gap to stand in.
    pub fn with_guard(self) -> usize {
        self.modes + 4
    }

    /// Compares the modes found below a shift in the widest gap past the wanted ones with the inertia.
    pub fn check_count(
        self,
        spectrum: &Spectrum,
        count_below: impl Fn(f64) -> Result<usize, LinalgError>,
    ) -> Result<(), LinalgError> {
        let values = &spectrum.eigenvalues;
        let last = values.len().saturating_sub(1);
        let first = self.modes.min(last).saturating_sub(1);
        let Some(below) =
            (first..last).max_by(|&a, &b| (values[a + 1] / values[a]).total_cmp(&(values[b + 1] / values[b])))
        else {
            return Ok(());
        };
        let shift = 0.5 * (values[below] + values[below + 1]);
        let (found, counted) = (below + 1, count_below(shift)?);
        if found == counted {
            return Ok(());
        }
        Err(LinalgError::ModesMissed { found, counted, frequency_hz: shift.sqrt() / TAU })
    }

    /// Frequencies (Hz) and shapes of the modes kept: the lowest, at most as many as asked for and
    /// none above the band.
    pub fn keep(self, spectrum: &Spectrum) -> (Vec<f64>, DMatrix<f64>) {
        let frequencies = spectrum.eigenvalues.iter().map(|l| l.sqrt() / TAU);
        let kept: Vec<f64> = frequencies.take(self.modes).take_while(|f| *f <= self.band).collect();
        let shapes = spectrum.shapes.columns(0, kept.len()).into_owned();
        (kept, shapes)
    }

    /// The vectors above the modes kept: the modes found beside them, then what the iteration holds beyond.
    pub fn above(spectrum: &Spectrum, kept: usize) -> DMatrix<f64> {
        let found = spectrum.shapes.columns_range(kept..).into_owned();
        side_by_side([&found, &spectrum.beyond].into_iter())
    }
}
