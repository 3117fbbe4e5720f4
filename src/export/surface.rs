//! One response over positions and frequencies as CSV, long form.

use std::path::{Path, PathBuf};

use nalgebra::Complex;
use rayon::prelude::*;

use super::atomic::AtomicFile;
use super::response::{Response, direct_responses};
use super::{ExportError, digits, finite, length};
use crate::frf::{ComplianceMap, Quantity, Tile, TileRange};

/// Positions whose lines are made together.
const BLOCK: usize = 64;

/// Writes `surface_<label>.csv` for every direct response of the map; returns the paths.
///
/// # Errors
/// As [`write_surface`].
pub fn write_direct_surfaces(folder: &Path, map: &ComplianceMap) -> Result<Vec<PathBuf>, ExportError> {
    direct_responses(map)
        .iter()
        .map(|response| {
            let path = folder.join(format!("surface_{}.csv", response.label));
            write_surface(&path, map, response).map(|()| path)
        })
        .collect()
}

/// Writes one response of a whole map; as [`SurfaceWriter`].
///
/// # Errors
/// [`ExportError::Shape`] if the values do not fill the map, [`ExportError::NotFinite`] for NaN and
/// infinities with their place, [`ExportError::Io`] if the file cannot be written.
///
/// # Panics
/// If the response is not one of the map.
pub fn write_surface(path: &Path, map: &ComplianceMap, response: &Response) -> Result<(), ExportError> {
    let axes = SurfaceAxes {
        positions: &map.positions,
        frequencies: &map.frequencies,
        n_outputs: map.outputs.len(),
        n_inputs: map.inputs.len(),
        quantity: map.quantity,
    };
    let per_position = map.frequencies.len() * axes.n_outputs * axes.n_inputs;
    length(path, "the map", map.values.len(), map.positions.len() * per_position)?;
    let mut writer = SurfaceWriter::create(path, axes, response)?;
    if per_position > 0 {
        for (block, values) in map.values.chunks(BLOCK * per_position).enumerate() {
            let first = block * BLOCK;
            let positions = first..first + values.len() / per_position;
            writer.append(&Tile { range: TileRange { positions, frequencies: 0..map.frequencies.len() }, values })?;
        }
    }
    writer.commit()
}

/// What a surface lies over, and of what its map consists.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceAxes<'a> {
    /// Positions, m.
    pub positions: &'a [f64],
    /// Frequencies, Hz.
    pub frequencies: &'a [f64],
    /// Outputs of the map.
    pub n_outputs: usize,
    /// Inputs of the map.
    pub n_inputs: usize,
    /// What the map holds.
    pub quantity: Quantity,
}

/// Writes one response tile by tile: `position_m, frequency_hz, magnitude_m_per_N, phase_deg`.
///
/// One line a position and frequency, frequencies fastest. The magnitude has nine significant
/// digits, the phase six decimals in (-180, 180]. For mobility and accelerance the third column is
/// `magnitude_m_per_s_N` and `magnitude_m_per_s2_N`.
pub struct SurfaceWriter<'a> {
    file: AtomicFile,
    axes: SurfaceAxes<'a>,
    /// Index of the response among the values of a pair.
    entry: usize,
    /// The frequencies as their column.
    frequencies: Vec<String>,
    pairs: usize,
}

impl<'a> SurfaceWriter<'a> {
    /// Begins the file aside.
    ///
    /// # Errors
    /// [`ExportError::Io`].
    ///
    /// # Panics
    /// If the response is not one of the map.
    pub fn create(path: &Path, axes: SurfaceAxes<'a>, response: &Response) -> Result<SurfaceWriter<'a>, ExportError> {
        let (n_out, n_in) = (axes.n_outputs, axes.n_inputs);
        assert!(response.output < n_out && response.input < n_in, "{response:?} of {n_out} x {n_in}");
        let column = match axes.quantity {
            Quantity::Receptance => "magnitude_m_per_N",
            Quantity::Mobility => "magnitude_m_per_s_N",
            Quantity::Accelerance => "magnitude_m_per_s2_N",
        };
        let mut file = AtomicFile::create(path)?;
        file.write(format!("position_m,frequency_hz,{column},phase_deg\n").as_bytes())?;
        let frequencies = axes.frequencies.iter().map(|f| format!(",{f},")).collect();
        Ok(SurfaceWriter { file, axes, entry: response.output * n_in + response.input, frequencies, pairs: 0 })
    }

    /// Appends the lines of a tile.
    ///
    /// # Errors
    /// [`ExportError::NotFinite`] for NaN and infinities with their place, [`ExportError::Io`].
    ///
    /// # Panics
    /// If the tile does not follow the one before.
    pub fn append(&mut self, tile: &Tile<'_>) -> Result<(), ExportError> {
        let first = tile.range.positions.start * self.axes.frequencies.len() + tile.range.frequencies.start;
        assert_eq!(first, self.pairs, "tiles come in the map's order");
        let per_position = tile.range.frequencies.len() * self.axes.n_outputs * self.axes.n_inputs;
        let rows = tile.range.positions.clone().into_par_iter().zip(tile.values.par_chunks(per_position));
        let lines: Vec<Vec<u8>> =
            rows.map(|(p, values)| self.lines(p, tile.range.frequencies.start, values)).collect::<Result<_, _>>()?;
        lines.iter().try_for_each(|block| self.file.write(block))?;
        self.pairs += tile.range.pairs();
        Ok(())
    }

    /// The lines of one position's values from the frequency number `first` on.
    fn lines(&self, p: usize, first: usize, values: &[Complex<f64>]) -> Result<Vec<u8>, ExportError> {
        let path = self.file.path();
        let position = finite(path, self.axes.positions[p], || format!("position {p}"))?.to_string();
        let rows = values.chunks_exact(self.axes.n_outputs * self.axes.n_inputs);
        let mut lines = Vec::with_capacity(rows.len() * 48);
        for (f, row) in (first..).zip(rows) {
            let Complex { re, im } = row[self.entry];
            let magnitude = re.hypot(im);
            let hertz = self.axes.frequencies[f];
            if !(magnitude.is_finite() && hertz.is_finite()) {
                let what = format!("the response at {position} m and {hertz} Hz");
                return Err(ExportError::NotFinite { path: path.into(), what, value: magnitude });
            }
            lines.extend_from_slice(position.as_bytes());
            lines.extend_from_slice(self.frequencies[f].as_bytes());
            digits::scientific(&mut lines, magnitude);
            lines.push(b',');
            digits::fixed6(&mut lines, im.atan2(re).to_degrees());
            lines.push(b'\n');
        }
        Ok(lines)
    }

    /// Puts the file in its place once the map is whole.
    ///
    /// # Errors
    /// [`ExportError::Shape`] if tiles are missing, [`ExportError::Io`].
    pub fn commit(self) -> Result<(), ExportError> {
        let expected = self.axes.positions.len() * self.axes.frequencies.len();
        length(self.file.path(), "the surface", self.pairs, expected)?;
        self.file.commit()
    }
}
