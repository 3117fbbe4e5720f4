//! Kernels on a device: against f64 and against the readable f32 twin.
//!
//! Without an adapter a test prints `skipped: no adapter`; with STIFFMAP_GPU=require that is a failure.

mod modal_fixture;
mod springs_on_device;
mod support;

use modal_fixture::device::device;
use modal_fixture::{Case, Numbers, differences, rich, symmetric_system};
use nalgebra::Complex;
use stiffmap::frf::metrics::{direct_pairs, grid_extrema};
use stiffmap::frf::{ModalSystem, Quantity, Tile, modal_sum};
use stiffmap::gpu::{self, GpuError, Precision, trust, twin};

const EPS: f64 = f32::EPSILON as f64;
const QUANTITIES: [Quantity; 3] = [Quantity::Receptance, Quantity::Mobility, Quantity::Accelerance];

/// Thirty modes and frequencies on and beside each of them.
fn beside_resonances(seed: u64, damping: impl Fn(usize) -> f64) -> Case {
    let mut numbers = Numbers(seed);
    let systems: Vec<ModalSystem> = (0..2)
        .map(|_| {
            let mut system = symmetric_system(&mut numbers, 3, 30, 0.0);
            system.damping_ratios = (0..30).map(&damping).collect();
            system
        })
        .collect();
    let offsets = (1..=7).flat_map(|k| [0.1f64.powi(k), -0.1f64.powi(k)]).chain([0.0]);
    let mut frequencies: Vec<f64> =
        offsets.flat_map(|o| systems.iter().flat_map(|s| &s.frequencies).map(move |f| f * (1.0 + o))).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    Case::new(systems, frequencies)
}

#[test]
fn f32_stays_within_its_bounds_on_and_beside_resonances_at_any_damping() {
    let Some(gpu) = device() else { return };
    let mixed = |r: usize| 10f64.powf(-4.0 + 3.0 * r as f64 / 29.0);
    let dampings: [(&str, &dyn Fn(usize) -> f64); 5] = [
        ("2 %", &|_| 0.02),
        ("0.1 %", &|_| 1e-3),
        ("0.01 %", &|_| 1e-4),
        ("10 %", &|_| 0.1),
        ("0.01 % to 10 %", &mixed),
    ];
    for (name, damping) in dampings {
        let case = beside_resonances(31, damping);
        let map = gpu::modal_sum(&gpu, &case.request(), Precision::F32).unwrap();
        let (entry, frobenius) = differences(&case, &map);
        println!("damping {name}: entry {:.2} eps, Frobenius {frobenius:.2e}", entry / EPS);
        assert!(entry <= 8.0 * EPS, "damping {name}: entry {:.2} eps", entry / EPS);
        assert!(frobenius <= 2e-6, "damping {name}: Frobenius {frobenius:.2e}");
    }
}

#[test]
fn a_plain_f32_difference_breaks_the_bounds() {
    let Some(gpu) = device() else { return };
    let case = beside_resonances(31, |_| 1e-3);
    let map = gpu::modal_sum_without_low_parts(&gpu, &case.request()).unwrap();
    let (entry, frobenius) = differences(&case, &map);
    println!("without low parts: entry {:.0} eps, Frobenius {frobenius:.2e}", entry / EPS);
    assert!(entry > 8.0 * EPS && frobenius > 2e-6, "entry {:.2} eps, Frobenius {frobenius:.2e}", entry / EPS);
}

#[test]
fn quantities_residuals_and_any_number_of_ports_are_summed() {
    let Some(gpu) = device() else { return };
    for n_ports in [1, 2, 3, 5] {
        for quantity in QUANTITIES {
            let mut case = rich(n_ports);
            case.quantity = quantity;
            let (entry, _) = differences(&case, &gpu::modal_sum(&gpu, &case.request(), Precision::F32).unwrap());
            assert!(entry <= 8.0 * EPS, "{n_ports} ports, {quantity:?}: {:.2} eps", entry / EPS);
        }
    }
    let mut numbers = Numbers(8);
    let mut case = rich(5);
    for system in &mut case.systems {
        let n = system.frequencies.len();
        system.inputs = numbers.matrix(3, n, 0.05);
        system.residual = vec![numbers.matrix(5, 3, 1e-9).map(|x| Complex::new(x, 0.5 * x))];
    }
    case.inputs.truncate(3);
    let (entry, _) = differences(&case, &gpu::modal_sum(&gpu, &case.request(), Precision::F32).unwrap());
    assert!(entry <= 8.0 * EPS, "5 x 3: {:.2} eps", entry / EPS);
}

#[test]
fn the_f64_shader_matches_to_1e_12() {
    let Some(gpu) = device() else { return };
    if !gpu.supports(Precision::F64) {
        println!("skipped: {} has no f64 in shaders", gpu.adapter().name);
        let error = gpu::modal_sum(&gpu, &rich(3).request(), Precision::F64).err().unwrap();
        assert!(matches!(error, GpuError::NoF64 { .. }), "{error}");
        return;
    }
    for case in [beside_resonances(31, |_| 1e-4), rich(3)] {
        let map = gpu::modal_sum(&gpu, &case.request(), Precision::F64).unwrap();
        let reference = modal_sum(&case.request()).unwrap();
        let mut worst = 0.0f64;
        for (row, exact) in map.values.chunks_exact(9).zip(reference.values.chunks_exact(9)) {
            let norm = |x: &mut dyn Iterator<Item = Complex<f64>>| x.map(|x| x.norm_sqr()).sum::<f64>().sqrt();
            let difference = norm(&mut row.iter().zip(exact).map(|(a, b)| a - b));
            let relative = difference / norm(&mut exact.iter().copied());
            assert!(relative <= 1e-12, "{relative:e}");
            worst = worst.max(relative);
        }
        println!("f64 shader: Frobenius {worst:.2e}");
    }
}

#[test]
fn the_readable_twin_is_the_kernel() {
    let Some(gpu) = device() else { return };
    for quantity in QUANTITIES {
        let mut case = rich(3);
        case.quantity = quantity;
        let request = case.request();
        let device = gpu::modal_sum(&gpu, &request, Precision::F32).unwrap();
        let exact = modal_sum(&request).unwrap();
        for (p, k, i, j) in [(0, 1, 0, 0), (1, 77, 0, 2), (2, 300, 2, 1), (4, 699, 1, 1)] {
            let twin = twin::entry(&request, p, k, i, j);
            let sum = modal_fixture::sum_of_magnitudes(&case.systems[p], case.frequencies[k], quantity)[(i, j)];
            for other in [device.at(p, k, i, j), exact.at(p, k, i, j)] {
                let difference = (twin - other).norm() / sum;
                assert!(difference <= 8.0 * EPS, "{quantity:?} {p} {k} {i} {j}: {:.2} eps", difference / EPS);
            }
        }
    }
}

#[test]
fn extrema_found_on_the_device_are_those_of_the_processor() {
    let Some(gpu) = device() else { return };
    let case = {
        let mut case = rich(3);
        // More than one chunk of the metrics kernel.
        case.frequencies = (0..3000).map(|i| 0.3 * i as f64).collect();
        case
    };
    let request = case.request();
    let map = modal_sum(&request).unwrap();
    let pairs: Vec<_> = (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).collect();
    let expected = grid_extrema(&map, &pairs);
    for precision in [Precision::F32, Precision::F64].into_iter().filter(|p| gpu.supports(*p)) {
        let found = gpu::metrics::grid_extrema(&gpu, &request, &pairs, precision).unwrap();
        for (p, (found, expected)) in found.iter().zip(&expected).enumerate() {
            for ((found, expected), &(i, j)) in found.iter().zip(expected).zip(&pairs) {
                // Another frequency only where its value is the same to the device's rounding.
                let peak = |k| map.at(p, k, i, j).norm();
                let real = |k| map.at(p, k, i, j).re;
                assert!(peak(found.peak) >= peak(expected.peak) * (1.0 - 16.0 * EPS), "{found:?} {expected:?}");
                let slack = 16.0 * EPS * peak(expected.peak);
                let (a, b) = (real(found.most_negative_real), real(expected.most_negative_real));
                assert!(a <= b + slack, "{found:?} {expected:?}: {a:e} {b:e}");
            }
        }
    }
    let refined = gpu::metrics::metrics(&gpu, &request, &direct_pairs(&request), Precision::F32).unwrap();
    let on_cpu = stiffmap::frf::metrics::metrics(&request, &map, &direct_pairs(&request)).unwrap();
    for (a, b) in refined.iter().flatten().zip(on_cpu.iter().flatten()) {
        assert!((a.peak.value / b.peak.value - 1.0).abs() < 1e-9, "{a:?} {b:?}");
        assert!((a.most_negative_real.value / b.most_negative_real.value - 1.0).abs() < 1e-9, "{a:?} {b:?}");
    }
}

#[test]
fn of_equal_values_the_lowest_frequency_is_named() {
    let Some(gpu) = device() else { return };
    // No residue at all: every value is 0, so every frequency ties.
    let mut case = rich(1);
    case.frequencies = (1..2500).map(|i| 0.3 * i as f64).collect();
    for system in &mut case.systems {
        system.outputs.fill(0.0);
        system.inputs.fill(0.0);
        system.residual.clear();
    }
    let request = case.request();
    let found = gpu::metrics::grid_extrema(&gpu, &request, &[(0, 0)], Precision::F32).unwrap();
    assert_eq!(found, grid_extrema(&modal_sum(&request).unwrap(), &[(0, 0)]));
    assert!(found.iter().all(|p| p[0].peak == 0 && p[0].most_negative_real == 0), "{found:?}");
}

#[test]
fn the_look_at_a_device_passes_and_notices_lost_low_parts() {
    let Some(gpu) = device() else { return };
    for precision in [Precision::F32, Precision::F64].into_iter().filter(|p| gpu.supports(*p)) {
        let figures = trust::check(&gpu, precision).unwrap();
        println!("{figures:?}");
        assert!(figures.pairs >= 200, "{} pairs", figures.pairs);
    }
    let broken = trust::figures_of(|request| gpu::modal_sum_without_low_parts(&gpu, request)).unwrap();
    assert!(broken.entry > broken.entry_bound, "{broken:?}");
}

#[test]
fn tiles_come_in_order_and_append_to_the_map() {
    let Some(gpu) = device() else { return };
    let mut numbers = Numbers(2);
    let systems = (0..40).map(|_| symmetric_system(&mut numbers, 3, 3, 0.02)).collect();
    let case = Case::new(systems, (0..4000).map(|i| 0.2 * i as f64).collect());
    let request = case.request();
    let whole = gpu::modal_sum(&gpu, &request, Precision::F32).unwrap();
    for first_pair in [0, 4001, 8000] {
        let (mut appended, mut tiles) = (Vec::new(), 0);
        let mut sink = |tile: Tile<'_>| {
            appended.extend_from_slice(tile.values);
            tiles += 1;
            Ok(())
        };
        gpu::modal_sum_tiles(&gpu, &request, Precision::F32, first_pair, &mut sink).unwrap();
        assert!(tiles > 2, "{tiles} tiles");
        assert!(appended == whole.values[first_pair * 9..], "from pair {first_pair}");
    }
}

#[test]
fn a_free_bodys_accelerance_at_0_hz_is_the_processors() {
    let Some(gpu) = device() else { return };
    let mut case = rich(3);
    case.quantity = Quantity::Accelerance;
    // Below the antiresonances the value at 0 Hz is the largest; with all frequencies some other.
    for frequencies in [vec![0.0], vec![0.0, 1e-3, 2e-3], (0..3000).map(|i| 0.3 * i as f64).collect()] {
        case.frequencies = frequencies;
        for system in &mut case.systems {
            system.frequencies[0] = 0.0;
            system.damping_ratios[0] = 0.0;
            system.loss_factors[0] = 0.0;
        }
        let request = case.request();
        let map = modal_sum(&request).unwrap();
        let pairs = direct_pairs(&request);
        for precision in [Precision::F32, Precision::F64].into_iter().filter(|p| gpu.supports(*p)) {
            let found = gpu::modal_sum(&gpu, &request, precision).unwrap();
            for p in 0..request.positions.len() {
                assert_eq!(found.matrix(p, 0), map.matrix(p, 0));
                assert!(map.matrix(p, 0).iter().any(|a| a.norm() > 0.0), "control: the body does accelerate");
            }
            let seen = gpu::metrics::grid_extrema(&gpu, &request, &pairs, precision).unwrap();
            for (p, (seen, expected)) in seen.iter().zip(grid_extrema(&map, &pairs)).enumerate() {
                for ((seen, expected), &(i, j)) in seen.iter().zip(&expected).zip(&pairs) {
                    let (a, b) = (map.at(p, seen.peak, i, j).norm(), map.at(p, expected.peak, i, j).norm());
                    assert!(a >= b * (1.0 - 16.0 * EPS), "{seen:?} {expected:?}");
                }
            }
        }
    }
}
