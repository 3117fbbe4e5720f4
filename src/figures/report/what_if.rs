//! What the page computes when a slider moves (`page/machine.js`, `page/sum.js`), in f64 here, and the same sum for the
//! whole model, against which the page is measured.

use super::ReportError;
use super::local::Local;
use crate::coupling::CoupledModel;
use crate::linalg::{LinalgError, multiply, symmetric_eigen};
use crate::machine::Damping;
use crate::modal::ModalError;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// A machine with changed joints at one position as a sum over modes.
pub(super) struct Summed {
    /// Free motions, the first modes.
    pub free: usize,
    /// Ascending, (rad/s)^2.
    pub eigenvalues: Vec<f64>,
    /// Outputs, then dissipating springs, over the modes.
    outputs: DMatrix<f64>,
    /// Inputs, then dissipating springs.
    inputs: DMatrix<f64>,
    /// Static flexibility between these rows that no mode carries, m/N.
    direct: DMatrix<f64>,
    /// What each dissipating spring adds: loss factor times stiffness (N/m), damper (N s/m).
    dissipation: Vec<[f64; 2]>,
}

/// Springs that dissipate: place among the page's springs, loss factor, damper.
pub(super) type Dissipating = [(usize, f64, f64)];

/// A mode that only springs damp has no damping in the sum that they are eliminated from: this loss factor keeps it finite.
const FLOOR: f64 = 1e-9;

impl Summed {
    /// The page's own solution for springs with these factors of stiffness.
    pub fn of_page(
        local: &Local,
        factors: &[f64],
        dissipating: &Dissipating,
        outputs: usize,
        symmetric: bool,
    ) -> Result<Self, LinalgError> {
        let (n, s) = (local.eigenvalues.len(), local.stiffness.len());
        let change: Vec<f64> = factors.iter().zip(&local.stiffness).map(|(factor, k)| (factor - 1.0) * k).collect();
        let changed: Vec<usize> = (0..s).filter(|&k| change[k] != 0.0).collect();
        let v = changed.len();
        let c = local.residual.select_columns(&changed);
        let inner =
            DMatrix::from_fn(v, v, |a, b| change[changed[a]] * c[(changed[a], b)] + f64::from(u8::from(a == b)));
        let changes = DVector::from_iterator(v, changed.iter().map(|&k| change[k]));
        let series = inner.lu().solve(&DMatrix::from_diagonal(&changes)).ok_or(LinalgError::Eigen { n: v })?;
        let series = 0.5 * (&series + series.transpose());
        let forces = multiply(&series, &local.rows.select_rows(&changed));
        let mut stiffness = multiply(&local.rows.select_rows(&changed).transpose(), &forces);
        for (r, l) in local.eigenvalues.iter().enumerate() {
            stiffness[(r, r)] += l;
        }
        let eigen = symmetric_eigen(&(0.5 * (&stiffness + stiffness.transpose())))?;
        let rows = multiply(&(&local.rows - multiply(&c, &forces)), &eigen.vectors);
        let residual = &local.residual - multiply(&c, &multiply(&series, &c.transpose()));
        let first_input = if symmetric { s } else { s + outputs };
        let end = local.rows.nrows();
        let springs = || dissipating.iter().map(|d| d.0);
        let out: Vec<usize> = (s..s + outputs).chain(springs()).collect();
        let into: Vec<usize> = (first_input..end).chain(springs()).collect();
        let mut eigenvalues: Vec<f64> = eigen.values.iter().map(|l| l.max(0.0)).collect();
        eigenvalues[..local.free.min(n)].fill(0.0);
        let loss = |&(k, eta, c): &(usize, f64, f64)| [eta * factors[k] * local.stiffness[k], c];
        Ok(Self {
            free: local.free,
            eigenvalues,
            outputs: rows.select_rows(&out),
            inputs: rows.select_rows(&into),
            direct: residual.select_rows(&out).select_columns(&into),
            dissipation: dissipating.iter().map(loss).collect(),
        })
    }

    /// All modes of the whole model with these stiffnesses of all springs; `places` are the page's springs among them.
    pub fn of_model(
        model: &CoupledModel,
        position: f64,
        stiffness: &[f64],
        places: &[usize],
        dissipating: &Dissipating,
    ) -> Result<Self, ReportError> {
        let at = model.at(position)?;
        let coupled = model.coupled(&at, stiffness)?;
        let eigen = model.eigen(&at, &coupled, stiffness).map_err(|source| ModalError::Eigen { position, source })?;
        let (s, o) = (at.springs.nrows(), at.outputs.nrows());
        let own: Vec<usize> = dissipating.iter().map(|d| places[d.0]).collect();
        let with_springs = |ports: &DMatrix<f64>| {
            let elongations = coupled.elongations.select_rows(&own);
            let all: Vec<_> = ports.row_iter().chain(elongations.row_iter()).collect();
            multiply(&DMatrix::from_rows(&all), &eigen.vectors)
        };
        let direct = if own.is_empty() {
            coupled.direct.clone()
        } else {
            let residual = model.residual_in_place(&at, stiffness)?;
            let rows: Vec<usize> = (s..s + o).chain(own.iter().copied()).collect();
            let columns: Vec<usize> = (s + o..residual.ncols()).chain(own.iter().copied()).collect();
            residual.select_rows(&rows).select_columns(&columns)
        };
        Ok(Self {
            free: eigen.free,
            eigenvalues: eigen.values.iter().copied().collect(),
            outputs: with_springs(&coupled.outputs),
            inputs: with_springs(&coupled.inputs),
            direct,
            dissipation: dissipating.iter().map(|&(k, eta, c)| [eta * stiffness[places[k]], c]).collect(),
        })
    }

    /// Frequency of mode r, Hz.
    pub fn frequency(&self, r: usize) -> f64 {
        self.eigenvalues[r].max(0.0).sqrt() / TAU
    }

    /// The same without what its springs dissipate.
    pub fn without_dissipation(&self) -> Self {
        let springs = self.dissipation.len();
        let (o, i) = (self.outputs.nrows() - springs, self.inputs.nrows() - springs);
        Self {
            free: self.free,
            eigenvalues: self.eigenvalues.clone(),
            outputs: self.outputs.rows(0, o).into_owned(),
            inputs: self.inputs.rows(0, i).into_owned(),
            direct: self.direct.view((0, 0), (o, i)).into_owned(),
            dissipation: Vec::new(),
        }
    }

    /// Receptances between outputs and inputs at a frequency (Hz, above 0), m/N.
    pub fn response(&self, damping: &Damping, frequency: f64) -> DMatrix<Complex<f64>> {
        let omega = TAU * frequency;
        let springs = self.dissipation.len();
        let (rows, columns) = self.direct.shape();
        let (o, i) = (rows - springs, columns - springs);
        let rest = Complex::new(1.0, damping.loss_factor).inv();
        let mut h = self.direct.map(|c| rest * c);
        let coupled = springs > 0 && !damping.projected;
        for (r, &lambda) in self.eigenvalues.iter().enumerate() {
            let own = lambda.sqrt();
            let (mut rate, mut eta) = (0.0, 0.0);
            if r >= self.free {
                let ratio = damping.ratios.get(r - self.free).or(damping.ratios.last()).copied().unwrap_or(0.0);
                rate = 2.0 * ratio * own + damping.rayleigh.map_or(0.0, |[alpha, beta]| alpha + beta * lambda);
                eta = damping.loss_factor;
                for (k, [loss, damper]) in self.dissipation.iter().enumerate().filter(|_| !coupled) {
                    let square = self.outputs[(o + k, r)].powi(2);
                    rate += damper * square;
                    eta += loss * square / lambda;
                }
            }
            if coupled && r >= self.free && rate + eta * own < FLOOR * own {
                eta = FLOOR;
            }
            let g = Complex::new(lambda - omega * omega, eta * lambda + rate * omega).inv();
            let (rows, columns) = if coupled { (rows, columns) } else { (o, i) };
            let (left, right) = (self.outputs.column(r), self.inputs.column(r));
            for (b, right) in right.iter().enumerate().take(columns) {
                let right = g * *right;
                for (h, left) in h.column_mut(b).iter_mut().zip(left.iter()).take(rows) {
                    *h += right * *left;
                }
            }
        }
        if coupled {
            self.eliminate(&mut h, omega);
        }
        h.view((0, 0), (o, i)).into_owned()
    }

    /// H - H_s (1/G + H_ss)^-1 H_s, spring by spring.
    fn eliminate(&self, h: &mut DMatrix<Complex<f64>>, omega: f64) {
        let springs = self.dissipation.len();
        let (o, i) = (h.nrows() - springs, h.ncols() - springs);
        for (k, [loss, damper]) in self.dissipation.iter().enumerate() {
            let g = Complex::new(0.0, loss + damper * omega);
            if g.im == 0.0 {
                continue;
            }
            let inverse = (h[(o + k, i + k)] + g.inv()).inv();
            let (column, row) = (h.column(i + k).into_owned(), h.row(o + k).into_owned());
            *h -= (column * inverse) * row;
        }
    }
}
