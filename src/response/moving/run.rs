//! Stepping along a path.

use super::basis::{LocalModel, PathModel};
use super::energy::{Account, Energy, Sample};
use crate::interrupt::Interrupt;
use crate::linalg::{multiply, symmetric_eigen_fast};
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
        Self { hold: 2, recording: Recording::default() }
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
        let mut eigen =
            symmetric_eigen_fast(&local.stiffness).map_err(|source| ResponseError::Dense { position, source })?;
        let free = model.free;
        // Beside stiff modes the lowest keep few digits; Rayleigh's quotient has them.
        let low = LOW * eigen.values.amax();
        for r in free..eigen.values.iter().take_while(|l| **l < low).count() {
            let shape = eigen.vectors.column(r);
            eigen.values[r] = shape.dot(&(&local.stiffness * shape)).max(0.0);
        }
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

/// Modes below this share of the largest eigenvalue are made accurate.
const LOW: f64 = 1e-8;

/// Flows that are made at once, in parallel.
const BLOCK: usize = 128;
/// Steps of the energy balance in a sample.
const PARTS: usize = 2;

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
    let (n, h, samples) = (model.n(), forces.step, forces.samples());
    let positions: Vec<f64> = (0..samples).map(|k| path.at(forces.time(k))).collect();
    let mut out = Outputs::new(options.recording, samples, model.at_ports(positions[0]).0.nrows(), h);
    let mut walk = Walk {
        model,
        path,
        part: h / PARTS as f64,
        z: DVector::zeros(n),
        v: DVector::zeros(n),
        acceleration: DVector::zeros(n),
        account: Account::new(PARTS * samples),
        stiffness: DMatrix::zeros(n, n),
    };
    let holds: Vec<usize> = (0..samples.max(2) - 1).step_by(options.hold).collect();
    for block in holds.chunks(BLOCK) {
        let middle = |first: usize| path.at(h * (first as f64 + 0.5 * options.hold as f64));
        let make = |&first: &usize| {
            if interrupt.requested() {
                return Err(ResponseError::Interrupted);
            }
            Flow::new(model, middle(first), h / PARTS as f64)
        };
        let flows = block.par_iter().map(make).collect::<Result<Vec<_>, _>>()?;
        for (&first, flow) in block.iter().zip(&flows) {
            if first == 0 {
                let u = forces.at(0.0);
                walk.note(flow, 0.0, &u, &DVector::zeros(u.len()));
                out.push(&model.at_ports(positions[0]), &walk, &u);
            }
            let mut modal = (flow.shapes.tr_mul(&walk.z), flow.shapes.tr_mul(&walk.v));
            let shaped = multiply(&flow.local.inputs, &flow.shapes);
            let last = (first + options.hold).min(samples - 1);
            for (k, &position) in positions.iter().enumerate().take(last + 1).skip(first + 1) {
                for part in 0..PARTS {
                    let time = |parts: usize| (k - 1) as f64 + parts as f64 / PARTS as f64;
                    let (before, after) = (forces.at(time(part)), forces.at(time(part + 1)));
                    advance(&mut modal, flow, &shaped.tr_mul(&before), &shaped.tr_mul(&after));
                    (walk.z, walk.v) = (&flow.shapes * &modal.0, &flow.shapes * &modal.1);
                    walk.note(flow, h * time(part + 1), &after, &((&after - before) / walk.part));
                }
                out.push(&model.at_ports(position), &walk, &forces.at(k as f64));
            }
            step();
        }
    }
    let mut history = out.history;
    history.last = [walk.z.as_slice().to_vec(), walk.v.as_slice().to_vec()];
    Ok(Travel { positions, history, energy: walk.account.energy.every(PARTS) })
}

/// The state on its way.
struct Walk<'a> {
    model: &'a PathModel,
    path: &'a Path,
    part: f64,
    z: DVector<f64>,
    v: DVector<f64>,
    acceleration: DVector<f64>,
    account: Account,
    stiffness: DMatrix<f64>,
}

impl Walk<'_> {
    /// Enters the state at a time into the energy balance, under forces u that came with a slope.
    fn note(&mut self, flow: &Flow, time: f64, u: &DVector<f64>, slope: &DVector<f64>) {
        self.model.stiffness_into(self.path.at(time), &mut self.stiffness);
        let (elastic, damping) = (&self.stiffness * &self.z, flow.damped(&self.v));
        let force = flow.local.inputs.tr_mul(u);
        self.acceleration = &force - &damping - &elastic;
        let (z, v, acceleration) = (self.z.clone(), self.v.clone(), self.acceleration.clone());
        let sample = Sample { z, v, acceleration, damping, elastic, force };
        self.account.push(sample, &self.stiffness, &flow.local.inputs.tr_mul(slope), self.part);
    }
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

    fn push(&mut self, ports: &(DMatrix<f64>, DMatrix<f64>), walk: &Walk<'_>, u: &DVector<f64>) {
        let (outputs, direct) = ports;
        self.history.displacement.extend((outputs * &walk.z + direct * u).iter());
        if let Some(list) = &mut self.history.velocity {
            list.extend((outputs * &walk.v).iter());
        }
        if let Some(list) = &mut self.history.acceleration {
            list.extend((outputs * &walk.acceleration).iter());
        }
    }
}
