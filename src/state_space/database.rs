//! A database of state spaces over the travel: selection by the paper's ceiling rule, interpolation by
//! aligned subspaces.
//!
//! Modes cross and veer, so no single mode is a smooth function of the position; the subspace that many
//! modes span together is. The modes of each position are therefore turned by the orthogonal matrix that
//! brings them nearest to those of the position before (Procrustes: the polar factor of the overlap
//! Phi_k^T Phi_(k+1), M = I). In these aligned coordinates stiffness, damping, inputs and outputs are
//! smooth, and their entries may be interpolated one by one; the modes in between come from the
//! eigenproblem of the interpolated stiffness. Some modes more than asked for are carried along, so that
//! a mode that leaves or enters the subspace at its upper end does not reach those that are asked for.
//!
//! Source: Amsallem and Farhat, An online method for interpolating linear parametric reduced-order
//! models, SIAM J. Sci. Comput. 33 (2011); the alignment between neighbours along a path is ours.

use super::assemble::assemble;
use super::damped_sum::DampedSum;
use super::{StateSpace, StateSpaceError, StateSpaceOptions, state_space};
use crate::linalg::{multiply_transposed, symmetric_eigen};
use crate::modal::Modes;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// The machine at one position in coordinates that are smooth over the positions.
#[derive(Clone, Debug)]
pub struct Aligned {
    /// Position, m.
    pub position: f64,
    /// n x n, (rad/s)^2; M = I.
    pub stiffness: DMatrix<f64>,
    /// n x n, 1/s.
    pub damping: DMatrix<f64>,
    /// n x n_input, kg^(-1/2).
    pub inputs: DMatrix<f64>,
    /// n_output x n, kg^(-1/2).
    pub outputs: DMatrix<f64>,
    /// Compliance of all elastic modes and the rest at 0 Hz, n_output x n_input, m/N.
    pub compliance: DMatrix<f64>,
}

/// State spaces over the travel.
#[derive(Clone, Debug)]
pub struct Database {
    /// One a position, in the order of the positions.
    pub states: Vec<StateSpace>,
    /// The same positions in aligned coordinates.
    pub aligned: Vec<Aligned>,
    /// Largest difference of the receptance matrix at each position when it is interpolated from the
    /// others, as a share of its peak (Frobenius norm, 0 Hz to the last mode); infinite where the interpolated stiffness
    /// is not positive, `None` at the ends.
    pub leave_one_out: Vec<Option<f64>>,
    /// What the states are.
    pub options: StateSpaceOptions,
    /// Free motions among the aligned coordinates: all, if a port feels one, or none.
    pub free: usize,
}

/// Modes beyond those asked for that the aligned coordinates may carry.
const MARGIN: std::ops::RangeInclusive<usize> = 4..=16;
/// Positions that take part in an interpolation.
const POINTS: usize = 8;
/// How much rougher than the smoothest window the centred one must be to be given up.
const KINK: f64 = 20.0;

impl Database {
    /// A database of the positions' modes, which must be in the order of the positions.
    ///
    /// # Errors
    /// [`StateSpaceError`] if there is no position, or they neither ascend nor descend.
    pub fn new(modes: &[Modes], options: StateSpaceOptions) -> Result<Self, StateSpaceError> {
        let positions: Vec<f64> = modes.iter().map(|m| m.position).collect();
        if positions.is_empty() {
            return Err(StateSpaceError::NoPositions);
        }
        let descends = positions.len() > 1 && positions[1] < positions[0];
        if let Some(at) = positions.windows(2).position(|p| p[0] == p[1] || (p[1] < p[0]) != descends) {
            return Err(StateSpaceError::Order { position: positions[at + 1], previous: positions[at] });
        }
        let n = modes.iter().map(|m| m.eigenvalues.len() - m.free).min().unwrap_or(0);
        let carried = carried_modes(modes, options.modes, n);
        let states = modes.iter().map(|m| state_space(m, options)).collect();
        let felt = modes.iter().any(|m| (0..m.free).any(|r| m.is_felt(r)));
        let free = if felt { modes.iter().map(|m| m.free).max().unwrap_or(0) } else { 0 };
        let aligned = align(modes, carried, felt)?;
        let mut database = Self { states, aligned, leave_one_out: Vec::new(), options, free };
        let loo = |k: usize| {
            let inside = k > 0 && k + 1 < positions.len() && positions.len() > 2;
            if !inside {
                return Ok(None);
            }
            match database.interpolate_without(positions[k], Some(k)) {
                Ok(found) => Ok(Some(receptance_difference(&found, &database.states[k]))),
                // The stations are too far apart to interpolate there: the database stands, and the figure says so.
                Err(StateSpaceError::Negative { .. }) => Ok(Some(f64::INFINITY)),
                Err(error) => Err(error),
            }
        };
        let figures = (0..positions.len()).into_par_iter().map(loo).collect::<Result<_, _>>()?;
        database.leave_one_out = figures;
        Ok(database)
    }

    /// The largest leave-one-out figure.
    pub fn worst_leave_one_out(&self) -> Option<f64> {
        self.leave_one_out.iter().flatten().copied().reduce(f64::max)
    }

    /// The paper's ceiling rule: the first position of the database at or beyond `position`, in the
    /// order of the database; stepped in between.
    ///
    /// # Errors
    /// [`StateSpaceError::Outside`].
    pub fn select(&self, position: f64) -> Result<&StateSpace, StateSpaceError> {
        self.check(position)?;
        let (first, last) = self.ends();
        let along = |p: f64| if last < first { -p } else { p };
        let slack = 1e-9 * (last - first).abs();
        let found = self.states.iter().find(|s| along(s.position) >= along(position) - slack);
        Ok(found.unwrap_or(&self.states[self.states.len() - 1]))
    }

    /// The system at any position between the first and the last, by aligned subspaces.
    ///
    /// Eight positions around it on the smoothest side, entries by Lagrange's polynomial, the modes asked for from the eigenproblem
    /// of the interpolated stiffness, and D so that the compliance at 0 Hz is the interpolated one.
    ///
    /// # Errors
    /// [`StateSpaceError::Outside`]; [`StateSpaceError::Eigen`] if the interpolated stiffness is not
    /// finite, [`StateSpaceError::Negative`] if it is not positive: the stations are too far apart.
    ///
    /// # Accuracy
    /// Stored with the database as [`Self::leave_one_out`], which has twice the spacing around it.
    pub fn interpolate(&self, position: f64) -> Result<StateSpace, StateSpaceError> {
        self.check(position)?;
        self.interpolate_without(position, None)
    }

    fn ends(&self) -> (f64, f64) {
        (self.states[0].position, self.states[self.states.len() - 1].position)
    }

    fn check(&self, position: f64) -> Result<(), StateSpaceError> {
        let (first, last) = self.ends();
        let slack = 1e-9 * (last - first).abs().max(1e-3);
        if position.is_finite() && position >= first.min(last) - slack && position <= first.max(last) + slack {
            return Ok(());
        }
        Err(StateSpaceError::Outside { position, first, last })
    }

    fn interpolate_without(&self, position: f64, left_out: Option<usize>) -> Result<StateSpace, StateSpaceError> {
        let near = self.stencil(position, left_out);
        let at = |k: usize| self.aligned[k].position;
        let weights: Vec<f64> = near
            .iter()
            .map(|&k| near.iter().filter(|o| **o != k).map(|&o| (position - at(o)) / (at(k) - at(o))).product())
            .collect();
        let blend = |of: fn(&Aligned) -> &DMatrix<f64>| {
            let parts = near.iter().zip(&weights).map(|(&k, w)| of(&self.aligned[k]) * *w);
            parts.reduce(|a, b| a + b).unwrap_or_else(|| DMatrix::zeros(0, 0))
        };
        let stiffness = blend(|a| &a.stiffness);
        let eigen = symmetric_eigen(&(0.5 * (&stiffness + stiffness.transpose())))
            .map_err(|source| StateSpaceError::Eigen { position, source })?;
        let free = self.free;
        let values: Vec<f64> = eigen.values.iter().enumerate().map(|(r, l)| if r < free { 0.0 } else { *l }).collect();
        if let Some(&eigenvalue) = values[free.min(values.len())..].iter().find(|l| **l <= 0.0) {
            return Err(StateSpaceError::Negative { position, eigenvalue });
        }
        let damping = multiply_transposed(&eigen.vectors, &(blend(|a| &a.damping) * &eigen.vectors));
        let ratio = |r: usize| if r < free { 0.0 } else { damping[(r, r)] / (2.0 * values[r].sqrt()) };
        let outputs = blend(|a| &a.outputs) * &eigen.vectors;
        let inputs = blend(|a| &a.inputs).transpose() * &eigen.vectors;
        let mut direct = blend(|a| &a.compliance);
        for (r, value) in values.iter().enumerate().skip(free) {
            direct -= outputs.column(r) * inputs.column(r).transpose() / *value;
        }
        let modes = Modes {
            position,
            free,
            damping_ratios: (0..values.len()).map(ratio).collect(),
            loss_factors: vec![0.0; values.len()],
            dissipation: None,
            shapes: eigen.vectors,
            eigenvalues: values,
            outputs,
            inputs,
            direct,
            direct_loss_factor: 0.0,
        };
        // The whole of C as rows of dampers, where it has terms between the modes.
        let coupled = self.states.iter().any(|s| s.dampers.nrows() > 0);
        let rows = if coupled { rows_of(&damping, position)? } else { DMatrix::zeros(0, modes.eigenvalues.len()) };
        Ok(assemble(&modes, &rows, self.options))
    }
}

impl Database {
    /// The positions that take part at a position: of the windows around it the one over which the
    /// compliance at 0 Hz is smoothest, so that a place where the machine is not smooth (a carriage that
    /// begins to leave its rail) is not interpolated across.
    fn stencil(&self, position: f64, left_out: Option<usize>) -> Vec<usize> {
        let all: Vec<usize> = (0..self.aligned.len()).filter(|k| Some(*k) != left_out).collect();
        if all.len() <= POINTS {
            return all;
        }
        let (first, last) = self.ends();
        let along = |p: f64| if last < first { -p } else { p };
        let after = all.iter().position(|&k| along(self.aligned[k].position) >= along(position));
        let interval = after.unwrap_or(all.len() - 1).clamp(1, all.len() - 1) - 1;
        let starts = (interval + 2).saturating_sub(POINTS)..=interval.min(all.len() - POINTS);
        let rough = |start: &usize| {
            let window = &all[*start..*start + POINTS];
            let at = |k: usize| self.aligned[k].position;
            // Highest divided difference.
            let weight = |k: usize| window.iter().filter(|o| **o != k).map(|&o| 1.0 / (at(k) - at(o))).product::<f64>();
            let parts = window.iter().map(|&k| &self.aligned[k].compliance * weight(k));
            parts.reduce(|a, b| a + b).map_or(0.0, |m| m.norm())
        };
        let centred = (interval + 1).saturating_sub(POINTS / 2).min(all.len() - POINTS);
        let smoothest = starts.min_by(|a, b| rough(a).total_cmp(&rough(b))).unwrap_or(centred);
        // A window aside extrapolates more: it must be worth it.
        let start = if rough(&centred) > KINK * rough(&smoothest) { smoothest } else { centred };
        all[start..start + POINTS].to_vec()
    }
}

/// How many elastic modes to carry: within the margin, where the gap above the last one is widest over
/// all positions.
fn carried_modes(modes: &[Modes], asked: usize, most: usize) -> usize {
    let gap = |n: usize| {
        let one = |m: &Modes| m.eigenvalues.get(m.free + n).map_or(1.0, |above| above / m.eigenvalues[m.free + n - 1]);
        modes.iter().map(one).fold(f64::INFINITY, f64::min)
    };
    let candidates = (*MARGIN.start()..=*MARGIN.end()).map(|extra| asked + extra).filter(|n| *n < most && *n > 0);
    candidates.max_by(|a, b| gap(*a).total_cmp(&gap(*b))).unwrap_or(most.min(asked.max(1)))
}

/// Turns the modes of each position to those of the one before.
fn align(modes: &[Modes], carried: usize, felt: bool) -> Result<Vec<Aligned>, StateSpaceError> {
    let mut out = Vec::with_capacity(modes.len());
    let mut turned: Option<DMatrix<f64>> = None;
    for m in modes {
        let first = if felt { 0 } else { m.free };
        let kept: Vec<usize> = (first..(m.free + carried).min(m.eigenvalues.len())).collect();
        let shapes = m.shapes.select_columns(&kept);
        let turn = match &turned {
            None => DMatrix::identity(kept.len(), kept.len()),
            Some(before) => nearest_turn(&multiply_transposed(before, &shapes), m.position)?,
        };
        // Rows of `turn` are aligned coordinates, columns are modes.
        let scaled = |value: &dyn Fn(usize) -> f64| {
            let mut columns = turn.clone();
            for (k, mut column) in columns.column_iter_mut().enumerate() {
                column *= value(kept[k]);
            }
            columns * turn.transpose()
        };
        let viscous = m.viscous();
        let rate = |r: usize| 2.0 * viscous.ratios[r] * m.eigenvalues[r].sqrt();
        let dampers = viscous.dampers.select_columns(&kept) * turn.transpose();
        let mut compliance = m.direct.clone();
        for r in m.free..m.eigenvalues.len() {
            compliance += m.outputs.column(r) * m.inputs.column(r).transpose() / m.eigenvalues[r];
        }
        out.push(Aligned {
            position: m.position,
            stiffness: scaled(&|r| m.eigenvalues[r]),
            damping: scaled(&rate) + dampers.tr_mul(&dampers),
            inputs: &turn * m.inputs.select_columns(&kept).transpose(),
            outputs: m.outputs.select_columns(&kept) * turn.transpose(),
            compliance,
        });
        turned = Some(shapes * turn.transpose());
    }
    Ok(out)
}

/// Rows G with G^T G = C, for a damping that interpolation may have left a rounding below zero.
fn rows_of(damping: &DMatrix<f64>, position: f64) -> Result<DMatrix<f64>, StateSpaceError> {
    let symmetric = 0.5 * (damping + damping.transpose());
    let eigen = symmetric_eigen(&symmetric).map_err(|source| StateSpaceError::Eigen { position, source })?;
    let mut rows = eigen.vectors.transpose();
    for (mut row, value) in rows.row_iter_mut().zip(eigen.values.iter()) {
        row *= value.max(0.0).sqrt();
    }
    Ok(rows)
}

/// The orthogonal matrix nearest to an overlap (its polar factor).
fn nearest_turn(overlap: &DMatrix<f64>, position: f64) -> Result<DMatrix<f64>, StateSpaceError> {
    let svd = overlap.clone().svd(true, true);
    match (svd.u, svd.v_t) {
        (Some(u), Some(v)) if u.iter().chain(v.iter()).all(|x| x.is_finite()) => Ok(u * v),
        _ => Err(StateSpaceError::Alignment { position }),
    }
}

/// Frequencies at which two systems are compared.
const PROBES: usize = 400;
/// The same where dampers couple the modes, each of which costs more.
const FEW_PROBES: usize = 60;

/// Largest difference of the receptance matrices of two modal state spaces as a share of the second's
/// peak (Frobenius norms), at 400 frequencies (60 where dampers couple the modes) from 0 Hz to the second's last mode
/// and at its own modes.
pub fn receptance_difference(a: &StateSpace, b: &StateSpace) -> f64 {
    let last = b.eigenvalues.iter().copied().fold(0.0, f64::max).sqrt() / TAU;
    let probes = if b.dampers.nrows() > 0 { FEW_PROBES } else { PROBES };
    let grid = (1..=probes).map(|k| last * k as f64 / probes as f64);
    let own = b.eigenvalues.iter().filter(|l| **l > 0.0).map(|l| l.sqrt() / TAU);
    let (mut largest, mut peak) = (0.0f64, 0.0f64);
    for frequency in grid.chain(own) {
        let (x, y) = (receptance(a, frequency), receptance(b, frequency));
        largest = largest.max((&x - &y).norm());
        peak = peak.max(y.norm());
    }
    largest / peak
}

/// C (j omega I - A)^-1 B + D of the displacement rows of a modal state space.
pub fn receptance(system: &StateSpace, frequency: f64) -> DMatrix<Complex<f64>> {
    let o = system.eigenvectors.ncols();
    let n = system.eigenvalues.len();
    let direct = system.d.rows(0, o).into_owned();
    let omega: Vec<f64> = system.eigenvalues.iter().map(|l| l.sqrt()).collect();
    let sum = DampedSum {
        omega: &omega,
        zeta: &system.own_damping(),
        outputs: &system.eigenvectors.transpose(),
        inputs: &system.b.rows(n, n).transpose(),
        dampers: &system.dampers,
    };
    sum.at(frequency) + direct.map(|v| Complex::new(v, 0.0))
}
