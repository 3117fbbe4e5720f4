//! Designs' springs on a device: `shaders/modification.wgsl` and `shaders/extrema.wgsl` against f64.
//!
//! Few sizes, none large: each is a shader of its own, and a software adapter takes 20 s to compile that of 24 springs.

mod route;

use super::EPS;
use crate::modal_fixture::device::device;
use crate::modal_fixture::springs::{AROUND, Machine, PORTS, all_pairs, frobenius, grid};
use nalgebra::{Complex, DMatrix};
use stiffmap::frf::modification::{BaseReceptance, SpringChange, Work};
use stiffmap::frf::refined_extrema;
use stiffmap::gpu::extrema::{extrema, places};
use stiffmap::gpu::modification::{SpringRequest, check, modified};
use stiffmap::gpu::{Gpu, GpuError, Precision};

const NO_CHANGE: SpringChange = SpringChange { stiffness: Complex::new(0.0, 0.0), damping: 0.0 };

/// Every third frequency of the grid.
fn sparse_grid() -> Vec<f64> {
    grid().into_iter().step_by(3).collect()
}

fn exactly(base: &BaseReceptance, designs: &[Vec<SpringChange>]) -> Vec<Vec<Vec<Complex<f64>>>> {
    designs.iter().map(|d| base.modified(d, &all_pairs(), &mut Work::default())).collect()
}

fn on_device(gpu: &Gpu, base: &BaseReceptance, designs: &[Vec<SpringChange>]) -> Vec<Vec<Vec<Complex<f64>>>> {
    modified(gpu, &SpringRequest { base, designs, pairs: &all_pairs(), position: 0 }, Precision::F32).unwrap()
}

#[test]
fn f32_keeps_1e_4_of_the_norm_between_0_3_and_3_times_the_stiffness() {
    let Some(gpu) = device() else { return };
    for (seed, springs) in [(1, 1), (2, 6), (4, 12)] {
        let machine = Machine::new(seed, springs);
        let base = machine.base(&sparse_grid(), AROUND);
        let designs = machine.designs(seed + 10, 3, AROUND);
        let exact = exactly(&base, &designs);
        let figure = frobenius(&on_device(&gpu, &base, &designs), &exact);
        println!("{springs} springs: Frobenius {figure:.2e} in f32");
        assert!(figure <= 1e-4, "{springs} springs: {figure:.2e}");
        // Control: a spring that is forgotten.
        let mut forgotten = designs[..1].to_vec();
        forgotten[0][springs - 1] = NO_CHANGE;
        let figure = frobenius(&on_device(&gpu, &base, &forgotten), &exact[..1]);
        assert!(figure > 1e-2, "control: {figure:.2e}");
    }
}

#[test]
fn a_base_of_uncoupled_parts_loses_ten_times_as_much() {
    let Some(gpu) = device() else { return };
    let machine = Machine::of_floating_parts(3, 12);
    let figure = |from: f64| {
        let base = machine.base(&sparse_grid(), from);
        let designs = machine.designs(13, 4, from);
        frobenius(&on_device(&gpu, &base, &designs), &exactly(&base, &designs))
    };
    let (coupled, uncoupled) = (figure(AROUND), figure(1e-6));
    println!("12 springs of floating parts: Frobenius {coupled:.2e} in f32, from uncoupled parts {uncoupled:.2e}");
    assert!(coupled <= 1e-4, "{coupled:.2e}");
    assert!(uncoupled > 10.0 * coupled, "{coupled:.2e} {uncoupled:.2e}");
}

/// u |T| G |T|^T of each pair: what an error of one rounding in every term comes to.
fn roundings(base: &BaseReceptance, changes: &[SpringChange], k: usize) -> Vec<f64> {
    let h = base.at(k);
    let (s, n) = (base.n_springs, base.n_rows);
    let omega = std::f64::consts::TAU * base.frequencies[k];
    let (mut so_far, mut sizes) = (h.clone(), h.map(|x| x.norm()));
    for (c, change) in changes.iter().enumerate() {
        let delta = change.stiffness + Complex::new(0.0, omega * change.damping);
        let gain = delta / (1.0 + delta * so_far[(c, c)]);
        let before = so_far.clone();
        for i in 0..n {
            for j in 0..n {
                let term = before[(i, c)] * before[(j, c)] * gain;
                so_far[(i, j)] -= term;
                sizes[(i, j)] += term.norm();
            }
        }
    }
    // T = [-H_ps Delta (1 + H_ss Delta)^-1, I].
    let delta = DMatrix::from_fn(s, s, |i, j| {
        if i == j { changes[i].stiffness + Complex::new(0.0, omega * changes[i].damping) } else { Complex::default() }
    });
    let inner = (DMatrix::identity(s, s) + h.view((0, 0), (s, s)) * &delta).try_inverse().unwrap();
    let left = h.view((s, 0), (n - s, s)) * &delta * inner;
    let t = DMatrix::from_fn(n - s, n, |i, j| if j < s { left[(i, j)].norm() } else { f64::from(i + s == j) });
    let bound = &t * sizes * t.transpose() * (EPS / 2.0);
    all_pairs().into_iter().map(|pair| bound[pair]).collect()
}

#[test]
fn f32_stays_within_the_derived_bound() {
    let Some(gpu) = device() else { return };
    let machine = Machine::new(5, 6);
    let base = machine.base(&sparse_grid(), AROUND);
    let mut designs = machine.designs(15, 4, AROUND);
    designs[1].iter_mut().for_each(|c| c.damping = 2e4 * c.stiffness.re / 1e8);
    let exact = exactly(&base, &designs);
    let worst = |found: &[Vec<Vec<Complex<f64>>>]| {
        let mut worst = 0.0f64;
        for (d, changes) in designs.iter().enumerate() {
            for k in (0..base.frequencies.len()).step_by(7) {
                for (p, bound) in roundings(&base, changes, k).iter().enumerate() {
                    worst = worst.max((found[d][p][k] - exact[d][p][k]).norm() / bound);
                }
            }
        }
        worst
    };
    let (found, allowed) = (on_device(&gpu, &base, &designs), (machine.springs() + 16) as f64);
    let figure = worst(&found);
    println!("roundings: {figure:.1} of {allowed}");
    assert!(figure <= allowed, "{figure:.1} of {allowed}");
    // Control: twelve bits of a number, as f16 has.
    let coarse = |x: f64| (x as f32).to_bits() & !0xfff;
    let rounded: Vec<Vec<Vec<_>>> = found
        .iter()
        .map(|d| {
            d.iter()
                .map(|h| h.iter().map(|x| Complex::new(f64::from(f32::from_bits(coarse(x.re))), x.im)).collect())
                .collect()
        })
        .collect();
    assert!(worst(&rounded) > allowed, "control");
}

#[test]
fn springs_that_do_not_change_and_bases_without_springs_are_served() {
    let Some(gpu) = device() else { return };
    let machine = Machine::new(6, 6);
    let base = machine.base(&sparse_grid(), AROUND);
    let mut designs = machine.designs(16, 3, AROUND);
    designs[0].fill(NO_CHANGE);
    designs[1][0] = NO_CHANGE;
    designs[1][4] = NO_CHANGE;
    let found = on_device(&gpu, &base, &designs);
    assert!(frobenius(&found, &exactly(&base, &designs)) <= 1e-4);
    let bare = (0..base.frequencies.len()).map(|k| base.at(k));
    for (k, h) in bare.enumerate() {
        for (p, (i, j)) in all_pairs().into_iter().enumerate() {
            let exact = h[(6 + i, 6 + j)];
            assert!((found[0][p][k] - exact).norm() <= EPS * exact.norm(), "nothing changes, nothing is lost");
        }
    }
    let unsprung = Machine::new(6, 0);
    let base = unsprung.base(&sparse_grid(), AROUND);
    let designs = [Vec::new()];
    assert!(frobenius(&on_device(&gpu, &base, &designs), &exactly(&base, &designs)) <= EPS);
}

#[test]
fn the_f64_shader_changes_springs_to_1e_11() {
    let Some(gpu) = device() else { return };
    let machine = Machine::new(3, 6);
    let base = machine.base(&sparse_grid(), AROUND);
    let designs = machine.designs(13, 2, AROUND);
    let request = SpringRequest { base: &base, designs: &designs, pairs: &all_pairs(), position: 0 };
    match modified(&gpu, &request, Precision::F64) {
        Err(GpuError::NoF64 { .. }) if !gpu.supports(Precision::F64) => println!("skipped: no f64 in shaders"),
        found => {
            let figure = frobenius(&found.unwrap(), &exactly(&base, &designs));
            println!("6 springs: Frobenius {figure:.2e} in f64");
            assert!(figure <= 1e-11, "{figure:.2e}");
        }
    }
}

#[test]
fn extrema_that_a_device_looks_for_are_those_of_the_whole_response() {
    let Some(gpu) = device() else { return };
    let cases =
        [(7, 1, 40, Precision::F32), (8, 6, 12, Precision::F32), (9, 12, 6, Precision::F32), (8, 6, 4, Precision::F64)];
    for (seed, springs, count, precision) in cases.into_iter().filter(|c| gpu.supports(c.3)) {
        let machine = Machine::new(seed, springs);
        let base = machine.base(&grid(), AROUND);
        let designs = machine.designs(seed + 10, count, AROUND);
        let pairs: Vec<_> = (0..PORTS).map(|i| (i, i)).chain([(1, 0)]).collect();
        let request = SpringRequest { base: &base, designs: &designs, pairs: &pairs, position: 0 };
        let found = extrema(&gpu, &request, precision).unwrap();
        let looked: usize = places(&gpu, &request, precision).unwrap().iter().map(Vec::len).sum();
        println!("{springs} springs: {} places a design", looked / designs.len());
        assert!(looked < designs.len() * base.frequencies.len() / 8, "a look at {looked} places spares nothing");
        let mut moved = 0;
        for (found, changes) in found.iter().zip(&designs) {
            let responses = base.modified(changes, &pairs, &mut Work::default());
            for (found, h) in found.iter().zip(&responses) {
                assert_eq!(*found, refined_extrema(&base.frequencies, h));
                let on_grid = h.iter().map(|h| h.norm()).fold(0.0, f64::max);
                moved += usize::from(found.0.value > on_grid * (1.0 + 1e-6));
            }
        }
        assert!(moved > designs.len(), "control: refinement is at work, {moved}");
    }
}

#[test]
fn the_look_at_a_device_passes_for_springs() {
    let Some(gpu) = device() else { return };
    for precision in [Precision::F32, Precision::F64].into_iter().filter(|p| gpu.supports(*p)) {
        println!("{precision:?}: {:.2e}", check(&gpu, precision).unwrap());
    }
}

#[test]
fn a_base_that_is_not_finite_is_an_error_with_its_place() {
    let Some(gpu) = device() else { return };
    let machine = Machine::new(6, 2);
    let mut frequencies = grid();
    frequencies[17] = f64::NAN;
    let base = machine.base(&frequencies, AROUND);
    let designs = machine.designs(16, 1, AROUND);
    let request = SpringRequest { base: &base, designs: &designs, pairs: &[(0, 0)], position: 5 };
    let error = extrema(&gpu, &request, Precision::F32).unwrap_err();
    assert!(matches!(error, GpuError::NotFinite { position: 5, frequency: 17, .. }), "{error}");
}
