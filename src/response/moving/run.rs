//! Stepping along a path.

use super::basis::{LocalModel, PathModel};
use super::energy::{Account, Energy, Sample};
use crate::interrupt::Interrupt;
use crate::linalg::{multiply, symmetric_eigen_polished};
use crate::response::{Forces, History, Path, Recording, ResponseError};
use crate::state_space::ModeStep;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// How a path is stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TravelOptions {
    /// Samples that share one K, at the middle of their time.
    pub hold: usize,
    /// What is recorded.
    pub recording: Recording,
}

impl Default for TravelOptions {
    fn default() -> Self {
        Self { hold: 4, recording: Recording::default() }
    }
}

/// The response along a path.
#[derive(Clone, Debug)]
pub struct Travel {
    /// Position at every sample, m.
    pub positions: Vec<f64>,
    /// Motions of the outputs.
    pub history: History,
    /// The energy balance.
    pub energy: Energy,
}

/// The exact flow of the frozen system over one sample.
struct Flow {
    shapes: DMatrix<f64>,
    steps: Vec<ModeStep>,
    /// 2 zeta omega.
    rates: Vec<f64>,
    local: LocalModel,
}

impl Flow {
    fn new(model: &PathModel, position: f64, step: f64) -> Result<Self, ResponseError> {
        let local = model.at(position);
        let eigen = symmetric_eigen_polished(&local.stiffness, 0)
            .map_err(|source| ResponseError::Dense { position, source })?;
        let rounding = 1e-12 * eigen.values.amax();
        let free = eigen.values.iter().take_while(|l| **l <= rounding).count();
        let ratios = model.ratios(position, eigen.values.len() - free);
        let omega = |r: usize| if r < free { 0.0 } else { eigen.values[r].sqrt() };
        let zeta = |r: usize| if r < free { 0.0 } else { ratios[r - free] };
        let n = eigen.values.len();
        Ok(Self {
            steps: (0..n).map(|r| ModeStep::new(omega(r), zeta(r), step)).collect(),
            rates: (0..n).map(|r| 2.0 * zeta(r) * omega(r)).collect(),
            shapes: eigen.vectors,
            local,
        })
    }

    /// C v.
    fn damped(&self, v: &DVector<f64>) -> DVector<f64> {
        let mut modal = self.shapes.tr_mul(v);
        modal.iter_mut().zip(&self.rates).for_each(|(x, rate)| *x *= rate);
        &self.shapes * modal
    }
}

/// Flows that are made at once, in parallel.
const BLOCK: usize = 128;

/// The response from rest along a path.
///
/// # Errors
/// [`ResponseError::NotAllowed`] if `hold` is 0, [`ResponseError::Dense`], [`ResponseError::Interrupted`].
///
/// # Accuracy
/// Second order in the step; exact where the path rests and the force is straight between samples. The
/// positions must be those of the model's range; beyond it the nearest end is taken.
pub fn travel(
    model: &PathModel,
    path: &Path,
    forces: &Forces,
    options: TravelOptions,
    interrupt: &Interrupt,
    step: &(dyn Fn() + Sync),
) -> Result<Travel, ResponseError> {
    if options.hold == 0 {
        return Err(ResponseError::not_allowed("the samples that share one stiffness", 0, "at least 1"));
    }
    let (n, h, samples, n_inputs) = (model.n(), forces.step, forces.samples(), forces.inputs.len());
    let positions: Vec<f64> = (0..samples).map(|k| path.at(forces.time(k))).collect();
    let force = |k: usize| DVector::from_column_slice(&forces.values[k * n_inputs..][..n_inputs]);
    let mut out = Outputs::new(options.recording, samples, model.at(positions[0]).outputs.nrows(), h);
    let mut account = Account::new(samples);
    let mut state = (DVector::zeros(n), DVector::zeros(n));
    let mut stiffness = DMatrix::zeros(n, n);
    let holds: Vec<usize> = (0..samples.max(2) - 1).step_by(options.hold).collect();
    for block in holds.chunks(BLOCK) {
        if interrupt.requested() {
            return Err(ResponseError::Interrupted);
        }
        let middle = |first: usize| path.at(h * (first as f64 + 0.5 * options.hold as f64));
        let flows =
            block.par_iter().map(|&first| Flow::new(model, middle(first), h)).collect::<Result<Vec<_>, _>>()?;
        for (&first, flow) in block.iter().zip(&flows) {
            let mut modal = (flow.shapes.tr_mul(&state.0), flow.shapes.tr_mul(&state.1));
            let shaped = multiply(&flow.local.inputs, &flow.shapes);
            let last = (first + options.hold).min(samples - 1);
            for k in first..=last {
                // The sample at which a hold begins was recorded by the one before.
                if k > first {
                    advance(&mut modal, flow, &shaped.tr_mul(&force(k - 1)), &shaped.tr_mul(&force(k)));
                } else if k > 0 {
                    continue;
                }
                state = (&flow.shapes * &modal.0, &flow.shapes * &modal.1);
                model.stiffness_into(positions[k], &mut stiffness);
                let u = force(k);
                let slope = if k > 0 { flow.local.inputs.tr_mul(&((&u - force(k - 1)) / h)) } else { DVector::zeros(n) };
                let (elastic, damping) = (&stiffness * &state.0, flow.damped(&state.1));
                let driven = flow.local.inputs.tr_mul(&u);
                let acceleration = &driven - &damping - &elastic;
                out.push(&model.at_ports(positions[k]), &state, &acceleration, &u);
                let sample = Sample {
                    z: state.0.clone(),
                    v: state.1.clone(),
                    acceleration,
                    damping,
                    elastic,
                    force: driven,
                };
                account.push(sample, &stiffness, &slope, h);
            }
            step();
        }
    }
    let mut history = out.history;
    history.last = [state.0.as_slice().to_vec(), state.1.as_slice().to_vec()];
    Ok(Travel { positions, history, energy: account.energy })
}

/// One exact step of every mode.
fn advance(modal: &mut (DVector<f64>, DVector<f64>), flow: &Flow, before: &DVector<f64>, after: &DVector<f64>) {
    for (r, s) in flow.steps.iter().enumerate() {
        let (q, v) = (modal.0[r], modal.1[r]);
        let row = |i: usize| s.phi[i][0] * q + s.phi[i][1] * v + s.from[i] * before[r] + s.to[i] * after[r];
        (modal.0[r], modal.1[r]) = (row(0), row(1));
    }
}

/// The recorded motions.
struct Outputs {
    history: History,
}

impl Outputs {
    fn new(recording: Recording, samples: usize, n_outputs: usize, step: f64) -> Self {
        let room = |wanted: bool| wanted.then(|| Vec::with_capacity(samples * n_outputs));
        Self {
            history: History {
                step,
                n_outputs,
                displacement: Vec::with_capacity(samples * n_outputs),
                velocity: room(recording.velocity),
                acceleration: room(recording.acceleration),
                last: Default::default(),
            },
        }
    }

    fn push(
        &mut self,
        ports: &(DMatrix<f64>, DMatrix<f64>),
        state: &(DVector<f64>, DVector<f64>),
        acceleration: &DVector<f64>,
        u: &DVector<f64>,
    ) {
        let (outputs, direct) = ports;
        self.history.displacement.extend((outputs * &state.0 + direct * u).iter());
        if let Some(list) = &mut self.history.velocity {
            list.extend((outputs * &state.1).iter());
        }
        if let Some(list) = &mut self.history.acceleration {
            list.extend((outputs * acceleration).iter());
        }
    }
}
