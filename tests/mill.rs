//! The bundled mill against its unreduced model, solved outside this program (tests/reference/full_order_top.json).

use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::OnceLock;
use stiffmap::coupling::{BasisOptions, CoupledModel, couple, reduction_requests};
use stiffmap::machine::{Machine, ReductionMethod, read_machine};
use stiffmap::mesh::{Mesh, read_mesh};
use stiffmap::modal::{Modes, check_count, modes_at};
use stiffmap::reduction::reduce;
use stiffmap::solid::interface_motions;

/// Upper end of the frequency grid, Hz.
const BAND: f64 = 900.0;

struct Mill {
    machine: Machine,
    meshes: Vec<Mesh>,
}

fn mill() -> &'static Mill {
    static MILL: OnceLock<Mill> = OnceLock::new();
    MILL.get_or_init(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/vertical_mill");
        let machine = read_machine(&folder).expect("the bundled machine file");
        let read = |part: &stiffmap::machine::Part| read_mesh(&part.mesh, part.mesh_units).expect("a bundled mesh");
        Mill { meshes: machine.parts.iter().map(read).collect(), machine }
    })
}

fn model_by(method: ReductionMethod) -> CoupledModel {
    let Mill { machine, meshes } = mill();
    let mut machine = machine.clone();
    machine.analysis.component.method = method;
    let parts = machine.parts.iter().zip(meshes);
    let interfaces: Vec<_> = parts.map(|(part, mesh)| interface_motions(part, mesh).expect("surfaces")).collect();
    let requests = reduction_requests(&machine, &interfaces);
    let reduced: Vec<_> = requests.iter().zip(meshes).map(|(r, m)| reduce(r, m, None).expect("reduces")).collect();
    couple(&machine, &reduced, BasisOptions::up_to(BAND)).expect("couples")
}

fn craig_bampton() -> &'static CoupledModel {
    static MODEL: OnceLock<CoupledModel> = OnceLock::new();
    MODEL.get_or_init(|| model_by(ReductionMethod::CraigBampton))
}

fn modes_of(model: &CoupledModel, position: f64) -> Modes {
    modes_at(model, &mill().machine.analysis.damping, position).expect("modes")
}

struct Reference {
    frequencies: Vec<f64>,
    receptance: Vec<(f64, DMatrix<f64>)>,
}

fn reference() -> Reference {
    let json: serde_json::Value = serde_json::from_str(include_str!("reference/full_order_top.json")).expect("JSON");
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
    };
    let receptance = &json["undamped_tool_receptance_m_per_N"];
    let matrices = receptance["matrix"].as_array().expect("a list").iter().map(|m| {
        let rows: Vec<Vec<f64>> = m.as_array().expect("rows").iter().map(numbers).collect();
        DMatrix::from_fn(3, 3, |i, j| rows[i][j])
    });
    Reference {
        frequencies: numbers(&json["frequencies_hz"]),
        receptance: numbers(&receptance["frequency_hz"]).into_iter().zip(matrices).collect(),
    }
}

fn worst_frequency(modes: &Modes, expected: &[f64]) -> f64 {
    let pairs = expected.iter().enumerate();
    pairs.map(|(r, f)| (modes.frequency(modes.free + r) / f - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn thirty_frequencies_at_the_top_are_the_unreduced_models() {
    let reference = reference();
    assert_eq!(reference.frequencies.len(), 30);
    let worst = worst_frequency(&modes_of(craig_bampton(), 0.0), &reference.frequencies);
    println!("largest error of 30 frequencies: {worst:.1e}");
    assert!(worst < 2e-5, "{worst:.1e}");
    let moved = worst_frequency(&modes_of(craig_bampton(), -0.005), &reference.frequencies);
    assert!(moved > 1e-4, "control: one station further down it is another machine, {moved:.1e}");
}

/// The undamped sum over all modes with the direct term, m/N; the free motions do not reach the tool.
fn receptance(modes: &Modes, frequency: f64, count: usize) -> DMatrix<f64> {
    let omega_squared = (TAU * frequency).powi(2);
    let mut sum = modes.direct.clone();
    for r in 0..count {
        let factor = 1.0 / (modes.eigenvalues[r] - omega_squared);
        sum += modes.outputs.column(r) * modes.inputs.column(r).transpose() * factor;
    }
    sum
}

#[test]
fn the_undamped_receptance_at_the_tool_is_the_unreduced_models() {
    let modes = modes_of(craig_bampton(), 0.0);
    let all = modes.eigenvalues.len();
    let reference = reference().receptance;
    assert_eq!(reference.len(), 7);
    for (frequency, exact) in &reference {
        let error = (receptance(&modes, *frequency, all) - exact).norm() / exact.norm();
        println!("{frequency} Hz: {error:.1e}");
        assert!(error < 1e-3, "{frequency} Hz: {error:.1e}");
        let moved = (receptance(&modes, frequency * 1.01, all) - exact).norm() / exact.norm();
        let cut = (receptance(&modes, *frequency, 31) - modes.direct.clone() - exact).norm() / exact.norm();
        assert!(moved.max(cut) > 1e-3, "control: 1 % in frequency or 30 modes alone show, {moved:.1e} {cut:.1e}");
    }
}

#[test]
fn the_spindles_free_turn_is_found_at_exactly_zero_and_named() {
    for position in [0.0, -0.3025, -0.6] {
        let modes = modes_of(craig_bampton(), position);
        assert_eq!(modes.free, 1);
        assert_eq!(modes.frequency(0), 0.0);
        assert!(modes.frequency(1) > 30.0);
        let free = modes.free_motions(craig_bampton());
        assert_eq!(free.len(), 1);
        assert_eq!(free[0].name, "spindle turns about z");
        let others = (1..31).map(|r| modes.outputs.column(r).amax()).fold(0.0, f64::max);
        assert!(
            free[0].at_outputs < 1e-3 * others,
            "{:.1e} of {others:.1e}: the tool's centre does not move",
            free[0].at_outputs
        );
    }
}

#[test]
fn no_mode_is_missed_anywhere_and_a_removed_one_is_noticed() {
    for position in [0.0, -0.1525, -0.3, -0.4475, -0.6] {
        let modes = modes_of(craig_bampton(), position);
        let count = check_count(craig_bampton(), &modes, 31).expect("complete");
        assert!(count.found >= 31 && count.found == count.counted);
        let mut fewer = modes;
        fewer.eigenvalues.remove(17);
        assert!(check_count(craig_bampton(), &fewer, 31).is_err());
    }
}

#[test]
fn the_two_reduction_methods_agree_in_thirty_frequencies() {
    let free = model_by(ReductionMethod::FreeInterface);
    for position in [0.0, -0.2875, -0.6] {
        let (a, b) = (modes_of(craig_bampton(), position), modes_of(&free, position));
        let expected: Vec<f64> = (1..31).map(|r| b.frequency(r)).collect();
        let worst = worst_frequency(&a, &expected);
        println!("{position} m: {worst:.1e}");
        assert!(worst < 1e-4, "{position} m: {worst:.1e}");
        let shifted = worst_frequency(&modes_of(craig_bampton(), position.min(-0.005) + 0.005), &expected);
        assert!(position == 0.0 || shifted > 1e-4, "control: 5 mm away they differ, {shifted:.1e}");
    }
}
