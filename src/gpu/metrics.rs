//! Extrema of every pair at every position, found on the device: a sweep reads back a few numbers instead of a map.

use std::time::Instant;

use bytemuck::Pod;

use crate::frf::metrics::{GridExtrema, PairMetrics, refine};
use crate::frf::{FrfRequest, GridSearch, Packing, Tile, modal_sum_tiles};

use super::backend::{Backend, BackendOptions, BackendReport, Choice, choose, on_cpu, on_device};
use super::modal_sum::plan;
use super::model::Model;
use super::shader::{CHUNK, Extrema, Kernel, Precision, Variant};
use super::{Gpu, GpuError};

/// Metrics as [`crate::frf::metrics::metrics`], with the grid searched on the device and the refinement in f64.
///
/// # Errors
/// As [`grid_extrema`] and [`refine`].
///
/// # Accuracy
/// As [`refine`]: the values are those of the full sum in f64; the device only says where to look.
pub fn metrics(
    gpu: &Gpu,
    request: &FrfRequest,
    pairs: &[(usize, usize)],
    precision: Precision,
) -> Result<Vec<Vec<PairMetrics>>, GpuError> {
    let grid = grid_extrema(gpu, request, pairs, precision)?;
    Ok(refine(request, pairs, &grid)?)
}

/// Metrics on the back end that the options choose, without a map in memory on either; with [`Backend::Auto`] the
/// processor does what a device could not.
///
/// # Errors
/// As [`super::compute`] and [`refine`].
///
/// # Accuracy
/// As [`refine`].
pub fn compute_metrics(
    request: &FrfRequest,
    pairs: &[(usize, usize)],
    options: &BackendOptions,
) -> Result<(Vec<Vec<PairMetrics>>, BackendReport), GpuError> {
    request.check()?;
    let start = Instant::now();
    let on_processor = |why: String| {
        let mut search = GridSearch::new(request, pairs);
        let mut sink = |tile: Tile<'_>| {
            search.look(&tile);
            Ok(())
        };
        modal_sum_tiles(request, 0, &mut sink)?;
        let found = refine(request, pairs, &search.finish())?;
        Ok((found, on_cpu(request, why, start)))
    };
    match choose(request, options)? {
        Choice::Cpu { why } => on_processor(why),
        Choice::Gpu(gpu, chosen) => match metrics(&gpu, request, pairs, options.precision) {
            Ok(found) => {
                let n_pairs = request.positions.len() * request.frequencies.len();
                Ok((found, on_device(&gpu, &chosen, options, n_pairs, start)))
            }
            Err(e) if options.backend == Backend::Auto && e.is_of_the_device() => {
                tracing::warn!("{e}; the processor does the work");
                on_processor(format!("{}; the device failed: {e}", chosen.why))
            }
            Err(e) => Err(e),
        },
    }
}

/// Extrema on the grid, `[position][pair]`: as [`crate::frf::metrics::grid_extrema`] without a map.
///
/// # Errors
/// As [`super::modal_sum`].
///
/// # Accuracy
/// Of frequencies whose values differ by less than the device's rounding either may be named.
pub fn grid_extrema(
    gpu: &Gpu,
    request: &FrfRequest,
    pairs: &[(usize, usize)],
    precision: Precision,
) -> Result<Vec<Vec<GridExtrema>>, GpuError> {
    request.check()?;
    if request.has_accelerance_at_rest() && request.systems.iter().any(|s| s.frequencies.contains(&0.0)) {
        return beside_rest(gpu, request, pairs, precision);
    }
    let packing = Packing::new(request);
    let wanted: Vec<usize> = pairs.iter().map(|(i, j)| packing.pair_of_value[i * request.inputs.len() + j]).collect();
    let search = Search { gpu, request, precision, wanted };
    match precision {
        Precision::F32 => search.run::<f32>(packing),
        Precision::F64 => search.run::<f64>(packing),
    }
}

/// The same where free motions make 0 Hz, the grid's first frequency, a case of its own that the kernel does not know:
/// the device searches the others, and what it finds is compared with the value at 0 Hz.
fn beside_rest(
    gpu: &Gpu,
    request: &FrfRequest,
    pairs: &[(usize, usize)],
    precision: Precision,
) -> Result<Vec<Vec<GridExtrema>>, GpuError> {
    let others = &request.frequencies[1..];
    let mut found = if others.is_empty() {
        vec![vec![GridExtrema { peak: 0, most_negative_real: 0 }; pairs.len()]; request.positions.len()]
    } else {
        grid_extrema(gpu, &FrfRequest { frequencies: others, ..request.clone() }, pairs, precision)?
    };
    if others.is_empty() {
        return Ok(found);
    }
    for (position, found) in found.iter_mut().enumerate() {
        for (at, &(output, input)) in found.iter_mut().zip(pairs) {
            let value = |frequency: usize| -> Result<_, GpuError> {
                let one = FrfRequest {
                    positions: &request.positions[position..=position],
                    systems: &request.systems[position..=position],
                    frequencies: &request.frequencies[frequency..=frequency],
                    ..request.clone()
                };
                Ok(crate::frf::modal_sum(&one)?.values[output * request.inputs.len() + input])
            };
            let (rest, peak, real) = (value(0)?, value(at.peak + 1)?, value(at.most_negative_real + 1)?);
            at.peak = if rest.norm() >= peak.norm() { 0 } else { at.peak + 1 };
            at.most_negative_real = if rest.re <= real.re { 0 } else { at.most_negative_real + 1 };
        }
    }
    Ok(found)
}

struct Search<'a> {
    gpu: &'a Gpu,
    request: &'a FrfRequest<'a>,
    precision: Precision,
    wanted: Vec<usize>,
}

/// A pair's best so far, with indices in the whole grid.
#[derive(Clone, Copy)]
struct Best {
    peak: f64,
    real_part: f64,
    at: GridExtrema,
}

impl Search<'_> {
    fn run<T: Pod + Into<f64>>(&self, packing: Packing) -> Result<Vec<Vec<GridExtrema>>, GpuError>
    where
        Extrema<T>: Pod,
    {
        let (gpu, request) = (self.gpu, self.request);
        let n_pairs = packing.pairs.len();
        let variant = Variant::new(Kernel::Metrics, self.precision, n_pairs);
        let pipeline = gpu.kernels().get(gpu, variant)?;
        let model = Model::new(request, packing, variant.duos);
        // A record stands for up to CHUNK frequencies; counting one a frequency keeps tiles small enough to overlap.
        let ranges = plan(gpu, request, &model, self.precision, 2 * self.precision.bytes() * n_pairs as u64, 0)?;
        let nothing = Best {
            peak: f64::NEG_INFINITY,
            real_part: f64::INFINITY,
            at: GridExtrema { peak: 0, most_negative_real: 0 },
        };
        let mut best = vec![vec![nothing; self.wanted.len()]; request.positions.len()];
        let mut slots = gpu.buffers();
        let mut flying = None;
        for (i, range) in ranges.iter().map(Some).chain([None]).enumerate() {
            let next = match range {
                None => None,
                Some(range) => {
                    let frequencies = &request.frequencies[range.frequencies.clone()];
                    let tile = model.tile(self.precision, range.positions.clone(), frequencies);
                    let chunks = range.frequencies.len().div_ceil(CHUNK as usize);
                    let workgroups = [chunks as u32, range.positions.len() as u32, model.groups(variant.duos)];
                    let bytes = range.positions.len() * chunks * n_pairs * size_of::<Extrema<T>>();
                    let tile = slots[i % 2].submit(gpu, &pipeline, tile.inputs(), workgroups, bytes as u64)?;
                    Some((range, chunks, i % 2, tile))
                }
            };
            if let Some((range, chunks, slot, tile)) = std::mem::replace(&mut flying, next) {
                let best = &mut best[range.positions.clone()];
                slots[slot].read(gpu, tile, |bytes| {
                    let records: &[Extrema<T>] = bytemuck::cast_slice(bytes);
                    for (row, record) in records.chunks_exact(n_pairs).enumerate() {
                        self.merge(&mut best[row / chunks], record, range.frequencies.start);
                    }
                    Ok(())
                })?;
            }
        }
        gpu.keep(slots);
        Ok(best.into_iter().map(|pairs| pairs.into_iter().map(|b| b.at).collect()).collect())
    }

    /// Chunks come in the grid's order, so the first of equal values stays.
    fn merge<T: Pod + Into<f64>>(&self, best: &mut [Best], records: &[Extrema<T>], first: usize) {
        for (best, &pair) in best.iter_mut().zip(&self.wanted) {
            let record = &records[pair];
            if record.peak.into() > best.peak {
                best.peak = record.peak.into();
                best.at.peak = first + record.peak_at as usize;
            }
            if record.real_part.into() < best.real_part {
                best.real_part = record.real_part.into();
                best.at.most_negative_real = first + record.real_part_at as usize;
            }
        }
    }
}
