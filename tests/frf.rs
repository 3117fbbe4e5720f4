//! The modal sum in f64 on the processor: against the sum as it is written, and against the laws that it obeys.

mod modal_fixture;

use modal_fixture::{Case, Numbers, differences, plain_sum, residual, symmetric_system};
use nalgebra::{Complex, DMatrix};
use proptest::prelude::*;
use stiffmap::frf::{FrfError, ModalSystem, Quantity, Tile, modal_sum, modal_sum_into, modal_sum_tiles};

const QUANTITIES: [Quantity; 3] = [Quantity::Receptance, Quantity::Mobility, Quantity::Accelerance];

/// Three positions with different numbers of modes, both kinds of damping and a residual.
fn machine(n_modes: usize) -> Case {
    let mut numbers = Numbers(7);
    let systems = (0..3)
        .map(|p| {
            let mut system = symmetric_system(&mut numbers, 3, n_modes + p, 0.02);
            system.loss_factors.iter_mut().for_each(|eta| *eta = numbers.within(0.0, 0.03));
            system.damping_ratios.iter_mut().for_each(|zeta| *zeta = numbers.within(1e-4, 0.05));
            system.residual = residual(&mut numbers, 3);
            system
        })
        .collect();
    Case::new(systems, (0..1237).map(|i| 0.75 * i as f64).collect())
}

/// Five outputs, two inputs, complex residual without symmetry.
fn unsymmetric(n_modes: usize) -> Case {
    let mut numbers = Numbers(11);
    let mut system = symmetric_system(&mut numbers, 5, n_modes, 0.01);
    system.inputs = numbers.matrix(2, n_modes, 0.05);
    system.residual = (0..4)
        .map(|k| {
            let scale = 1e-9 * 1e-3f64.powi(k);
            let (re, im) = (numbers.matrix(5, 2, scale), numbers.matrix(5, 2, scale));
            re.zip_map(&im, Complex::new)
        })
        .collect();
    Case::new(vec![system], (0..61).map(|i| 1.0 + 13.0 * i as f64).collect())
}

#[test]
fn the_sum_equals_the_sum_as_it_is_written() {
    for mut case in [machine(1), machine(30), unsymmetric(8), unsymmetric(31)] {
        for quantity in QUANTITIES {
            case.quantity = quantity;
            let (entry, frobenius) = differences(&case, &modal_sum(&case.request()).unwrap());
            assert!(entry < 2e-12 && frobenius < 2e-12, "{quantity:?}: entry {entry:e}, Frobenius {frobenius:e}");
        }
    }
}

#[test]
fn the_comparison_notices_a_perturbed_mode() {
    let case = machine(30);
    let mut map = modal_sum(&case.request()).unwrap();
    let middle = map.values.len() / 2;
    map.values[middle] *= 1.0 + 1e-9;
    assert!(differences(&case, &map).0 > 2e-12);
}

#[test]
fn every_count_of_pairs_is_summed() {
    let mut numbers = Numbers(3);
    for n_ports in 1..=6 {
        let system = symmetric_system(&mut numbers, n_ports, 5, 0.01);
        let mut asymmetric = system.clone();
        asymmetric.inputs = numbers.matrix(2, 5, 0.05);
        for system in [system, asymmetric] {
            let case = Case::new(vec![system], vec![0.0, 100.0, 333.0]);
            let (entry, _) = differences(&case, &modal_sum(&case.request()).unwrap());
            assert!(entry < 1e-12, "{n_ports} ports: {entry:e}");
        }
    }
}

#[test]
fn light_damping_keeps_its_digits_beside_a_resonance() {
    let mut system = symmetric_system(&mut Numbers(5), 1, 1, 1e-9);
    system.frequencies[0] = 123.456;
    let f = 123.456 * (1.0 + 1e-9);
    let case = Case::new(vec![system], vec![f]);
    let h = modal_sum(&case.request()).unwrap().values[0];
    // With x = f - f_r small: D = -x (2 f_r + x) + 2 j zeta f_r f, all without cancellation.
    let x = f - 123.456;
    let d = Complex::new(-x * (2.0 * 123.456 + x), 2e-9 * 123.456 * f);
    let a = case.systems[0].outputs[(0, 0)].powi(2) / std::f64::consts::TAU.powi(2);
    let relative = (h * d / a - 1.0).norm();
    assert!(relative < 1e-14, "{relative:e}");
}

#[test]
fn tiles_append_to_the_whole_map_from_any_pair_on() {
    let case = machine(6);
    let request = case.request();
    let whole = modal_sum(&request).unwrap();
    let mut held = vec![Complex::default(); request.len()];
    modal_sum_into(&request, &mut held).unwrap();
    assert_eq!(held, whole.values);
    for first_pair in [0, 1, 1236, 1237, 2000, 3 * 1237 - 1] {
        let mut appended = Vec::new();
        let mut sink = |tile: Tile<'_>| {
            appended.extend_from_slice(tile.values);
            Ok(())
        };
        modal_sum_tiles(&request, first_pair, &mut sink).unwrap();
        assert_eq!(appended, whole.values[first_pair * 9..], "from pair {first_pair}");
    }
}

#[test]
fn a_receiver_that_fails_stops_the_map() {
    let case = machine(2);
    let mut sink = |_: Tile<'_>| Err("disk full".into());
    let error = modal_sum_tiles(&case.request(), 0, &mut sink).unwrap_err();
    assert!(matches!(&error, FrfError::Sink { position: 0, .. }) && error.to_string().contains("disk full"), "{error}");
}

#[test]
fn bad_requests_are_refused_with_the_value_seen() {
    let refuse = |change: &dyn Fn(&mut Case)| {
        let mut case = machine(4);
        change(&mut case);
        modal_sum(&case.request()).unwrap_err().to_string()
    };
    type Change<'a> = &'a dyn Fn(&mut Case);
    let cases: [(Change, &str); 10] = [
        (&|c| c.frequencies.clear(), "frequencies is empty"),
        (&|c| c.frequencies[3] = f64::NAN, "frequency 3 of the grid is NaN"),
        (&|c| c.frequencies[0] = -1.0, "frequency 0 of the grid is -1"),
        (&|c| c.frequencies[3] = 0.1, "must ascend"),
        (&|c| c.positions[1] = f64::INFINITY, "position 1 is inf"),
        (&|c| c.systems[2].frequencies[1] = f64::NAN, "mode 1 at position 2: the frequency in Hz is NaN"),
        (&|c| c.systems[2].damping_ratios[1] = -0.1, "the damping ratio is -0.1"),
        (&|c| c.systems[0].outputs[(1, 2)] = f64::NAN, "mode 2 at position 0: a shape is NaN"),
        (&|c| c.systems[0].residual[1][(0, 0)].im = f64::NAN, "residual coefficient 1 at position 0"),
        (
            &|c| c.systems[1].frequencies[0] = 0.0,
            "at position -0.005 m nothing resists 1 rigid motion that the ports feel",
        ),
    ];
    for (change, expected) in cases {
        let message = refuse(change);
        assert!(message.contains(expected), "expected {expected:?} in {message:?}");
    }
    let undamped = refuse(&|c| {
        c.systems[0].damping_ratios[2] = 0.0;
        c.systems[0].loss_factors[2] = 0.0;
        c.frequencies = vec![1.0, c.systems[0].frequencies[2]];
    });
    assert!(undamped.contains("mode 2 at position 0 has no damping"), "{undamped}");
}

#[test]
#[should_panic(expected = "shape of inputs at position 1")]
fn a_shape_that_does_not_fit_is_a_callers_mistake() {
    let mut case = machine(4);
    case.systems[1].inputs = DMatrix::zeros(2, 5);
    let _ = modal_sum(&case.request());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_symmetric_map_is_reciprocal_and_dissipates(seed in any::<u64>(), zeta in 1e-5..0.2f64, eta in 0.0..0.3f64) {
        let case = passive(seed, zeta, eta);
        prop_assert!(is_passive(&case));
    }

    #[test]
    fn the_static_response_is_the_sum_of_flexibilities_and_the_residual(seed in any::<u64>(), zeta in 1e-5..0.2f64) {
        let case = passive(seed, zeta, 0.0);
        let difference = static_difference(&case);
        prop_assert!(difference < 1e-13, "{difference:e}");
    }
}

fn passive(seed: u64, zeta: f64, eta: f64) -> Case {
    let mut numbers = Numbers(seed);
    let mut system = symmetric_system(&mut numbers, 3, 12, zeta);
    system.loss_factors.fill(eta);
    system.residual = residual(&mut numbers, 3);
    Case::new(vec![system], (0..200).map(|i| 5.0 * i as f64).collect())
}

/// H = H^T and Im H_ii <= 0 at every frequency.
fn is_passive(case: &Case) -> bool {
    let map = modal_sum(&case.request()).unwrap();
    (0..case.frequencies.len()).all(|k| {
        let h = map.matrix(0, k);
        h == h.transpose() && (0..3).all(|i| h[(i, i)].im <= 0.0)
    })
}

/// |H(0) - (sum L R^T / omega_r^2 + C_0)| / |H(0)|.
fn static_difference(case: &Case) -> f64 {
    let system = &case.systems[0];
    let mut expected = system.residual[0].clone();
    for (r, f) in system.frequencies.iter().enumerate() {
        let omega = std::f64::consts::TAU * f;
        let product = system.outputs.column(r) * system.inputs.column(r).transpose() / (omega * omega);
        expected += product.map(Complex::from);
    }
    let h = modal_sum(&case.request()).unwrap().matrix(0, 0);
    (&h - expected).map(|x| x.norm()).norm() / h.map(|x| x.norm()).norm()
}

#[test]
fn the_laws_notice_a_broken_system() {
    let mut reciprocal = passive(1, 0.02, 0.0);
    reciprocal.systems[0].inputs[(0, 0)] *= 1.0 + 1e-6;
    assert!(!is_passive(&reciprocal));
    let mut dissipative = passive(1, 0.02, 0.0);
    dissipative.systems[0].inputs.neg_mut();
    assert!(!is_passive(&dissipative));
    let mut at_rest = passive(1, 0.02, 0.0);
    assert!(static_difference(&at_rest) < 1e-13);
    at_rest.frequencies[0] = 0.5;
    assert!(static_difference(&at_rest) > 1e-6);
}

#[test]
fn the_oracle_is_the_closed_form_of_one_spring_and_mass() {
    // m = 4 kg, k = 9e6 N/m, no damping, at half the natural frequency: 1 / (k (1 - 1/4)).
    let natural = (9e6f64 / 4.0).sqrt() / std::f64::consts::TAU;
    let system = ModalSystem {
        frequencies: vec![natural],
        damping_ratios: vec![0.0],
        loss_factors: vec![0.0],
        outputs: DMatrix::from_element(1, 1, 0.5),
        inputs: DMatrix::from_element(1, 1, 0.5),
        residual: Vec::new(),
        exact: None,
    };
    let expected = 1.0 / (9e6 * 0.75);
    let oracle = plain_sum(&system, natural / 2.0, Quantity::Receptance)[(0, 0)];
    assert!((oracle / expected - 1.0).norm() < 1e-14);
    let case = Case::new(vec![system], vec![natural / 2.0]);
    assert!((modal_sum(&case.request()).unwrap().values[0] / expected - 1.0).norm() < 1e-14);
}

/// Two masses (kg) in line, joined by a spring (N/m) alone: a free motion and an elastic one.
fn two_masses(m: [f64; 2], k: f64, zeta: f64) -> ModalSystem {
    let whole = m[0] + m[1];
    let reduced = m[0] * m[1] / whole;
    let free = 1.0 / whole.sqrt();
    let apart = [(m[1] / (m[0] * whole)).sqrt(), -(m[0] / (m[1] * whole)).sqrt()];
    let shapes = DMatrix::from_row_slice(2, 2, &[free, apart[0], free, apart[1]]);
    ModalSystem {
        frequencies: vec![0.0, (k / reduced).sqrt() / std::f64::consts::TAU],
        damping_ratios: vec![0.0, zeta],
        loss_factors: vec![0.0; 2],
        outputs: shapes.clone(),
        inputs: shapes,
        residual: Vec::new(),
        exact: None,
    }
}

#[test]
fn accelerance_of_a_free_body_at_0_hz_is_one_over_its_mass() {
    let (m, k) = ([3.0, 5.0], 2e7);
    let mut case = Case::new(vec![two_masses(m, k, 0.02)], vec![0.0, 1e-3, 100.0, 400.0]);
    case.quantity = Quantity::Accelerance;
    let map = modal_sum(&case.request()).expect("it is finite");
    // Force on one mass, acceleration of either: the whole moves by 1 / (m_1 + m_2), and no spring is stretched.
    for value in map.matrix(0, 0).iter() {
        assert!((value - 1.0 / 8.0).norm() < 1e-15, "{value}");
        assert!((value - 1.0 / 3.0).norm() > 0.1, "control: not one mass alone");
    }
    // Continuous: beside 0 Hz it differs by the elastic mode's omega^2 phi^2 / omega_r^2 alone.
    assert!((map.matrix(0, 1) - map.matrix(0, 0)).iter().all(|d| d.norm() < 1e-11));
    // Elsewhere as the equations of motion say, without damping: (k - m_2 omega^2) / (m_1 m_2 omega^2 - k (m_1 + m_2)).
    case.systems = vec![two_masses(m, k, 0.0)];
    let omega2 = (std::f64::consts::TAU * 100.0).powi(2);
    let exact = -omega2 * (k - m[1] * omega2) / (m[0] * m[1] * omega2 * omega2 - k * 8.0 * omega2);
    let found = modal_sum(&case.request()).expect("finite").matrix(0, 2)[(0, 0)];
    assert!((found.re / exact - 1.0).abs() < 1e-12 && found.im == 0.0, "{found} {exact}");
    // A grid of 0 Hz alone, and tiles from any pair on, agree.
    case.frequencies = vec![0.0];
    assert!((modal_sum(&case.request()).expect("finite").values[0] - 0.125).norm() < 1e-15);
    // A machine that is held does not accelerate at 0 Hz.
    let mut held = machine(3);
    held.quantity = Quantity::Accelerance;
    assert!(modal_sum(&held.request()).expect("finite").matrix(0, 0).iter().all(|a| a.norm() == 0.0));
}

#[test]
fn receptance_and_mobility_of_a_free_body_at_0_hz_are_refused_with_what_moves_and_no_word_of_damping() {
    let mut case = Case::new(vec![two_masses([3.0, 5.0], 2e7, 0.02)], vec![0.0, 10.0]);
    for quantity in [Quantity::Receptance, Quantity::Mobility] {
        case.quantity = quantity;
        let error = modal_sum(&case.request()).expect_err("it is infinite").to_string();
        let request = case.request();
        let named = request.check_at_rest(&["bed slides along x".into(), "bed slides along x".into()]);
        let named = named.expect_err("it is infinite").to_string();
        for (text, fragments) in [
            (&error, ["1 rigid motion that the ports feel", "begin the frequencies above 0 Hz", quantity.name()]),
            (&named, ["(bed slides along x)", "a joint to a part that is held", "accelerance is finite"]),
        ] {
            fragments.iter().for_each(|f| assert!(text.contains(f), "{f:?} is not in {text}"));
            assert!(!text.contains("damping"), "{text}");
        }
    }
    case.frequencies[0] = 0.001;
    assert!(modal_sum(&case.request()).is_ok(), "above 0 Hz every quantity is finite");
}
