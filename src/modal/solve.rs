//! Modes of the coupled machine at one position.

use super::{ModalError, free_motion};
use crate::coupling::{AtPosition, Coupled, CoupledModel};
use crate::linalg::{multiply, symmetric_eigen_polished};
use crate::machine::Damping;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// All modes of the machine in its fixed basis at one position.
#[derive(Clone, Debug)]
pub struct Modes {
    /// Position, m.
    pub position: f64,
    /// omega_r^2, (rad/s)^2, ascending; exactly 0 for free motions. As many as the basis has coordinates.
    pub eigenvalues: Vec<f64>,
    /// Free motions at 0 Hz, the first modes.
    pub free: usize,
    /// Viscous damping ratio of each mode; 0 for free motions.
    pub damping_ratios: Vec<f64>,
    /// Structural loss factor of each mode.
    pub loss_factors: Vec<f64>,
    /// Mass-normalised shapes in the fixed basis, n x n.
    pub shapes: DMatrix<f64>,
    /// Shapes at the outputs, n_output x n, kg^(-1/2).
    pub outputs: DMatrix<f64>,
    /// Shapes at the inputs, n_input x n, kg^(-1/2).
    pub inputs: DMatrix<f64>,
    /// Static compliance that no mode of the basis carries, n_output x n_input, m/N.
    pub direct: DMatrix<f64>,
}

/// Share of the largest elastic mode's port motion above which a port feels a free motion.
const FELT: f64 = 1e-6;

/// A motion that nothing resists.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeMotion {
    /// What moves and how, such as `spindle turns about z`.
    pub name: String,
    /// Largest displacement of an output per unit modal amplitude, kg^(-1/2).
    pub at_outputs: f64,
}

impl Modes {
    /// Natural frequency of mode r, Hz.
    pub fn frequency(&self, r: usize) -> f64 {
        self.eigenvalues[r].max(0.0).sqrt() / TAU
    }

    /// Modes at or below a frequency (Hz), free motions included.
    pub fn count_up_to(&self, frequency: f64) -> usize {
        let limit = (TAU * frequency).powi(2);
        self.eigenvalues.iter().take_while(|l| **l <= limit).count()
    }

    /// Whether a mode moves both an output and an input by more than rounding: a free motion that it
    /// does not (a spindle that turns about its axis, for a force through that axis) is left out of sums.
    ///
    /// The bound is 1e-6 of what the softest elastic mode moves.
    pub fn is_felt(&self, r: usize) -> bool {
        let product = |r: usize| self.outputs.column(r).norm() * self.inputs.column(r).norm();
        let elastic = (self.free..self.eigenvalues.len()).map(product).fold(0.0, f64::max);
        product(r) > FELT * elastic
    }

    /// What the free motions are.
    pub fn free_motions(&self, model: &CoupledModel) -> Vec<FreeMotion> {
        (0..self.free)
            .map(|r| FreeMotion {
                name: free_motion::describe(model, &self.shapes.column(r).into_owned()),
                at_outputs: self.outputs.column(r).amax(),
            })
            .collect()
    }
}

/// Modes at a position: the dense f64 eigenproblem of K(p) in the fixed basis, of which the lowest
/// `polished` modes are wanted to full accuracy.
///
/// # Errors
/// [`ModalError`]; a negative eigenvalue beyond rounding is an error, not a mode.
///
/// # Accuracy
/// omega^2 of the polished modes to 1e-10; of the others to some 1e-12 of the largest eigenvalue of
/// K(p), which the fixed basis bounds.
pub fn modes_at(model: &CoupledModel, damping: &Damping, position: f64, polished: usize) -> Result<Modes, ModalError> {
    let at = model.at(position)?;
    let stiffness = model.stiffness(position)?;
    modes_of(model, damping, &at, &stiffness, polished)
}

/// The same with given spring stiffnesses (N/m or N m/rad), for designs.
///
/// # Errors
/// As [`modes_at`].
pub fn modes_of(
    model: &CoupledModel,
    damping: &Damping,
    at: &AtPosition,
    stiffness: &[f64],
    polished: usize,
) -> Result<Modes, ModalError> {
    let position = at.position;
    let coupled = model.coupled(at, stiffness);
    let eigen = symmetric_eigen_polished(&coupled.stiffness, polished)
        .map_err(|source| ModalError::Eigen { position, source })?;
    let n = model.n();
    let rounding = f64::EPSILON * n as f64 * eigen.values.amax();
    let mut eigenvalues: Vec<f64> = eigen.values.iter().copied().collect();
    if let Some(&lowest) = eigenvalues.first()
        && lowest < -rounding
    {
        return Err(ModalError::Negative { position, eigenvalue: lowest, rounding });
    }
    let free = eigenvalues.iter().take_while(|l| **l <= rounding).count();
    eigenvalues[..free].fill(0.0);

    let (damping_ratios, loss_factors) =
        modal_damping(model, damping, at, &coupled, stiffness, &eigenvalues, free, &eigen.vectors);
    Ok(Modes {
        position,
        free,
        damping_ratios,
        loss_factors,
        outputs: multiply(&coupled.outputs, &eigen.vectors),
        inputs: multiply(&coupled.inputs, &eigen.vectors),
        direct: coupled.direct,
        shapes: eigen.vectors,
        eigenvalues,
    })
}

/// Viscous ratio and loss factor of every mode.
///
/// Joint dampers and loss factors of single parts and joints are projected on the undamped modes:
/// their coupling between modes is left out, which is an approximation of second order in the damping.
#[expect(clippy::too_many_arguments, reason = "one step of modes_of, with its locals")]
fn modal_damping(
    model: &CoupledModel,
    damping: &Damping,
    at: &AtPosition,
    coupled: &Coupled,
    stiffness: &[f64],
    eigenvalues: &[f64],
    free: usize,
    shapes: &DMatrix<f64>,
) -> (Vec<f64>, Vec<f64>) {
    let n = eigenvalues.len();
    let springs: Vec<(f64, f64)> = model
        .joints()
        .iter()
        .flat_map(|j| j.springs.iter().map(|s| (s.damping, j.loss_factor.unwrap_or(0.0))))
        .collect();
    let elongations =
        springs.iter().any(|(c, eta)| *c > 0.0 || *eta > 0.0).then(|| multiply(&coupled.elongations, shapes));
    let mut ratios = vec![0.0; n];
    let mut losses = vec![0.0; n];
    for r in free..n {
        let omega = eigenvalues[r].sqrt();
        let listed = damping.ratios.get(r - free).or(damping.ratios.last()).copied().unwrap_or(0.0);
        let rayleigh = damping.rayleigh.map_or(0.0, |[alpha, beta]| 0.5 * (alpha / omega + beta * omega));
        let (mut dampers, mut joint_loss) = (0.0, 0.0);
        if let Some(elongations) = &elongations {
            for (s, (c, eta)) in springs.iter().enumerate() {
                let square = elongations[(s, r)].powi(2);
                dampers += c * square;
                joint_loss += eta * stiffness[s] * square;
            }
        }
        ratios[r] = listed + rayleigh + dampers / (2.0 * omega);
        losses[r] = damping.loss_factor + joint_loss / eigenvalues[r];
    }
    for (part, residual) in model.parts.iter().zip(&at.residual_of_part) {
        let (Some(eta), Some(k), Some(c)) = (part.loss_factor, &part.stiffness, residual) else { continue };
        let forces = multiply(&coupled.forces, shapes);
        let strain = multiply(k, shapes) - 2.0 * multiply(&c.with_basis, &forces);
        let in_series = multiply(&c.between_forces, &forces);
        for r in free..n {
            let energy = shapes.column(r).dot(&strain.column(r)) + forces.column(r).dot(&in_series.column(r));
            losses[r] += eta * energy / eigenvalues[r];
        }
    }
    (ratios, losses)
}

/// The inertia count at one position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeCount {
    /// The frequency below which modes were counted, Hz.
    pub below: f64,
    /// Modes found by the eigensolver in the fixed basis, free motions included.
    pub found: usize,
    /// Modes counted by the inertia of the superelements side by side.
    pub counted: usize,
}

/// Counts the modes below a frequency in the widest gap between modes `wanted` and `wanted` + 6 by
/// the inertia of the side-by-side machine, which knows nothing of the fixed basis or of the dense
/// eigensolver.
///
/// # Errors
/// [`ModalError::Missed`] if the numbers differ.
pub fn check_count(model: &CoupledModel, modes: &Modes, wanted: usize) -> Result<ModeCount, ModalError> {
    let values = &modes.eigenvalues;
    let last = (wanted + 6).min(values.len() - 1);
    let first = wanted.min(last).saturating_sub(1).max(modes.free);
    let gap = |r: usize| values[r + 1] / values[r].max(f64::MIN_POSITIVE);
    let below = (first..last).max_by(|&a, &b| gap(a).total_cmp(&gap(b))).unwrap_or(first);
    let shift = if below + 1 < values.len() { 0.5 * (values[below] + values[below + 1]) } else { 2.0 * values[below] };
    let counted = model.side_by_side.count_below(modes.position, shift)?;
    let count = ModeCount { below: shift.sqrt() / TAU, found: below + 1, counted };
    if count.found == count.counted {
        return Ok(count);
    }
    Err(ModalError::Missed { position: modes.position, frequency: count.below, found: count.found, counted })
}
