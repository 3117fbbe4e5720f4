//! Milling forces of a rigid cutter.
//!
//! Seen along the spindle so that the cutter turns from the normal direction towards the feed, which is the direction
//! in which the tool advances into the workpiece:
//!
//! ```text
//!            normal (across)
//!              ^   phi = 0: a tooth enters with chip thickness 0 (up-milling)
//!              |  /
//!              | / phi of tooth j = 2 pi n t + 2 pi j / N, tooth 0 at phi = 0 at t = 0
//!              |/
//!              o------------> feed (along), phi = 90 degrees: the thickest chip
//!              |
//!              |   phi = 180 degrees: a tooth leaves with chip thickness 0 (down-milling)
//! ```
//!
//! A tooth cuts between entry and exit with the chip thickness h = c sin(phi), and pushes the tool with
//!
//! ```text
//! F_t = Kt a h, F_r = Kr F_t
//! F_feed   = sum_j -F_t cos(phi_j) - F_r sin(phi_j)
//! F_normal = sum_j +F_t sin(phi_j) - F_r cos(phi_j)
//! ```
//!
//! Straight teeth, no edge forces, no regeneration: the force does not feel the vibration it makes.
//! Source: Altintas, Manufacturing Automation, 2nd ed., ch. 2.

use super::sampling::Piece;
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
    /// 1, or -1 where the feed or the normal direction is against its input's.
    pub signs: [f64; 2],
}

/// Part of a tooth passing period, as a share, below which two angles are one.
const SAME: f64 = 1e-12;

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
        [self.signs[0] * force[0], self.signs[1] * force[1]]
    }

    /// How often a tooth passes, Hz.
    pub fn tooth_passing(&self) -> f64 {
        self.speed * self.teeth as f64
    }

    /// Kt a c sqrt(1 + Kr^2), N: what a tooth pushes with at most.
    pub fn peak(&self) -> f64 {
        (self.kt * self.depth * self.feed).abs() * 1.0f64.hypot(self.kr)
    }

    /// Fewest and most teeth that cut at once.
    pub fn engaged(&self) -> [usize; 2] {
        let counts: Vec<usize> = self.intervals().map(|[from, to]| self.angles(from, to).len()).collect();
        [counts.iter().copied().min().unwrap_or(0), counts.iter().copied().max().unwrap_or(0)]
    }

    /// The parts of a tooth passing period, 0 to 1, in which the same teeth cut.
    fn intervals(&self) -> impl Iterator<Item = [f64; 2]> {
        let pitch = TAU / self.teeth as f64;
        let mut ends: Vec<f64> = [self.entry, self.exit].map(|angle| (angle / pitch).fract()).to_vec();
        ends.retain(|end| (SAME..1.0 - SAME).contains(end));
        ends.extend([0.0, 1.0]);
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|b, a| *b - *a < SAME);
        let pairs: Vec<[f64; 2]> = ends.windows(2).map(|w| [w[0], w[1]]).collect();
        pairs.into_iter()
    }

    /// Angles at the beginning of an interval of those teeth that cut in it.
    fn angles(&self, from: f64, to: f64) -> Vec<f64> {
        let pitch = TAU / self.teeth as f64;
        let angle = |tooth: usize, part: f64| pitch * (tooth as f64 + part);
        let cuts = |tooth: &usize| (self.entry..=self.exit).contains(&angle(*tooth, 0.5 * (from + to)));
        (0..self.teeth).filter(cuts).map(|tooth| angle(tooth, from)).collect()
    }

    /// The force in feed (0) or normal (1) direction up to a time. The teeth are alike, so each passing of a tooth is as
    /// the first; between two changes of the teeth that cut, their sum is a constant and one wave of twice the speed:
    /// sin phi cos phi = sin(2 phi) / 2, sin^2 phi = (1 - cos(2 phi)) / 2.
    pub(super) fn pieces(&self, direction: usize, end: f64) -> impl Iterator<Item = Piece> {
        let half = 0.5 * self.kt * self.depth * self.feed * self.signs[direction];
        let radial = half * self.kr;
        let [sine, cosine] = if direction == 0 { [-half, radial] } else { [-radial, -half] };
        let period = self.tooth_passing().recip();
        let mut first = Vec::new();
        for [from, to] in self.intervals() {
            let angles = self.angles(from, to);
            let (mut in_phase, mut quadrature) = (0.0, 0.0);
            for (s, c) in angles.iter().map(|phi| (2.0 * phi).sin_cos()) {
                in_phase += sine * c - cosine * s;
                quadrature += sine * s + cosine * c;
            }
            first.push(Piece {
                from: from * period,
                to: to * period,
                offset: -cosine * angles.len() as f64,
                slope: 0.0,
                amplitude: f64::hypot(in_phase, quadrature),
                omega: 2.0 * TAU * self.speed,
                phase: f64::atan2(quadrature, in_phase),
            });
        }
        let passings = (end / period).ceil() as u64 + 1;
        (0..passings).flat_map(move |k| {
            let shift = k as f64 * period;
            first.clone().into_iter().map(move |p| Piece { from: p.from + shift, to: p.to + shift, ..p })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_the_teeth_one_by_one() {
        for (teeth, entry, exit) in
            [(1, 0.0, 180.0), (3, 20.0, 75.0), (4, 0.0, 180.0), (4, 120.0, 180.0), (2, 10.0, 170.0)]
        {
            let cut = Milling {
                teeth,
                speed: 47.0,
                feed: 1e-4,
                depth: 2e-3,
                kt: 2e9,
                kr: 0.3,
                entry: f64::to_radians(entry),
                exit: f64::to_radians(exit),
                feed_input: "x".into(),
                normal_input: "y".into(),
                signs: [1.0, -1.0],
            };
            for direction in 0..2 {
                let pieces: Vec<Piece> = cut.pieces(direction, 0.05).collect();
                assert!(pieces.windows(2).all(|w| (w[0].to - w[1].from).abs() < 1e-12), "no gap");
                for k in 0..500 {
                    // Off the angles at which a tooth enters or leaves.
                    let time = 0.05 * (f64::from(k) + 0.123) / 500.0;
                    let piece = pieces.iter().find(|p| p.from <= time && time < p.to).unwrap();
                    let apart = (piece.at(time) - cut.at(time)[direction]).abs();
                    assert!(apart < 1e-9 * cut.peak(), "{teeth} {entry} {exit}: {apart:e}");
                    let other = (piece.at(time + 1e-4) - cut.at(time)[direction]).abs();
                    assert!(cut.at(time)[direction] == 0.0 || teeth == 4 || other > 1e-9 * cut.peak(), "control");
                }
            }
        }
    }
}
