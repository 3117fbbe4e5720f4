//! Measures the modal sum on the processor and on each adapter, as `stiffmap bench` prints it.

mod case;
mod memory;
mod peaks;

use std::hint::black_box;
use std::time::Instant;

use nalgebra::Complex;
use pulp::Arch;
use serde::Serialize;

use crate::frf::{self, Tile};
use case::Case;
use peaks::{Lanes, Peaks};

use super::backend::{Backend, work};
use super::{Gpu, GpuError, Precision, modal_sum, modal_sum_tiles};

/// Bytes of a map above which it is computed in tiles that are read and dropped, as a map that exceeds memory is.
const STREAMED_FROM: usize = 512 << 20;

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
    /// Whether every map is computed in tiles that are read and dropped, whatever its size.
    pub streamed: bool,
}

impl Default for BenchRequest {
    /// The main job's size.
    fn default() -> BenchRequest {
        BenchRequest {
            backend: Backend::Auto,
            positions: 121,
            frequencies: 2000,
            modes: 30,
            ports: 3,
            repetitions: 10,
            streamed: false,
        }
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
    /// Whether the map was handed over in tiles, which are read and dropped.
    pub streamed: bool,
    /// Most memory that the process held during the runs, bytes, as far as the system says.
    pub peak_rss_bytes: Option<u64>,
    /// Median seconds a run: the request in, the whole f64 map written (streamed: each tile written and read).
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
    let streamed = bench.streamed || request.len() * size_of::<Complex<f64>>() > STREAMED_FROM;
    let mut rows = Vec::new();
    if bench.backend != Backend::Gpu {
        memory::forget_peak();
        let seconds = if streamed {
            median(bench.repetitions, || Ok(frf::modal_sum_tiles(&request, 0, &mut read)?))?
        } else {
            let mut values = frf::zeros(request.len());
            median(bench.repetitions, || Ok(frf::modal_sum_into(&request, &mut values)?))?
        };
        let peak = memory::peak();
        let device = format!("{} f64 lanes, {} threads", Arch::new().dispatch(Lanes), rayon::current_num_threads());
        let made = Row { bench, streamed, backend: "cpu", device, precision: Precision::F64, seconds, peak };
        rows.push(made.row(Some(Peaks::measure())));
    }
    if bench.backend != Backend::Cpu {
        let devices = match Gpu::open_each() {
            Err(GpuError::NoAdapter { .. }) if bench.backend == Backend::Auto => Vec::new(),
            devices => devices?,
        };
        for gpu in &devices {
            for precision in [Precision::F32, Precision::F64].into_iter().filter(|p| gpu.supports(*p)) {
                memory::forget_peak();
                let seconds = median(bench.repetitions, || {
                    if streamed {
                        return modal_sum_tiles(gpu, &request, precision, 0, &mut read);
                    }
                    black_box(modal_sum(gpu, &request, precision)?);
                    Ok(())
                })?;
                let (device, peak) = (gpu.adapter().name.clone(), memory::peak());
                rows.push(Row { bench, streamed, backend: "gpu", device, precision, seconds, peak }.row(None));
            }
        }
    }
    Ok(rows)
}

/// Reads a tile once, as a writer would, and drops it.
fn read(tile: Tile<'_>) -> Result<(), frf::SinkError> {
    black_box(tile.values.iter().sum::<Complex<f64>>());
    Ok(())
}

/// What a row is made of.
struct Row<'a> {
    bench: &'a BenchRequest,
    streamed: bool,
    backend: &'static str,
    device: String,
    precision: Precision,
    seconds: f64,
    peak: Option<u64>,
}

impl Row<'_> {
    fn row(self, peaks: Option<Peaks>) -> BenchRow {
        let Row { bench, streamed, backend, device, precision, seconds, peak } = self;
        let pairs = (bench.positions * bench.frequencies) as f64;
        let values = bench.ports * bench.ports;
        let summed = bench.ports * (bench.ports + 1) / 2;
        let flops_per_second = pairs * bench.modes as f64 * (11 + 4 * summed) as f64 / seconds;
        let bytes_per_second = pairs * (values * size_of::<Complex<f64>>()) as f64 / seconds;
        BenchRow {
            backend,
            device,
            precision,
            positions: bench.positions,
            frequencies: bench.frequencies,
            modes: bench.modes,
            values,
            repetitions: bench.repetitions,
            streamed,
            peak_rss_bytes: peak,
            median_seconds: seconds,
            pairs_per_second: pairs / seconds,
            values_per_second: pairs * values as f64 / seconds,
            flops_per_second,
            bytes_per_second,
            roofline_share: peaks.map(|p| (flops_per_second / p.flops).max(bytes_per_second / p.bytes)),
        }
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
