//! The modal sum on the processor: blocks of frequencies over threads, tiles for a receiver.

use nalgebra::Complex;
use rayon::prelude::*;

use super::exact::Packed;
use super::kernel::{Block, GROUP, Model, lay_out};
use super::packing::{PackedSystem, Packing};
use super::scatter::LARGE;
use super::tiles::{Sink, Tile, TileLimits, TileRange, tiles};
use super::{ComplianceMap, FrfError, FrfRequest, Quantity};

/// Frequencies a task; a multiple of the kernel's group.
const BLOCK: usize = 32 * GROUP;
/// Values of a tile when a map is streamed (32 MiB).
const TILE_VALUES: usize = 1 << 21;

/// Frequency responses of modal models over positions and frequencies, in f64.
///
/// ```text
///             n           L_ir R_jr                                d
/// H_ij(omega) = sum ------------------------------------------------ + sum C_k,ij (j omega)^k
///            r=1  omega_r^2 (1 + j eta_r) - omega^2 + 2 j zeta_r omega_r omega   k=0
/// ```
///
/// times (j omega)^q, q = 0, 1, 2 for receptance, mobility and accelerance. At 0 Hz the accelerance is the sum of
/// L_ir R_jr over the free motions (omega_r = 0).
///
/// # Shapes and units
/// | name | shape | unit |
/// |---|---|---|
/// | `request.frequencies` | n_frequency, ascending | Hz |
/// | `request.systems` | n_position | see [`super::ModalSystem`] |
/// | returns | n_position x n_frequency x n_output x n_input, last fastest | m/N, m/(s N), m/(s^2 N) |
///
/// # Errors
/// As [`FrfRequest::check`].
///
/// # Accuracy
/// Each term is exact to about 12 roundings, beside and at the resonances too: an entry is within
/// (n + 12) 2.2e-16 sum_r |term_r| of the exact sum.
///
/// # Source
/// Ewins, Modal Testing, 2nd ed., ch. 2.
pub fn modal_sum(request: &FrfRequest) -> Result<ComplianceMap, FrfError> {
    request.check()?;
    let mut values = zeros(request.len());
    fill(request, &mut values);
    Ok(ComplianceMap::around(request, values))
}

/// [`modal_sum`] into values that the caller holds, `[position, frequency, output, input]`.
///
/// # Errors
/// As [`FrfRequest::check`].
pub fn modal_sum_into(request: &FrfRequest, values: &mut [Complex<f64>]) -> Result<(), FrfError> {
    assert_eq!(values.len(), request.len(), "values of the map");
    request.check()?;
    fill(request, values);
    Ok(())
}

/// [`modal_sum`] in tiles: while the receiver works on one tile the next is computed; two tiles are held.
///
/// Begins at the (position, frequency) pair number `first_pair` of the map, so that a map which a device began can be
/// finished from the first pair that it did not deliver; 0 for the whole map.
///
/// # Errors
/// As [`FrfRequest::check`], and [`FrfError::Sink`] with the receiver's error, after which no more tiles come.
pub fn modal_sum_tiles(request: &FrfRequest, first_pair: usize, sink: &mut Sink) -> Result<(), FrfError> {
    request.check()?;
    let packing = Packing::new(request);
    let n_values = request.values_per_pair();
    let limits = TileLimits { pairs: (TILE_VALUES / n_values).max(1), positions: usize::MAX, frequencies: usize::MAX };
    let ranges = tiles(request.positions.len(), request.frequencies.len(), first_pair, limits);
    let mut ready: Option<(TileRange, Vec<Complex<f64>>)> = None;
    let mut spare = Vec::new();
    for range in ranges {
        let mut values = std::mem::take(&mut spare);
        values.resize(range.pairs() * n_values, Complex::new(0.0, 0.0));
        let ((), delivered) =
            rayon::join(|| fill_range(request, &packing, &range, &mut values), || deliver(ready.take(), sink));
        spare = delivered?;
        ready = Some((range, values));
    }
    deliver(ready, sink).map(|_| ())
}

/// Hands a tile to the receiver and returns its memory for the next.
fn deliver(ready: Option<(TileRange, Vec<Complex<f64>>)>, sink: &mut Sink) -> Result<Vec<Complex<f64>>, FrfError> {
    let Some((range, values)) = ready else {
        return Ok(Vec::new());
    };
    let position = range.positions.start;
    sink(Tile { range, values: &values }).map_err(|source| FrfError::Sink { position, source })?;
    Ok(values)
}

fn fill(request: &FrfRequest, values: &mut [Complex<f64>]) {
    let packing = Packing::new(request);
    let range = TileRange { positions: 0..request.positions.len(), frequencies: 0..request.frequencies.len() };
    fill_range(request, &packing, &range, values);
}

fn fill_range(request: &FrfRequest, packing: &Packing, range: &TileRange, values: &mut [Complex<f64>]) {
    let n_values = request.values_per_pair();
    let frequencies = lay_out(&request.frequencies[range.frequencies.clone()]);
    let systems = &request.systems[range.positions.clone()];
    let stream = values.len() >= LARGE;
    let plain = &request.frequencies[range.frequencies.clone()];
    values.par_chunks_mut(range.frequencies.len() * n_values).zip(systems).for_each(|(values, system)| {
        let exact = system.exact.as_deref();
        let system = PackedSystem::new(system, packing);
        let model = Model { system: &system, packing, quantity: request.quantity };
        if let Some(exact) = exact {
            let packed = exact.pack();
            let blocks = values.par_chunks_mut(BLOCK * n_values).zip(plain.par_chunks(BLOCK));
            blocks.for_each(|(values, frequencies)| packed.sum(frequencies, request.quantity, values));
        } else {
            let blocks = values.par_chunks_mut(BLOCK * n_values).zip(frequencies.par_chunks(BLOCK));
            blocks.for_each(|(values, frequencies)| Block { model, frequencies, stream, values }.sum());
        }
        if range.frequencies.start == 0
            && request.has_accelerance_at_rest()
            && let Some(at_rest) = system.at_rest(packing, request.quantity)
        {
            values[..n_values].copy_from_slice(&at_rest);
        }
    });
}

/// The sum of one position at any ascending frequencies (Hz), `[frequency, output, input]`, on the calling thread.
pub(super) fn sum_at(
    system: &PackedSystem,
    exact: Option<&Packed<'_>>,
    packing: &Packing,
    quantity: Quantity,
    frequencies: &[f64],
    n_values: usize,
) -> Vec<Complex<f64>> {
    let mut values = vec![Complex::new(0.0, 0.0); frequencies.len() * n_values];
    if frequencies.is_empty() {
        return values;
    }
    match exact {
        Some(exact) => exact.sum(frequencies, quantity, &mut values),
        None => {
            let model = Model { system, packing, quantity };
            for (values, frequencies) in values.chunks_mut(BLOCK * n_values).zip(lay_out(frequencies).chunks(BLOCK)) {
                Block { model, frequencies, stream: false, values }.sum();
            }
        }
    }
    if let Some(at_rest) = system.at_rest(packing, quantity) {
        let resting = frequencies.iter().take_while(|f| **f == 0.0).count();
        values[..resting * n_values].chunks_exact_mut(n_values).for_each(|values| values.copy_from_slice(&at_rest));
    }
    values
}

/// Zeros straight from the system, whose pages the threads then touch first.
pub(crate) fn zeros(n: usize) -> Vec<Complex<f64>> {
    let mut values: Vec<Complex<f64>> = bytemuck::allocation::cast_vec(vec![[0.0f64; 2]; n]);
    prefer_huge_pages(&mut values);
    values
}

/// Asks for 2 MiB pages: a fresh map otherwise spends more time in page faults than in sums.
#[cfg(target_os = "linux")]
fn prefer_huge_pages(values: &mut [Complex<f64>]) {
    const PAGE: usize = 2 << 20;
    const MADV_HUGEPAGE: i32 = 14;
    unsafe extern "C" {
        fn madvise(address: *mut std::ffi::c_void, length: usize, advice: i32) -> i32;
    }
    let start = values.as_mut_ptr().addr().next_multiple_of(PAGE);
    let end = values.as_mut_ptr_range().end.addr() / PAGE * PAGE;
    if end > start {
        let address = values.as_mut_ptr().with_addr(start).cast();
        // SAFETY: the range lies inside memory that this vector owns, and the advice changes no content. A refusal
        // leaves small pages, which is as good as no advice.
        unsafe { madvise(address, end - start, MADV_HUGEPAGE) };
    }
}

/// Elsewhere the system chooses its pages.
#[cfg(not(target_os = "linux"))]
fn prefer_huge_pages(_: &mut [Complex<f64>]) {}
