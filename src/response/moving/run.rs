//! Stepping along a path.

use super::energy::Energy;
use super::flow::{AtSample, Flow, Stepped};
use super::mode_table::ModeTable;
use super::model::PathModel;
use crate::interrupt::Interrupt;
use crate::response::{Forces, History, Path, Recording, ResponseError};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::sync::OnceLock;

/// How a path is stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TravelOptions {
    /// Samples that share one K, that at the middle of their time.
    pub hold: usize,
    /// What is recorded.
    pub recording: Recording,
    /// Modes up to this frequency count for the frequency error, Hz.
    pub highest: f64,
}

impl Default for TravelOptions {
    fn default() -> Self {
        Self { hold: 2, recording: Recording::default(), highest: f64::INFINITY }
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
    /// Largest share by which a frequency is off because the change from the nearest station acts with its mean over a
    /// step: (K(p) - K_s)_rr h^2 / 12 of the modes up to a tenth of the sampling rate and up to the highest asked for.
    pub frequency_error: f64,
}

/// Flows that are made at once, in parallel.
const BLOCK: usize = 128;
/// A step is short enough for the dampers up to this rate times its length: what their quadratic force leaves out is
/// then below 1e-4 of any output.
const STRONG: f64 = 8.0;
/// Steps of a sample at most.
const MOST_PARTS: f64 = 16.0;
/// Modes up to this share of the sampling rate count for the frequency error; a straight force tells less of more.
const RESOLVED: f64 = 0.1;

/// The response from rest along a path.
///
/// # Errors
/// [`ResponseError::NotAllowed`] if `hold` is 0, [`ResponseError::Step`], [`ResponseError::Interrupted`].
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
    let mut walk = Walk {
        model,
        options,
        forces,
        q: DVector::zeros(n),
        v: DVector::zeros(n),
        station: None,
        parts: 1,
        energy: Energy::with_room(samples),
        history: History { step: h, n_outputs: model.at(positions[0]).outputs.nrows(), ..History::default() },
        frequency_error: 0.0,
    };
    let recorded = |wanted: bool| wanted.then(|| Vec::with_capacity(samples * walk.history.n_outputs));
    let (velocity, acceleration) = (recorded(options.recording.velocity), recorded(options.recording.acceleration));
    (walk.history.velocity, walk.history.acceleration) = (velocity, acceleration);
    let holds: Vec<usize> = (0..samples.max(2) - 1).step_by(options.hold).collect();
    let parts = (model.strongest_damping() * h / STRONG).ceil().clamp(1.0, MOST_PARTS);
    walk.parts = parts as usize;
    let modes: Vec<OnceLock<Vec<ModeTable>>> = (0..model.stations()).map(|_| OnceLock::new()).collect();
    for block in holds.chunks(BLOCK) {
        let make = |&first: &usize| {
            if interrupt.requested() {
                return Err(ResponseError::Interrupted);
            }
            let last = (first + options.hold).min(samples - 1);
            let middle = path.at(0.5 * (forces.time(first) + forces.time(last)));
            let station = model.station(middle);
            let modes = modes[station].get_or_init(|| model.of(station).over(h / parts));
            Flow::new(model, (station, modes), middle, &positions[first..=last], h / parts)
        };
        let flows = block.par_iter().map(make).collect::<Result<Vec<_>, _>>()?;
        for (&first, flow) in block.iter().zip(&flows) {
            walk.enter(flow);
            if first == 0 {
                walk.record(flow, &flow.samples[0], 0, [0.0; 3]);
            }
            for (k, ends) in flow.samples.windows(2).enumerate() {
                walk.step(flow, ends, first + k);
            }
            step();
        }
    }
    let mut history = walk.history;
    history.last = [walk.q.as_slice().to_vec(), walk.v.as_slice().to_vec()];
    Ok(Travel { positions, history, energy: walk.energy, frequency_error: walk.frequency_error })
}

/// The state on its way, over the modes of the station it is near.
struct Walk<'a> {
    model: &'a PathModel,
    options: TravelOptions,
    forces: &'a Forces,
    q: DVector<f64>,
    v: DVector<f64>,
    station: Option<usize>,
    /// Steps a sample.
    parts: usize,
    energy: Energy,
    history: History,
    frequency_error: f64,
}

impl Walk<'_> {
    /// Turns the state to the modes of the flow's station.
    fn enter(&mut self, flow: &Flow<'_>) {
        let model = self.model;
        if let Some(before) = self.station.filter(|&s| s != flow.station) {
            let turned = |x: &DVector<f64>| model.of(flow.station).shapes.tr_mul(&(&model.of(before).shapes * x));
            (self.q, self.v) = (turned(&self.q), turned(&self.v));
        }
        self.station = Some(flow.station);
        let edge = std::f64::consts::TAU * (RESOLVED / self.forces.step).min(self.options.highest);
        let resolved = model.of(flow.station).omega.iter().take_while(|w| **w <= edge).count();
        let step = self.forces.step / self.parts as f64;
        let off = flow.middle.largest_on_diagonal(resolved) * step.powi(2) / 12.0;
        self.frequency_error = self.frequency_error.max(off);
    }

    /// One step from sample k, between what the machine is at both ends.
    fn step(&mut self, flow: &Flow<'_>, ends: &[AtSample], k: usize) {
        let share = |part: usize| k as f64 + part as f64 / self.parts as f64;
        let modal = |part: usize| flow.inputs.tr_mul(&self.forces.at(share(part)));
        let mut next = flow.advance((&self.q, &self.v), (&modal(0), &modal(1)));
        for part in 1..self.parts {
            let Stepped { q, v, force, lost } = flow.advance((&next.q, &next.v), (&modal(part), &modal(part + 1)));
            next = Stepped { q, v, force: next.force + force, lost: next.lost + lost };
        }
        // K goes from that of the sample to that of the middle before the step, and on to the next sample's after it.
        let before = flow.middle.form(&self.q) - ends[0].stiffness.form(&self.q);
        let after = ends[1].stiffness.form(&next.q) - flow.middle.form(&next.q);
        (self.q, self.v) = (next.q, next.v);
        self.record(flow, &ends[1], k + 1, [next.force, next.lost, 0.5 * (before + after)]);
    }

    /// Enters a sample into the history and the energy balance.
    fn record(&mut self, flow: &Flow<'_>, at: &AtSample, k: usize, works: [f64; 3]) {
        let u = self.forces.at(k as f64);
        let station = self.model.of(flow.station);
        let omega = &station.omega;
        let elastic: f64 = omega.iter().zip(self.q.iter()).map(|(w, q)| (w * q).powi(2)).sum();
        let stored = [0.5 * self.v.norm_squared(), 0.5 * (elastic + at.stiffness.form(&self.q))];
        self.energy.push(stored, works);
        let outputs: &DMatrix<f64> = &at.outputs;
        self.history.displacement.extend((outputs * &self.q + &at.direct * &u).iter());
        if let Some(list) = &mut self.history.velocity {
            list.extend((outputs * &self.v).iter());
        }
        if self.options.recording.acceleration {
            let mut rate = flow.inputs.tr_mul(&u) - at.stiffness.times(&self.q);
            for (r, w) in omega.iter().enumerate() {
                rate[r] -= w * w * self.q[r] + 2.0 * station.ratios[r] * w * self.v[r];
            }
            rate -= flow.dampers.tr_mul(&(&flow.dampers * &self.v));
            if let Some(list) = &mut self.history.acceleration {
                list.extend((outputs * &rate).iter());
            }
        }
    }
}
