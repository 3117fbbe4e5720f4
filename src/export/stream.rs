//! A map on its way to its files: tiles come in, nothing of the map is kept.

use std::path::{Path, PathBuf};

use super::npy::NpyWriter;
use super::response::direct_responses_of;
use super::surface::{SurfaceAxes, SurfaceWriter};
use super::{ExportError, mat};
use crate::frf::metrics::GridExtrema;
use crate::frf::{FrfRequest, GridSearch, Tile};

/// Name of the file of a streamed map.
pub const MAP_FILE: &str = "compliance.npy";

/// Writes `compliance.npy`, `compliance.mat` with its axes, and the surfaces of the direct responses from the tiles of a
/// map, and finds the extrema on its grid. All files are written aside until [`MapStream::commit`].
pub struct MapStream<'a> {
    request: &'a FrfRequest<'a>,
    folder: PathBuf,
    map: NpyWriter<'a>,
    surfaces: Vec<(PathBuf, SurfaceWriter<'a>)>,
    search: GridSearch,
    tiles: usize,
    largest_tile: usize,
}

/// What a streamed map left.
#[derive(Debug)]
pub struct Streamed {
    /// The files.
    pub files: Vec<PathBuf>,
    /// Extrema on the grid, `[position][pair]`.
    pub extrema: Vec<Vec<GridExtrema>>,
    /// Tiles that came.
    pub tiles: usize,
    /// Bytes of the largest.
    pub tile_bytes: usize,
}

impl<'a> MapStream<'a> {
    /// Begins the files in a folder; extrema are sought of `pairs` of (output, input).
    ///
    /// # Errors
    /// [`ExportError::Io`].
    pub fn create(
        folder: &Path,
        request: &'a FrfRequest<'a>,
        pairs: &[(usize, usize)],
    ) -> Result<MapStream<'a>, ExportError> {
        let axes = SurfaceAxes {
            positions: request.positions,
            frequencies: request.frequencies,
            n_outputs: request.outputs.len(),
            n_inputs: request.inputs.len(),
            quantity: request.quantity,
        };
        let surface = |response: super::response::Response| {
            let path = folder.join(format!("surface_{}.csv", response.label));
            SurfaceWriter::create(&path, axes, &response).map(|writer| (path, writer))
        };
        Ok(MapStream {
            request,
            folder: folder.to_path_buf(),
            map: NpyWriter::create(&folder.join(MAP_FILE), request)?,
            surfaces: direct_responses_of(request.outputs, request.inputs)
                .into_iter()
                .map(surface)
                .collect::<Result<_, _>>()?,
            search: GridSearch::new(request, pairs),
            tiles: 0,
            largest_tile: 0,
        })
    }

    /// Takes the next tile.
    ///
    /// # Errors
    /// [`ExportError::NotFinite`] for NaN and infinities with their place, [`ExportError::Io`].
    ///
    /// # Panics
    /// If the tile does not follow the one before.
    pub fn append(&mut self, tile: &Tile<'_>) -> Result<(), ExportError> {
        self.map.append(tile)?;
        self.surfaces.iter_mut().try_for_each(|(_, surface)| surface.append(tile))?;
        self.search.look(tile);
        self.tiles += 1;
        self.largest_tile = self.largest_tile.max(size_of_val(tile.values));
        Ok(())
    }

    /// Puts the files in their places once the map is whole.
    ///
    /// # Errors
    /// [`ExportError::Shape`] if tiles are missing, [`ExportError::Io`].
    pub fn commit(self) -> Result<Streamed, ExportError> {
        let map = self.folder.join(MAP_FILE);
        self.map.commit()?;
        let axes = self.folder.join("compliance.mat");
        mat::write_axes(&axes, self.request, MAP_FILE)?;
        let mut files = vec![axes, map];
        for (path, surface) in self.surfaces {
            surface.commit()?;
            files.push(path);
        }
        Ok(Streamed { files, extrema: self.search.finish(), tiles: self.tiles, tile_bytes: self.largest_tile })
    }
}
