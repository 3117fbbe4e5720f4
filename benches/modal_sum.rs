//! The modal sum on the processor at the main job's size: 121 positions x 2000 frequencies x 30 modes, 3 x 3.
//! The devices, how long it takes to list and open them, and every back end in one run.
//! `cargo bench --bench modal_sum`; with `-- --json`, the processor's row alone as `stiffmap bench --json`
//! gives it; with `-- --stream`, maps that are never held whole.

use std::time::Instant;

use nalgebra::Complex;
use stiffmap::frf::{Tile, metrics, modal_sum, modal_sum_into, modal_sum_tiles};
use stiffmap::gpu::{self, Gpu, Precision};

#[path = "../tests/modal_fixture/mod.rs"]
mod modal_fixture;
use modal_fixture::{Case, Numbers, symmetric_system};

fn main() {
    if std::env::args().any(|a| a == "--stream") {
        return streaming();
    }
    if std::env::args().any(|a| a == "--json") {
        let backend = gpu::Backend::Cpu;
        let request = gpu::bench::BenchRequest { backend, ..Default::default() };
        let rows = gpu::bench::measure(&request).expect("the processor works");
        return println!("{}", serde_json::to_string(&rows).expect("rows are plain numbers"));
    }
    let mut numbers = Numbers(1);
    let systems = (0..121).map(|_| symmetric_system(&mut numbers, 3, 30, 0.02)).collect();
    let case = Case::new(systems, (0..2000).map(|i| 0.5 * i as f64).collect());
    let request = case.request();
    let mut values = vec![Complex::default(); request.len()];
    report("modal_sum_into, f64", || modal_sum_into(&request, &mut values).expect("a good request"));
    report("modal_sum, f64, memory included", || drop(modal_sum(&request).expect("a good request")));
    let map = modal_sum(&request).expect("a good request");
    let pairs = metrics::direct_pairs(&request);
    report("metrics of the direct pairs, refined", || {
        drop(metrics::metrics(&request, &map, &pairs).expect("a good request"));
    });
    devices(&request, &pairs);
}

/// Time must grow with the positions, memory must not.
fn streaming() {
    let mut numbers = Numbers(1);
    let systems: Vec<_> = (0..12_100).map(|_| symmetric_system(&mut numbers, 3, 30, 0.02)).collect();
    for n in [1210, 12_100] {
        let frequencies = (0..2000).map(|i| 0.5 * i as f64).collect();
        let case = Case::new(systems[..n].to_vec(), frequencies);
        let mut bytes = 0;
        let mut sink = |tile: Tile<'_>| {
            bytes += size_of_val(tile.values);
            Ok(())
        };
        let start = Instant::now();
        modal_sum_tiles(&case.request(), 0, &mut sink).expect("a good request");
        let seconds = start.elapsed().as_secs_f64();
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let peak = status.lines().find(|l| l.starts_with("VmHWM")).unwrap_or("peak memory unknown");
        println!("streamed {n} positions, {} MB of map: {:.0} ms, {peak}", bytes >> 20, 1e3 * seconds);
    }
}

fn devices(request: &stiffmap::frf::FrfRequest, pairs: &[(usize, usize)]) {
    let start = Instant::now();
    let adapters = gpu::list_adapters();
    println!("listing adapters: {:.1} ms", 1e3 * start.elapsed().as_secs_f64());
    adapters.iter().for_each(|a| println!("  {a:?}"));
    let start = Instant::now();
    let Ok(gpu) = Gpu::open() else {
        return println!("no adapter");
    };
    println!("opening {}: {:.1} ms", gpu.adapter().name, 1e3 * start.elapsed().as_secs_f64());
    for precision in [Precision::F32, Precision::F64] {
        println!("{:?}", gpu::trust::check(&gpu, precision));
    }
    report("extrema on the device, f32, refined", || {
        drop(gpu::metrics::metrics(&gpu, request, pairs, Precision::F32).expect("a good request"));
    });
    for row in gpu::bench::measure(&gpu::bench::BenchRequest::default()).expect("the device works") {
        println!("{row:?}");
    }
}

fn report(name: &str, mut run: impl FnMut()) {
    run();
    let mut seconds: Vec<f64> = (0..20)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    println!("{name}: median {:.2} ms, least {:.2} ms", 1e3 * seconds[seconds.len() / 2], 1e3 * seconds[0]);
}
