//! Structural modification on a device: the base's receptances at one position, and thousands of designs' springs.
//!
//! The twin of [`crate::frf::modification`]. Every invocation eliminates one design's springs at one frequency; rows are
//! scaled by powers of two, which loses nothing and keeps squares inside f32 whatever the springs' units.

use std::f64::consts::TAU;
use std::ops::Range;

use bytemuck::Pod;
use nalgebra::{Complex, DMatrix};

use crate::frf::modification::{BaseMode, BaseReceptance, LANES, SpringChange, Work, entry};

use super::buffers::Inputs;
use super::shader::{CORE, Kernel, MAX_ROWS, Maxima, Precision, SpringParams, Variant, WORKGROUP};
use super::{Gpu, GpuError};

/// Device bytes of a tile's results at most.
const TILE_BYTES: u64 = 32 << 20;
/// Complex products of a tile at most: a fraction of a second on a small device, whose driver ends longer work.
const TILE_PRODUCTS: u64 = 4_000_000_000;
/// The same where the processor itself is the device.
const SOFTWARE_TILE_PRODUCTS: u64 = 20_000_000;
/// Relative Frobenius difference that f32 may have from f64: see [`modified`].
const BOUND: f64 = 1e-4;

/// Designs at one position that differ from a base by their springs.
#[derive(Clone, Copy, Debug)]
pub struct SpringRequest<'a> {
    /// Receptances of the base.
    pub base: &'a BaseReceptance,
    /// `[design][spring]`.
    pub designs: &'a [Vec<SpringChange>],
    /// Ports (row, column), counted from 0.
    pub pairs: &'a [(usize, usize)],
    /// Index of the position, which errors name.
    pub position: usize,
}

impl SpringRequest<'_> {
    fn ports(&self) -> usize {
        self.base.n_rows - self.base.n_springs
    }
}

/// Refuses bases that the kernels have no room for.
///
/// # Errors
/// [`GpuError::TooManyRows`] above [`MAX_ROWS`].
pub fn check_rows(springs: usize, ports: usize) -> Result<(), GpuError> {
    if springs + ports > MAX_ROWS {
        return Err(GpuError::TooManyRows { springs, ports, allowed: MAX_ROWS });
    }
    Ok(())
}

/// Receptances of changed machines, `[design][pair][frequency]`, m/N: as [`BaseReceptance::modified`] for each design.
///
/// # Errors
/// [`GpuError::TooManyRows`]; [`GpuError::NoF64`]; [`GpuError::NotFinite`] where the base or a result is not finite;
/// what a device may do.
///
/// # Accuracy
/// With A the receptances of the base, u = 2^-24, T = [-H_ps (Delta^-1 + H_ss)^-1, I] and G_ij = |A_ij| + sum_k |a_ik
/// a_kj gain_k| the magnitudes that the elimination of r springs adds up, the error of f32 is to first order
///
/// ```text
/// |dH| <= (r + 16) u |T| G |T|^T
/// ```
///
/// since each term passes some 16 roundings (the entry's own, two complex products, the gain) and at most r
/// subtractions, and what is wrong with A comes through T on both sides. T is about 1 where design and base resonate
/// apart, so the base has to be the machine that the designs surround: between 0.3 and 3 times its stiffness at 2 %
/// structural damping the tests hold 1e-4 of the Frobenius norm over the ports at every frequency. f64 holds 1e-11.
pub fn modified(
    gpu: &Gpu,
    request: &SpringRequest<'_>,
    precision: Precision,
) -> Result<Vec<Vec<Vec<Complex<f64>>>>, GpuError> {
    match precision {
        Precision::F32 => values::<f32>(gpu, request, precision, |x| x as f32),
        Precision::F64 => values::<f64>(gpu, request, precision, |x| x),
    }
}

fn values<T: Pod + Into<f64>>(
    gpu: &Gpu,
    request: &SpringRequest<'_>,
    precision: Precision,
    real: impl Fn(f64) -> T,
) -> Result<Vec<Vec<Vec<Complex<f64>>>>, GpuError> {
    let n = request.base.frequencies.len();
    let mut out = vec![vec![vec![Complex::default(); n]; request.pairs.len()]; request.designs.len()];
    let packed = Packed::new(gpu, request)?;
    packed.run(gpu, Kernel::Modification, precision, &real, &mut |tile, bytes| {
        let read: &[[T; 2]] = bytemuck::cast_slice(bytes);
        let rows = out[tile.designs.clone()].iter_mut().flat_map(|design| design.iter_mut().enumerate());
        for ((pair, row), read) in rows.zip(read.chunks_exact(tile.frequencies.len())) {
            let unit = packed.unit(pair);
            for (k, (value, [re, im])) in
                tile.frequencies.clone().zip(row[tile.frequencies.clone()].iter_mut().zip(read))
            {
                *value = Complex::new((*re).into(), (*im).into()) * unit;
                if !(value.re.is_finite() && value.im.is_finite()) {
                    return Err(not_finite(gpu, request.position, k));
                }
            }
        }
        Ok(())
    })?;
    Ok(out)
}

pub(super) fn not_finite(gpu: &Gpu, position: usize, frequency: usize) -> GpuError {
    GpuError::NotFinite { adapter: gpu.adapter().name.clone(), position, frequency }
}

/// Receives a tile's bytes.
type Deliver<'a> = dyn FnMut(&SpringTile, &[u8]) -> Result<(), GpuError> + 'a;

/// Designs and chunks of frequencies that a dispatch computes.
#[derive(Clone, Debug)]
pub(super) struct SpringTile {
    pub designs: Range<usize>,
    pub chunks: Range<usize>,
    pub frequencies: Range<usize>,
}

/// A request in the device's units.
pub(super) struct Packed<'a> {
    request: &'a SpringRequest<'a>,
    /// Powers of two by which rows are multiplied.
    scales: Vec<f64>,
    /// Unit of omega, rad/s.
    omega: f64,
}

impl<'a> Packed<'a> {
    pub fn new(gpu: &Gpu, request: &'a SpringRequest<'a>) -> Result<Self, GpuError> {
        let base = request.base;
        check_rows(base.n_springs, request.ports())?;
        let ports = request.ports();
        assert!(request.pairs.iter().all(|&(a, b)| a < ports && b < ports), "pairs {:?} of {ports}", request.pairs);
        assert!(request.designs.iter().all(|d| d.len() == base.n_springs), "one change a spring");
        let n = base.frequencies.len();
        let mut largest = vec![0.0f64; base.n_rows];
        for block in 0..n.div_ceil(LANES) {
            let block_values = base.block(block);
            if let Some(at) = block_values.iter().find_map(|v| v.iter().position(|x| !x.is_finite())) {
                return Err(not_finite(gpu, request.position, (block * LANES + at % LANES).min(n - 1)));
            }
            for (i, largest) in largest.iter_mut().enumerate() {
                let v = &block_values[entry(i, i)];
                *largest = (0..LANES).map(|lane| v[lane].hypot(v[LANES + lane])).fold(*largest, f64::max);
            }
        }
        let power = |x: f64| if x > 0.0 { (-0.5 * x.log2()).floor().exp2() } else { 1.0 };
        let omega = TAU * base.frequencies[n - 1];
        Ok(Self {
            request,
            scales: largest.into_iter().map(power).collect(),
            omega: if omega > 0.0 { omega } else { 1.0 },
        })
    }

    /// What turns a pair's value into m/N.
    pub fn unit(&self, pair: usize) -> f64 {
        let (a, b) = self.request.pairs[pair];
        let springs = self.request.base.n_springs;
        1.0 / (self.scales[springs + a] * self.scales[springs + b])
    }

    /// The base's receptances at the slots of some chunks, each grid's end standing twice.
    fn receptances<T: Pod>(&self, chunks: &Range<usize>, real: impl Fn(f64) -> T) -> Vec<[T; 2]> {
        let base = self.request.base;
        let n = base.frequencies.len();
        let first = chunks.start * CORE as usize;
        let slots: Vec<usize> = (first..first + slots(chunks)).map(|k| k.saturating_sub(1).min(n - 1)).collect();
        let rows = (0..base.n_rows).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let mut out = Vec::with_capacity((entry(base.n_rows, 0) + 1) * slots.len());
        for (i, j) in rows {
            let scale = self.scales[i] * self.scales[j];
            out.extend(slots.iter().map(|k| {
                let value = &base.block(k / LANES)[entry(i, j)];
                [real(scale * value[k % LANES]), real(scale * value[LANES + k % LANES])]
            }));
        }
        out.extend(slots.iter().map(|&k| [real(TAU * base.frequencies[k] / self.omega), real(0.0)]));
        out
    }

    fn changes<T: Pod>(&self, designs: &Range<usize>, real: impl Fn(f64) -> T) -> Vec<[T; 2]> {
        let scaled = |(change, scale): (&SpringChange, &f64)| {
            let stiffness = change.stiffness / (scale * scale);
            let damping = change.damping * self.omega / (scale * scale);
            [[real(stiffness.re), real(stiffness.im)], [real(damping), real(0.0)]]
        };
        let designs = &self.request.designs[designs.clone()];
        designs.iter().flat_map(|design| design.iter().zip(&self.scales).flat_map(scaled)).collect()
    }

    fn pairs(&self) -> Vec<u32> {
        let springs = self.request.base.n_springs;
        let places = |&(a, b): &(usize, usize)| {
            let (row, column) = (springs + a.max(b), springs + a.min(b));
            [entry(row, column), entry(row, 0), entry(column, 0)].map(|place| place as u32)
        };
        self.request.pairs.iter().flat_map(places).collect()
    }

    fn params(&self, tile: &SpringTile) -> SpringParams {
        SpringParams {
            n_frequencies: tile.frequencies.len() as u32,
            n_slots: slots(&tile.chunks) as u32,
            n_designs: tile.designs.len() as u32,
            n_pairs: self.request.pairs.len() as u32,
            zero: 0,
        }
    }

    fn variant(&self, kernel: Kernel, precision: Precision) -> Variant {
        Variant::of_springs(kernel, precision, self.request.base.n_springs, self.request.ports())
    }

    /// The tiles that the device's limits allow.
    fn tiles(&self, gpu: &Gpu, kernel: Kernel, precision: Precision) -> Result<Vec<SpringTile>, GpuError> {
        let base = self.request.base;
        let (n, rows, n_pairs) = (base.frequencies.len(), base.n_rows as u64, self.request.pairs.len() as u64);
        let per_slot = 2 * precision.bytes() * (entry(base.n_rows, 0) as u64 + 1);
        let fitting = (gpu.max_binding() / per_slot).saturating_sub(2) / u64::from(CORE);
        let per_chunk = n_pairs * record(kernel, precision);
        let room = TILE_BYTES.min(gpu.max_binding());
        let most_chunks = fitting.min(room / per_chunk).min(gpu.max_workgroups() as u64) as usize;
        if most_chunks == 0 {
            let (needed, allowed) = (per_chunk.max(per_slot * u64::from(WORKGROUP)), room);
            let adapter = gpu.adapter().name.clone();
            return Err(GpuError::TooLarge { adapter, what: "a chunk of frequencies", needed, allowed });
        }
        let patience = if gpu.adapter().is_software() { SOFTWARE_TILE_PRODUCTS } else { TILE_PRODUCTS };
        let all_chunks = n.div_ceil(CORE as usize);
        let mut tiles = Vec::new();
        for first in (0..all_chunks).step_by(most_chunks) {
            let chunks = first..(first + most_chunks).min(all_chunks);
            let frequencies = first * CORE as usize..(chunks.end * CORE as usize).min(n);
            let products =
                chunks.len() as u64 * u64::from(WORKGROUP) * (base.n_springs as u64 * rows * rows / 2 + rows);
            let changes = 4 * precision.bytes() * base.n_springs.max(1) as u64;
            let most = (room / (per_chunk * chunks.len() as u64))
                .min(patience / products)
                .min(gpu.max_binding() / changes)
                .clamp(1, gpu.max_workgroups() as u64) as usize;
            for design in (0..self.request.designs.len()).step_by(most) {
                let designs = design..(design + most).min(self.request.designs.len());
                tiles.push(SpringTile { designs, chunks: chunks.clone(), frequencies: frequencies.clone() });
            }
        }
        Ok(tiles)
    }

    /// Runs a kernel over all tiles; while one tile is read the next is computed.
    pub fn run<T: Pod>(
        &self,
        gpu: &Gpu,
        kernel: Kernel,
        precision: Precision,
        real: &dyn Fn(f64) -> T,
        deliver: &mut Deliver<'_>,
    ) -> Result<(), GpuError> {
        if self.request.pairs.is_empty() {
            return Ok(());
        }
        let pipeline = gpu.kernels().get(gpu, self.variant(kernel, precision))?;
        let tiles = self.tiles(gpu, kernel, precision)?;
        let pairs = self.pairs();
        let mut receptances: (Range<usize>, Vec<[T; 2]>) = (0..0, Vec::new());
        let mut slots = gpu.buffers();
        let mut flying = None;
        for (i, tile) in tiles.iter().map(Some).chain([None]).enumerate() {
            let next = match tile {
                None => None,
                Some(tile) => {
                    if receptances.0 != tile.chunks {
                        receptances = (tile.chunks.clone(), self.receptances(&tile.chunks, real));
                    }
                    let changes = self.changes(&tile.designs, real);
                    let params = self.params(tile);
                    let inputs = Inputs {
                        uniform: bytemuck::bytes_of(&params),
                        arrays: [
                            bytemuck::cast_slice(&receptances.1),
                            bytemuck::cast_slice(&changes),
                            bytemuck::cast_slice(&pairs),
                        ],
                    };
                    let workgroups = [tile.chunks.len() as u32, tile.designs.len() as u32, 1];
                    let bytes = tile.designs.len() as u64 * self.bytes(tile, kernel, precision);
                    Some((tile, i % 2, slots[i % 2].submit(gpu, &pipeline, inputs, workgroups, bytes)?))
                }
            };
            if let Some((tile, slot, work)) = std::mem::replace(&mut flying, next) {
                slots[slot].read(gpu, work, |bytes| deliver(tile, bytes))?;
            }
        }
        gpu.keep(slots);
        Ok(())
    }

    /// Bytes of a design's results in a tile.
    fn bytes(&self, tile: &SpringTile, kernel: Kernel, precision: Precision) -> u64 {
        let each = match kernel {
            Kernel::Extrema => tile.chunks.len() as u64 * record(kernel, precision),
            _ => tile.frequencies.len() as u64 * 2 * precision.bytes(),
        };
        self.request.pairs.len() as u64 * each
    }
}

/// Slots of some chunks: their frequencies and a neighbour on either side.
fn slots(chunks: &Range<usize>) -> usize {
    chunks.len() * CORE as usize + 2
}

/// Bytes of a pair's results in a chunk at most.
fn record(kernel: Kernel, precision: Precision) -> u64 {
    match (kernel, precision) {
        (Kernel::Extrema, Precision::F32) => size_of::<Maxima<f32>>() as u64,
        (Kernel::Extrema, Precision::F64) => size_of::<Maxima<f64>>() as u64,
        _ => u64::from(CORE) * 2 * precision.bytes(),
    }
}

/// Shader text, parameters, read-only arrays, workgroups, and the unit of each pair's values in m/N.
#[doc(hidden)]
pub type SpringShaderInputs = (String, SpringParams, [Vec<u8>; 3], [u32; 3], Vec<f64>);

/// What a device is given for a whole request in f32: as [`super::shader_inputs`], for a kernel that changes springs,
/// and the unit of each pair's values in m/N.
///
/// # Errors
/// As [`modified`].
#[doc(hidden)]
pub fn spring_shader_inputs(
    gpu: &Gpu,
    request: &SpringRequest<'_>,
    kernel: Kernel,
) -> Result<SpringShaderInputs, GpuError> {
    let packed = Packed::new(gpu, request)?;
    let n = request.base.frequencies.len();
    let tile =
        SpringTile { designs: 0..request.designs.len(), chunks: 0..n.div_ceil(CORE as usize), frequencies: 0..n };
    let real = |x: f64| x as f32;
    let arrays = [
        bytemuck::cast_slice(&packed.receptances(&tile.chunks, real)).to_vec(),
        bytemuck::cast_slice(&packed.changes(&tile.designs, real)).to_vec(),
        bytemuck::cast_slice(&packed.pairs()).to_vec(),
    ];
    let workgroups = [tile.chunks.len() as u32, tile.designs.len() as u32, 1];
    let units = (0..request.pairs.len()).map(|pair| packed.unit(pair)).collect();
    Ok((packed.variant(kernel, Precision::F32).source(), packed.params(&tile), arrays, workgroups, units))
}

/// Compares the device with f64 on a small base before it is used: the largest relative Frobenius difference.
///
/// # Errors
/// [`GpuError::Inaccurate`] above 1e-4, and as [`modified`].
pub fn check(gpu: &Gpu, precision: Precision) -> Result<f64, GpuError> {
    let modes: Vec<BaseMode> = (0..12)
        .map(|r| BaseMode { frequency: 14.1 * 1.431f64.powi(r), damping_ratio: 0.0, loss_factor: 0.02 })
        .collect();
    let rows = DMatrix::from_fn(9, 12, |i, r| 0.05 * (1.7 * (1 + i + 9 * r) as f64).sin());
    let frequencies: Vec<f64> = (0..200).map(|k| 10.0 * 1.02f64.powi(k)).collect();
    let base = BaseReceptance::new(&frequencies, &modes, &rows, &DMatrix::zeros(9, 9), 6);
    let change =
        |s: usize| SpringChange { stiffness: Complex::new(1.0, 0.02) * 3e6 * (2.3 * s as f64).sin(), damping: 40.0 };
    let designs = [(0..6).map(change).collect::<Vec<_>>()];
    let pairs: Vec<(usize, usize)> = (0..3).flat_map(|i| (0..=i).map(move |j| (i, j))).collect();
    let request = SpringRequest { base: &base, designs: &designs, pairs: &pairs, position: 0 };
    let found = modified(gpu, &request, precision)?.swap_remove(0);
    let exact = base.modified(&designs[0], &pairs, &mut Work::default());
    let figure = (0..frequencies.len())
        .map(|k| {
            let norm = |of: &dyn Fn(usize) -> Complex<f64>| (0..6).map(|p| of(p).norm_sqr()).sum::<f64>().sqrt();
            norm(&|p| found[p][k] - exact[p][k]) / norm(&|p| exact[p][k])
        })
        .fold(0.0, f64::max);
    if figure > BOUND {
        let adapter = gpu.adapter().name.clone();
        return Err(GpuError::Inaccurate {
            adapter,
            what: "Frobenius difference of changed springs",
            figure,
            bound: BOUND,
        });
    }
    Ok(figure)
}
