//! The energy balance of a travelling machine, from exact integrals over each step.
//!
//! The work of the forces and of the dampers follows from the moments of the rates over the step, what each mode loses
//! from a quadratic form in its state at the step's beginning and the forces on it ([`super::mode_table`]). Neither is
//! got from the balance itself: a wrong step, a wrong change of stiffness or a wrong turn from one station's modes to
//! the next shows as an energy that came from nowhere.

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
    pub(super) fn with_room(samples: usize) -> Self {
        let room = || Vec::with_capacity(samples);
        Self { kinetic: room(), potential: room(), force: room(), dissipated: room(), travel: room() }
    }

    /// The next sample: kinetic and potential energy, and the works since the one before.
    pub(super) fn push(&mut self, [kinetic, potential]: [f64; 2], [force, dissipated, travel]: [f64; 3]) {
        self.kinetic.push(kinetic);
        self.potential.push(potential);
        let add = |list: &mut Vec<f64>, work: f64| list.push(list.last().copied().unwrap_or(0.0) + work);
        add(&mut self.force, force);
        add(&mut self.dissipated, dissipated);
        add(&mut self.travel, travel);
    }

    /// kinetic + potential - force - travel + dissipated at every sample, which is zero but for errors, J.
    pub fn imbalance(&self) -> Vec<f64> {
        let stored = |k: usize| self.kinetic[k] + self.potential[k];
        let supplied = |k: usize| self.force[k] + self.travel[k] - self.dissipated[k];
        (0..self.kinetic.len()).map(|k| stored(k) - stored(0) - supplied(k)).collect()
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
