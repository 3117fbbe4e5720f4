//! What a truncated sum leaves out: the polynomial in j omega against the sum over all modes, written
//! out here; and the laws that the bundled mill's own compliance obeys.

use nalgebra::{Complex, DMatrix};
use stiffmap::frf::{FrfRequest, ModalSystem, Quantity, Selection, modal_sum, modal_systems};
use stiffmap::modal::Modes;

type Response = DMatrix<Complex<f64>>;

const TAU: f64 = std::f64::consts::TAU;
const HIGHEST: f64 = 900.0;

/// 120 modes from 20 Hz to 12 kHz, both dampings, one position.
fn modes(position: usize) -> Modes {
    let n = 120;
    let frequency = |r: usize| (20.0 + 40.0 * r as f64 + 0.5 * (r * r) as f64) * (1.0 + 0.02 * position as f64);
    let shapes = DMatrix::from_fn(3, n, |i, r| 0.05 * (1.9 * i as f64 + 0.37 * r as f64 + position as f64).sin());
    Modes {
        position: -0.1 * position as f64,
        eigenvalues: (0..n).map(|r| (TAU * frequency(r)).powi(2)).collect(),
        free: 0,
        damping_ratios: (0..n).map(|r| 0.02 + 1e-4 * r as f64).collect(),
        loss_factors: vec![0.004; n],
        shapes: DMatrix::identity(n, n),
        outputs: shapes.clone(),
        inputs: shapes,
        direct: DMatrix::identity(3, 3) * 2e-10,
        dissipation: None,
        direct_loss_factor: 0.0,
    }
}

/// The oracle: every mode, and the static compliance that no mode carries.
fn all_modes(modes: &Modes, frequency: f64) -> Response {
    let s = Complex::new(0.0, TAU * frequency);
    let mut h = modes.direct.map(|x| Complex::new(x, 0.0));
    for r in 0..modes.eigenvalues.len() {
        let own = modes.eigenvalues[r].sqrt();
        let stiffness = Complex::new(1.0, modes.loss_factors[r]) * own * own;
        let denominator = stiffness + s * s + s * (2.0 * modes.damping_ratios[r] * own);
        let amplitude = modes.outputs.column(r) * modes.inputs.column(r).transpose();
        h += amplitude.map(|a| Complex::new(a, 0.0) / denominator);
    }
    h
}

fn names() -> Vec<String> {
    ["tool.x", "tool.y", "tool.z"].map(String::from).to_vec()
}

/// Largest relative Frobenius difference of the systems' sum to all modes over a grid of the band.
fn error(modes: &[Modes], systems: &[ModalSystem]) -> f64 {
    let frequencies: Vec<f64> = (0..=300).map(|k| HIGHEST * k as f64 / 300.0).collect();
    let positions: Vec<f64> = modes.iter().map(|m| m.position).collect();
    let request = FrfRequest {
        positions: &positions,
        systems,
        frequencies: &frequencies,
        outputs: &names(),
        inputs: &names(),
        quantity: Quantity::Receptance,
    };
    let map = modal_sum(&request).unwrap();
    let mut largest = 0.0f64;
    for (p, modes) in modes.iter().enumerate() {
        for (k, frequency) in frequencies.iter().enumerate() {
            let expected = all_modes(modes, *frequency);
            largest = largest.max((map.matrix(p, k) - &expected).norm() / expected.norm());
        }
    }
    largest
}

#[test]
fn a_controlled_truncation_keeps_its_tolerance() {
    let modes = [modes(0), modes(1), modes(2)];
    let mut degrees = Vec::new();
    for tolerance in [1e-2, 1e-4, 1e-5] {
        let (systems, truncation) = modal_systems(&modes, HIGHEST, Selection::Controlled { tolerance }).unwrap();
        assert!(truncation.error <= tolerance);
        // The program probes at 24 frequencies; between them the error may be a little larger.
        let found = error(&modes, &systems);
        assert!(found <= 1.5 * tolerance, "{found:.1e} for {tolerance:.0e}");
        assert!(truncation.fewest_modes < 120 && truncation.most_modes < 120);
        for (system, modes) in systems.iter().zip(&modes) {
            assert_eq!(system.frequencies.len(), modes.count_up_to(2.0 * HIGHEST));
        }
        degrees.push(truncation.degree.unwrap());
    }
    assert!(degrees.is_sorted() && degrees[0] < degrees[2], "{degrees:?}");
}

#[test]
fn negative_control_a_truncation_without_its_polynomial_misses_the_tolerance() {
    let modes = [modes(0)];
    let (mut systems, _) = modal_systems(&modes, HIGHEST, Selection::Controlled { tolerance: 1e-4 }).unwrap();
    for coefficients in [1, 0] {
        systems[0].residual.truncate(coefficients);
        assert!(error(&modes, &systems) > 1.5e-4, "{coefficients} coefficients");
    }
}

#[test]
fn a_tolerance_that_no_degree_meets_is_an_error_with_both_figures() {
    let refused = modal_systems(&[modes(0)], HIGHEST, Selection::Controlled { tolerance: 1e-30 });
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("12") && message.contains("e-30"), "{message}");
}

#[test]
fn exactly_n_modes_with_the_residual_are_exact_at_rest() {
    let mut modes = modes(0);
    // The constant residual is real: with a loss factor at rest it is the elastic part.
    modes.loss_factors.fill(0.0);
    let expected = all_modes(&modes, 0.0);
    let at_rest = |residual: bool| {
        let selection = Selection::Exactly { modes: 30, residual };
        let (systems, truncation) = modal_systems(std::slice::from_ref(&modes), HIGHEST, selection).unwrap();
        assert_eq!((truncation.fewest_modes, truncation.most_modes), (30, 30));
        assert_eq!(truncation.degree, residual.then_some(0));
        let request = FrfRequest {
            positions: &[0.0],
            systems: &systems,
            frequencies: &[0.0],
            outputs: &names(),
            inputs: &names(),
            quantity: Quantity::Receptance,
        };
        (modal_sum(&request).unwrap().matrix(0, 0) - &expected).norm() / expected.norm()
    };
    assert!(at_rest(true) <= 1e-12, "{:.1e}", at_rest(true));
    assert!(at_rest(false) > 1e-3, "without the residual the machine is too stiff at rest: {:.1e}", at_rest(false));
}

/// The bundled mill's own compliance at rest and over its band, at an end and between stations.
mod mill {
    use super::*;
    use std::sync::OnceLock;
    use stiffmap::frf::ComplianceMap;
    use stiffmap::interrupt::Interrupt;
    use stiffmap::machine::{bundled_vertical_mill, read_machine};
    use stiffmap::modal::modes_at;
    use stiffmap::pipeline;

    struct Solved {
        modes: Vec<Modes>,
        map: ComplianceMap,
    }

    fn solved() -> &'static Solved {
        static SOLVED: OnceLock<Solved> = OnceLock::new();
        SOLVED.get_or_init(|| {
            let folder = tempfile::tempdir().unwrap();
            for (name, content) in bundled_vertical_mill() {
                std::fs::write(folder.path().join(name), content).unwrap();
            }
            let machine = read_machine(&folder.path().join("machine.toml")).unwrap();
            let meshes = pipeline::read_meshes(&machine).unwrap();
            let parts = pipeline::reduce_parts(&machine, &meshes, None, &Interrupt::default(), &|| {}).unwrap();
            let parts: Vec<_> = parts.into_iter().map(|p| p.superelement).collect();
            let model = pipeline::build_model(&machine, &parts, 30, HIGHEST).unwrap().model;
            let positions = [0.0, -0.3137];
            let modes = positions.map(|p| modes_at(&model, &machine.analysis.damping, p).unwrap()).to_vec();
            let (systems, _) = modal_systems(&modes, HIGHEST, Selection::Controlled { tolerance: 1e-4 }).unwrap();
            let frequencies: Vec<f64> = (0..=450).map(|k| 2.0 * f64::from(k)).collect();
            let request = FrfRequest {
                positions: &positions,
                systems: &systems,
                frequencies: &frequencies,
                outputs: &model.output_names(),
                inputs: &model.input_names(),
                quantity: Quantity::Receptance,
            };
            Solved { modes, map: modal_sum(&request).unwrap() }
        })
    }

    fn matrices() -> impl Iterator<Item = Response> {
        let map = &solved().map;
        let at = move |p| (0..map.frequencies.len()).map(move |f| map.matrix(p, f));
        (0..map.positions.len()).flat_map(at)
    }

    fn asymmetry(h: &Response) -> f64 {
        (h - h.transpose()).norm() / h.norm()
    }

    /// Largest imaginary part on the diagonal, relative to the norm.
    fn gain(h: &Response) -> f64 {
        h.diagonal().iter().map(|v| v.im).fold(f64::NEG_INFINITY, f64::max) / h.norm()
    }

    #[test]
    fn the_compliance_is_reciprocal() {
        let largest = matrices().map(|h| asymmetry(&h)).fold(0.0, f64::max);
        assert!(largest <= 1e-12, "{largest:.1e}");
    }

    #[test]
    fn negative_control_one_perturbed_entry_is_not_reciprocal() {
        let mut h = solved().map.matrix(1, 40);
        let norm = h.norm();
        h[(0, 1)] += norm * 1e-9;
        assert!(asymmetry(&h) > 1e-12);
    }

    #[test]
    fn the_machine_takes_power_and_gives_none() {
        let largest = matrices().map(|h| gain(&h)).fold(f64::NEG_INFINITY, f64::max);
        assert!(largest <= 1e-12, "{largest:.1e}");
    }

    #[test]
    fn negative_control_the_other_sign_of_time_gives_power() {
        assert!(gain(&solved().map.matrix(0, 20).map(|v| v.conj())) > 1e-6);
    }

    /// What every elastic mode and the part that no mode carries give at rest.
    fn static_compliance(modes: &Modes) -> DMatrix<f64> {
        let elastic = (modes.free..modes.eigenvalues.len())
            .map(|r| modes.outputs.column(r) * modes.inputs.column(r).transpose() / modes.eigenvalues[r]);
        elastic.fold(modes.direct.clone(), |sum, term| sum + term)
    }

    #[test]
    fn at_rest_the_map_is_the_static_compliance() {
        let Solved { modes, map } = solved();
        for (p, modes) in modes.iter().enumerate() {
            let (found, expected) = (map.matrix(p, 0), static_compliance(modes));
            assert!(found.iter().all(|v| v.im == 0.0));
            let difference = (found.map(|v| v.re) - &expected).norm() / expected.norm();
            assert!(difference <= 1e-12, "{difference:.1e}");
            // Negative control: without its softest mode the machine is another.
            let r = modes.free;
            let softest = modes.outputs.column(r) * modes.inputs.column(r).transpose() / modes.eigenvalues[r];
            assert!(softest.norm() / expected.norm() > 1e-3);
            // A static compliance is positive definite.
            assert!(expected.symmetric_eigenvalues().min() > 0.0);
        }
    }
}
