//! Families of modes over the travel: crossings, veerings, the mode table.

use nalgebra::DMatrix;
use std::f64::consts::TAU;
use stiffmap::modal::{ModeFamilies, Modes, mode_table, track};

/// Modes with given frequencies (Hz), by rank, and shapes in the columns.
fn made(position: f64, mut pairs: Vec<(f64, Vec<f64>)>) -> Modes {
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let n = pairs.len();
    let shapes = DMatrix::from_fn(n, n, |i, r| pairs[r].1[i]);
    Modes {
        position,
        eigenvalues: pairs.iter().map(|(f, _)| (TAU * f).powi(2)).collect(),
        free: 0,
        damping_ratios: vec![0.0; n],
        loss_factors: vec![0.0; n],
        outputs: shapes.clone(),
        inputs: shapes.clone(),
        direct: DMatrix::zeros(n, n),
        dissipation: None,
        direct_loss_factor: 0.0,
        shapes,
    }
}

/// Two families 100 + 20 p and 100 - 20 p Hz, coupled by `coupling` (Hz) about p = `at`, and a third at 150 Hz.
fn two(position: f64, coupling: f64, at: f64) -> Modes {
    let delta = 20.0 * (position - at);
    let split = delta.hypot(coupling);
    let angle = 0.5 * coupling.atan2(delta);
    let (c, s) = (angle.cos(), angle.sin());
    made(
        position,
        vec![(100.0 + split, vec![c, s, 0.0]), (100.0 - split, vec![-s, c, 0.0]), (150.0, vec![0.0, 0.0, 1.0])],
    )
}

fn tracked(coupling: f64, at: f64) -> ModeFamilies {
    let stations: Vec<Modes> = [-1.5, -0.5, 0.5, 1.5].map(|p| two(p, coupling, at)).into();
    track(&stations, 3, &|p| Ok(two(p, coupling, at))).expect("tracks")
}

fn family(families: &ModeFamilies, name: usize) -> Vec<f64> {
    families.modes.iter().map(|m| m.iter().find(|m| m.family == name).map_or(f64::NAN, |m| m.frequency)).collect()
}

#[test]
fn families_that_cross_keep_their_shapes_labels() {
    let families = tracked(0.0, 0.1);
    assert!(families.veerings.is_empty(), "{:?}", families.veerings);
    let rising = family(&families, 1);
    assert!(rising.is_sorted() && (rising[0] - 68.0).abs() < 1e-9 && (rising[3] - 128.0).abs() < 1e-9, "{rising:?}");
    let ranks: Vec<usize> =
        families.modes.iter().map(|m| m.iter().find(|m| m.family == 1).map_or(0, |m| m.rank)).collect();
    assert_eq!(ranks, [1, 1, 2, 2]);
    // Control: families that repel each other over a width that the stations resolve keep their ranks.
    let apart = tracked(30.0, 0.1);
    assert!(apart.veerings.is_empty());
    assert!(apart.modes.iter().all(|m| m.iter().all(|m| m.family == m.rank)), "{:?}", apart.modes);
}

#[test]
fn a_veering_narrower_than_the_finest_spacing_is_reported_with_its_pair() {
    // The station at 0.5 m stands in the veering, 3 mm wide; six bisections of the step of 1 m end at 16 mm.
    let families = tracked(20.0 / 640.0, 0.501);
    assert!(!families.veerings.is_empty());
    for veering in &families.veerings {
        assert_eq!(veering.families, [1, 2]);
        assert!(veering.mac > 0.4 && veering.mac < 0.9, "{veering:?}");
        assert!((veering.from - 0.5).abs() < 0.016 && (veering.to - 0.5).abs() < 0.016, "{veering:?}");
    }
    assert!(tracked(2.0, 0.501).veerings.is_empty(), "control: a veering of 0.1 m is followed step by step");
}

#[test]
fn a_veering_over_two_of_the_finest_intervals_is_one_line() {
    let veerings = tracked(20.0 / 640.0, 0.501).veerings;
    assert_eq!(veerings.len(), 1, "{veerings:?}");
}

#[test]
fn the_mode_table_gives_range_place_and_interior_extrema() {
    let frequencies = |p: f64| {
        vec![
            (50.0 + 10.0 * p, vec![1.0, 0.0, 0.0]),
            (80.0 - 8.0 * p * (1.0 - p), vec![0.0, 1.0, 0.0]),
            (0.0, vec![0.0, 0.0, 1.0]),
        ]
    };
    let stations: Vec<Modes> = [0.0, 0.25, 0.5, 0.75, 1.0].map(|p| made(p, frequencies(p))).into();
    let families = track(&stations, 3, &|p| Ok(made(p, frequencies(p)))).expect("tracks");
    let table = mode_table(&families);
    assert_eq!(table.len(), 3);
    assert!(
        table[0].min == 0.0 && table[0].difference_percent == 0.0,
        "a free motion divides by nothing: {:?}",
        table[0]
    );
    let straight = table[1];
    assert!(
        (straight.min - 50.0).abs() < 1e-9
            && (straight.max - 60.0).abs() < 1e-9
            && (straight.difference_percent - 20.0).abs() < 1e-7
    );
    assert_eq!((straight.position_of_min, straight.position_of_max, straight.interior_extremum), (0.0, 1.0, false));
    let bowed = table[2];
    assert!((bowed.min - 78.0).abs() < 1e-9 && bowed.position_of_min == 0.5 && bowed.interior_extremum, "{bowed:?}");
    assert!(mode_table(&ModeFamilies::default()).is_empty());
}
