//! Extrema of changed machines: a device looks over the whole grid, the processor computes the few places that it names.
//!
//! The device returns, for each chunk of frequencies, its largest values and where its local maxima are. Around those
//! that can hold the extremum the processor repeats the elimination in f64 and refines as
//! [`crate::frf::refined_extrema`] does, so that what comes out does not depend on the device's precision.

use bytemuck::Pod;
use rayon::prelude::*;

use crate::frf::metrics::Extremum;
use crate::frf::modification::Work;
use crate::frf::{REACH, refined_extrema_in};

use super::modification::{Packed, SpringRequest, not_finite};
use super::shader::{CORE, Kernel, Maxima, Precision, SHARE};
use super::{Gpu, GpuError};

/// Largest |H| and smallest Re H of changed machines, `[design][pair]`, with their frequencies.
///
/// # Errors
/// As [`super::modification::modified`].
///
/// # Accuracy
/// The numbers of [`crate::frf::refined_extrema`] on the f64 responses, bit for bit, where the device's error is below
/// what sets a local maximum apart from the values two steps beside it.
pub fn extrema(
    gpu: &Gpu,
    request: &SpringRequest<'_>,
    precision: Precision,
) -> Result<Vec<Vec<(Extremum, Extremum)>>, GpuError> {
    let places = places(gpu, request, precision)?;
    let refine = |(places, changes): (&Vec<usize>, &Vec<_>)| {
        let base = request.base;
        let runs = base.runs_around(places, REACH);
        let responses = base.modified_in(changes, request.pairs, &runs, &mut Work::default());
        responses.iter().map(|h| refined_extrema_in(&base.frequencies, &runs, h)).collect()
    };
    Ok(places.par_iter().zip(request.designs).map(refine).collect())
}

/// Indices of the frequencies around which each design's extrema lie, for all pairs together, `[design]`.
///
/// # Errors
/// As [`extrema`].
pub fn places(gpu: &Gpu, request: &SpringRequest<'_>, precision: Precision) -> Result<Vec<Vec<usize>>, GpuError> {
    match precision {
        Precision::F32 => search::<f32>(gpu, request, precision, |x| x as f32),
        Precision::F64 => search::<f64>(gpu, request, precision, |x| x),
    }
}

fn search<T: Pod + Into<f64>>(
    gpu: &Gpu,
    request: &SpringRequest<'_>,
    precision: Precision,
    real: impl Fn(f64) -> T,
) -> Result<Vec<Vec<usize>>, GpuError>
where
    Maxima<T>: Pod,
{
    let n_pairs = request.pairs.len();
    let mut found = vec![vec![[Candidates::default(), Candidates::default()]; n_pairs]; request.designs.len()];
    let packed = Packed::new(gpu, request)?;
    packed.run(gpu, Kernel::Extrema, precision, &real, &mut |tile, bytes| {
        let records: &[Maxima<T>] = bytemuck::cast_slice(bytes);
        let designs = found[tile.designs.clone()].iter_mut();
        for (pairs, records) in designs.zip(records.chunks_exact(tile.chunks.len() * n_pairs)) {
            for (chunk, records) in tile.chunks.clone().zip(records.chunks_exact(n_pairs)) {
                for ([peaks, dips], record) in pairs.iter_mut().zip(records) {
                    let (peak, dip) = (record.peak.into(), record.dip.into());
                    // A chunk of values that are no numbers keeps the kernel's lowest.
                    if !(peak.is_finite() && dip.is_finite() && peak >= 0.0) {
                        return Err(not_finite(gpu, request.position, chunk * CORE as usize));
                    }
                    peaks.add(chunk, peak, record.peaks);
                    dips.add(chunk, dip, record.dips);
                }
            }
        }
        Ok(())
    })?;
    Ok(found.iter().map(|pairs| pairs.iter().flatten().flat_map(Candidates::places).collect()).collect())
}

/// Local maxima of one goal, pair and design.
#[derive(Clone, Debug, Default)]
struct Candidates {
    /// Chunk, its largest value, its maxima.
    chunks: Vec<(usize, f64, u64)>,
}

impl Candidates {
    fn add(&mut self, chunk: usize, top: f64, bits: [u32; 2]) {
        let bits = u64::from(bits[0]) | u64::from(bits[1]) << 32;
        if bits != 0 {
            self.chunks.push((chunk, top, bits));
        }
    }

    /// Indices of maxima in the chunks whose best may be refined into the extremum.
    fn places(&self) -> impl Iterator<Item = usize> {
        let top = self.chunks.iter().map(|c| c.1).fold(f64::NEG_INFINITY, f64::max);
        let bar = top - SHARE * top.abs();
        let good = self.chunks.iter().filter(move |c| c.1 >= bar);
        good.flat_map(|&(chunk, _, bits)| {
            (0..CORE as usize).filter(move |k| bits >> k & 1 == 1).map(move |k| chunk * CORE as usize + k)
        })
    }
}
