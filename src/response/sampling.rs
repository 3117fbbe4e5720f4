//! Samples whose straight lines push as the force itself does.
//!
//! All integrators take forces that are straight between samples: u(t) = sum_k u_k phi_k(t), phi_k the hat that is 1
//! at sample k and 0 at its neighbours. The force's own values at the samples would lose what it does between them: a
//! short blow would vanish, a step would come half a sample early. So u_k is the force's mean under its hat,
//!
//! ```text
//! u_k = 1/h int f phi_k dt                                   (the first and the last hat are halves)
//! ```
//!
//! which keeps int f dt and int t f dt exactly, whatever f is. Means alone flatten: of a wave they lose x^2/12,
//! x = omega h, and the lines between them as much again. Two additions make that good without touching the integral:
//!
//! - In a step from a to b in which f is smooth or near its chord, (f(a) - f(b)) / 6 moves from sample b to sample a. Over
//!   a run that begins and ends at one value this cancels in the first moment too; what is left of the loss is 0.015 x^4.
//!   A polygon with its corners on samples comes out as it is.
//! - What changes faster than the steps, a short blow, has no form to keep, but its second moment can be kept as well: with
//!   e = int f phi_a phi_b dt over a step, hats and lines widen the blow by e + 1/6 int f dt, and second differences
//!   (-1, 2, -1) at the step's samples take that back. A blow so turns its sign beside itself.
//!
//! A jump, and a bend inside a step, keep their plain means: no sign turns and nothing overshoots beside a step.
//!
//! Source: the means are the lumped projection on linear elements; the additions are one step of its iteration towards
//! the consistent one (Zienkiewicz and Taylor, The Finite Element Method, vol. 1, on mass lumping).

/// A stretch of a force: offset + slope s + amplitude sin(omega s + phase), s = t - from, for from <= t <= to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    /// Beginning, s.
    pub from: f64,
    /// End, s.
    pub to: f64,
    /// N.
    pub offset: f64,
    /// N/s.
    pub slope: f64,
    /// N.
    pub amplitude: f64,
    /// rad/s.
    pub omega: f64,
    /// rad.
    pub phase: f64,
}

impl Piece {
    /// A straight line between two values.
    pub fn line(from: f64, to: f64, [first, last]: [f64; 2]) -> Self {
        Self { from, to, offset: first, slope: (last - first) / (to - from), amplitude: 0.0, omega: 0.0, phase: 0.0 }
    }

    /// A constant.
    pub fn constant(from: f64, to: f64, value: f64) -> Self {
        Self { from, to, offset: value, slope: 0.0, amplitude: 0.0, omega: 0.0, phase: 0.0 }
    }

    /// Value at a time, whether the piece reaches there or not.
    pub fn at(&self, time: f64) -> f64 {
        let s = time - self.from;
        let wave = if self.amplitude == 0.0 { 0.0 } else { self.amplitude * (self.omega * s + self.phase).sin() };
        self.offset + self.slope * s + wave
    }

    /// The same with time counted in samples. An end that rounding puts beside a sample is put on it.
    fn in_samples(&self, step: f64) -> Self {
        let snapped = |t: f64| {
            let (sample, whole) = (t / step, (t / step).round());
            let wide = self.to - self.from > 1e-3 * step;
            if wide && (sample - whole).abs() < SNAP { whole } else { sample }
        };
        let (slope, omega) = (self.slope * step, self.omega * step);
        Self { from: snapped(self.from), to: snapped(self.to), slope, omega, ..*self }
    }

    /// Integrals over a part of one step, which begins at the sample `first`: of f times the left hat, the right hat, and
    /// both.
    fn moments(&self, first: f64, from: f64, to: f64) -> [f64; 3] {
        let rule: &[(f64, f64)] = if self.amplitude == 0.0 { &GAUSS_2 } else { &GAUSS_8 };
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let mut sums = [0.0; 3];
        for &(place, weight) in rule {
            for side in [-place, place] {
                let t = middle + half * side;
                let f = self.at(t) * weight * half;
                sums[0] += f * (1.0 - (t - first));
                sums[1] += f * (t - first);
                sums[2] += f * (1.0 - (t - first)) * (t - first);
            }
        }
        sums
    }
}

/// Distance in samples within which an end counts as lying on a sample.
const SNAP: f64 = 1e-7;
/// A force counts as smooth over a bend if it stays this near to its chord, as a share of its largest value.
const NEAR: f64 = 0.01;
/// A force is resolved by a step over which it changes by no more than this share of its largest value.
const SLOW: f64 = 0.4;
/// A force has lost its form in a step if it turns twice inside and leaves its chord by this share of its largest value.
const LOST: f64 = 0.05;

/// Gauss-Legendre places and weights, one of each pair: exact for what a straight piece times a hat is.
const GAUSS_2: [(f64, f64); 1] = [(0.577_350_269_189_625_8, 1.0)];
/// Exact to rounding for half a period, and to 1e-9 for a whole one.
const GAUSS_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Adds the samples of a force that is given by pieces in the order of time and zero between them; `add` takes a sample's
/// number and what comes to it. `peak` is the force's largest absolute value; a `brief` force has no form to keep in any
/// step. Returns the number of steps in which the
/// force's form is lost, because it turns more than once inside; its momentum is there all the same.
pub(super) fn sample(
    pieces: impl IntoIterator<Item = Piece>,
    peak: f64,
    brief: bool,
    step: f64,
    samples: usize,
    mut add: impl FnMut(usize, f64),
) -> usize {
    let mut pieces = pieces.into_iter().map(|p| p.in_samples(step)).filter(|p| p.to > p.from).peekable();
    let mut inside: Vec<Piece> = Vec::new();
    let mut lost = 0;
    for first in 0..samples.saturating_sub(1) {
        let (from, to) = (first as f64, first as f64 + 1.0);
        inside.retain(|p| p.to > from);
        while let Some(piece) = pieces.next_if(|p| p.from < to) {
            if piece.to > from {
                inside.push(piece);
            }
        }
        if inside.is_empty() {
            if pieces.peek().is_none() {
                break;
            }
            continue;
        }
        let found = one_step(&inside, from, peak, brief);
        lost += usize::from(found.lost);
        // The hats at the two ends of the record are halves.
        let at_end = |k: usize| k == 0 || k + 1 == samples;
        for (k, side) in [(first, 0), (first + 1, 1)] {
            let share = found.shares[side];
            if at_end(k) {
                add(k, 2.0 * share);
                continue;
            }
            add(k, share);
            if found.fast && !at_end(k - 1) && !at_end(k + 1) {
                let narrower = 0.25 * found.width + share / 12.0;
                add(k - 1, -narrower);
                add(k, 2.0 * narrower);
                add(k + 1, -narrower);
            }
        }
    }
    lost
}

/// What one step gives to the samples at its two ends.
struct OneStep {
    shares: [f64; 2],
    /// Integral of f times both hats.
    width: f64,
    /// The force changes faster than the step, without one jump that explains it.
    fast: bool,
    /// The force turns more than once inside.
    lost: bool,
}

fn one_step(inside: &[Piece], from: f64, peak: f64, brief: bool) -> OneStep {
    let to = from + 1.0;
    let (mut shares, mut width) = ([0.0; 2], 0.0);
    // Where the force bends or jumps inside the step: time, value before, value after.
    let mut bends: Vec<(f64, f64, f64)> = Vec::new();
    let mut ends = [0.0; 2];
    let (mut reached, mut value) = (from, 0.0);
    for piece in inside {
        let (begin, end) = (piece.from.max(from), piece.to.min(to));
        let [left, right, both] = piece.moments(from, begin, end);
        shares[0] += left;
        shares[1] += right;
        width += both;
        if begin > reached + SNAP && reached > from {
            bends.push((reached, value, 0.0));
            value = 0.0;
        }
        if begin > from {
            bends.push((begin, value, piece.at(begin)));
        } else {
            ends[0] = piece.at(from);
        }
        (reached, value) = (end, piece.at(end));
    }
    if reached < to - SNAP {
        bends.push((reached, value, 0.0));
    } else {
        ends[1] = value;
    }
    let chord = |t: f64| ends[0] + (ends[1] - ends[0]) * (t - from);
    let departure = bends.iter().map(|&(t, a, b)| (a - chord(t)).abs().max((b - chord(t)).abs())).fold(0.0, f64::max);
    // A line from sample to sample is what it is, however steep.
    let is_line = |p: &Piece| p.amplitude == 0.0 && p.from.fract() == 0.0 && p.to.fract() == 0.0;
    let slow = (ends[0] - ends[1]).abs() <= SLOW * peak || inside.len() == 1 && is_line(&inside[0]);
    let jumps = bends.iter().any(|(_, before, after)| (before - after).abs() > NEAR * peak);
    let lost = bends.len() > 1 && departure > LOST * peak;
    if slow && departure <= NEAR * peak && !brief {
        let moved = (ends[0] - ends[1]) / 6.0;
        shares[0] += moved;
        shares[1] -= moved;
    }
    OneStep { shares, width, fast: brief || lost || !slow && !jumps, lost }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(pieces: &[Piece], peak: f64, step: f64, count: usize) -> Vec<f64> {
        let mut out = vec![0.0; count];
        sample(pieces.iter().copied(), peak, false, step, count, |k, f| out[k] += f);
        out
    }

    #[test]
    fn lines_between_samples_come_out_as_they_are() {
        let pieces = [Piece::line(1.0, 2.0, [0.0, 3.0]), Piece::line(2.0, 4.0, [3.0, -1.0])];
        let found = samples(&pieces, 3.0, 1.0, 7);
        // At 4 the force jumps from -1 to 0: half of it is the sample's.
        let right = [0.0, 0.0, 3.0, 1.0, -0.5, 0.0, 0.0];
        assert!(found.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?}");
    }

    #[test]
    fn a_resolved_sine_keeps_its_size_to_the_fourth_power_of_the_step() {
        // Straight lines lose 1 - sinc^2(x / 2), so the samples must be larger by that: x^2 / 12 to first order.
        for (x, left) in [(0.2f64, 3e-5), (0.4, 5e-4)] {
            let wave = Piece { from: -10.0, to: 1000.0, offset: 0.0, slope: 0.0, amplitude: 1.0, omega: x, phase: 0.3 };
            let found = samples(&[wave], 1.0, 1.0, 200);
            let sinc = (0.5 * x).sin() / (0.5 * x);
            let off = (1..199).map(|k| (found[k] * sinc * sinc - wave.at(k as f64)).abs()).fold(0.0, f64::max);
            assert!(off < left, "{off:e}");
            let plain = 1.0 - sinc * sinc;
            assert!(plain > 20.0 * off, "control: plain samples lose {plain:e}, these {off:e}");
        }
    }
}
