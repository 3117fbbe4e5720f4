//! Tiles: contiguous pieces of a map, for maps that do not fit memory or a device.

use std::ops::Range;

use nalgebra::Complex;

/// What a receiver of tiles may answer.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// A receiver of tiles. Tiles come in the map's order and each is contiguous in it, so a writer can append them.
pub type Sink<'a> = dyn FnMut(Tile<'_>) -> Result<(), SinkError> + Send + 'a;

/// Where a tile lies in the map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileRange {
    /// Indices of the positions.
    pub positions: Range<usize>,
    /// Indices of the frequencies; the whole grid unless the tile has a single position.
    pub frequencies: Range<usize>,
}

impl TileRange {
    /// (position, frequency) pairs in the tile.
    pub fn pairs(&self) -> usize {
        self.positions.len() * self.frequencies.len()
    }
}

/// A contiguous piece of a map.
#[derive(Clone, Debug)]
pub struct Tile<'a> {
    /// Where it lies.
    pub range: TileRange,
    /// `[position, frequency, output, input]` within the tile, last index fastest.
    pub values: &'a [Complex<f64>],
}

/// What a tile may hold at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileLimits {
    /// (position, frequency) pairs.
    pub pairs: usize,
    /// Positions.
    pub positions: usize,
    /// Frequencies.
    pub frequencies: usize,
}

/// Cuts the map from its pair number `first_pair` on into tiles, in the map's order: whole positions together where one
/// fits, pieces of one position's grid otherwise.
pub fn tiles(n_positions: usize, n_frequencies: usize, first_pair: usize, limits: TileLimits) -> Vec<TileRange> {
    assert!(limits.pairs > 0 && limits.positions > 0 && limits.frequencies > 0, "a tile holds a pair: {limits:?}");
    assert!(n_frequencies > 0, "a map has frequencies");
    let longest = limits.pairs.min(limits.frequencies);
    let mut tiles = Vec::new();
    let mut pieces = |position: usize, from: usize| {
        tiles.extend((from..n_frequencies).step_by(longest).map(|start| TileRange {
            positions: position..position + 1,
            frequencies: start..(start + longest).min(n_frequencies),
        }));
    };
    let (mut position, frequency) = (first_pair / n_frequencies, first_pair % n_frequencies);
    if frequency > 0 && position < n_positions {
        pieces(position, frequency);
        position += 1;
    }
    if n_frequencies > longest {
        (position..n_positions).for_each(|position| pieces(position, 0));
        return tiles;
    }
    let step = (limits.pairs / n_frequencies).min(limits.positions);
    tiles.extend(
        (position..n_positions).step_by(step).map(|start| TileRange {
            positions: start..(start + step).min(n_positions),
            frequencies: 0..n_frequencies,
        }),
    );
    tiles
}
