//! The request as the device reads it: packed reals in scaled units.
//!
//! Frequencies are divided by a power of two next to the grid's highest, which loses nothing and keeps squares inside
//! f32 whatever the band; responses are in um/N. The scale and the powers of 2 pi of mobility and accelerance are folded
//! into the residues and the residual here, in f64.

use std::f64::consts::TAU;

use rayon::prelude::*;

use crate::frf::{FrfRequest, ModalSystem, PackedSystem, Packing};

use super::buffers::Inputs;
use super::shader::{Params, Precision};

/// Metres in the device's unit of length.
pub(super) const MICRON: f64 = 1e-6;

/// A request, from which tiles are packed.
#[derive(Debug)]
pub(super) struct Model<'a> {
    pub packing: Packing,
    systems: &'a [ModalSystem],
    /// Hz in the unit of frequency, a power of two.
    scale: f64,
    n_modes: usize,
    n_degrees: usize,
    n_duos: usize,
    power: u32,
}

/// The reals of a tile, as bytes of the precision.
#[derive(Debug)]
pub(super) struct TileModel {
    pub params: Params,
    pub frequencies: Vec<u8>,
    pub modes: Vec<u8>,
    pub residual: Vec<u8>,
}

impl TileModel {
    /// As a kernel reads them.
    pub fn inputs(&self) -> Inputs<'_> {
        Inputs { uniform: bytemuck::bytes_of(&self.params), arrays: [&self.frequencies, &self.modes, &self.residual] }
    }
}

impl<'a> Model<'a> {
    /// Packs a checked request for groups of `duos` duos.
    pub fn new(request: &FrfRequest<'a>, packing: Packing, duos: u32) -> Model<'a> {
        let systems = request.systems;
        let highest = request.frequencies[request.frequencies.len() - 1];
        let scale = if highest > 0.0 { highest.log2().ceil().exp2() } else { 1.0 };
        let n_pairs = packing.pairs.len();
        Model {
            scale,
            n_modes: request.max_modes(),
            n_degrees: systems.iter().map(|s| s.residual.len()).max().unwrap_or(0),
            n_duos: n_pairs.div_ceil(2).next_multiple_of(duos as usize),
            power: request.quantity.power(),
            packing,
            systems,
        }
    }

    /// Reals a position in `modes`.
    pub fn mode_reals(&self) -> usize {
        2 * self.n_modes * (2 + self.n_duos)
    }

    /// Reals a position in `residual`.
    pub fn residual_reals(&self) -> usize {
        4 * self.n_degrees * self.n_duos
    }

    /// Groups of duos: workgroups in z.
    pub fn groups(&self, duos: u32) -> u32 {
        self.n_duos as u32 / duos
    }

    /// Packs a tile.
    pub fn tile(&self, precision: Precision, positions: std::ops::Range<usize>, frequencies: &[f64]) -> TileModel {
        let params = Params {
            n_frequencies: frequencies.len() as u32,
            n_positions: positions.len() as u32,
            n_modes: self.n_modes as u32,
            n_degrees: self.n_degrees as u32,
            n_pairs: self.packing.pairs.len() as u32,
            n_duos: self.n_duos as u32,
            power: self.power,
            zero: 0,
        };
        let systems: Vec<_> = self.systems[positions].par_iter().map(|s| PackedSystem::new(s, &self.packing)).collect();
        let mut out = [Reals::new(precision), Reals::new(precision), Reals::new(precision)];
        frequencies.iter().for_each(|f| out[0].push_split(f / self.scale));
        systems.iter().for_each(|s| self.push_modes(s, &mut out[1]));
        systems.iter().for_each(|s| self.push_residual(s, &mut out[2]));
        let [frequencies, modes, residual] = out.map(|reals| reals.bytes);
        TileModel { params, frequencies, modes, residual }
    }

    /// What turns m/N into the device's unit.
    fn unit(&self) -> f64 {
        (TAU * self.scale).powi(self.power as i32) / MICRON
    }

    fn push_modes(&self, system: &PackedSystem, out: &mut Reals) {
        let n_pairs = self.packing.pairs.len();
        let square = self.scale * self.scale;
        let unit = self.unit() / square;
        for (mode, residues) in system.modes.iter().zip(system.residues.chunks_exact(n_pairs)) {
            out.push_split(mode.frequency / self.scale);
            out.push(mode.viscous / self.scale);
            out.push(mode.loss / square);
            residues.iter().for_each(|a| out.push(a * unit));
            (n_pairs..2 * self.n_duos).for_each(|_| out.push(0.0));
        }
        for _ in system.modes.len()..self.n_modes {
            // A mode that is not there: no residue, and a denominator that is never 0.
            [0.0, 0.0, 0.0, 1.0].into_iter().for_each(|x| out.push(x));
            (0..2 * self.n_duos).for_each(|_| out.push(0.0));
        }
    }

    fn push_residual(&self, system: &PackedSystem, out: &mut Reals) {
        let n_pairs = self.packing.pairs.len();
        for k in 0..self.n_degrees {
            let unit = self.unit() * self.scale.powi(k as i32);
            let at = |pair: usize| {
                let c = system.residual.get(k * n_pairs + pair).filter(|_| pair < n_pairs);
                c.map_or((0.0, 0.0), |c| (c.re * unit, c.im * unit))
            };
            for duo in 0..self.n_duos {
                let (a, b) = (at(2 * duo), at(2 * duo + 1));
                [a.0, b.0, a.1, b.1].into_iter().for_each(|x| out.push(x));
            }
        }
    }
}

/// Bytes of reals in the device's precision.
struct Reals {
    precision: Precision,
    bytes: Vec<u8>,
}

impl Reals {
    fn new(precision: Precision) -> Reals {
        Reals { precision, bytes: Vec::new() }
    }

    fn push(&mut self, x: f64) {
        match self.precision {
            Precision::F32 => self.bytes.extend_from_slice(&(x as f32).to_ne_bytes()),
            Precision::F64 => self.bytes.extend_from_slice(&x.to_ne_bytes()),
        }
    }

    /// x as hi + lo.
    fn push_split(&mut self, x: f64) {
        let high = match self.precision {
            Precision::F32 => f64::from(x as f32),
            Precision::F64 => x,
        };
        self.push(high);
        self.push(x - high);
    }
}
