//! H by one complex solve of all superelement coordinates: the damped equations themselves, without modes.

use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use nalgebra::{Complex, DMatrix, SymmetricEigen};
use std::f64::consts::TAU;
use stiffmap::coupling::{CoupledModel, PortRow};
use stiffmap::machine::Machine;

/// K + j omega C + j L - omega^2 of a machine at a position, in coordinates of unit mass.
pub struct Direct {
    stiffness: DMatrix<f64>,
    /// What dissipates: loss (N/m) and viscous (N s/m) matrices.
    loss: DMatrix<f64>,
    viscous: DMatrix<f64>,
    outputs: DMatrix<f64>,
    inputs: DMatrix<f64>,
    /// Undamped eigenfrequencies, Hz, ascending.
    pub eigenfrequencies: Vec<f64>,
}

impl Direct {
    /// The equations of a machine that is coupled from its superelements.
    pub fn new(machine: &Machine, model: &CoupledModel, position: f64) -> Self {
        let side = &model.side_by_side;
        let n = side.n();
        let rows = side.rows(position).expect("rows");
        let springs = model.springs(position).expect("springs");
        let stiffness = side.coupled_stiffness(position).expect("coupled");
        let diagonal = |of: &dyn Fn(usize) -> f64| {
            DMatrix::from_fn(springs.stiffness.len(), springs.stiffness.len(), |a, b| if a == b { of(a) } else { 0.0 })
        };
        let joints = diagonal(&|s| springs.stiffness[s] * springs.loss_factors[s]);
        let damping = &machine.analysis.damping;
        let mut loss = rows.transpose() * joints * &rows + &stiffness * damping.loss_factor;
        for (p, part) in machine.parts.iter().enumerate() {
            let end = side.first_column.get(p + 1).copied().unwrap_or(n);
            for k in side.first_column[p]..end {
                loss[(k, k)] += part.loss_factor.unwrap_or(0.0) * side.eigenvalues[k];
            }
        }
        // A ratio of all modes, and Rayleigh damping, belong to the undamped modes of this machine.
        let modes = SymmetricEigen::new(stiffness.clone());
        let [alpha, beta] = damping.rayleigh.unwrap_or_default();
        let ratio = damping.ratios.first().copied().unwrap_or(0.0);
        let rate = |l: f64| 2.0 * ratio * l.max(0.0).sqrt() + alpha + beta * l;
        let v = &modes.eigenvectors;
        let viscous = rows.transpose() * diagonal(&|s| springs.damping[s]) * &rows
            + v * DMatrix::from_diagonal(&modes.eigenvalues.map(rate)) * v.transpose();
        let ports = |list: &[PortRow]| DMatrix::from_rows(&list.iter().map(|p| p.row.clone()).collect::<Vec<_>>());
        let (outputs, inputs) = (ports(&side.outputs), ports(&side.inputs));
        let mut eigenfrequencies: Vec<f64> = modes.eigenvalues.iter().map(|l| l.max(0.0).sqrt() / TAU).collect();
        eigenfrequencies.sort_by(f64::total_cmp);
        Self { stiffness, loss, viscous, outputs, inputs, eigenfrequencies }
    }

    /// H at a frequency (Hz), outputs by inputs.
    pub fn at(&self, frequency: f64) -> DMatrix<Complex<f64>> {
        let omega = TAU * frequency;
        let n = self.stiffness.nrows();
        let z = Mat::from_fn(n, n, |a, b| {
            let own = if a == b { omega * omega } else { 0.0 };
            c64::new(self.stiffness[(a, b)] - own, self.loss[(a, b)] + omega * self.viscous[(a, b)])
        });
        let forces = Mat::from_fn(n, self.inputs.nrows(), |k, i| c64::new(self.inputs[(i, k)], 0.0));
        let motion = z.partial_piv_lu().solve(&forces);
        let motion =
            DMatrix::from_fn(n, self.inputs.nrows(), |k, i| Complex::new(motion[(k, i)].re, motion[(k, i)].im));
        self.outputs.map(|x| Complex::new(x, 0.0)) * motion
    }

    /// What stands still under a constant force, m/N, without damping: outputs by inputs.
    pub fn still(&self) -> DMatrix<f64> {
        &self.outputs * self.stiffness.clone().lu().solve(&self.inputs.transpose()).expect("a machine that stands")
    }
}
