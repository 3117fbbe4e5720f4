//! Measures the modal sum on the processor and on each adapter, as `stiffmap bench` prints it.

use std::hint::black_box;
use std::time::Instant;

use nalgebra::{Complex, DMatrix};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use serde::Serialize;

use crate::frf::{self, FrfRequest, ModalSystem, Quantity};

use super::backend::{Backend, work};
use super::{Gpu, GpuError, Precision, modal_sum};

/// What is measured.
#[derive(Clone, Debug)]
pub struct BenchRequest {
    /// Processor, device or (with [`Backend::Auto`]) both.
    pub backend: Backend,
    /// Positions.
    pub positions: usize,
    /// Frequencies.
    pub frequencies: usize,
    /// Modes.
    pub modes: usize,
    /// Ports: outputs and inputs are the same.
    pub ports: usize,
    /// Runs; the median counts. One more goes before.
    pub repetitions: usize,
}

impl Default for BenchRequest {
    /// The main job's size.
    fn default() -> BenchRequest {
        BenchRequest { backend: Backend::Auto, positions: 121, frequencies: 2000, modes: 30, ports: 3, repetitions: 10 }
    }
}

/// One measured back end.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BenchRow {
    /// `cpu` or `gpu`.
    pub backend: &'static str,
    /// The adapter's name, or the vector lanes and threads of the processor.
    pub device: String,
    /// Precision of the sums; the map is f64 in either.
    pub precision: Precision,
    /// Positions.
    pub positions: usize,
    /// Frequencies.
    pub frequencies: usize,
    /// Modes.
    pub modes: usize,
    /// Values a (position, frequency) pair.
    pub values: usize,
    /// Runs.
    pub repetitions: usize,
    /// Median seconds a run: the request in, the whole f64 map written.
    pub median_seconds: f64,
    /// (position, frequency) pairs a second.
    pub pairs_per_second: f64,
    /// Complex values a second.
    pub values_per_second: f64,
    /// Floating-point operations a second: 11 a mode and pair, 4 for each (output, input) pair that is summed.
    pub flops_per_second: f64,
    /// Bytes of the map written a second.
    pub bytes_per_second: f64,
    /// The larger of both shares of the measured peaks (multiply-adds, memory writes); none for a device.
    pub roofline_share: Option<f64>,
}

/// Measures the back ends that the request names; a machine without adapters gives the processor's row alone.
///
/// # Errors
/// With [`Backend::Gpu`], [`GpuError::NoAdapter`]; else what a device may do.
pub fn measure(bench: &BenchRequest) -> Result<Vec<BenchRow>, GpuError> {
    let case = Case::new(bench.positions, bench.frequencies, bench.modes, bench.ports);
    let request = case.request();
    let mut values = frf::zeros(request.len());
    let mut rows = Vec::new();
    if bench.backend != Backend::Gpu {
        let seconds = median(bench.repetitions, || Ok(frf::modal_sum_into(&request, &mut values)?))?;
        let lanes = Arch::new().dispatch(Lanes);
        let device = format!("{lanes} f64 lanes, {} threads", rayon::current_num_threads());
        rows.push(row(bench, "cpu", device, Precision::F64, seconds, Some(Peaks::measure())));
    }
    if bench.backend != Backend::Cpu {
        let gpu = match Gpu::open() {
            Ok(gpu) => gpu,
            Err(GpuError::NoAdapter { .. }) if bench.backend == Backend::Auto => return Ok(rows),
            Err(e) => return Err(e),
        };
        for precision in [Precision::F32, Precision::F64].into_iter().filter(|p| gpu.supports(*p)) {
            let seconds = median(bench.repetitions, || {
                black_box(modal_sum(&gpu, &request, precision)?);
                Ok(())
            })?;
            rows.push(row(bench, "gpu", gpu.adapter().name.clone(), precision, seconds, None));
        }
    }
    Ok(rows)
}

fn row(
    bench: &BenchRequest,
    backend: &'static str,
    device: String,
    precision: Precision,
    median_seconds: f64,
    peaks: Option<Peaks>,
) -> BenchRow {
    let pairs = (bench.positions * bench.frequencies) as f64;
    let values = bench.ports * bench.ports;
    let summed = bench.ports * (bench.ports + 1) / 2;
    let flops_per_second = pairs * bench.modes as f64 * (11 + 4 * summed) as f64 / median_seconds;
    let bytes_per_second = pairs * (values * size_of::<Complex<f64>>()) as f64 / median_seconds;
    BenchRow {
        backend,
        device,
        precision,
        positions: bench.positions,
        frequencies: bench.frequencies,
        modes: bench.modes,
        values,
        repetitions: bench.repetitions,
        median_seconds,
        pairs_per_second: pairs / median_seconds,
        values_per_second: pairs * values as f64 / median_seconds,
        flops_per_second,
        bytes_per_second,
        roofline_share: peaks.map(|p| (flops_per_second / p.flops).max(bytes_per_second / p.bytes)),
    }
}

/// Work a second on the processor, from a few milliseconds.
pub(super) fn work_per_second_on_cpu() -> Result<f64, GpuError> {
    let case = Case::new(32, 1024, 30, 3);
    let request = case.request();
    let mut values = frf::zeros(request.len());
    let seconds = median(3, || Ok(frf::modal_sum_into(&request, &mut values)?))?;
    Ok(work(&request) / seconds)
}

/// Work a second on a device, from a few milliseconds.
pub(super) fn work_per_second_on(gpu: &Gpu, precision: Precision) -> Result<f64, GpuError> {
    let case = Case::new(128, 2048, 30, 3);
    let request = case.request();
    let seconds = median(3, || {
        black_box(modal_sum(gpu, &request, precision)?);
        Ok(())
    })?;
    Ok(work(&request) / seconds)
}

/// Median seconds of runs after one that does not count.
fn median(repetitions: usize, mut run: impl FnMut() -> Result<(), GpuError>) -> Result<f64, GpuError> {
    assert!(repetitions > 0, "at least one run, not {repetitions}");
    run()?;
    let mut seconds = Vec::with_capacity(repetitions);
    for _ in 0..repetitions {
        let start = Instant::now();
        run()?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    Ok(seconds[repetitions / 2])
}

/// A machine-like request of any size.
struct Case {
    positions: Vec<f64>,
    systems: Vec<ModalSystem>,
    frequencies: Vec<f64>,
    names: Vec<String>,
}

impl Case {
    fn new(positions: usize, frequencies: usize, modes: usize, ports: usize) -> Case {
        let system = |p: usize| {
            let shapes = DMatrix::from_fn(ports, modes, |i, r| 0.05 * (1.7 * (1 + i + 3 * r + 7 * p) as f64).sin());
            ModalSystem {
                frequencies: (0..modes).map(|r| 14.1 + 29.3 * r as f64 + 1e-3 * p as f64).collect(),
                damping_ratios: vec![0.02; modes],
                loss_factors: vec![0.0; modes],
                outputs: shapes.clone(),
                inputs: shapes,
                residual: Vec::new(),
            }
        };
        Case {
            positions: (0..positions).map(|p| -0.005 * p as f64).collect(),
            systems: (0..positions).map(system).collect(),
            frequencies: (0..frequencies).map(|k| 900.0 * k as f64 / frequencies as f64).collect(),
            names: (0..ports).map(|i| format!("port {i}")).collect(),
        }
    }

    fn request(&self) -> FrfRequest<'_> {
        FrfRequest {
            positions: &self.positions,
            systems: &self.systems,
            frequencies: &self.frequencies,
            outputs: &self.names,
            inputs: &self.names,
            quantity: Quantity::Receptance,
        }
    }
}

/// What the processor reaches: operations and bytes written a second, all threads.
#[derive(Clone, Copy, Debug)]
struct Peaks {
    flops: f64,
    bytes: f64,
}

impl Peaks {
    fn measure() -> Peaks {
        const ROUNDS: usize = 200_000;
        let threads = rayon::current_num_threads();
        let best = |run: &mut dyn FnMut() -> f64| (0..3).map(|_| run()).fold(0.0, f64::max);
        let flops = best(&mut || {
            let start = Instant::now();
            let flops: f64 =
                (0..threads).into_par_iter().map(|_| Arch::new().dispatch(MultiplyAdds { rounds: ROUNDS })).sum();
            flops / start.elapsed().as_secs_f64()
        });
        let mut memory = vec![0u64; 8 << 20];
        let bytes = best(&mut || {
            let start = Instant::now();
            let chunk = memory.len() / threads;
            memory.par_chunks_mut(chunk.max(1)).for_each(|chunk| chunk.fill(black_box(1)));
            size_of_val(&memory[..]) as f64 / start.elapsed().as_secs_f64()
        });
        Peaks { flops, bytes }
    }
}

struct Lanes;

impl WithSimd for Lanes {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F64_LANES
    }
}

/// Independent multiply-adds that never leave the registers; returns their number of operations.
struct MultiplyAdds {
    rounds: usize,
}

impl WithSimd for MultiplyAdds {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        const CHAINS: usize = 12;
        let factor = simd.splat_f64s(black_box(0.999));
        let mut sums = [simd.splat_f64s(black_box(1.0)); CHAINS];
        for _ in 0..self.rounds {
            for sum in &mut sums {
                *sum = simd.mul_add_f64s(*sum, factor, factor);
            }
        }
        let total = sums.iter().map(|s| simd.reduce_sum_f64s(*s)).sum::<f64>();
        black_box(total);
        (self.rounds * CHAINS * 2 * S::F64_LANES) as f64
    }
}
