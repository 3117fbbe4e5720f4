//! One mode over one sample, exactly.
//!
//! In the time scaled by the step, with w = omega h and c = zeta w, the response to a unit impulse is
//!
//! ```text
//! g(s) = e^(-c s) sin(d s) / d,   d^2 = w^2 - c^2      G(s) = int_0^s g
//! ```
//!
//! and a force that is constant or linear over the step enters by g(1), G(1) and int_0^1 G. For small w
//! and c these come from the Taylor series of g, whose terms follow from the equation of motion; two
//! well separated real roots by their own exponentials; everything between from sine (or sinh) and the
//! equation of motion integrated once and twice. No branch subtracts nearly equal numbers.

/// The exact step of q'' + 2 zeta omega q' + omega^2 q = f over a time h.
///
/// ```text
/// [q, q'](h) = phi [q, q'](0) + constant f                      f constant
/// [q, q'](h) = phi [q, q'](0) + from f(0) + to f(h)             f linear in between
/// ```
///
/// Any zeta of at least zero (overdamped modes too), omega = 0 included.
///
/// # Accuracy
/// A few units in the last place of the largest entry of each row, plus that of omega h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeStep {
    /// Rows q, q'; columns q, q'.
    pub phi: [[f64; 2]; 2],
    /// q (kg^(1/2) m per N kg^(-1/2)) and q' for a force that stays constant.
    pub constant: [f64; 2],
    /// q and q' for the force at the beginning of the step.
    pub from: [f64; 2],
    /// q and q' for the force at its end.
    pub to: [f64; 2],
    /// q and q' for a force that grows with the square of the time, to 1/2 at the end.
    pub quadratic: [f64; 2],
}

impl ModeStep {
    /// The step of a mode over a time.
    ///
    /// # Panics
    /// If omega or zeta is negative, or the step is not positive.
    pub fn new(omega: f64, zeta: f64, step: f64) -> Self {
        assert!(omega >= 0.0 && zeta >= 0.0 && step > 0.0, "omega {omega}, zeta {zeta}, step {step}");
        let (w, c) = (omega * step, zeta * omega * step);
        let Impulse { g, rate, first, second, third } = Impulse::after_one(w, zeta);
        let h = step;
        Self {
            // q from a unit displacement is g' + 2 c g = 1 - w^2 G.
            phi: [[if w < 1.0 { 1.0 - w * w * first } else { rate + 2.0 * c * g }, h * g], [-w * w * g / h, rate]],
            constant: [h * h * first, h * g],
            from: [h * h * (first - second), h * (g - first)],
            to: [h * h * second, h * first],
            quadratic: [h * h * third, h * second],
        }
    }

    /// q and q' at the end of the step, for q and q' and the force at its beginning and the force at its end.
    pub fn advance(&self, [q, v]: [f64; 2], [from, to]: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| self.phi[i][0] * q + self.phi[i][1] * v + self.from[i] * from + self.to[i] * to)
    }
}

/// g(1), g'(1), int g, int int g, int int int g in scaled time.
struct Impulse {
    g: f64,
    rate: f64,
    first: f64,
    second: f64,
    third: f64,
}

impl Impulse {
    fn after_one(w: f64, zeta: f64) -> Self {
        let c = zeta * w;
        // c^2 - w^2 without the loss of 1 - zeta^2 near critical damping.
        let discriminant = w * w * (zeta - 1.0) * (zeta + 1.0);
        if w.max(2.0 * c) <= 2.0 {
            Self::series(w, c)
        } else if discriminant >= 0.25 {
            Self::two_roots(w, c, discriminant.sqrt())
        } else {
            Self::closed(w, c, discriminant)
        }
    }

    /// g = sum t_k with (k + 2)(k + 1) t_(k+2) = -2 c (k + 1) t_(k+1) - w^2 t_k.
    fn series(w: f64, c: f64) -> Self {
        let (mut before, mut term) = (0.0, 1.0);
        let mut out = Self { g: 0.0, rate: 0.0, first: 0.0, second: 0.0, third: 0.0 };
        for k in 1..60 {
            let n = f64::from(k);
            out.g += term;
            out.rate += n * term;
            out.first += term / (n + 1.0);
            out.second += term / ((n + 1.0) * (n + 2.0));
            out.third += term / ((n + 1.0) * (n + 2.0) * (n + 3.0));
            let next = -(2.0 * c * n * term + w * w * before) / ((n + 1.0) * n);
            (before, term) = (term, next);
        }
        out
    }

    /// Roots r_1 = -w^2 / (c + root) and r_2 = -(c + root), apart by 2 root.
    fn two_roots(w: f64, c: f64, root: f64) -> Self {
        let (slow, fast) = (-w * w / (c + root), -(c + root));
        let apart = 2.0 * root;
        let difference = |f: fn(f64) -> f64| (f(slow) - f(fast)) / apart;
        Self {
            g: difference(f64::exp),
            rate: (slow * slow.exp() - fast * fast.exp()) / apart,
            first: difference(mean_exponential),
            second: difference(|r| rest_of_exponential(r, 2)),
            third: difference(|r| rest_of_exponential(r, 3)),
        }
    }

    fn closed(w: f64, c: f64, discriminant: f64) -> Self {
        let root = discriminant.abs().sqrt();
        let (sine, cosine) = match () {
            () if root < 1e-8 => (1.0, 1.0),
            () if discriminant < 0.0 => (root.sin() / root, root.cos()),
            () => (root.sinh() / root, root.cosh()),
        };
        let decay = (-c).exp();
        let (g, rate) = (decay * sine, decay * (cosine - c * sine));
        let first = (1.0 - rate - 2.0 * c * g) / (w * w);
        let second = (1.0 - 2.0 * c * first - g) / (w * w);
        Self { g, rate, first, second, third: (0.5 - 2.0 * c * second - first) / (w * w) }
    }
}

/// (e^r - 1) / r.
fn mean_exponential(r: f64) -> f64 {
    if r == 0.0 { 1.0 } else { r.exp_m1() / r }
}

/// e^r without the first so many terms of its series, over r to that power: (e^r - 1 - r) / r^2 for two.
fn rest_of_exponential(r: f64, terms: i32) -> f64 {
    if r.abs() > 0.5 {
        let (mut term, mut rest) = (r, r.exp_m1());
        for k in 1..terms {
            rest -= term;
            term *= r / f64::from(k + 1);
        }
        return rest / r.powi(terms);
    }
    let mut term: f64 = (1..=terms).map(|k| f64::from(k).recip()).product();
    let mut sum = 0.0;
    for k in terms + 1..terms + 22 {
        sum += term;
        term *= r / f64::from(k);
    }
    sum
}
