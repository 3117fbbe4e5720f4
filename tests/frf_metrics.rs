//! Peaks and grids: metrics must not depend on where the grid's points fall.

mod modal_fixture;

use modal_fixture::{Case, Numbers, symmetric_system};
use stiffmap::frf::metrics::{PairMetrics, direct_pairs, grid_extrema, metrics};
use stiffmap::frf::{FrequencyGrid, GridSearch, ModalSystem, Quantity, Tile, TileLimits, modal_sum, tiles};

/// Fifteen modes at 0.5 % damping, two of them within one half band of each other.
fn system(seed: u64) -> ModalSystem {
    let mut system = symmetric_system(&mut Numbers(seed), 3, 15, 0.005);
    system.frequencies[8] = system.frequencies[7] * 1.003;
    system.frequencies.sort_by(f64::total_cmp);
    system
}

/// Every pair of three ports, cross pairs too.
fn pairs() -> Vec<(usize, usize)> {
    (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).collect()
}

fn refined(system: &ModalSystem, quantity: Quantity, step: f64) -> Vec<PairMetrics> {
    let grid = FrequencyGrid::Uniform { from: 0.0, to: 950.0, step };
    let mut case = Case::new(vec![system.clone()], grid.frequencies().unwrap());
    case.quantity = quantity;
    let request = case.request();
    metrics(&request, &modal_sum(&request).unwrap(), &pairs()).unwrap().remove(0)
}

/// Peak and most negative real part on a grid of 1e-4 Hz, taken in pieces of the band.
fn on_a_fine_grid(system: &ModalSystem, quantity: Quantity) -> Vec<(f64, f64)> {
    let mut best = vec![(0.0f64, f64::INFINITY); 9];
    for piece in 0..95 {
        let from = 10.0 * piece as f64;
        let mut case = Case::new(vec![system.clone()], (0..=100_000).map(|i| from + 1e-4 * i as f64).collect());
        case.quantity = quantity;
        let map = modal_sum(&case.request()).unwrap();
        for row in map.values.chunks_exact(9) {
            for (best, h) in best.iter_mut().zip(row) {
                *best = (best.0.max(h.norm()), best.1.min(h.re));
            }
        }
    }
    best
}

#[test]
fn refined_peaks_from_half_a_hertz_match_a_grid_of_a_tenth_of_a_millihertz() {
    for (seed, quantity) in [(1, Quantity::Receptance), (2, Quantity::Mobility), (3, Quantity::Accelerance)] {
        let system = system(seed);
        let fine = on_a_fine_grid(&system, quantity);
        let mut worst = [0.0f64; 2];
        for (m, (peak, real)) in refined(&system, quantity, 0.5).iter().zip(&fine) {
            let name = format!("{quantity:?} {} {}", m.output, m.input);
            assert!((m.peak.value / peak - 1.0).abs() < 1e-4, "{name}: {:?} against {peak:e}", m.peak);
            // Where a real part is never negative its smallest value is near 0, so it is measured by the peak.
            let difference = (m.most_negative_real.value - real).abs() / real.abs().max(1e-3 * peak);
            assert!(difference < 1e-4, "{name}: {:?} against {real:e}", m.most_negative_real);
            worst = [worst[0].max((m.peak.value / peak - 1.0).abs()), worst[1].max(difference)];
        }
        println!("{quantity:?}: peak {:.1e}, most negative real part {:.1e}", worst[0], worst[1]);
    }
}

#[test]
fn the_grid_alone_misses_what_refinement_finds() {
    let system = system(1);
    let fine = on_a_fine_grid(&system, Quantity::Receptance);
    let case = Case::new(vec![system], (0..1900).map(|i| 0.5 * i as f64).collect());
    let map = modal_sum(&case.request()).unwrap();
    let coarse = grid_extrema(&map, &pairs()).remove(0);
    let missed = pairs()
        .iter()
        .zip(&coarse)
        .zip(&fine)
        .any(|((&(i, j), grid), (peak, _))| map.at(0, grid.peak, i, j).norm() / peak < 1.0 - 1e-3);
    assert!(missed, "a 0.5 Hz grid at 0.5 % damping should miss a peak by more than 1e-3");
}

#[test]
fn metrics_do_not_depend_on_the_grid() {
    let system = system(4);
    for (a, b) in refined(&system, Quantity::Receptance, 0.5).iter().zip(refined(&system, Quantity::Receptance, 3.7)) {
        assert!((a.peak.value / b.peak.value - 1.0).abs() < 1e-9, "{a:?} {b:?}");
        assert!((a.peak.frequency / b.peak.frequency - 1.0).abs() < 1e-6, "{a:?} {b:?}");
        assert!((a.most_negative_real.value / b.most_negative_real.value - 1.0).abs() < 1e-9, "{a:?} {b:?}");
    }
}

#[test]
fn one_modes_extrema_are_the_closed_forms() {
    let (f, zeta) = (100.0, 0.05f64);
    let mut one = symmetric_system(&mut Numbers(9), 1, 1, zeta);
    one.frequencies[0] = f;
    let a = one.outputs[(0, 0)].powi(2) / (std::f64::consts::TAU * f).powi(2);
    let case = Case::new(vec![one], (0..=20).map(|i| 10.0 * i as f64).collect());
    let request = case.request();
    let found = metrics(&request, &modal_sum(&request).unwrap(), &direct_pairs(&request)).unwrap()[0][0];
    let near = |x: f64, y: f64| assert!((x / y - 1.0).abs() < 1e-9, "{x} against {y}");
    near(found.peak.value, a / (2.0 * zeta * (1.0 - zeta * zeta).sqrt()));
    near(found.peak.frequency, f * (1.0 - 2.0 * zeta * zeta).sqrt());
    near(found.most_negative_real.value, -a / (4.0 * zeta * (1.0 + zeta)));
    near(found.most_negative_real.frequency, f * (1.0 + 2.0 * zeta).sqrt());
    near(found.smallest_dynamic_stiffness(), 1.0 / found.peak.value);
}

#[test]
fn an_undamped_mode_between_two_frequencies_has_no_peak_to_report() {
    let mut one = symmetric_system(&mut Numbers(9), 1, 1, 0.0);
    one.frequencies[0] = 100.5;
    let case = Case::new(vec![one], vec![100.0, 101.0]);
    let request = case.request();
    let error = metrics(&request, &modal_sum(&request).unwrap(), &direct_pairs(&request)).unwrap_err();
    assert!(error.to_string().contains("100.5"), "{error}");
}

#[test]
fn grids_hold_their_ends_and_ascend() {
    let uniform = FrequencyGrid::Uniform { from: 0.0, to: 900.0, step: 0.1 }.frequencies().unwrap();
    assert_eq!((uniform.len(), uniform[0], uniform[9000]), (9001, 0.0, 900.0));
    let short = FrequencyGrid::Uniform { from: 1.0, to: 2.0, step: 0.3 }.frequencies().unwrap();
    assert_eq!(short.len(), 4);
    let log = FrequencyGrid::Logarithmic { from: 1.0, to: 1000.0, count: 4 }.frequencies().unwrap();
    assert!(log.iter().zip([1.0, 10.0, 100.0, 1000.0]).all(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{log:?}");
    assert_eq!(FrequencyGrid::Listed(vec![1.0, 5.0]).frequencies().unwrap(), [1.0, 5.0]);
}

#[test]
fn thirteen_clustered_frequencies_come_within_a_thousandth_of_a_peak() {
    let modes = vec![(20.03, 0.001), (333.3, 0.02), (2000.0, 0.01)];
    let clustered = FrequencyGrid::Clustered { from: 0.0, to: 900.0, modes, points: 13, background: 10 };
    let grid = clustered.frequencies().unwrap();
    assert_eq!(grid.len(), 10 + 2 * 13);
    assert!(grid.windows(2).all(|w| w[0] < w[1]) && grid[0] == 0.0 && grid[grid.len() - 1] == 900.0);
    // The seventh is the mode's own frequency.
    let mut one = symmetric_system(&mut Numbers(9), 1, 1, 0.001);
    one.frequencies[0] = 20.03;
    let case = Case::new(vec![one], grid);
    let request = case.request();
    let map = modal_sum(&request).unwrap();
    let on_grid = map.values.iter().map(|h| h.norm()).fold(0.0, f64::max);
    let peak = metrics(&request, &map, &[(0, 0)]).unwrap()[0][0].peak.value;
    assert!(on_grid / peak > 0.999, "{}", on_grid / peak);
}

#[test]
fn one_clustered_grid_serves_every_position() {
    // A family that wanders from 40 to 44 Hz, one at rest, one that is hardly damped.
    let n = 60;
    let systems: Vec<ModalSystem> = (0..n)
        .map(|p| {
            let mut system = symmetric_system(&mut Numbers(5), 1, 3, 0.02);
            system.frequencies = vec![40.0 + 4.0 * p as f64 / n as f64, 120.0, 300.0 + 0.1 * p as f64];
            system.damping_ratios = vec![0.02, 0.01, 1e-4];
            system
        })
        .collect();
    let modes: Vec<(f64, f64)> =
        systems.iter().flat_map(|s| s.frequencies.iter().copied().zip(s.damping_ratios.iter().copied())).collect();
    let count = modes.len();
    let grid = FrequencyGrid::Clustered { from: 0.0, to: 900.0, modes, points: 13, background: 10 };
    let grid = grid.frequencies().unwrap();
    println!("{} frequencies for {count} modes", grid.len());
    assert!(grid.windows(2).all(|w| w[0] < w[1]));
    assert!(grid.len() < 13 * count * 2 / 3, "{}", grid.len());
    let case = Case::new(systems, grid);
    let request = case.request();
    let map = modal_sum(&request).unwrap();
    let peaks = metrics(&request, &map, &[(0, 0)]).unwrap();
    let on_grid = grid_extrema(&map, &[(0, 0)]);
    for (p, (peak, grid)) in peaks.iter().zip(&on_grid).enumerate() {
        let ratio = map.at(p, grid[0].peak, 0, 0).norm() / peak[0].peak.value;
        assert!(ratio > 0.98, "position {p}: {ratio}");
    }
}

#[test]
fn extrema_are_the_same_tile_by_tile() {
    let systems: Vec<ModalSystem> = (1..=5).map(system).collect();
    let case = Case::new(systems, (0..1900).map(|i| 0.5 * i as f64).collect());
    let request = case.request();
    let map = modal_sum(&request).unwrap();
    for limit in [700, 1900, 4000] {
        let limits = TileLimits { pairs: limit, positions: usize::MAX, frequencies: usize::MAX };
        let mut search = GridSearch::new(&request, &pairs());
        let mut from = 0;
        for range in tiles(5, 1900, 0, limits) {
            let to = from + 9 * range.pairs();
            search.look(&Tile { range, values: &map.values[from..to] });
            from = to;
        }
        assert_eq!(search.finish(), grid_extrema(&map, &pairs()), "tiles of {limit}");
    }
}

#[test]
fn grids_that_make_no_sense_are_refused() {
    let refused = [
        FrequencyGrid::Uniform { from: 0.0, to: 900.0, step: 0.0 },
        FrequencyGrid::Uniform { from: 0.0, to: 900.0, step: f64::NAN },
        FrequencyGrid::Uniform { from: 0.0, to: 900.0, step: 1e-12 },
        FrequencyGrid::Uniform { from: -1.0, to: 900.0, step: 1.0 },
        FrequencyGrid::Uniform { from: 2.0, to: 1.0, step: 1.0 },
        FrequencyGrid::Logarithmic { from: 0.0, to: 900.0, count: 10 },
        FrequencyGrid::Logarithmic { from: 1.0, to: 900.0, count: 1 },
        FrequencyGrid::Clustered { from: 0.0, to: 9.0, modes: vec![(f64::NAN, 0.1)], points: 13, background: 5 },
        FrequencyGrid::Listed(vec![]),
        FrequencyGrid::Listed(vec![2.0, 1.0]),
    ];
    for grid in refused {
        assert!(grid.frequencies().is_err(), "{grid:?}");
    }
}

#[test]
fn a_free_bodys_accelerance_is_largest_at_0_hz_below_its_antiresonance() {
    let mut case = Case::new(vec![symmetric_system(&mut Numbers(9), 1, 2, 0.02)], (0..=20).map(f64::from).collect());
    case.quantity = Quantity::Accelerance;
    case.systems[0].frequencies = vec![0.0, 500.0];
    case.systems[0].damping_ratios[0] = 0.0;
    let rigid = case.systems[0].outputs[(0, 0)].powi(2);
    let request = case.request();
    let found = metrics(&request, &modal_sum(&request).unwrap(), &direct_pairs(&request)).unwrap()[0][0];
    assert!((found.peak.value / rigid - 1.0).abs() < 1e-14 && found.peak.frequency == 0.0, "{found:?} {rigid}");
    assert!(found.most_negative_real.value < rigid && found.most_negative_real.frequency == 20.0, "{found:?}");
}
