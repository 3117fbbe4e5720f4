//! One step of the machine near a station.

use super::mode_table::ModeTable;
use super::model::{LocalModel, PathModel};
use crate::linalg::multiply;
use crate::response::ResponseError;
use nalgebra::{DMatrix, DVector, Dyn, LU};

/// K(p) - K_s over the modes of a station, as M^T E + E^T M with E the change of the joints' rows and M their mean.
pub(super) struct Change {
    mean: DMatrix<f64>,
    change: DMatrix<f64>,
}

/// A row that has changed by less than this share of the strongest row has not.
const UNCHANGED: f64 = 1e-14;

impl Change {
    fn new(at_station: &DMatrix<f64>, joints: &DMatrix<f64>) -> Self {
        let change = joints - at_station;
        let edge = UNCHANGED * at_station.row_iter().map(|row| row.norm()).fold(0.0, f64::max);
        let rows: Vec<usize> = (0..change.nrows()).filter(|&i| change.row(i).norm() > edge).collect();
        let change = change.select_rows(&rows);
        Self { mean: at_station.select_rows(&rows) + &change * 0.5, change }
    }

    /// q . (K - K_s) q.
    pub fn form(&self, q: &DVector<f64>) -> f64 {
        2.0 * (&self.mean * q).dot(&(&self.change * q))
    }

    /// The largest entry of the diagonal of the first so many modes, without its sign.
    pub fn largest_on_diagonal(&self, modes: usize) -> f64 {
        let own = |r: usize| 2.0 * self.mean.column(r).dot(&self.change.column(r));
        (0..modes).map(|r| own(r).abs()).fold(0.0, f64::max)
    }

    /// (K - K_s) q.
    pub fn times(&self, q: &DVector<f64>) -> DVector<f64> {
        self.change.tr_mul(&(&self.mean * q)) + self.mean.tr_mul(&(&self.change * q))
    }
}

/// What a sample needs to know of the machine there.
pub(super) struct AtSample {
    pub stiffness: Change,
    pub outputs: DMatrix<f64>,
    pub direct: DMatrix<f64>,
}

/// State of the modes and works over a step.
pub(super) struct Stepped {
    pub q: DVector<f64>,
    pub v: DVector<f64>,
    /// Work of the forces, J.
    pub force: f64,
    /// Loss of the modes and the dampers, J.
    pub lost: f64,
}

/// A step near one station, with the joints at one position.
///
/// The unknowns are the moments m_j = int z' P_j dt of the rates over the step (P_j Legendre's polynomials), of which
/// m_0 is the change of z. Change and dampers act with the forces
///
/// ```text
/// F_0 = -(K - K_s)(z + m_0 / 2) - G^T G m_0 / h,   F_1 = -3 G^T G m_1 / h,   F_2 = -5 G^T G m_2 / h
/// ```
///
/// the damper's force being that of the rate's best quadratic over the step, which takes sum (2 j + 1)/h |G m_j|^2 from
/// the energy and is of sixth order. Only a few rows of the moments are needed to know these forces.
pub(super) struct Flow<'a> {
    pub station: usize,
    modes: &'a [ModeTable],
    /// The machine in the middle.
    pub middle: Change,
    pub dampers: DMatrix<f64>,
    pub inputs: DMatrix<f64>,
    /// The machine at each of its samples, the first included.
    pub samples: Vec<AtSample>,
    /// [M; E; G], the rows of m_0, 2 c + d; those of m_1 and m_2 are G.
    rows: DMatrix<f64>,
    /// Answer of these rows to forces on them.
    compliance: DMatrix<f64>,
    /// I + compliance H, with H the resistance against the rows' moments.
    factor: LU<f64, Dyn, Dyn>,
    step: f64,
}

impl<'a> Flow<'a> {
    /// Near a station, with the joints in the middle, for samples at the given positions.
    pub fn new(
        model: &PathModel,
        (station, modes): (usize, &'a [ModeTable]),
        middle: f64,
        samples: &[f64],
        step: f64,
    ) -> Result<Self, ResponseError> {
        let around = |position: f64| model.around(station, position);
        let home = around(model.position_of(station)).joints;
        let local = around(middle);
        let change = Change::new(&home, &local.joints);
        let (n, c, d) = (modes.len(), change.change.nrows(), local.dampers.nrows());
        let mut rows = DMatrix::zeros(2 * c + d, n);
        rows.rows_mut(0, c).copy_from(&change.mean);
        rows.rows_mut(c, c).copy_from(&change.change);
        rows.rows_mut(2 * c, d).copy_from(&local.dampers);
        let of = |j: usize| if j == 0 { &rows } else { &local.dampers };
        let firsts = [0, 2 * c + d, 2 * c + 2 * d];
        let all = 2 * c + 3 * d;
        let mut compliance = DMatrix::zeros(all, all);
        for i in 0..3 {
            for j in 0..3 {
                let mut weighted = of(i).clone();
                for (mut column, table) in weighted.column_iter_mut().zip(modes) {
                    column *= table.moments[i][2 + j];
                }
                let block = multiply(&weighted, &of(j).transpose());
                compliance.view_mut((firsts[i], firsts[j]), block.shape()).copy_from(&block);
            }
        }
        // H is symmetric: row k of compliance H is H times row k of compliance.
        let mut system = DMatrix::identity(all, all);
        for k in 0..all {
            let row = resistance(&compliance.row(k).transpose(), (c, d), step);
            system.row_mut(k).zip_apply(&row.transpose(), |a, b| *a += b);
        }
        let factor = system.lu();
        if !factor.is_invertible() {
            return Err(ResponseError::Step { position: middle, step });
        }
        let at = |&position: &f64| {
            let LocalModel { joints, outputs, direct, .. } = around(position);
            AtSample { stiffness: Change::new(&home, &joints), outputs, direct }
        };
        Ok(Self {
            station,
            modes,
            middle: change,
            dampers: local.dampers,
            inputs: local.inputs,
            samples: samples.iter().map(at).collect(),
            rows,
            compliance,
            factor,
            step,
        })
    }

    /// The step from a state under modal forces that are straight over it.
    pub fn advance(
        &self,
        (q, v): (&DVector<f64>, &DVector<f64>),
        (from, to): (&DVector<f64>, &DVector<f64>),
    ) -> Stepped {
        let (n, c, d) = (q.len(), self.middle.change.nrows(), self.dampers.nrows());
        let given: Vec<[f64; 2]> = (0..n).map(|r| [0.5 * (from[r] + to[r]), 0.5 * (to[r] - from[r])]).collect();
        let moment =
            |j: usize, r: usize, force: [f64; 3]| ModeTable::of(&self.modes[r].moments[j], [q[r], v[r]], force);
        let mut forces: Vec<[f64; 3]> = given.iter().map(|f| [f[0], f[1], 0.0]).collect();
        let mut lost = 0.0;
        if self.rows.nrows() > 0 {
            let moments = |j: usize| DVector::from_fn(n, |r, _| moment(j, r, forces[r]));
            let mut right = DVector::zeros(2 * c + 3 * d);
            right.rows_mut(0, 2 * c + d).copy_from(&(&self.rows * moments(0)));
            if d > 0 {
                right.rows_mut(2 * c + d, d).copy_from(&(&self.dampers * moments(1)));
                right.rows_mut(2 * c + 2 * d, d).copy_from(&(&self.dampers * moments(2)));
            }
            // What the change does to the state at the beginning.
            let at_start = self.rows.rows(0, 2 * c) * q;
            let mut known = DVector::zeros(2 * c + 3 * d);
            known.rows_mut(0, c).copy_from(&at_start.rows(c, c));
            known.rows_mut(c, c).copy_from(&at_start.rows(0, c));
            let mut y = right - &self.compliance * &known;
            self.factor.solve_mut(&mut y);
            let resisted = known + resistance(&y, (c, d), self.step);
            let own = self.rows.tr_mul(&resisted.rows(0, 2 * c + d));
            let slopes = self.dampers.tr_mul(&resisted.rows(2 * c + d, d));
            let curves = self.dampers.tr_mul(&resisted.rows(2 * c + 2 * d, d));
            for (r, force) in forces.iter_mut().enumerate() {
                *force = [force[0] - own[r], force[1] - slopes[r], force[2] - curves[r]];
            }
            for j in 0..3 {
                lost += (2 * j + 1) as f64 / self.step * y.rows(2 * c + j * d, d).norm_squared();
            }
        }
        let mut out = Stepped { q: q.clone(), v: v.clone(), force: 0.0, lost };
        for (r, table) in self.modes.iter().enumerate() {
            let change = moment(0, r, forces[r]);
            out.force += given[r][0] * change + given[r][1] * moment(1, r, forces[r]);
            out.lost += table.loss([q[r], v[r]], forces[r]);
            out.q[r] += change;
            out.v[r] = ModeTable::of(&table.rate, [q[r], v[r]], forces[r]);
        }
        out
    }
}

/// H y: how much the change (2 c rows) and the dampers (d rows of each moment) resist moments y of their rows.
fn resistance(y: &DVector<f64>, (c, d): (usize, usize), step: f64) -> DVector<f64> {
    DVector::from_fn(y.len(), |i, _| match i {
        _ if i < c => 0.5 * y[c + i],
        _ if i < 2 * c => 0.5 * y[i - c],
        _ => (2 * ((i - 2 * c) / d) + 1) as f64 / step * y[i],
    })
}
