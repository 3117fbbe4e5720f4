//! One mode over one step under a force that is a quadratic of the time, with all that the step and its energies need.
//!
//! The force is F_0 P_0 + F_1 P_1 + F_2 P_2 in Legendre's polynomials of the step: its mean, its slope and its curve.

use crate::state_space::ModeStep;
use nalgebra::{Matrix5, RowVector5};

/// Columns of all tables: q and q' at the beginning, then F_0, F_1, F_2.
pub(super) type Row = [f64; 5];

/// A mode over a step.
#[derive(Clone, Debug)]
pub(super) struct ModeTable {
    /// q' at the end.
    pub rate: Row,
    /// int q' P_j dt over the step for j = 0, 1, 2; the first is the change of q.
    pub moments: [Row; 3],
    /// The loss over the step, int 2 zeta omega q'^2 dt, as a quadratic form: its upper triangle by rows, the entries
    /// beside the diagonal twice.
    loss: [f64; 15],
}

/// Phase and decay over a part of a step in which Gauss's rule is exact to rounding.
const SHORT: f64 = 0.5;
/// Parts of a step at most; only a mode that creeps would need more.
const MOST_PARTS: f64 = 4096.0;
/// Gauss's points of [0, 1] and their weights.
const GAUSS: [(f64, f64); 8] = [
    (0.019_855_071_751_231_856, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_64, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_64),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

impl ModeTable {
    pub fn new(omega: f64, zeta: f64, step: f64) -> Self {
        let turn = from_legendre(step);
        let end = transition(omega, zeta, step) * turn;
        let moments = if omega * step < 1.0 {
            by_quadrature(omega, zeta, step).map(|row| row * turn)
        } else {
            by_parts(omega, zeta, step, &end)
        };
        let plain = |row: RowVector5<f64>| std::array::from_fn(|k| row[k]);
        let change = end.row(0) - RowVector5::new(1.0, 0.0, 0.0, 0.0, 0.0);
        Self {
            rate: plain(end.row(1).into_owned()),
            moments: [plain(change), plain(moments[1]), plain(moments[2])],
            loss: loss(omega, zeta, step),
        }
    }

    /// What a row gives for a state and a force.
    pub fn of(row: &Row, [q, v]: [f64; 2], force: [f64; 3]) -> f64 {
        row[0] * q + row[1] * v + row[2] * force[0] + row[3] * force[1] + row[4] * force[2]
    }

    /// The loss over the step, J.
    pub fn loss(&self, [q, v]: [f64; 2], [a, b, c]: [f64; 3]) -> f64 {
        let f = &self.loss;
        q * (f[0] * q + f[1] * v + f[2] * a + f[3] * b + f[4] * c)
            + v * (f[5] * v + f[6] * a + f[7] * b + f[8] * c)
            + a * (f[9] * a + f[10] * b + f[11] * c)
            + b * (f[12] * b + f[13] * c)
            + f[14] * c * c
    }
}

/// q, q', the force and its first and second derivatives after a time.
fn transition(omega: f64, zeta: f64, time: f64) -> Matrix5<f64> {
    let s = ModeStep::new(omega, zeta, time);
    let mut out = Matrix5::identity();
    for i in 0..2 {
        let row = [s.phi[i][0], s.phi[i][1], s.constant[i], s.to[i] * time, s.quadratic[i] * time * time];
        out.row_mut(i).copy_from(&RowVector5::from(row));
    }
    (out[(2, 3)], out[(3, 4)], out[(2, 4)]) = (time, time, 0.5 * time * time);
    out
}

/// Force and derivatives at the beginning of a step from F_0, F_1, F_2, with the state as it is:
/// P_0 = 1, P_1 = 2 s - 1, P_2 = 6 s^2 - 6 s + 1 over s = t / h.
fn from_legendre(step: f64) -> Matrix5<f64> {
    let mut out = Matrix5::identity();
    (out[(2, 3)], out[(2, 4)]) = (-1.0, 1.0);
    (out[(3, 3)], out[(3, 4)]) = (2.0 / step, -6.0 / step);
    out[(4, 4)] = 12.0 / (step * step);
    out
}

/// Parts of a step short enough for Gauss's rule.
fn parts(omega: f64, zeta: f64, step: f64) -> f64 {
    (omega.max(2.0 * zeta * omega) * step / SHORT).ceil().clamp(1.0, MOST_PARTS)
}

/// The moments of the rate over state, force and derivatives.
fn by_quadrature(omega: f64, zeta: f64, step: f64) -> [RowVector5<f64>; 3] {
    let count = parts(omega, zeta, step);
    let part = step / count;
    let points = GAUSS.map(|(at, weight)| (at, weight, transition(omega, zeta, at * part).row(1).into_owned()));
    let over = transition(omega, zeta, part);
    let mut start = Matrix5::identity();
    let mut out = [RowVector5::zeros(); 3];
    for k in 0..count as usize {
        for (at, weight, row) in &points {
            let s = (k as f64 + at) / count;
            let rate = row * start * (weight * part);
            let values = [1.0, 2.0 * s - 1.0, 6.0 * s * s - 6.0 * s + 1.0];
            out.iter_mut().zip(values).for_each(|(sum, p)| *sum += rate * p);
        }
        start = over * start;
    }
    out
}

/// The same for a mode that turns far over the step, from the equation of motion times 1 and s, integrated over the
/// step in the scaled time s: with w = omega h, c = zeta w, q' for dq/ds,
///
/// ```text
/// w^2 int q   = int f   - [q']   - 2 c [q]                     int q' s   = q(1) - int q
/// w^2 int q s = int f s - q'(1)  + [q] - 2 c int q' s          int q' s^2 = q(1) - 2 int q s
/// ```
fn by_parts(omega: f64, zeta: f64, step: f64, end: &Matrix5<f64>) -> [RowVector5<f64>; 3] {
    let (w, h) = (omega * step, step);
    let c = zeta * w;
    let unit = |k: usize| RowVector5::from_fn(|_, j| f64::from(u8::from(j == k)));
    let (q, rate) = (end.row(0).into_owned(), end.row(1) * h);
    let change = q - unit(0);
    // Integrals of h^2 f and h^2 f s over s.
    let (force, first) = (unit(2) * (h * h), (unit(2) / 2.0 + unit(3) / 6.0) * (h * h));
    let area = (force - (rate - unit(1) * h) - change * (2.0 * c)) / (w * w);
    let linear = q - area;
    let moment = (first - rate + change - linear * (2.0 * c)) / (w * w);
    let square = q - moment * 2.0;
    [change, linear * 2.0 - change, square * 6.0 - linear * 6.0 + change]
}

/// The loss as a quadratic form in state and F_0, F_1, F_2: that of a short part, then of twice as long a time again
/// and again.
fn loss(omega: f64, zeta: f64, step: f64) -> [f64; 15] {
    let coefficient = 2.0 * zeta * omega;
    if coefficient == 0.0 {
        return [0.0; 15];
    }
    let doublings = (omega.max(coefficient) * step / SHORT).log2().ceil().max(0.0);
    let mut time = step / doublings.exp2();
    let mut form = Matrix5::zeros();
    for (at, weight) in GAUSS {
        let rate = transition(omega, zeta, at * time).row(1).into_owned();
        form += rate.transpose() * rate * (coefficient * weight * time);
    }
    for _ in 0..doublings as usize {
        let over = transition(omega, zeta, time);
        form += over.transpose() * form * over;
        time *= 2.0;
    }
    let turn = from_legendre(step);
    let form = turn.transpose() * form * turn;
    let mut triangle = [0.0; 15];
    let upper = (0..5).flat_map(|i| (i..5).map(move |j| (i, j)));
    for (entry, (i, j)) in triangle.iter_mut().zip(upper) {
        *entry = if i == j { form[(i, i)] } else { form[(i, j)] + form[(j, i)] };
    }
    triangle
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_to_the_moments_agree_and_the_energy_of_one_mode_closes() {
        let step = 5e-5;
        for (omega, zeta) in [(2.2e4, 0.02), (3e4, 0.3), (9e4, 0.001), (2.5e4, 1.7), (4e5, 0.02)] {
            let end = transition(omega, zeta, step) * from_legendre(step);
            let a = by_parts(omega, zeta, step, &end);
            let b = by_quadrature(omega, zeta, step).map(|row| row * from_legendre(step));
            for (a, b) in a.iter().zip(&b) {
                for k in 0..5 {
                    let scale = b[k].abs().max(1e-6 * b.amax());
                    assert!((a[k] - b[k]).abs() < 1e-10 * scale, "{omega} {zeta}: {a} {b}");
                }
            }
        }
        for (omega, zeta) in
            [(0.0, 0.0), (300.0, 0.02), (2e3, 0.0), (3e4, 0.3), (9e4, 0.001), (2.5e4, 1.7), (4e5, 0.02)]
        {
            let table = ModeTable::new(omega, zeta, step);
            let (state, force) = ([1e-6, 0.02], [3.0, -1.5, 0.7]);
            let [m0, m1, m2] = table.moments.map(|row| ModeTable::of(&row, state, force));
            let rate = ModeTable::of(&table.rate, state, force);
            let work = force[0] * m0 + force[1] * m1 + force[2] * m2;
            let stored = |q: f64, v: f64| 0.5 * v * v + 0.5 * (omega * q).powi(2);
            let gained = stored(state[0] + m0, rate) - stored(state[0], state[1]);
            let lost = table.loss(state, force);
            let scale = stored(state[0], state[1]) + work.abs();
            assert!((gained - work + lost).abs() < 1e-11 * scale, "{omega} {zeta}: {gained:e} {work:e} {lost:e}");
            assert!((gained - work + 1.001 * lost).abs() > 1e-11 * scale || lost == 0.0, "control");
        }
    }
}
