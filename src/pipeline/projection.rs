//! What projecting the damping on the undamped modes leaves out, for the machine at hand.

use super::PipelineError;
use crate::coupling::CoupledModel;
use crate::frf::{FrfRequest, Quantity, Selection, modal_sum, modal_systems};
use crate::machine::{Damping, Machine};
use crate::modal::{Modes, modes_at};
use crate::response::Plant;
use crate::state_space::{DampedSum, StateSpaceOptions, receptance, state_space};
use nalgebra::{Complex, DMatrix};
use serde::Serialize;

/// Frequencies over the band at which responses are compared, beside those of the modes.
const PROBES: usize = 60;
/// Ratio and loss factor together below which a mode counts as undamped.
const UNDAMPED: f64 = 1e-9;
/// Share of a response's largest value from which projection is warned of.
pub const PROJECTION_TOLD: f64 = 0.02;

/// What stands for the exact damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Simplified {
    /// Dampers and loss factors of joints and parts projected on the undamped modes.
    Projected,
    /// Dampers between the modes as they are; loss factors as viscous ratios of the modes, half as large: what a time
    /// response can have.
    Viscous,
    /// The same between the modes of a state space, beyond which dampers meet what answers statically.
    StateSpace(StateSpaceOptions),
}

impl Simplified {
    fn words(self) -> &'static str {
        match self {
            Self::Projected => "dampers and loss factors of joints and parts as projected on the undamped modes",
            Self::Viscous => "loss factors of joints and parts as viscous ratios of the undamped modes",
            Self::StateSpace(_) => {
                "dampers between its modes only, and loss factors of joints and parts as viscous ratios of its modes"
            }
        }
    }
}

/// The largest difference between responses with projected and with exact damping, as shares of each response's largest
/// value over the band.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProjectionError {
    /// What was compared with the exact damping, in words.
    pub taken: &'static str,
    /// Of the responses with force and motion in one place and direction.
    pub direct: f64,
    /// Of the others.
    pub cross: f64,
    /// Where the larger of the two is: output and input.
    pub response: String,
    /// Position there, m.
    pub position_m: f64,
    /// Frequency there, Hz.
    pub frequency_hz: f64,
}

impl ProjectionError {
    /// The larger of the two.
    pub fn largest(&self) -> f64 {
        self.direct.max(self.cross)
    }

    /// What a reader of projected results (`what`) should know; `None` where it is small.
    pub fn warning(&self, what: &str) -> Option<String> {
        (self.largest() > PROJECTION_TOLD).then(|| {
            format!(
                "{what} {}: responses are off by up to {:.1} % (direct) and {:.1} % (cross) of their peaks, most in \
                 {} at {} m, {:.1} Hz",
                self.taken,
                100.0 * self.direct,
                100.0 * self.cross,
                self.response,
                self.position_m,
                self.frequency_hz
            )
        })
    }
}

/// Compares a simplified damping with the exact one at the first, the middle and the last position up to `highest`
/// (Hz); `None` where no damping couples the modes and where nothing is simplified.
///
/// # Errors
/// [`PipelineError`] of modes or sums.
pub fn projection_error(
    machine: &Machine,
    model: &CoupledModel,
    positions: &[f64],
    highest: f64,
    simplified: Simplified,
) -> Result<Option<ProjectionError>, PipelineError> {
    let dampers = simplified != Simplified::Viscous;
    let joints = machine.joints.iter().any(|j| {
        j.loss_factor.is_some_and(|eta| eta > 0.0) || dampers && j.springs.iter().any(|spring| spring.damping > 0.0)
    });
    let parts = machine.parts.iter().any(|p| p.loss_factor.is_some_and(|eta| eta > 0.0));
    if !(joints || parts) || positions.is_empty() || highest <= 0.0 {
        return Ok(None);
    }
    let mut chosen = vec![0, positions.len() / 2, positions.len() - 1];
    chosen.dedup();
    let damping = Damping { projected: false, ..machine.analysis.damping.clone() };
    let (outputs, inputs) = (model.output_names(), model.input_names());
    let mut worst: Option<ProjectionError> = None;
    for position in chosen.into_iter().map(|k| positions[k]) {
        let modes: Vec<Modes> = vec![modes_at(model, &damping, position)?];
        // A tail that projected dampers leave without oscillation has no polynomial: all modes are summed.
        let all = Selection::Exactly { modes: modes[0].eigenvalues.len(), residual: true };
        let (exact, _) = modal_systems(&modes, highest, all)?;
        let mut projected = exact.clone();
        projected[0].exact = None;
        // The peak of a mode that nothing damps has no bound, and neither solution has anything to say of it.
        let damped = |r: usize| projected[0].damping_ratios[r] + projected[0].loss_factors[r] > UNDAMPED;
        let in_band = exact[0].frequencies.iter().copied().enumerate();
        let in_band = in_band.filter(|(r, f)| *f > 0.0 && *f <= highest && damped(*r)).map(|(_, f)| f);
        let mut grid: Vec<f64> = (1..=PROBES).map(|k| highest * k as f64 / PROBES as f64).chain(in_band).collect();
        grid.sort_by(f64::total_cmp);
        grid.dedup();
        let map = |systems| {
            modal_sum(&FrfRequest {
                positions: &[position],
                systems,
                frequencies: &grid,
                outputs: &outputs,
                inputs: &inputs,
                quantity: Quantity::Receptance,
            })
        };
        let (exact, projected) = (map(&exact)?, map(&projected)?);
        let viscous: Option<Vec<_>> = match simplified {
            Simplified::Projected => None,
            Simplified::Viscous => Some(of_plant(&Plant::whole(&modes[0]), &grid)),
            Simplified::StateSpace(options) => {
                let system = state_space(&modes[0], options);
                Some(grid.iter().map(|f| receptance(&system, *f)).collect())
            }
        };
        for (o, output) in outputs.iter().enumerate() {
            for (i, input) in inputs.iter().enumerate() {
                let simple = |k: usize| viscous.as_ref().map_or_else(|| projected.at(0, k, o, i), |v| v[k][(o, i)]);
                let values = |k: usize| (exact.at(0, k, o, i), simple(k));
                let peak = (0..grid.len()).map(|k| values(k).0.norm()).fold(f64::MIN_POSITIVE, f64::max);
                let off = |k: usize| (values(k).0 - values(k).1).norm() / peak;
                let Some(k) = (0..grid.len()).max_by(|a, b| off(*a).total_cmp(&off(*b))) else { continue };
                let own = worst.get_or_insert(ProjectionError {
                    taken: simplified.words(),
                    direct: 0.0,
                    cross: 0.0,
                    response: String::new(),
                    position_m: position,
                    frequency_hz: 0.0,
                });
                if off(k) > own.largest() {
                    own.response = format!("{output} for a force in {input}");
                    (own.position_m, own.frequency_hz) = (position, grid[k]);
                }
                let side = if output == input { &mut own.direct } else { &mut own.cross };
                *side = side.max(off(k));
            }
        }
    }
    Ok(worst)
}

/// The receptance of a time response's plant at frequencies, Hz.
fn of_plant(plant: &Plant, frequencies: &[f64]) -> Vec<DMatrix<Complex<f64>>> {
    let sum = DampedSum {
        omega: &plant.omega,
        zeta: &plant.zeta,
        outputs: &plant.outputs,
        inputs: &plant.inputs,
        dampers: &plant.dampers,
    };
    frequencies.iter().map(|f| sum.at(*f) + plant.direct.map(|d| Complex::new(d, 0.0))).collect()
}

/// Every damping that acts in a machine, in words.
pub fn acting_damping(machine: &Machine) -> Vec<String> {
    let damping = &machine.analysis.damping;
    let mut out = Vec::new();
    if damping.ratios.iter().any(|zeta| *zeta > 0.0) {
        let list: Vec<String> = damping.ratios.iter().map(f64::to_string).collect();
        out.push(format!("viscous ratios of the modes: {}", list.join(", ")));
    }
    if let Some([alpha, beta]) = damping.rayleigh {
        out.push(format!("Rayleigh: alpha {alpha} 1/s, beta {beta} s"));
    }
    if damping.loss_factor > 0.0 {
        out.push(format!("loss factor of the machine: {}", damping.loss_factor));
    }
    for part in &machine.parts {
        out.extend(
            part.loss_factor
                .filter(|eta| *eta > 0.0)
                .map(|eta| format!("loss factor of part \"{}\": {eta}", part.name)),
        );
    }
    for joint in &machine.joints {
        out.extend(
            joint
                .loss_factor
                .filter(|eta| *eta > 0.0)
                .map(|eta| format!("loss factor of joint \"{}\": {eta}", joint.name)),
        );
        let dampers = joint.springs.iter().filter(|s| s.damping > 0.0).map(|s| format!("{} {}", s.label, s.damping));
        let dampers: Vec<String> = dampers.collect();
        if !dampers.is_empty() {
            out.push(format!("dampers of joint \"{}\", N s/m or N m s/rad: {}", joint.name, dampers.join(", ")));
        }
    }
    out
}
