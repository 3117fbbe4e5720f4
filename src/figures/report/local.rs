//! The machine around its nominal joints, in the few coordinates that the page solves while a slider moves.

use super::ReportError;
use super::accuracy::{Accuracy, Checked};
use super::header::SpringList;
use crate::coupling::{Around, AroundOptions, CoupledEigen, CoupledModel};
use crate::machine::Damping;
use crate::modal::Modes;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::borrow::Cow;

/// What the page keeps of the machine as it was run, where that is accurate over the range of its sliders; with joints a
/// quarter to four times as stiff it keeps the frequencies of the band to some 1e-6.
pub const PAGE: AroundOptions = AroundOptions { band: 1.3, tolerance: 2e-3 };
/// What is kept where it is not, less to more.
const WIDER: [AroundOptions; 2] =
    [AroundOptions { band: 1.6, tolerance: 1e-3 }, AroundOptions { band: 2.0, tolerance: 5e-4 }];

/// Positions times the cube of the coordinates that a page solves while a slider moves: some 200 ms on two cores.
const MOST_WORK: f64 = 2e8;

/// Coordinates are made for frequencies this much above the last listed one, which stiffer joints raise.
const ABOVE_LAST: f64 = 1.1;
/// Steps in which the frequency is found that time allows.
const HALVINGS: usize = 4;

/// Motion of springs and ports below which a free motion is left out, relative to the largest of any coordinate.
const UNFELT: f64 = 1e-9;

/// The machine around its nominal joints at one position, as the page holds it.
#[derive(Clone, Debug)]
pub(super) struct Local {
    /// Eigenvalues, (rad/s)^2.
    pub eigenvalues: Vec<f64>,
    /// How many of them, the first, are free motions.
    pub free: usize,
    /// Elongations of the springs, then outputs, then inputs, over the coordinates.
    pub rows: DMatrix<f64>,
    /// Static flexibility between the rows that the coordinates leave out.
    pub residual: DMatrix<f64>,
    /// Of the springs, N/m or N m/rad.
    pub stiffness: Vec<f64>,
}

/// What local coordinates are made of.
#[derive(Clone, Copy)]
pub(super) struct LocalInput<'a> {
    pub model: &'a CoupledModel,
    /// Modes at the page's positions, with shapes.
    pub modes: &'a [Cow<'a, Modes>],
    /// Whether the inputs are the outputs.
    pub symmetric: bool,
    pub damping: &'a Damping,
    /// Highest frequency of the map, Hz.
    pub highest: f64,
    /// The same or, where that is higher, the highest listed frequency, Hz.
    pub last: f64,
}

impl Local {
    /// The coordinates of all positions, and how far they hold over the range of the sliders: as few as do, within what a
    /// page can solve in time.
    ///
    /// # Errors
    /// [`ReportError`] if a position cannot be coupled or solved.
    pub(super) fn all(input: &LocalInput<'_>, springs: SpringList<'_>) -> Result<(Vec<Self>, Accuracy), ReportError> {
        let mut best: Option<(Vec<Self>, Accuracy)> = None;
        for options in std::iter::once(PAGE).chain(WIDER) {
            let Some(frequency) = input.affordable(springs.places, options, best.is_none())? else { break };
            let one = |modes: &Cow<'_, Modes>| input.local(modes, springs.places, frequency, options);
            let all = input.modes.par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
            // Between the band and what the coordinates are made for, the directions above the band still converge.
            let most = frequency * options.band.sqrt();
            let accuracy = Checked { input, springs, local: &all, most }.accuracy()?;
            let holds = accuracy.holds(input.highest);
            if best.as_ref().is_none_or(|(_, before)| accuracy.is_better(before, input.highest)) {
                best = Some((all, accuracy));
            }
            if holds {
                break;
            }
        }
        Ok(best.expect("the first is always formed"))
    }

    fn new(around: &Around, symmetric: bool) -> Self {
        let (n_springs, n_outputs) = (around.springs.nrows(), around.outputs.nrows());
        let ports = if symmetric { n_outputs } else { n_outputs + around.inputs.nrows() };
        let places: Vec<usize> = around.varied.iter().copied().chain((0..ports).map(|p| n_springs + p)).collect();
        let row = |place: usize, r: usize| match place {
            s if s < n_springs => around.springs[(s, r)],
            o if o < n_springs + n_outputs => around.outputs[(o - n_springs, r)],
            i => around.inputs[(i - n_springs - n_outputs, r)],
        };
        let rows = DMatrix::from_fn(places.len(), around.n(), |i, r| row(places[i], r));
        let largest = rows.column_iter().map(|c| c.norm()).fold(0.0, f64::max);
        let is_free = |r: usize| r < around.free;
        let kept: Vec<usize> =
            (0..around.n()).filter(|&r| !is_free(r) || rows.column(r).norm() > UNFELT * largest).collect();
        // Rounded as the page's arrays are.
        let stored = |v: f64| f64::from(v as f32);
        Self {
            free: kept.iter().filter(|r| is_free(**r)).count(),
            eigenvalues: kept.iter().map(|&r| around.eigenvalues[r]).collect(),
            rows: rows.select_columns(&kept).map(stored),
            residual: DMatrix::from_fn(places.len(), places.len(), |i, j| {
                stored(around.residual[(places[i], places[j])])
            }),
            stiffness: around.varied.iter().map(|&s| around.base[s]).collect(),
        }
    }
}

impl LocalInput<'_> {
    fn local(
        &self,
        modes: &Modes,
        springs: &[usize],
        frequency: f64,
        options: AroundOptions,
    ) -> Result<Local, ReportError> {
        let stiffness = self.model.stiffness(modes.position)?;
        let base =
            CoupledEigen { values: modes.eigenvalues.clone().into(), vectors: modes.shapes.clone(), free: modes.free };
        let at = self.model.at(modes.position)?;
        let around = self.model.around_modes(&at, &stiffness, &base, springs, frequency, options)?;
        Ok(Local::new(&around, self.symmetric))
    }

    /// The frequency (Hz) that coordinates can be made for in the page's time: somewhat above the last listed mode's,
    /// else as far as time allows, but the map's highest at least; nothing if that takes too long, unless there is
    /// nothing else yet.
    fn affordable(
        &self,
        springs: &[usize],
        options: AroundOptions,
        is_first: bool,
    ) -> Result<Option<f64>, ReportError> {
        let wanted = if self.last > self.highest { self.highest.max(ABOVE_LAST * self.last) } else { self.highest };
        let Some(middle) = self.modes.get(self.modes.len() / 2) else { return Ok(Some(self.highest)) };
        if is_first && wanted <= self.highest {
            return Ok(Some(self.highest));
        }
        let fits = |frequency: f64| -> Result<bool, ReportError> {
            let n = self.local(middle, springs, frequency, options)?.eigenvalues.len() as f64;
            Ok(self.modes.len() as f64 * n.powi(3) <= MOST_WORK)
        };
        if fits(wanted)? {
            return Ok(Some(wanted));
        }
        if !fits(self.highest)? {
            return Ok(is_first.then_some(self.highest));
        }
        let (mut low, mut high) = (self.highest, wanted);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if fits(middle)? { low = middle } else { high = middle }
        }
        Ok(Some(low))
    }
}
