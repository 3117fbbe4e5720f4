//! Which back end answers, what it reports, and what happens without an adapter or with a damaged cache.

mod modal_fixture;

use std::path::Path;
use std::process::Command;

use modal_fixture::{Case, Numbers, symmetric_system};
use nalgebra::Complex;
use stiffmap::frf::metrics::{direct_pairs, metrics};
use stiffmap::frf::{Tile, modal_sum};
use stiffmap::gpu::{
    self, Backend, BackendOptions, GpuError, MeasuredCache, Precision, compute, compute_metrics, compute_tiles,
};

fn case(n_positions: usize, n_frequencies: usize) -> Case {
    let mut numbers = Numbers(17);
    let systems = (0..n_positions).map(|_| symmetric_system(&mut numbers, 3, 30, 0.02)).collect();
    Case::new(systems, (0..n_frequencies).map(|i| 900.0 * i as f64 / n_frequencies as f64).collect())
}

fn options(backend: Backend, cache_dir: Option<&Path>) -> BackendOptions {
    BackendOptions { backend, precision: Precision::F32, cache_dir: cache_dir.map(Path::to_path_buf) }
}

/// Largest |difference| over the largest |value|.
fn difference(a: &[Complex<f64>], b: &[Complex<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = b.iter().map(|x| x.norm()).fold(0.0, f64::max);
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) / largest
}

#[test]
fn a_small_job_stays_on_the_processor_without_a_look_at_devices() {
    let directory = tempfile::tempdir().unwrap();
    let case = case(3, 200);
    let (map, report) = compute(&case.request(), &options(Backend::Auto, Some(directory.path()))).unwrap();
    assert_eq!((report.backend, report.pairs_on_cpu, report.pairs_on_device), ("cpu", 600, 0));
    assert!(report.why.contains("less than opening a device"), "{}", report.why);
    assert_eq!(map.values, modal_sum(&case.request()).unwrap().values);
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0, "nothing was measured");
    assert!(serde_json::to_string(&report).unwrap().contains("\"precision\":\"f64\""));
}

#[test]
fn the_processor_is_taken_when_it_is_asked_for() {
    let case = case(2, 100);
    let (_, report) = compute(&case.request(), &options(Backend::Cpu, None)).unwrap();
    assert_eq!((report.backend, report.why.as_str()), ("cpu", "asked for"));
}

#[test]
fn a_software_adapter_is_never_picked_for_speed() {
    let software = gpu::list_adapters().first().is_some_and(|a| a.is_software());
    if !software {
        return println!("skipped: the first adapter is no software adapter");
    }
    let directory = tempfile::tempdir().unwrap();
    let case = case(400, 3000);
    for _ in 0..2 {
        let (_, report) = compute(&case.request(), &options(Backend::Auto, Some(directory.path()))).unwrap();
        assert_eq!(report.backend, "cpu", "{report:?}");
        assert!(report.why.contains("runs on the processor itself") || report.why.contains("less than"), "{report:?}");
    }
}

#[test]
fn a_device_that_is_asked_for_answers_and_its_look_is_kept() {
    let directory = tempfile::tempdir().unwrap();
    let case = case(20, 500);
    let request = case.request();
    let run = || compute(&request, &options(Backend::Gpu, Some(directory.path())));
    let (map, report) = match run() {
        Ok(answer) => answer,
        Err(GpuError::NoAdapter { .. }) => {
            let required = std::env::var("STIFFMAP_GPU").is_ok_and(|v| v == "require");
            assert!(!required, "STIFFMAP_GPU=require and no adapter");
            return println!("skipped: no adapter");
        }
        Err(e) => panic!("{e}"),
    };
    println!("adapter: {}", report.adapter.as_ref().unwrap().key());
    assert_eq!((report.backend, report.pairs_on_device, report.pairs_on_cpu), ("gpu", 10_000, 0));
    assert!(difference(&map.values, &modal_sum(&request).unwrap().values) < 1e-5);
    let kept = MeasuredCache::load(Some(directory.path()));
    let adapter = report.adapter.clone().unwrap();
    assert_eq!(kept.trust(&adapter, Precision::F32), report.trust.as_ref());
    assert_eq!(kept.trust(&adapter, Precision::F64), None);
    assert_eq!(run().unwrap().1.trust, report.trust, "the second run takes the first one's figures");
    // A damaged file is measured again and replaced.
    let file = directory.path().join("devices.json");
    std::fs::write(&file, "{ \"version\": 1, \"trust\": 3").unwrap();
    assert!(run().unwrap().1.trust.is_some());
    assert_ne!(MeasuredCache::load(Some(directory.path())), MeasuredCache::load(None));
}

#[test]
fn with_the_adapter_taken_away_auto_finishes_and_gpu_fails() {
    let answer = |backend: &str| {
        let output = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "helper_computes_a_map", "--ignored", "--nocapture"])
            .env("VK_DRIVER_FILES", "/nonexistent/icd.json")
            .env("VK_ICD_FILENAMES", "/nonexistent/icd.json")
            .env("HELPER_BACKEND", backend)
            .output()
            .unwrap();
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let auto = answer("auto");
    assert!(auto.contains("backend cpu") && auto.contains("same map"), "{auto}");
    let gpu = answer("gpu");
    assert!(gpu.contains("no GPU adapter was found"), "{gpu}");
}

#[test]
#[ignore = "run by the test above in its own process"]
fn helper_computes_a_map() {
    let backend: Backend = std::env::var("HELPER_BACKEND").unwrap().parse().unwrap();
    // Large enough that `auto` looks for adapters.
    let case = case(300, 3000);
    let request = case.request();
    let mut values = Vec::new();
    let mut sink = |tile: Tile<'_>| {
        values.extend_from_slice(tile.values);
        Ok(())
    };
    match compute_tiles(&request, &options(backend, None), &mut sink) {
        Err(e) => println!("{e}"),
        Ok(report) => {
            println!("backend {}: {}", report.backend, report.why);
            assert!(difference(&values, &modal_sum(&request).unwrap().values) < 1e-5);
            println!("same map");
        }
    }
}

#[test]
fn back_ends_have_the_names_of_the_command_line() {
    let names = ["auto", "cpu", "gpu"].map(|name| name.parse::<Backend>().unwrap());
    assert_eq!(names, [Backend::Auto, Backend::Cpu, Backend::Gpu]);
    assert!("cuda".parse::<Backend>().unwrap_err().contains("auto, cpu, gpu"));
}

#[test]
fn a_receiver_that_fails_is_reported_and_not_retried() {
    let case = case(3, 100);
    let mut calls = 0;
    let mut sink = |_: Tile<'_>| {
        calls += 1;
        Err("disk full".into())
    };
    let error = compute_tiles(&case.request(), &options(Backend::Auto, None), &mut sink).unwrap_err();
    assert!(error.to_string().contains("disk full") && !error.is_of_the_device(), "{error}");
    assert_eq!(calls, 1);
}

#[test]
fn metrics_come_from_either_back_end() {
    let case = case(20, 500);
    let request = case.request();
    let pairs = direct_pairs(&request);
    let expected = metrics(&request, &modal_sum(&request).unwrap(), &pairs).unwrap();
    let (found, report) = compute_metrics(&request, &pairs, &options(Backend::Cpu, None)).unwrap();
    assert_eq!((report.backend, found), ("cpu", expected.clone()));
    match compute_metrics(&request, &pairs, &options(Backend::Gpu, None)) {
        Err(GpuError::NoAdapter { .. }) => println!("skipped: no adapter"),
        Err(e) => panic!("{e}"),
        Ok((found, report)) => {
            assert_eq!((report.backend, report.pairs_on_device), ("gpu", 10_000));
            assert!(report.trust.is_some(), "a device is looked at before its numbers are used");
            for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
                assert!((a.peak.value / b.peak.value - 1.0).abs() < 1e-9, "{a:?} {b:?}");
                assert!((a.peak.value * 1.001 / b.peak.value - 1.0).abs() > 1e-9, "control");
            }
        }
    }
}

#[test]
fn the_bench_counts_what_it_says() {
    let request = gpu::bench::BenchRequest {
        backend: Backend::Cpu,
        positions: 3,
        frequencies: 64,
        modes: 5,
        ports: 3,
        repetitions: 3,
        streamed: false,
    };
    let rows = gpu::bench::measure(&request).unwrap();
    assert_eq!(rows.len(), 1);
    let row = &rows[0];
    let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    near(row.pairs_per_second * row.median_seconds, 192.0);
    near(row.values_per_second, 9.0 * row.pairs_per_second);
    near(row.bytes_per_second, 144.0 * row.pairs_per_second);
    near(row.flops_per_second, 5.0 * (11.0 + 24.0) * row.pairs_per_second);
    assert!(row.roofline_share.is_some_and(|share| share > 0.0));
}
