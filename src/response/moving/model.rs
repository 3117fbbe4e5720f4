//! The machine over the positions of a path.

use super::station::Station;
use crate::coupling::CoupledModel;
use crate::interrupt::Interrupt;
use crate::linalg::{multiply, multiply_transposed};
use crate::machine::Damping;
use crate::modal::{damper_rows, modes_at};
use crate::response::{Path, ResponseError};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// How finely a path is tabulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathOptions {
    /// Distance of the stations, whose modes are known, m.
    pub stations: f64,
    /// Distance of the positions at which the joints' rows are tabulated, m.
    pub spacing: f64,
}

impl Default for PathOptions {
    fn default() -> Self {
        Self { stations: 0.005, spacing: 0.001 }
    }
}

/// Intervals between tabulated positions at most: on longer paths they are further apart.
const MOST_INTERVALS: usize = 3000;
/// The same between stations.
const MOST_STATIONS: usize = 300;
/// Positions that an interpolation takes.
pub(super) const POINTS: usize = 4;

/// The machine at one position over some coordinates.
#[derive(Clone, Debug)]
pub struct LocalModel {
    /// Rows W of the joints, n_spring x n: their share of the stiffness is W^T W.
    pub joints: DMatrix<f64>,
    /// Rows G of the joints' dampers, n_damper x n: the damping between modes is G^T G.
    pub dampers: DMatrix<f64>,
    /// n_output x n.
    pub outputs: DMatrix<f64>,
    /// n_input x n.
    pub inputs: DMatrix<f64>,
    /// Compliance that no coordinate carries, n_output x n_input, m/N.
    pub direct: DMatrix<f64>,
}

impl LocalModel {
    /// The weighted sum of models.
    pub(super) fn sum<'a>(of: impl Iterator<Item = (&'a Self, f64)> + Clone) -> Self {
        let add = |field: fn(&Self) -> &DMatrix<f64>| {
            let mut out = None::<DMatrix<f64>>;
            for (model, weight) in of.clone().filter(|(_, weight)| *weight != 0.0) {
                let matrix = field(model);
                match &mut out {
                    None => out = Some(matrix * weight),
                    Some(sum) => sum.zip_apply(matrix, |a, b| *a += weight * b),
                }
            }
            out.unwrap_or_else(|| DMatrix::zeros(0, 0))
        };
        Self {
            joints: add(|m| &m.joints),
            dampers: add(|m| &m.dampers),
            outputs: add(|m| &m.outputs),
            inputs: add(|m| &m.inputs),
            direct: add(|m| &m.direct),
        }
    }

    /// The same over other coordinates z = Phi q.
    pub(super) fn turned(&self, shapes: &DMatrix<f64>) -> Self {
        Self {
            joints: multiply(&self.joints, shapes),
            dampers: multiply(&self.dampers, shapes),
            outputs: multiply(&self.outputs, shapes),
            inputs: multiply(&self.inputs, shapes),
            direct: self.direct.clone(),
        }
    }
}

/// The machine over the positions of a path.
///
/// # Accuracy
/// Exact at the tabulated positions and cubic in between; [`Self::difference`] measures it.
#[derive(Debug)]
pub struct PathModel {
    /// Of the coordinates without joints, (rad/s)^2.
    eigenvalues: DVector<f64>,
    /// Tabulated positions, ascending, m.
    positions: Vec<f64>,
    table: Vec<LocalModel>,
    stations: Vec<Station>,
}

impl PathModel {
    /// The machine over a path. Wherever the path rests is a station.
    ///
    /// # Errors
    /// [`ResponseError::Coupling`] for a position outside the travel, [`ResponseError::Modal`],
    /// [`ResponseError::Interrupted`].
    pub fn new(
        model: &CoupledModel,
        damping: &Damping,
        path: &Path,
        options: PathOptions,
        interrupt: &Interrupt,
        step: &(dyn Fn() + Sync),
    ) -> Result<Self, ResponseError> {
        let [from, to] = path.range();
        model.check_position(from)?;
        model.check_position(to)?;
        let (positions, stations) = places(path, options);
        let watched = || if interrupt.requested() { Err(ResponseError::Interrupted) } else { Ok(()) };
        let tabulate = |&position: &f64| {
            watched()?;
            let made = local(model, damping, position)?;
            step();
            Ok::<_, ResponseError>(made)
        };
        let table = positions.par_iter().map(tabulate).collect::<Result<Vec<_>, _>>()?;
        let solve = |&at: &usize| {
            watched()?;
            let made = Station::new(at, modes_at(model, damping, positions[at])?);
            step();
            Ok::<_, ResponseError>(made)
        };
        let stations = stations.par_iter().map(solve).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { eigenvalues: model.eigenvalues.clone(), positions, table, stations })
    }

    /// Steps that [`Self::new`] reports.
    pub fn reported_steps(path: &Path, options: PathOptions) -> usize {
        let (positions, stations) = places(path, options);
        positions.len() + stations.len()
    }

    /// Coordinates.
    pub fn n(&self) -> usize {
        self.eigenvalues.len()
    }

    /// Stations.
    pub fn stations(&self) -> usize {
        self.stations.len()
    }

    /// The machine at a position of the path, over the coordinates of the fixed basis.
    pub fn at(&self, position: f64) -> LocalModel {
        LocalModel::sum(self.weights(position).into_iter().map(|(k, weight)| (&self.table[k], weight)))
    }

    /// K at a position of the path, n x n, (rad/s)^2.
    pub fn stiffness(&self, position: f64) -> DMatrix<f64> {
        let joints = self.at(position).joints;
        let mut full = multiply_transposed(&joints, &joints);
        for (k, value) in self.eigenvalues.iter().enumerate() {
            full[(k, k)] += value;
        }
        full
    }

    /// The largest difference of an eigenvalue up to `highest` (Hz) between this model and the machine itself, as a
    /// share of the eigenvalue, in the middle between tabulated positions at some `probes` places of the path.
    ///
    /// To first order it is that of z . K z for the machine's own mode shapes z.
    ///
    /// # Errors
    /// [`ResponseError::Modal`].
    pub fn difference(
        &self,
        model: &CoupledModel,
        damping: &Damping,
        highest: f64,
        probes: usize,
    ) -> Result<f64, ResponseError> {
        let intervals = self.positions.len() - 1;
        let count = probes.min(intervals.max(1));
        let probe = |k: usize| {
            let before = (k * intervals + intervals / 2) / count;
            let after = (before + 1).min(intervals);
            let position = 0.5 * (self.positions[before.min(intervals)] + self.positions[after]);
            let modes = modes_at(model, damping, position)?;
            let own = self.at(position);
            let mut largest = 0.0f64;
            for r in modes.free..modes.count_up_to(highest) {
                let shape = modes.shapes.columns(r, 1).into_owned();
                let parts: f64 = self.eigenvalues.iter().zip(shape.iter()).map(|(l, z)| l * z * z).sum();
                let found = parts + multiply(&own.joints, &shape).norm_squared();
                largest = largest.max((found / modes.eigenvalues[r] - 1.0).abs());
            }
            Ok::<_, ResponseError>(largest)
        };
        let all = (0..count).into_par_iter().map(probe).collect::<Result<Vec<_>, _>>()?;
        Ok(all.into_iter().fold(0.0, f64::max))
    }

    /// The largest rate at which the dampers take motion from the machine, the largest eigenvalue of G G^T over the
    /// tabulated positions, 1/s.
    pub(super) fn strongest_damping(&self) -> f64 {
        let one = |m: &LocalModel| (&m.dampers * m.dampers.transpose()).symmetric_eigenvalues().amax();
        self.table.iter().filter(|m| m.dampers.nrows() > 0).map(one).fold(0.0, f64::max)
    }

    /// The station nearest to a position.
    pub(super) fn station(&self, position: f64) -> usize {
        let place = |k: usize| self.positions[self.stations[k].at];
        let after = self.stations.partition_point(|s| self.positions[s.at] < position).min(self.stations.len() - 1);
        let nearer = after > 0 && position - place(after - 1) < place(after) - position;
        if nearer { after - 1 } else { after }
    }

    /// Where a station is, m.
    pub(super) fn position_of(&self, station: usize) -> f64 {
        self.positions[self.stations[station].at]
    }

    /// A station by its number.
    pub(super) fn of(&self, station: usize) -> &Station {
        &self.stations[station]
    }

    /// The machine at a position, over the modes of a station near it.
    pub(super) fn around(&self, station: usize, position: f64) -> LocalModel {
        let own = &self.stations[station];
        let place = |k: usize| self.stations.get(k).map(|s| s.at);
        let first = station.checked_sub(1).and_then(place).unwrap_or(own.at).saturating_sub(POINTS);
        let last = (place(station + 1).unwrap_or(own.at) + POINTS).min(self.table.len() - 1);
        let turned = own.turned.get_or_init(|| (first..=last).map(|_| std::sync::OnceLock::new()).collect());
        let weights = self.weights(position);
        let at = |k: usize| turned[k - first].get_or_init(|| self.table[k].turned(&own.shapes));
        LocalModel::sum(weights.iter().map(|&(k, weight)| (at(k), weight)))
    }

    /// Lagrange's weights of the tabulated positions around a position; beyond the ends those of the end.
    fn weights(&self, position: f64) -> Vec<(usize, f64)> {
        let n = self.positions.len();
        let position = position.clamp(self.positions[0], self.positions[n - 1]);
        let after = self.positions.partition_point(|p| *p < position);
        let points = POINTS.min(n);
        let first = after.saturating_sub(points / 2).min(n - points);
        let chosen = first..first + points;
        let weight = |k: usize| {
            let p = |o: usize| self.positions[o];
            chosen.clone().filter(|o| *o != k).map(|o| (position - p(o)) / (p(k) - p(o))).product()
        };
        chosen.clone().map(|k| (k, weight(k))).collect()
    }
}

/// The machine at a position over the fixed basis.
fn local(model: &CoupledModel, damping: &Damping, position: f64) -> Result<LocalModel, ResponseError> {
    let at = model.at(position)?;
    let springs = model.springs(position)?;
    let coupled = model.coupled(&at, &springs.stiffness)?;
    // Projected dampers are in the stations' ratios.
    let viscous: &[f64] = if damping.projected { &[] } else { &springs.damping };
    let dampers = damper_rows(&coupled.elongations, viscous);
    Ok(LocalModel {
        joints: model.smooth_roots(&at, &springs.stiffness)?,
        dampers,
        outputs: coupled.outputs,
        inputs: coupled.inputs,
        direct: coupled.direct,
    })
}

/// The tabulated positions of a path, ascending, and which of them are stations.
fn places(path: &Path, options: PathOptions) -> (Vec<f64>, Vec<usize>) {
    let [from, to] = path.range();
    let wanted = ((to - from) / options.spacing).ceil().max(0.0);
    let intervals = if to > from { (wanted as usize).clamp(POINTS, MOST_INTERVALS) } else { 0 };
    let spacing = if intervals > 0 { (to - from) / intervals as f64 } else { 0.0 };
    let rests = path.rests();
    // A tabulated position beside a rest gives way to it.
    let taken = |p: f64| rests.iter().any(|r| (r - p).abs() <= 0.3 * spacing);
    let stride = (options.stations / spacing.max(f64::MIN_POSITIVE)).round().max(1.0);
    let stride = (stride as usize).max(intervals.div_ceil(MOST_STATIONS)).max(1);
    let mut all: Vec<(f64, bool)> = (0..=intervals)
        .map(|k| (if k == intervals { to } else { from + spacing * k as f64 }, k % stride == 0 || k == intervals))
        .filter(|(p, _)| !taken(*p))
        .chain(rests.iter().map(|p| (*p, true)))
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let stations = (0..all.len()).filter(|&k| all[k].1).collect();
    (all.into_iter().map(|(p, _)| p).collect(), stations)
}
