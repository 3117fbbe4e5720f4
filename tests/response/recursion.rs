//! The exact step of a mode and exact discretisation, against the matrix exponential.

use nalgebra::{DMatrix, Matrix4, SMatrix};
use stiffmap::state_space::{Hold, ModeStep, StateSpace, discretise};

/// exp of [[A, b, 0], [0, 0, 1], [0, 0, 0]] in scaled time, by its Taylor series at a 2^-k of it, squared k times.
fn exponential(omega: f64, zeta: f64, h: f64) -> Matrix4<f64> {
    let (w, c) = (omega * h, zeta * omega * h);
    #[rustfmt::skip]
    let a = Matrix4::new(
        0.0, 1.0, 0.0, 0.0,
        -w * w, -2.0 * c, 1.0, 0.0,
        0.0, 0.0, 0.0, 1.0,
        0.0, 0.0, 0.0, 0.0,
    );
    let halvings = (w.max(2.0 * c).max(1.0).log2().ceil() as i32 + 4).max(0);
    let small = a * 0.5f64.powi(halvings);
    let mut term: SMatrix<f64, 4, 4> = Matrix4::identity();
    let mut sum = term;
    for k in 1..30 {
        term = term * small / f64::from(k);
        sum += term;
    }
    (0..halvings).for_each(|_| sum *= sum);
    sum
}

/// Largest difference of a step to the exponential, each row relative to its largest entry.
fn difference(step: &ModeStep, omega: f64, zeta: f64, h: f64) -> f64 {
    let e = exponential(omega, zeta, h);
    let mut worst = 0.0f64;
    for row in 0..2 {
        let unit = [h, 1.0][row];
        // Scaled time: q stays, q' carries h.
        let expected =
            [e[(row, 0)] * if row == 0 { 1.0 } else { 1.0 / h }, e[(row, 1)] * if row == 0 { h } else { 1.0 }];
        let scale = (expected[0] * if row == 0 { 1.0 } else { h }).abs().max(e[(row, 1)].abs()).max(1e-300);
        worst = worst.max((step.phi[row][0] - expected[0]).abs() * if row == 0 { 1.0 } else { h } / scale);
        worst = worst.max((step.phi[row][1] - expected[1]).abs() / unit / scale);
        let force = [e[(row, 2)] - e[(row, 3)], e[(row, 3)], e[(row, 2)]].map(|x| x * h * unit);
        let found = [step.from[row], step.to[row], step.constant[row]];
        let scale = force.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        worst = worst.max(found.iter().zip(force).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale);
    }
    worst
}

const PHASES: [f64; 14] = [0.0, 1e-9, 1e-4, 0.01, 0.3, 0.999, 1.0, 1.9, 2.1, 3.2, 6.3, 20.0, 100.0, 1000.0];
const RATIOS: [f64; 12] = [0.0, 1e-6, 0.02, 0.5, 0.999999, 1.0, 1.000001, 1.01, 1.5, 10.0, 300.0, 1e5];

#[test]
fn a_step_is_the_matrix_exponentials_from_free_to_overdamped() {
    let h = 5e-5;
    for phase in PHASES {
        for zeta in RATIOS {
            // The reference itself loses what it squares.
            let bound = 3e-13 * (phase * zeta.max(1.0)).max(10.0);
            if bound > 1e-9 {
                continue;
            }
            let step = ModeStep::new(phase / h, zeta, h);
            let found = difference(&step, phase / h, zeta, h);
            assert!(found < bound, "omega h {phase}, zeta {zeta}: {found:.1e}");
        }
    }
    let step = ModeStep::new(0.3 / h, 0.02, h);
    assert!(difference(&step, 0.3 / h * (1.0 + 1e-13), 0.02, h) < 1e-12);
    assert!(difference(&step, 0.3 / h * (1.0 + 1e-9), 0.02, h) > 1e-12, "control: another frequency shows");
    assert!(difference(&step, 0.3 / h, 0.02001, h) > 1e-9, "control: another ratio shows");
}

#[test]
fn a_free_mode_gathers_speed_as_newton_says() {
    let step = ModeStep::new(0.0, 0.0, 0.1);
    assert_eq!(step.phi, [[1.0, 0.1], [0.0, 1.0]]);
    let near = |a: f64, b: f64| (a - b).abs() < 1e-16;
    assert!(near(step.constant[0], 0.005) && near(step.constant[1], 0.1));
    assert!(near(step.from[0], 0.01 / 3.0) && near(step.to[0], 0.01 / 6.0));
}

#[test]
fn an_extremely_damped_mode_creeps_to_its_static_deflection() {
    // c / k = 2 zeta / omega = 2 s: after 1 s it is at 1 - e^(-1/2) of f / k.
    let (omega, zeta) = (1e3, 1e6);
    let step = ModeStep::new(omega, zeta, 1.0);
    let slow = omega / (2.0 * zeta);
    let expected = -(-slow).exp_m1() / (omega * omega);
    assert!((step.constant[0] / expected - 1.0).abs() < 1e-9, "{} {expected}", step.constant[0]);
}

/// A system in modal form with an overdamped and a free mode among the others.
fn system() -> StateSpace {
    let eigenvalues: Vec<f64> = vec![0.0, 1e4, 4e5, 9e6];
    let damping = vec![0.0, 1.4, 0.02, 0.3];
    let n = eigenvalues.len();
    let shape = DMatrix::from_fn(n, 2, |r, i| ((1 + r + 3 * i) as f64).sin());
    let mut a = DMatrix::zeros(2 * n, 2 * n);
    for r in 0..n {
        a[(r, n + r)] = 1.0;
        a[(n + r, r)] = -eigenvalues[r];
        a[(n + r, n + r)] = -2.0 * damping[r] * eigenvalues[r].sqrt();
    }
    let mut b = DMatrix::zeros(2 * n, 2);
    b.rows_mut(n, n).copy_from(&shape);
    let mut c = DMatrix::zeros(2, 2 * n);
    c.columns_mut(0, n).copy_from(&shape.transpose());
    let d = DMatrix::from_row_slice(2, 2, &[1e-7, 2e-8, 2e-8, 3e-7]);
    StateSpace { position: 0.0, a, b, c, d, eigenvalues, eigenvectors: shape, damping, dampers: DMatrix::zeros(0, n) }
}

/// The response to the samples u by the augmented exponential in small pieces, forces held or straight.
fn by_exponential(s: &StateSpace, u: &[[f64; 2]], h: f64, hold: Hold) -> Vec<f64> {
    let (n, m) = (s.a.nrows(), 2);
    let mut big = DMatrix::zeros(n + 2 * m, n + 2 * m);
    big.view_mut((0, 0), (n, n)).copy_from(&(&s.a * h));
    big.view_mut((0, n), (n, m)).copy_from(&(&s.b * h));
    big.view_mut((n, n + m), (m, m)).fill_with_identity();
    let e = big.exp();
    let (phi, held, ramp) = (e.view((0, 0), (n, n)), e.view((0, n), (n, m)), e.view((0, n + m), (n, m)));
    let mut x = nalgebra::DVector::zeros(n);
    let mut out = Vec::new();
    for k in 0..u.len() {
        let now = nalgebra::DVector::from_row_slice(&u[k]);
        out.extend((&s.c * &x + &s.d * &now).iter());
        let next = nalgebra::DVector::from_row_slice(u.get(k + 1).unwrap_or(&u[k]));
        x = phi * &x + held * &now;
        if hold == Hold::First {
            x += ramp * (next - now);
        }
    }
    out
}

fn by_recursion(s: &StateSpace, u: &[[f64; 2]]) -> Vec<f64> {
    let mut x = nalgebra::DVector::zeros(s.a.nrows());
    let mut out = Vec::new();
    for u in u {
        let u = nalgebra::DVector::from_row_slice(u);
        out.extend((&s.c * &x + &s.d * &u).iter());
        x = &s.a * &x + &s.b * &u;
    }
    out
}

#[test]
fn a_discretised_system_has_the_continuous_ones_response_at_the_samples() {
    let s = system();
    let h = 1e-3;
    // From zero, since with straight forces the state of rest is shifted by the first sample.
    let u: Vec<[f64; 2]> = (0..200).map(|k| [(0.3 * f64::from(k)).sin(), (0.11 * f64::from(k * k)).sin()]).collect();
    for hold in [Hold::Zero, Hold::First] {
        let expected = by_exponential(&s, &u, h, hold);
        let found = crate::apart(&by_recursion(&discretise(&s, h, hold), &u), &expected);
        assert!(found < 1e-11, "{hold:?}: {found:.1e}");
        let other = if hold == Hold::Zero { Hold::First } else { Hold::Zero };
        let control = crate::apart(&by_recursion(&discretise(&s, h, other), &u), &expected);
        assert!(control > 1e-3, "control: the other hold is another system, {control:.1e}");
    }
}
