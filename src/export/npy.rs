//! `compliance.npy`: a map larger than memory or than a MAT-file's variable, in NumPy's format.
//!
//! The file is a header of a whole number of 64 bytes and the values in the map's order, so it is written tile by tile
//! and read by memory mapping: `numpy.load(file, mmap_mode="r")`, or MATLAB's `memmapfile` with the offset and extents
//! that stand in `compliance.mat` beside it. Values are complex f64 in the machine's own byte order, which the header
//! states.
//!
//! Source: NumPy Enhancement Proposal 1, format version 1.0.

use std::path::Path;

use rayon::prelude::*;

use super::atomic::AtomicFile;
use super::{ExportError, length};
use crate::frf::{FrfRequest, Tile};

/// Bytes before the values of an array of these extents.
pub fn header(extents: &[usize]) -> Vec<u8> {
    let extents: Vec<String> = extents.iter().map(|n| format!("{n},")).collect();
    let order = if cfg!(target_endian = "little") { '<' } else { '>' };
    let text = format!("{{'descr': '{order}c16', 'fortran_order': False, 'shape': ({}), }}", extents.join(" "));
    // Magic, version, the length of what follows, the text, spaces, a line feed: together a multiple of 64.
    let before = 10;
    let total = (before + text.len() + 1).next_multiple_of(64);
    let padding = total - before - text.len() - 1;
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend(((total - before) as u16).to_le_bytes());
    header.extend(text.bytes());
    header.resize(header.len() + padding, b' ');
    header.push(b'\n');
    header
}

/// Writes a map tile by tile.
pub struct NpyWriter<'a> {
    file: AtomicFile,
    request: &'a FrfRequest<'a>,
    pairs: usize,
}

impl<'a> NpyWriter<'a> {
    /// Begins the file of a request's map aside.
    ///
    /// # Errors
    /// [`ExportError::Io`].
    pub fn create(path: &Path, request: &'a FrfRequest<'a>) -> Result<NpyWriter<'a>, ExportError> {
        let mut file = AtomicFile::create(path)?;
        file.write(&header(&extents(request)))?;
        Ok(NpyWriter { file, request, pairs: 0 })
    }

    /// Appends a tile.
    ///
    /// # Errors
    /// [`ExportError::NotFinite`] for NaN and infinities with their place, [`ExportError::Io`].
    ///
    /// # Panics
    /// If the tile does not follow the one before.
    pub fn append(&mut self, tile: &Tile<'_>) -> Result<(), ExportError> {
        let first = tile.range.positions.start * self.request.frequencies.len() + tile.range.frequencies.start;
        assert_eq!(first, self.pairs, "tiles come in the map's order");
        let bad = tile.values.par_iter().position_first(|v| !(v.re.is_finite() && v.im.is_finite()));
        if let Some(at) = bad {
            let pair = first + at / self.request.values_per_pair();
            let (p, f) = (pair / self.request.frequencies.len(), pair % self.request.frequencies.len());
            let value = tile.values[at];
            return Err(ExportError::NotFinite {
                path: self.file.path().into(),
                what: format!("the response at {} m and {} Hz", self.request.positions[p], self.request.frequencies[f]),
                value: if value.re.is_finite() { value.im } else { value.re },
            });
        }
        self.file.write(bytemuck::cast_slice(tile.values))?;
        self.pairs += tile.range.pairs();
        Ok(())
    }

    /// Puts the file in its place once the map is whole.
    ///
    /// # Errors
    /// [`ExportError::Shape`] if tiles are missing, [`ExportError::Io`].
    pub fn commit(self) -> Result<(), ExportError> {
        let expected = self.request.positions.len() * self.request.frequencies.len();
        length(self.file.path(), "the map", self.pairs, expected)?;
        self.file.commit()
    }
}

/// Positions, frequencies, outputs, inputs.
pub fn extents(request: &FrfRequest) -> [usize; 4] {
    [request.positions.len(), request.frequencies.len(), request.outputs.len(), request.inputs.len()]
}
