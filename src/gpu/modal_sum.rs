//! The modal sum on a device, in tiles: while one tile's values are read and handed on, the next is summed.

use bytemuck::Pod;
use nalgebra::Complex;
use rayon::prelude::*;

use crate::frf::{
    ComplianceMap, FrfError, FrfRequest, PackedSystem, Packing, Sink, Tile, TileLimits, TileRange, tiles,
};

use super::model::{MICRON, Model};
use super::shader::{CHUNK, Kernel, Params, Precision, Variant, WORKGROUP};
use super::{Gpu, GpuError};

/// Device bytes of a tile's values at most: large enough to fill a device, small enough for read-back to overlap.
const TILE_BYTES: u64 = 32 << 20;
/// Below this a tile is not cut further for overlap.
const SMALL_TILE_BYTES: u64 = 1 << 20;
/// Tiles that a map is cut into where it is large enough.
const TILES: u64 = 6;

/// Frequency responses of modal models on a device: the same request, answered as [`crate::frf::modal_sum`] does.
///
/// # Errors
/// [`GpuError::Request`] as [`FrfRequest::check`], [`GpuError::NoF64`], [`GpuError::NotFinite`] where the request leaves
/// the range of f32, and what a device may do: lost, out of memory, refused, timed out.
///
/// # Accuracy
/// In f32, with u = 2^-24 the unit roundoff and t_r the terms of an entry (residual powers included), each term's
/// relative error is at most about 16 u: the difference 2 u, the sum f_r + f 2 u and their product u; the loss 4 u;
/// |D|^2 of these 2 to 3 u, its inverse 2 u (5 u where the device divides as loosely as Vulkan allows), the residue and
/// two products 3 u. Adding n terms costs at most n u sum |t_r|, and about sqrt(n) u for roundings that do not conspire.
/// The bound that is held and tested is
///
/// ```text
/// |dH_ij| <= 8 eps sum_r |t_r|,   eps = 2^-23 = 2 u
/// ```
///
/// whatever the damping and the distance from a resonance, because the difference f_r - f is taken on hi + lo parts
/// (48 bits): its absolute error is 2^-48 f, which is 2^-48 / (2 zeta) of the denominator at a resonance.
/// In f64 the same count gives 1e-14 times sum |t_r|; 1e-12 is held.
///
/// # Source
/// Kernel: `shaders/modal_sum.wgsl`; its readable twin: [`super::twin`].
pub fn modal_sum(gpu: &Gpu, request: &FrfRequest, precision: Precision) -> Result<ComplianceMap, GpuError> {
    request.check()?;
    let mut values = crate::frf::zeros(request.len());
    let packing = Packing::new(request);
    let variant = Variant::new(Kernel::ModalSum, precision, packing.pairs.len());
    run(gpu, request, packing, variant, 0, &mut |range, unpack| {
        let start =
            (range.positions.start * request.frequencies.len() + range.frequencies.start) * request.values_per_pair();
        unpack.fill(&mut values[start..start + range.pairs() * request.values_per_pair()])
    })?;
    Ok(ComplianceMap::around(request, values))
}

/// [`modal_sum`] in tiles, from the map's (position, frequency) pair number `first_pair` on; as
/// [`crate::frf::modal_sum_tiles`], which can finish what a device could not.
///
/// # Errors
/// As [`modal_sum`], and the receiver's error as [`FrfError::Sink`]. The tiles that were received before are good.
pub fn modal_sum_tiles(
    gpu: &Gpu,
    request: &FrfRequest,
    precision: Precision,
    first_pair: usize,
    sink: &mut Sink,
) -> Result<(), GpuError> {
    request.check()?;
    let packing = Packing::new(request);
    let variant = Variant::new(Kernel::ModalSum, precision, packing.pairs.len());
    let mut values = Vec::new();
    run(gpu, request, packing, variant, first_pair, &mut |range, unpack| {
        values.resize(range.pairs() * request.values_per_pair(), Complex::default());
        unpack.fill(&mut values)?;
        let position = range.positions.start;
        sink(Tile { range: range.clone(), values: &values })
            .map_err(|source| FrfError::Sink { position, source }.into())
    })
}

/// The sum without the frequencies' low parts: what f32 gives when a compiler loses them. For tests alone.
#[doc(hidden)]
pub fn modal_sum_without_low_parts(gpu: &Gpu, request: &FrfRequest) -> Result<ComplianceMap, GpuError> {
    request.check()?;
    let packing = Packing::new(request);
    let variant = Variant { split: false, ..Variant::new(Kernel::ModalSum, Precision::F32, packing.pairs.len()) };
    let mut values = vec![Complex::default(); request.len()];
    run(gpu, request, packing, variant, 0, &mut |range, unpack| {
        let start =
            (range.positions.start * request.frequencies.len() + range.frequencies.start) * request.values_per_pair();
        unpack.fill(&mut values[start..start + range.pairs() * request.values_per_pair()])
    })?;
    Ok(ComplianceMap::around(request, values))
}

/// What a device is given for a whole request in f32: the shader's text, the parameters, the arrays of group 0 in the
/// order of their bindings, and the workgroups. For tests that run the shader elsewhere; the output is
/// `[position, pair, frequency]`, (re, im) in um/N.
#[doc(hidden)]
pub fn shader_inputs(request: &FrfRequest, kernel: Kernel) -> (String, Params, [Vec<u8>; 3], [u32; 3]) {
    assert!(matches!(kernel, Kernel::ModalSum | Kernel::Metrics), "{} does not sum modes", kernel.name());
    let packing = Packing::new(request);
    let variant = Variant::new(kernel, Precision::F32, packing.pairs.len());
    let model = Model::new(request, packing, variant.duos);
    let tile = model.tile(Precision::F32, 0..request.positions.len(), request.frequencies);
    let chunk = match kernel {
        Kernel::Metrics => CHUNK,
        _ => WORKGROUP * variant.ways(),
    };
    let workgroups = [tile.params.n_frequencies.div_ceil(chunk), tile.params.n_positions, model.groups(variant.duos)];
    (variant.source(), tile.params, [tile.frequencies, tile.modes, tile.residual], workgroups)
}

/// The tiles that the device's limits and the wish for overlap allow.
pub(super) fn plan(
    gpu: &Gpu,
    request: &FrfRequest,
    model: &Model,
    precision: Precision,
    bytes_per_pair: u64,
    first_pair: usize,
) -> Result<Vec<TileRange>, GpuError> {
    let total = (request.positions.len() * request.frequencies.len()) as u64 * bytes_per_pair;
    let tile = (total / TILES).clamp(SMALL_TILE_BYTES, TILE_BYTES).min(gpu.max_binding());
    let reals = model.mode_reals().max(model.residual_reals()) as u64 * precision.bytes();
    let limits = TileLimits {
        pairs: (tile / bytes_per_pair) as usize,
        positions: gpu.max_workgroups().min((gpu.max_binding() / reals.max(1)) as usize),
        frequencies: gpu.max_workgroups() * WORKGROUP as usize,
    };
    let too_large =
        |what, needed, allowed| Err(GpuError::TooLarge { adapter: gpu.adapter().name.clone(), what, needed, allowed });
    if limits.positions == 0 {
        return too_large("the modal model", reals, gpu.max_binding());
    }
    if limits.pairs == 0 {
        return too_large("one frequency's values", bytes_per_pair, tile);
    }
    Ok(tiles(request.positions.len(), request.frequencies.len(), first_pair, limits))
}

fn run(
    gpu: &Gpu,
    request: &FrfRequest,
    packing: Packing,
    variant: Variant,
    first_pair: usize,
    deliver: &mut dyn FnMut(&TileRange, &Unpack) -> Result<(), GpuError>,
) -> Result<(), GpuError> {
    let precision = variant.precision;
    let pipeline = gpu.kernels().get(gpu, variant)?;
    let model = Model::new(request, packing, variant.duos);
    let bytes_per_pair = 2 * precision.bytes() * model.packing.pairs.len() as u64;
    let ranges = plan(gpu, request, &model, precision, bytes_per_pair, first_pair)?;
    let mut slots = gpu.buffers();
    let mut flying = None;
    for (i, range) in ranges.iter().map(Some).chain([None]).enumerate() {
        let next = match range {
            None => None,
            Some(range) => {
                let frequencies = &request.frequencies[range.frequencies.clone()];
                let tile = model.tile(precision, range.positions.clone(), frequencies);
                let workgroups = [
                    (range.frequencies.len() as u32).div_ceil(WORKGROUP * variant.ways()),
                    range.positions.len() as u32,
                    model.groups(variant.duos),
                ];
                let bytes = range.pairs() as u64 * bytes_per_pair;
                Some((range, i % 2, slots[i % 2].submit(gpu, &pipeline, tile.inputs(), workgroups, bytes)?))
            }
        };
        if let Some((range, slot, tile)) = std::mem::replace(&mut flying, next) {
            slots[slot].read(gpu, tile, |bytes| {
                deliver(
                    range,
                    &Unpack { adapter: &gpu.adapter().name, bytes, precision, packing: &model.packing, range, request },
                )
            })?;
        }
    }
    gpu.keep(slots);
    Ok(())
}

/// A tile's values as the device wrote them: `[position, pair, frequency]`, um/N.
struct Unpack<'a> {
    adapter: &'a str,
    bytes: &'a [u8],
    precision: Precision,
    packing: &'a Packing,
    range: &'a TileRange,
    request: &'a FrfRequest<'a>,
}

impl Unpack<'_> {
    /// Into `[position, frequency, output, input]`, m/N.
    fn fill(&self, values: &mut [Complex<f64>]) -> Result<(), GpuError> {
        match self.precision {
            Precision::F32 => self.convert::<f32>(values),
            Precision::F64 => self.convert::<f64>(values),
        }
    }

    fn convert<T: Pod + Into<f64> + Sync>(&self, values: &mut [Complex<f64>]) -> Result<(), GpuError> {
        /// Frequencies whose values stay in the first cache together.
        const BLOCK: usize = 128;
        let read: &[[T; 2]] = bytemuck::cast_slice(self.bytes);
        let n = self.range.frequencies.len();
        let (n_pairs, n_values) = (self.packing.pairs.len(), self.packing.pair_of_value.len());
        let rests = self.range.frequencies.start == 0 && self.request.has_accelerance_at_rest();
        let bad = values
            .par_chunks_mut(n * n_values)
            .zip(read.par_chunks(n * n_pairs))
            .enumerate()
            .flat_map(|(position, (values, read))| {
                let blocks = values.par_chunks_mut(BLOCK * n_values).enumerate();
                blocks.map(move |(block, values)| (position, block * BLOCK, values, read))
            })
            .find_map_any(|(position, first, values, read)| {
                for (value, &pair) in self.packing.pair_of_value.iter().enumerate() {
                    let column = &read[pair * n + first..(pair + 1) * n];
                    for (row, [re, im]) in values.chunks_exact_mut(n_values).zip(column) {
                        row[value] = Complex::new((*re).into() * MICRON, (*im).into() * MICRON);
                    }
                }
                // Free motions divide 0 by 0 there; the processor knows the value in f64.
                if rests && first == 0 {
                    let system = &self.request.systems[self.range.positions.start + position];
                    let at_rest = PackedSystem::new(system, self.packing).at_rest(self.packing, self.request.quantity);
                    at_rest.into_iter().for_each(|at_rest| values[..n_values].copy_from_slice(&at_rest));
                }
                let bad = values.iter().position(|x| !(x.re.is_finite() && x.im.is_finite()));
                bad.map(|at| (position, first + at / n_values))
            });
        match bad {
            None => Ok(()),
            Some((position, frequency)) => Err(GpuError::NotFinite {
                adapter: self.adapter.to_string(),
                position: self.range.positions.start + position,
                frequency: self.range.frequencies.start + frequency,
            }),
        }
    }
}
