//! Damping that couples the modes: dampers and loss factors of single joints and parts.
//!
//! The undamped modes diagonalise mass and stiffness, and a ratio, Rayleigh's damping and a loss factor of the whole
//! machine with them. A damper between two parts, or a loss factor of one joint or part, has terms between different
//! modes as well. Two ways to deal with them:
//!
//! - **projected**: the terms between different modes are left out, and each mode has a ratio and a loss factor of its
//!   own ([`super::Modes::damping_ratios`], [`super::Modes::loss_factors`]);
//! - **exact**: what [`Dissipation`] holds goes into the sum of the responses ([`crate::frf::ExactDamping`]).

use crate::coupling::SpringValues;
use crate::machine::Damping;
use nalgebra::{Complex, DMatrix};

/// What couples the modes of one position, and the damping without it.
#[derive(Clone, Debug)]
pub struct Dissipation {
    /// Elongations of the springs that dissipate, n_springs x n, kg^(-1/2).
    pub springs: DMatrix<f64>,
    /// Static compliance that no mode carries between outputs, then these springs, and inputs, then these springs, m/N.
    pub direct: DMatrix<f64>,
    /// Damper of each spring, N s/m or N m s/rad.
    pub viscous: Vec<f64>,
    /// Loss factor times stiffness of each spring, N/m or N m/rad.
    pub structural: Vec<f64>,
    /// Parts with a loss factor.
    pub parts: Option<PartLosses>,
    /// Viscous ratio of each mode by what couples no modes.
    pub damping_ratios: Vec<f64>,
    /// Loss factor of each mode by what couples no modes; with it the own terms of parts where [`Self::parts`] ends.
    pub loss_factors: Vec<f64>,
}

impl Dissipation {
    /// Loss factor of mode r, of eigenvalue (rad/s)^2, with the own term of the parts but without springs.
    pub fn loss_factor(&self, r: usize, eigenvalue: f64) -> f64 {
        let own = self.parts.as_ref().map(|p| &p.between_modes).filter(|p| r < p.nrows() && eigenvalue > 0.0);
        self.loss_factors[r] + own.map_or(0.0, |p| p[(r, r)].im / eigenvalue)
    }
}

/// What the parts with a loss factor add to the stiffness, j sum of eta_p K_p, between the modes of the lowest
/// frequencies; the modes beyond and what no mode carries answer statically.
#[derive(Clone, Debug)]
pub struct PartLosses {
    /// Between modes, m x m, (rad/s)^2.
    pub between_modes: DMatrix<Complex<f64>>,
    /// What it takes from the modes' shapes at outputs, then springs: the static answer to it, x m, kg^(-1/2).
    pub outputs: DMatrix<Complex<f64>>,
    /// The same at inputs, then springs.
    pub inputs: DMatrix<Complex<f64>>,
    /// Sum of eta_p K_p between the static responses to unit loads, as [`Dissipation::direct`], m/N.
    pub direct: DMatrix<f64>,
}

/// Viscous ratios and loss factors of the modes by what the machine as a whole has, which couples no modes.
pub(super) fn uncoupled(damping: &Damping, eigenvalues: &[f64], free: usize) -> (Vec<f64>, Vec<f64>) {
    let n = eigenvalues.len();
    let (mut ratios, mut losses) = (vec![0.0; n], vec![0.0; n]);
    for r in free..n {
        let omega = eigenvalues[r].sqrt();
        let listed = damping.ratios.get(r - free).or(damping.ratios.last()).copied().unwrap_or(0.0);
        let rayleigh = damping.rayleigh.map_or(0.0, |[alpha, beta]| 0.5 * (alpha / omega + beta * omega));
        (ratios[r], losses[r]) = (listed + rayleigh, damping.loss_factor);
    }
    (ratios, losses)
}

/// Adds the own terms of springs (elongations n_springs x n) and parts to the ratios and loss factors of the modes.
pub(super) fn project(
    springs: &SpringValues,
    elongations: Option<&DMatrix<f64>>,
    parts: &[(f64, DMatrix<f64>)],
    eigenvalues: &[f64],
    free: usize,
    (ratios, losses): (&mut [f64], &mut [f64]),
) {
    for r in free..eigenvalues.len() {
        let omega = eigenvalues[r].sqrt();
        let (mut dampers, mut joint_loss) = (0.0, 0.0);
        if let Some(elongations) = elongations {
            for (s, elongation) in elongations.column(r).iter().enumerate() {
                let square = elongation * elongation;
                dampers += springs.damping[s] * square;
                joint_loss += springs.loss_factors[s] * springs.stiffness[s] * square;
            }
        }
        ratios[r] += dampers / (2.0 * omega);
        let part_loss: f64 = parts.iter().map(|(eta, energy)| eta * energy[(r, r)]).sum();
        losses[r] += (joint_loss + part_loss) / eigenvalues[r];
    }
}

/// Rows and columns of [`Dissipation::direct`] among springs, outputs and inputs.
pub(super) fn direct_rows(
    chosen: &[usize],
    n_springs: usize,
    n_outputs: usize,
    n_inputs: usize,
) -> (Vec<usize>, Vec<usize>) {
    let with_springs = |ports: std::ops::Range<usize>| ports.chain(chosen.iter().copied()).collect();
    let first_input = n_springs + n_outputs;
    (with_springs(n_springs..first_input), with_springs(first_input..first_input + n_inputs))
}

/// Damping as a time response takes it, which knows no loss factor: C = diag(2 zeta_r omega_r) + G^T G.
#[derive(Clone, Debug)]
pub struct ViscousDamping {
    /// zeta_r: viscous ratios, and half of every loss factor, those of joints and parts projected on the mode.
    pub ratios: Vec<f64>,
    /// G, a row a damper of the joints: the root of its value times its elongation, n_dampers x n. Without rows where
    /// the dampers are projected on the modes or there is none.
    pub dampers: DMatrix<f64>,
}

impl super::Modes {
    /// The damping of a time response at this position.
    pub fn viscous(&self) -> ViscousDamping {
        let ratio = |viscous: &[f64]| viscous.iter().zip(&self.loss_factors).map(|(z, eta)| z + 0.5 * eta).collect();
        let Some(own) = &self.dissipation else {
            let dampers = DMatrix::zeros(0, self.eigenvalues.len());
            return ViscousDamping { ratios: ratio(&self.damping_ratios), dampers };
        };
        ViscousDamping { ratios: ratio(&own.damping_ratios), dampers: damper_rows(&own.springs, &own.viscous) }
    }
}

/// Rows G of the dampers among springs, from the springs' elongations (n_spring x n) and dampers (N s/m or N m s/rad).
pub(crate) fn damper_rows(elongations: &DMatrix<f64>, viscous: &[f64]) -> DMatrix<f64> {
    let acting: Vec<usize> = (0..viscous.len()).filter(|&s| viscous[s] > 0.0).collect();
    let mut dampers = elongations.select_rows(&acting);
    for (mut row, &s) in dampers.row_iter_mut().zip(&acting) {
        row *= viscous[s].sqrt();
    }
    dampers
}
