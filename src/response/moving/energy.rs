//! The energy balance of a travelling machine, integrated from its sampled motion.
//!
//! Between two samples each power g is integrated by Hermite's rule h/2 (g_0 + g_1) + h^2/12 (g_0' - g_1'),
//! fourth order, with the slopes from the equation of motion at the samples. Nothing of the stepping enters:
//! what the stepping does wrong shows as an energy that came from nowhere.

use nalgebra::{DMatrix, DVector};

/// Energies and works since the beginning at every sample, J.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energy {
    /// 1/2 z' . z'.
    pub kinetic: Vec<f64>,
    /// 1/2 z . K(p) z.
    pub potential: Vec<f64>,
    /// Work of the forces.
    pub force: Vec<f64>,
    /// Work dissipated.
    pub dissipated: Vec<f64>,
    /// Work done on the machine through the change of K.
    pub travel: Vec<f64>,
}

impl Energy {
    /// kinetic + potential - force - travel + dissipated at every sample, which is zero but for errors, J.
    pub fn imbalance(&self) -> Vec<f64> {
        let stored = |k: usize| self.kinetic[k] + self.potential[k];
        let supplied = |k: usize| self.force[k] + self.travel[k] - self.dissipated[k];
        (0..self.kinetic.len()).map(|k| stored(k) - stored(0) - supplied(k)).collect()
    }

    /// Every so-many-th sample.
    pub(super) fn every(self, stride: usize) -> Self {
        let thin = |list: Vec<f64>| list.into_iter().step_by(stride).collect();
        Self {
            kinetic: thin(self.kinetic),
            potential: thin(self.potential),
            force: thin(self.force),
            dissipated: thin(self.dissipated),
            travel: thin(self.travel),
        }
    }

    /// Largest imbalance as a share of the largest of stored energy, work of the forces and dissipated work.
    pub fn closure(&self) -> f64 {
        let stored = self.kinetic.iter().zip(&self.potential).map(|(a, b)| a + b);
        let scale = stored.chain(self.dissipated.iter().copied()).chain(self.force.iter().map(|w| w.abs()));
        let scale = scale.fold(0.0, f64::max);
        let largest = self.imbalance().iter().fold(0.0f64, |m, x| m.max(x.abs()));
        if scale > 0.0 { largest / scale } else { largest }
    }
}

/// What the balance needs to know of one sample.
pub(super) struct Sample {
    pub z: DVector<f64>,
    pub v: DVector<f64>,
    pub acceleration: DVector<f64>,
    /// C z'.
    pub damping: DVector<f64>,
    /// K(p) z.
    pub elastic: DVector<f64>,
    /// R^T u.
    pub force: DVector<f64>,
}

/// Adds one step after another.
pub(super) struct Account {
    pub energy: Energy,
    before: Option<(Sample, DMatrix<f64>)>,
}

impl Account {
    pub fn new(samples: usize) -> Self {
        let room = || Vec::with_capacity(samples);
        let energy = Energy { kinetic: room(), potential: room(), force: room(), dissipated: room(), travel: room() };
        Self { energy, before: None }
    }

    /// The next sample, with K(p) there and the slope of R^T u over the step that led to it.
    pub fn push(&mut self, sample: Sample, stiffness: &DMatrix<f64>, force_slope: &DVector<f64>, step: f64) {
        let e = &mut self.energy;
        e.kinetic.push(0.5 * sample.v.norm_squared());
        e.potential.push(0.5 * sample.z.dot(&sample.elastic));
        let Some((old, old_stiffness)) = self.before.take() else {
            e.force.push(0.0);
            e.dissipated.push(0.0);
            e.travel.push(0.0);
            self.before = Some((sample, stiffness.clone()));
            return;
        };
        let hermite = |g0: f64, g1: f64, d0: f64, d1: f64| step / 2.0 * (g0 + g1) + step * step / 12.0 * (d0 - d1);
        let last = |list: &[f64]| list.last().copied().unwrap_or(0.0);
        let power = |s: &Sample| s.v.dot(&s.force);
        let slope = |s: &Sample| s.v.dot(force_slope) + s.acceleration.dot(&s.force);
        let work = hermite(power(&old), power(&sample), slope(&old), slope(&sample));
        e.force.push(last(&e.force) + work);
        let lost = |s: &Sample| s.v.dot(&s.damping);
        let lost_slope = |s: &Sample| 2.0 * s.acceleration.dot(&s.damping);
        let loss = hermite(lost(&old), lost(&sample), lost_slope(&old), lost_slope(&sample));
        e.dissipated.push(last(&e.dissipated) + loss);
        // dK/dt over the step from K at its ends.
        let change = |s: &Sample, own: &DVector<f64>, other: &DMatrix<f64>, sign: f64| {
            let d = (other * &s.z - own) * sign / step;
            (0.5 * s.z.dot(&d), s.v.dot(&d))
        };
        let (g0, d0) = change(&old, &old.elastic, stiffness, 1.0);
        let (g1, d1) = change(&sample, &sample.elastic, &old_stiffness, -1.0);
        e.travel.push(last(&e.travel) + hermite(g0, g1, d0, d1));
        self.before = Some((sample, stiffness.clone()));
    }
}
