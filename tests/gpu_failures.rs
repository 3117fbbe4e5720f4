//! What happens when a device fails, and when a request leaves its range.

mod modal_fixture;

use modal_fixture::device::device;
use modal_fixture::{Case, Numbers, rich, symmetric_system};
use nalgebra::Complex;
use stiffmap::frf::{Tile, modal_sum};
use stiffmap::gpu::backend::compute_tiles_on;
use stiffmap::gpu::{self, Backend, BackendOptions, Gpu, GpuError, Precision};

#[test]
fn a_lost_device_is_an_error_and_auto_finishes_on_the_processor() {
    let Some(gpu) = device() else { return };
    let mut numbers = Numbers(2);
    let systems = (0..40).map(|_| symmetric_system(&mut numbers, 3, 3, 0.02)).collect();
    let case = Case::new(systems, (0..4000).map(|i| 0.2 * i as f64).collect());
    let request = case.request();
    let exact = modal_sum(&request).unwrap();
    for backend in [Backend::Auto, Backend::Gpu] {
        let gpu = if backend == Backend::Auto { &gpu } else { &Gpu::open().unwrap() };
        let options = BackendOptions { backend, ..BackendOptions::default() };
        let mut appended = Vec::new();
        let mut sink = |tile: Tile<'_>| {
            appended.extend_from_slice(tile.values);
            gpu.destroy();
            Ok(())
        };
        let outcome = compute_tiles_on(gpu, &request, &options, &mut sink);
        match backend {
            Backend::Auto => {
                let report = outcome.unwrap();
                assert_eq!(report.backend, "gpu, finished on the cpu", "{report:?}");
                assert!(report.pairs_on_device > 0 && report.pairs_on_cpu > 0, "{report:?}");
                assert!(report.why.contains("lost"), "{report:?}");
                assert_eq!(appended.len(), exact.values.len());
                let largest = |x: &[Complex<f64>]| x.iter().map(|x| x.norm()).fold(0.0, f64::max);
                let difference: Vec<_> = appended.iter().zip(&exact.values).map(|(a, b)| a - b).collect();
                assert!(largest(&difference) <= 1e-5 * largest(&exact.values));
            }
            _ => {
                let error = outcome.unwrap_err();
                assert!(matches!(error, GpuError::DeviceLost { .. }), "{error}");
                assert!(appended.len() < exact.values.len(), "no partial map passes as whole");
            }
        }
    }
}

#[test]
fn values_outside_f32_are_an_error_with_their_place() {
    let Some(gpu) = device() else { return };
    let mut case = rich(1);
    case.systems[2].outputs *= 1e22;
    case.systems[2].inputs *= 1e22;
    let error = gpu::modal_sum(&gpu, &case.request(), Precision::F32).err().unwrap();
    assert!(matches!(error, GpuError::NotFinite { position: 2, .. }), "{error}");
}

#[test]
fn a_named_adapter_that_is_not_there_is_an_error() {
    let Some(_) = device() else { return };
    let binary = std::env::current_exe().unwrap();
    let output = std::process::Command::new(binary)
        .args(["--exact", "helper_opens_a_device", "--ignored", "--nocapture"])
        .env("STIFFMAP_ADAPTER", "no such adapter")
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("STIFFMAP_ADAPTER=\"no such adapter\""), "{text}");
}

#[test]
#[ignore = "run by the test above in its own process"]
fn helper_opens_a_device() {
    match Gpu::open() {
        Ok(gpu) => println!("opened {}", gpu.adapter().name),
        Err(e) => println!("{e}"),
    }
}
