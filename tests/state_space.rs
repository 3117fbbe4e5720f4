//! State space and modal sum of the same modes: C (j omega I - A)^-1 B + D, solved as it is written,
//! equals the sum over the modes with the constant residual.

use nalgebra::{Complex, DMatrix};
use stiffmap::modal::Modes;
use stiffmap::state_space::{StateSpace, StateSpaceOptions, state_space};

type Response = DMatrix<Complex<f64>>;

const TAU: f64 = std::f64::consts::TAU;

/// A free mode that no port feels, then elastic ones; 3 outputs, 3 inputs (or `inputs`), a static part.
fn modes(n_elastic: usize, n_input: usize, zeta: f64) -> Modes {
    let n = n_elastic + 1;
    let wave = |i: usize, r: usize, seed: f64| 0.05 * (1.3 * i as f64 + 0.7 * r as f64 + seed).sin();
    let frequency = |r: usize| 14.0 + 31.0 * r as f64 + 4.0 * (r as f64).sin();
    let felt = |r: usize| if r == 0 { 0.0 } else { 1.0 };
    Modes {
        position: -0.3,
        eigenvalues: (0..n).map(|r| felt(r) * (TAU * frequency(r)).powi(2)).collect(),
        free: 1,
        damping_ratios: (0..n).map(|r| felt(r) * zeta * (1.0 + 0.1 * r as f64)).collect(),
        loss_factors: vec![0.0; n],
        shapes: DMatrix::identity(n, n),
        outputs: DMatrix::from_fn(3, n, |i, r| felt(r) * wave(i, r, 0.2)),
        inputs: DMatrix::from_fn(n_input, n, |i, r| felt(r) * wave(i, r, 0.9)),
        direct: DMatrix::from_fn(3, n_input, |i, j| 1e-10 * (1.0 + i as f64 + 2.0 * j as f64)),
        dissipation: None,
        direct_loss_factor: 0.0,
    }
}

fn options(modes: usize, residual: bool) -> StateSpaceOptions {
    StateSpaceOptions { modes, velocity: false, acceleration: false, residual }
}

/// C (j omega I - A)^-1 B + D.
fn transfer(system: &StateSpace, frequency: f64) -> Response {
    let complex = |m: &DMatrix<f64>| m.map(|x| Complex::new(x, 0.0));
    let n = system.a.nrows();
    let s = Complex::new(0.0, TAU * frequency);
    let resolvent = DMatrix::identity(n, n) * s - complex(&system.a);
    let states = resolvent.lu().solve(&complex(&system.b)).unwrap();
    complex(&system.c) * states + complex(&system.d)
}

/// The receptance sum over the elastic modes of `range`, and nothing else.
fn modal_sum(modes: &Modes, range: std::ops::Range<usize>, frequency: f64) -> Response {
    let omega = TAU * frequency;
    let mut h = Response::zeros(modes.outputs.nrows(), modes.inputs.nrows());
    for r in range {
        let own = modes.eigenvalues[r].sqrt();
        let denominator = Complex::new(own * own - omega * omega, 2.0 * modes.damping_ratios[r] * own * omega);
        let amplitude = modes.outputs.column(r) * modes.inputs.column(r).transpose();
        h += amplitude.map(|a| Complex::new(a, 0.0) / denominator);
    }
    h
}

/// R0 = H(0) - sum over the kept modes: the static part and the modes left out, at rest.
fn residual(modes: &Modes, kept: usize) -> Response {
    modal_sum(modes, modes.free + kept..modes.eigenvalues.len(), 0.0) + modes.direct.map(|x| Complex::new(x, 0.0))
}

fn difference(a: &Response, b: &Response) -> f64 {
    (a - b).norm() / b.norm()
}

const FREQUENCIES: [f64; 7] = [0.0, 3.0, 44.9, 80.0, 200.0, 333.3, 900.0];
const DAMPINGS: [f64; 3] = [0.02, 1e-3, 1e-4];

#[test]
fn the_transfer_matrix_is_the_modal_sum_with_the_constant_residual() {
    for zeta in DAMPINGS {
        let modes = modes(12, 3, zeta);
        for (kept, with) in [(12, true), (8, true), (8, false), (1, true)] {
            let system = state_space(&modes, options(kept, with));
            for frequency in FREQUENCIES {
                let mut expected = modal_sum(&modes, 1..1 + kept, frequency);
                if with {
                    expected += residual(&modes, kept);
                }
                let found = difference(&transfer(&system, frequency), &expected);
                assert!(found <= 1e-10, "zeta {zeta}, {kept} modes, {frequency} Hz: {found:.1e}");
            }
        }
    }
}

#[test]
fn negative_control_a_perturbed_eigenvalue_is_noticed() {
    let modes = modes(8, 3, 0.02);
    let mut system = state_space(&modes, options(8, true));
    let n = system.a.nrows() / 2;
    system.a[(n + 2, 2)] *= 1.0 + 1e-6;
    let own = modes.frequency(3);
    let expected = modal_sum(&modes, 1..9, own) + residual(&modes, 8);
    let found = difference(&transfer(&system, own), &expected);
    assert!(found > 1e-8, "{found:.1e}");
}

#[test]
fn negative_control_a_missing_residual_is_noticed() {
    let modes = modes(12, 3, 0.02);
    let system = state_space(&modes, options(8, false));
    let expected = modal_sum(&modes, 1..9, 80.0) + residual(&modes, 8);
    assert!(difference(&transfer(&system, 80.0), &expected) > 1e-4);
}

#[test]
fn velocity_rows_are_j_omega_and_acceleration_rows_its_square_times_the_sum() {
    for zeta in DAMPINGS {
        let modes = modes(10, 3, zeta);
        let asked = StateSpaceOptions { modes: 7, velocity: true, acceleration: true, residual: true };
        let system = state_space(&modes, asked);
        for frequency in FREQUENCIES {
            let found = transfer(&system, frequency);
            let s = Complex::new(0.0, TAU * frequency);
            // The residual is the displacement's alone: its rate would need derivatives of the force.
            let sum = modal_sum(&modes, 1..8, frequency);
            let rows = |block: usize| found.rows(3 * block, 3).into_owned();
            assert!(difference(&rows(0), &(&sum + residual(&modes, 7))) <= 1e-10);
            // At 0 Hz both are zero, which the scale of the sum of terms tells from a difference.
            let scale = |power: i32| sum.norm() * (TAU * frequency.max(1.0)).powi(power);
            let velocity = (rows(1) - &sum * s).norm() / scale(1);
            assert!(velocity <= 1e-10, "zeta {zeta}, {frequency} Hz: {velocity:.1e}");
            // D of these rows cancels C (j omega I - A)^-1 B there, so its norm is the scale.
            let direct = system.d.rows(6, 3).norm();
            let acceleration = (rows(2) - &sum * (s * s)).norm() / direct.max(scale(2));
            assert!(acceleration <= 1e-10, "zeta {zeta}, {frequency} Hz: {acceleration:.1e}");
        }
        // Without D the acceleration rows are not the accelerance.
        let mut wrong = system.clone();
        wrong.d.rows_mut(6, 3).fill(0.0);
        let s = Complex::new(0.0, TAU * 80.0);
        let expected = modal_sum(&modes, 1..8, 80.0) * (s * s);
        assert!(difference(&transfer(&wrong, 80.0).rows(6, 3).into_owned(), &expected) > 1e-2);
    }
}

#[test]
fn rows_stand_in_the_order_that_was_asked_for() {
    let modes = modes(5, 2, 0.02);
    let ask = |velocity, acceleration| {
        state_space(&modes, StateSpaceOptions { modes: 5, velocity, acceleration, residual: false })
    };
    let (both, only) = (ask(true, true), ask(false, true));
    assert_eq!(only.c.shape(), (6, 10));
    assert_eq!(only.c.rows(3, 3), both.c.rows(6, 3));
    assert_eq!(only.d.rows(3, 3), both.d.rows(6, 3));
    assert_ne!(only.c.rows(3, 3), both.c.rows(3, 3));
}

#[test]
fn shapes_are_those_of_the_papers_equations() {
    for (n, n_input) in [(30, 3), (4, 2), (1, 1)] {
        let modes = modes(n + 3, n_input, 0.02);
        let system =
            state_space(&modes, StateSpaceOptions { modes: n, velocity: true, acceleration: true, residual: true });
        assert_eq!(system.a.shape(), (2 * n, 2 * n));
        assert_eq!(system.b.shape(), (2 * n, n_input));
        assert_eq!(system.c.shape(), (9, 2 * n));
        assert_eq!(system.d.shape(), (9, n_input));
        assert_eq!(system.eigenvectors.shape(), (n, 3));
        // The free mode that no port feels is not among them.
        assert_eq!(system.eigenvalues, modes.eigenvalues[1..=n]);
        assert_eq!(system.damping, modes.damping_ratios[1..=n]);
        assert_eq!(system.a.view((0, n), (n, n)), DMatrix::<f64>::identity(n, n));
        assert!(system.b.rows(0, n).iter().all(|b| *b == 0.0));
        assert_eq!(system.position, -0.3);
    }
}

#[test]
fn a_structural_loss_enters_as_half_its_viscous_ratio() {
    let mut modes = modes(4, 3, 0.01);
    modes.loss_factors.iter_mut().skip(1).for_each(|eta| *eta = 0.006);
    let system = state_space(&modes, options(4, false));
    for (found, viscous) in system.damping.iter().zip(&modes.damping_ratios[1..]) {
        assert!((found - viscous - 0.003).abs() < 1e-15);
    }
}

#[test]
fn a_free_motion_that_a_port_feels_is_kept() {
    let mut modes = modes(4, 3, 0.01);
    modes.outputs.column_mut(0).fill(0.05);
    modes.inputs.column_mut(0).fill(0.05);
    let system = state_space(&modes, options(4, false));
    assert_eq!(system.a.nrows(), 10);
    assert_eq!(system.eigenvalues[0], 0.0);
}
