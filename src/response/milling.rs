//! Milling forces of a rigid cutter.
//!
//! Tooth j stands at phi_j = 2 pi n t + 2 pi j / N, measured from the normal direction towards the feed
//! in up-milling, and cuts between entry and exit with the chip thickness h = c sin(phi_j):
//!
//! ```text
//! F_t = Kt a h, F_r = Kr F_t
//! F_feed   = sum_j -F_t cos(phi_j) - F_r sin(phi_j)
//! F_normal = sum_j +F_t sin(phi_j) - F_r cos(phi_j)
//! ```
//!
//! Straight teeth, no edge forces, no regeneration: the force does not feel the vibration it makes.
//! Source: Altintas, Manufacturing Automation, 2nd ed., ch. 2.

use std::f64::consts::TAU;

/// A cutter and its cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Milling {
    /// Teeth N.
    pub teeth: usize,
    /// Spindle speed n, revolutions a second.
    pub speed: f64,
    /// Feed a tooth c, m.
    pub feed: f64,
    /// Axial depth of cut a, m.
    pub depth: f64,
    /// Tangential cutting coefficient Kt, N/m^2.
    pub kt: f64,
    /// Radial over tangential force Kr.
    pub kr: f64,
    /// Angle at which a tooth enters, rad.
    pub entry: f64,
    /// Angle at which it leaves, rad.
    pub exit: f64,
    /// Input along the feed.
    pub feed_input: String,
    /// Input normal to it.
    pub normal_input: String,
}

impl Milling {
    /// Force in feed and normal direction at a time, N.
    pub fn at(&self, time: f64) -> [f64; 2] {
        let mut force = [0.0; 2];
        for tooth in 0..self.teeth {
            let phi = (TAU * (self.speed * time + tooth as f64 / self.teeth as f64)).rem_euclid(TAU);
            if phi < self.entry || phi > self.exit {
                continue;
            }
            let (sine, cosine) = phi.sin_cos();
            let tangential = self.kt * self.depth * self.feed * sine;
            let radial = self.kr * tangential;
            force[0] += -tangential * cosine - radial * sine;
            force[1] += tangential * sine - radial * cosine;
        }
        force
    }
}
