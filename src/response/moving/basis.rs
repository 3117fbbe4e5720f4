//! A basis that spans the modes of a path, and the machine in it at any position.

use crate::coupling::CoupledModel;
use crate::interrupt::Interrupt;
use crate::linalg::{multiply, multiply_transposed, orthonormal_span, symmetric_eigen, symmetric_eigen_fast};
use crate::machine::Damping;
use crate::modal::{Modes, modes_at};
use crate::response::ResponseError;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// What the path's basis keeps and how finely it is tabulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathOptions {
    /// Modes up to this frequency are spanned at every position, Hz; infinite keeps the whole fixed basis.
    pub band: f64,
    /// Distance of the positions whose modes are spanned, m.
    pub training: f64,
    /// Distance of the positions at which matrices are tabulated, m.
    pub spacing: f64,
    /// Directions below this share of the strongest are left out.
    pub tolerance: f64,
}

impl PathOptions {
    /// For forces up to a frequency (Hz).
    pub fn up_to(frequency: f64) -> Self {
        Self { band: 2.0 * frequency, training: 0.02, spacing: 0.001, tolerance: 3e-3 }
    }
}

/// The machine at one position in the path's basis.
#[derive(Clone, Debug)]
pub struct LocalModel {
    /// n x n, (rad/s)^2.
    pub stiffness: DMatrix<f64>,
    /// n_output x n.
    pub outputs: DMatrix<f64>,
    /// n_input x n.
    pub inputs: DMatrix<f64>,
    /// Compliance that the basis does not carry, n_output x n_input, m/N.
    pub direct: DMatrix<f64>,
}

impl LocalModel {
    fn zeros(like: &Self) -> Self {
        let zero = |m: &DMatrix<f64>| DMatrix::zeros(m.nrows(), m.ncols());
        Self {
            stiffness: zero(&like.stiffness),
            outputs: zero(&like.outputs),
            inputs: zero(&like.inputs),
            direct: zero(&like.direct),
        }
    }

    fn add(&mut self, other: &Self, weight: f64) {
        let add = |a: &mut DMatrix<f64>, b: &DMatrix<f64>| a.zip_apply(b, |a, b| *a += weight * b);
        add(&mut self.stiffness, &other.stiffness);
        add(&mut self.outputs, &other.outputs);
        add(&mut self.inputs, &other.inputs);
        add(&mut self.direct, &other.direct);
    }
}

/// The machine over the positions of a path, in one basis.
///
/// # Accuracy
/// Matrices are exact at the tabulated positions and cubic in between. Of what lies above the band the span
/// has the static compliance and its inertia; its damping is that of the span, which on the bundled mill under
/// 200 Hz is 1e-3 of the peak.
#[derive(Clone, Debug)]
pub struct PathModel {
    first: f64,
    spacing: f64,
    table: Vec<LocalModel>,
    /// Free motions, the same at every position.
    pub(super) free: usize,
    /// Damping ratio by rank of mode at each training position.
    ratios: Vec<(f64, Vec<f64>)>,
}

impl PathModel {
    /// The machine over positions from `range[0]` to `range[1]` (ascending).
    ///
    /// # Errors
    /// [`ResponseError::Coupling`] for a position outside the travel, [`ResponseError::Modal`],
    /// [`ResponseError::Dense`], [`ResponseError::Interrupted`].
    pub fn new(
        model: &CoupledModel,
        damping: &Damping,
        range: [f64; 2],
        options: PathOptions,
        interrupt: &Interrupt,
        step: &(dyn Fn() + Sync),
    ) -> Result<Self, ResponseError> {
        let [from, to] = range;
        model.check_position(from)?;
        model.check_position(to)?;
        let trained = Self::solve(model, damping, &spread(from, to, options.training), interrupt, step)?;
        let basis = span(model, &trained, options)?;
        let direct: Vec<(f64, DMatrix<f64>)> = trained
            .iter()
            .map(|m| Ok((m.position, rest(m, &basis).map_err(|source| dense(m.position, source))?)))
            .collect::<Result<_, ResponseError>>()?;
        let stations = spread(from, to, options.spacing);
        let one = |&position: &f64| {
            if interrupt.requested() {
                return Err(ResponseError::Interrupted);
            }
            let coupled = model.coupled(&model.at(position)?, &model.stiffness(position)?)?;
            // The joints' rows first: a stiff one hardly moves with the basis, and only its square is added.
            let joints = multiply(&coupled.roots, &basis);
            let mut parts = basis.clone();
            scale_rows(&mut parts, model.eigenvalues.iter().map(|l| l.sqrt()));
            let stiffness = multiply_transposed(&parts, &parts) + multiply_transposed(&joints, &joints);
            step();
            Ok(LocalModel {
                stiffness: 0.5 * (&stiffness + stiffness.transpose()),
                outputs: multiply(&coupled.outputs, &basis),
                inputs: multiply(&coupled.inputs, &basis),
                direct: between(&direct, position),
            })
        };
        let table = stations.par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
        let spacing = if stations.len() > 1 { stations[1] - stations[0] } else { 1.0 };
        let ratios = trained
            .iter()
            .map(|m| {
                let all = m.damping_ratios.iter().zip(&m.loss_factors).skip(m.free);
                (m.position, all.map(|(zeta, eta)| zeta + 0.5 * eta).collect())
            })
            .collect();
        let free = trained.iter().map(|m| m.free).min().unwrap_or(0);
        Ok(Self { first: from, spacing, table, free, ratios })
    }

    /// Steps that [`Self::new`] reports for a range.
    pub fn reported_steps(range: [f64; 2], options: PathOptions) -> usize {
        spread(range[0], range[1], options.training).len() + spread(range[0], range[1], options.spacing).len()
    }

    fn solve(
        model: &CoupledModel,
        damping: &Damping,
        positions: &[f64],
        interrupt: &Interrupt,
        step: &(dyn Fn() + Sync),
    ) -> Result<Vec<Modes>, ResponseError> {
        let one = |&position: &f64| {
            if interrupt.requested() {
                return Err(ResponseError::Interrupted);
            }
            let modes = modes_at(model, damping, position)?;
            step();
            Ok(modes)
        };
        positions.par_iter().map(one).collect()
    }

    /// Coordinates of the basis.
    pub fn n(&self) -> usize {
        self.table[0].stiffness.nrows()
    }

    /// The machine at a position of the path.
    pub fn at(&self, position: f64) -> LocalModel {
        let mut out = LocalModel::zeros(&self.table[0]);
        for (k, weight) in self.weights(position) {
            out.add(&self.table[k], weight);
        }
        out
    }

    /// The stiffness alone, into a matrix that is there already.
    pub(super) fn stiffness_into(&self, position: f64, out: &mut DMatrix<f64>) {
        let weights = self.weights(position);
        let Ok([a, b, c, d]) = <[(usize, f64); 4]>::try_from(weights.as_slice()) else {
            *out = self.at(position).stiffness;
            return;
        };
        let table = |k: usize| self.table[k].stiffness.as_slice();
        let first = table(a.0).iter().zip(table(b.0)).map(|(x, y)| a.1 * x + b.1 * y);
        let second = table(c.0).iter().zip(table(d.0)).map(|(x, y)| c.1 * x + d.1 * y);
        out.as_mut_slice().iter_mut().zip(first.zip(second)).for_each(|(out, (x, y))| *out = x + y);
    }

    /// Output rows and direct compliance alone.
    pub(super) fn at_ports(&self, position: f64) -> (DMatrix<f64>, DMatrix<f64>) {
        let like = &self.table[0];
        let mut outputs = DMatrix::zeros(like.outputs.nrows(), like.outputs.ncols());
        let mut direct = DMatrix::zeros(like.direct.nrows(), like.direct.ncols());
        for (k, weight) in self.weights(position) {
            outputs.zip_apply(&self.table[k].outputs, |a, b| *a += weight * b);
            direct.zip_apply(&self.table[k].direct, |a, b| *a += weight * b);
        }
        (outputs, direct)
    }

    /// Lagrange's weights of the four tabulated positions around a position.
    fn weights(&self, position: f64) -> Vec<(usize, f64)> {
        let n = self.table.len();
        if n < 4 {
            let at = |k: usize| self.first + self.spacing * k as f64;
            let product = |k: usize| (0..n).filter(|o| *o != k).map(|o| (position - at(o)) / (at(k) - at(o))).product();
            return (0..n).map(|k| (k, product(k))).collect();
        }
        let s = ((position - self.first) / self.spacing).clamp(0.0, (n - 1) as f64);
        let base = (s.floor() as usize).clamp(1, n - 3) - 1;
        let x = s - base as f64;
        let weights = [
            -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0,
            x * (x - 2.0) * (x - 3.0) / 2.0,
            -x * (x - 1.0) * (x - 3.0) / 2.0,
            x * (x - 1.0) * (x - 2.0) / 6.0,
        ];
        weights.into_iter().enumerate().map(|(k, w)| (base + k, w)).collect()
    }

    /// Damping ratio of the elastic mode of a rank at a position; linear between training positions.
    pub(super) fn ratios(&self, position: f64, n: usize) -> Vec<f64> {
        let after = self.ratios.partition_point(|(p, _)| *p <= position);
        let before = &self.ratios[after.saturating_sub(1)];
        let after = self.ratios.get(after).unwrap_or(before);
        let apart = after.0 - before.0;
        let share = if apart > 0.0 { ((position - before.0) / apart).clamp(0.0, 1.0) } else { 0.0 };
        let of = |list: &[f64], r: usize| list.get(r).or(list.last()).copied().unwrap_or(0.0);
        (0..n).map(|r| (1.0 - share) * of(&before.1, r) + share * of(&after.1, r)).collect()
    }
}

fn dense(position: f64, source: crate::linalg::LinalgError) -> ResponseError {
    ResponseError::Dense { position, source }
}

/// Positions from one to the other, at most `apart` from each other and evenly spread.
fn spread(from: f64, to: f64, apart: f64) -> Vec<f64> {
    let intervals = ((to - from) / apart).ceil().max(0.0) as usize;
    (0..=intervals).map(|k| if k == 0 { from } else { from + (to - from) * k as f64 / intervals as f64 }).collect()
}

/// Linear between the two neighbours of a position in a list.
fn between(list: &[(f64, DMatrix<f64>)], position: f64) -> DMatrix<f64> {
    let after = list.partition_point(|(p, _)| *p <= position);
    let before = &list[after.saturating_sub(1)];
    let after = list.get(after).unwrap_or(before);
    let apart = after.0 - before.0;
    let share = if apart > 0.0 { ((position - before.0) / apart).clamp(0.0, 1.0) } else { 0.0 };
    &before.1 * (1.0 - share) + &after.1 * share
}

/// Orthonormal span of the modes up to the band, and of the static rest, at all training positions.
///
/// What may be cut is measured with M + K / omega_b^2 of the middle position: a direction with little motion
/// may still be stiff, and a mode without its small stiff part is too stiff by far.
fn span(model: &CoupledModel, trained: &[Modes], options: PathOptions) -> Result<DMatrix<f64>, ResponseError> {
    let n = model.n();
    let limit = (TAU * options.band).powi(2);
    let kept = |m: &Modes| m.eigenvalues.iter().take_while(|l| **l <= limit).count().max(m.free);
    if trained.iter().any(|m| kept(m) == n) {
        return Ok(DMatrix::identity(n, n));
    }
    let middle = &trained[trained.len() / 2];
    let weights: Vec<f64> = middle.eigenvalues.iter().map(|l| (1.0 + l / limit).sqrt()).collect();
    let mut gram = DMatrix::zeros(n, n);
    for modes in trained {
        let shapes = modes.shapes.columns(0, kept(modes)).into_owned();
        for columns in [shapes, static_rest(modes, kept(modes))] {
            let mut weighted = multiply_transposed(&middle.shapes, &columns);
            scale_rows(&mut weighted, weights.iter().copied());
            for mut column in weighted.column_iter_mut() {
                let length = column.norm();
                if length > 0.0 {
                    column /= length;
                }
            }
            gram += multiply(&weighted, &weighted.transpose());
        }
    }
    let failed = |source| dense(middle.position, source);
    let eigen = symmetric_eigen_fast(&gram).map_err(failed)?;
    let edge = options.tolerance.powi(2) * eigen.values.amax();
    let strong: Vec<usize> = (0..n).filter(|k| eigen.values[*k] > edge).collect();
    let mut directions = eigen.vectors.select_columns(&strong);
    scale_rows(&mut directions, weights.iter().map(|w| w.recip()));
    orthonormal_span(&multiply(&middle.shapes, &directions), 1e-12).map_err(failed)
}

fn scale_rows(m: &mut DMatrix<f64>, factors: impl Iterator<Item = f64>) {
    for (mut row, factor) in m.row_iter_mut().zip(factors) {
        row *= factor;
    }
}

/// Static responses to the ports' forces of the modes above the kept ones: with them in the span, the
/// inertia of the rest needs no further modes.
fn static_rest(modes: &Modes, kept: usize) -> DMatrix<f64> {
    let n = modes.eigenvalues.len();
    let ports = modes.outputs.nrows() + modes.inputs.nrows();
    let row = |i: usize, r: usize| {
        let shape = if i < modes.outputs.nrows() {
            modes.outputs[(i, r)]
        } else {
            modes.inputs[(i - modes.outputs.nrows(), r)]
        };
        shape / modes.eigenvalues[r]
    };
    let amplitudes = DMatrix::from_fn(n - kept, ports, |r, i| row(i, kept + r));
    multiply(&modes.shapes.columns(kept, n - kept).into_owned(), &amplitudes)
}

/// Static compliance of the elastic modes that a basis leaves out, with what no mode carries.
fn rest(modes: &Modes, basis: &DMatrix<f64>) -> Result<DMatrix<f64>, crate::linalg::LinalgError> {
    let mut direct = modes.direct.clone();
    let n = modes.eigenvalues.len();
    if basis.ncols() == n {
        return Ok(direct);
    }
    let elastic = modes.free..n;
    for r in elastic {
        direct += modes.outputs.column(r) * modes.inputs.column(r).transpose() / modes.eigenvalues[r];
    }
    // The same in the basis: its modes from V^T K V with K = Phi diag(lambda) Phi^T.
    let mut turned = multiply_transposed(&modes.shapes, basis);
    let ports = |rows: &DMatrix<f64>| multiply(rows, &turned);
    let (outputs, inputs) = (ports(&modes.outputs), ports(&modes.inputs));
    scale_rows(&mut turned, modes.eigenvalues.iter().map(|l| l.sqrt()));
    let own = symmetric_eigen(&multiply_transposed(&turned, &turned))?;
    let (outputs, inputs) = (multiply(&outputs, &own.vectors), multiply(&inputs, &own.vectors));
    for r in modes.free..own.values.len() {
        direct -= outputs.column(r) * inputs.column(r).transpose() / own.values[r];
    }
    Ok(direct)
}
