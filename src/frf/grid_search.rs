//! The extrema of a map on its grid, found tile by tile: a map that is streamed never lies in memory as a whole.

use nalgebra::Complex;
use rayon::prelude::*;

use super::metrics::GridExtrema;
use super::{FrfRequest, Tile};

/// A pair's best so far at a position.
#[derive(Clone, Copy)]
struct Best {
    squared: f64,
    real: f64,
    at: GridExtrema,
}

const NOTHING: Best =
    Best { squared: f64::NEG_INFINITY, real: f64::INFINITY, at: GridExtrema { peak: 0, most_negative_real: 0 } };

/// Looks for the largest |H| and the smallest Re H of some pairs at each position in tiles that come in the map's order.
pub struct GridSearch {
    pairs: Vec<(usize, usize)>,
    n_inputs: usize,
    values_per_pair: usize,
    n_positions: usize,
    /// `[position, pair]`.
    best: Vec<Best>,
}

impl GridSearch {
    /// A search in the map of a request for pairs of (output, input).
    pub fn new(request: &FrfRequest, pairs: &[(usize, usize)]) -> GridSearch {
        GridSearch::with(request.positions.len(), request.inputs.len(), request.values_per_pair(), pairs)
    }

    pub(super) fn with(
        n_positions: usize,
        n_inputs: usize,
        values_per_pair: usize,
        pairs: &[(usize, usize)],
    ) -> GridSearch {
        let best = vec![NOTHING; n_positions * pairs.len()];
        GridSearch { pairs: pairs.to_vec(), n_inputs, values_per_pair, n_positions, best }
    }

    /// Looks at a tile. Of equal values the lowest frequency is kept, if tiles come in order.
    pub fn look(&mut self, tile: &Tile<'_>) {
        let n_pairs = self.pairs.len();
        if n_pairs == 0 {
            return;
        }
        let first = tile.range.frequencies.start;
        let per_position = tile.range.frequencies.len() * self.values_per_pair;
        let best = &mut self.best[tile.range.positions.start * n_pairs..tile.range.positions.end * n_pairs];
        best.par_chunks_mut(n_pairs).zip(tile.values.par_chunks(per_position)).for_each(|(best, values)| {
            for (best, &(output, input)) in best.iter_mut().zip(&self.pairs) {
                best.look(values.chunks_exact(self.values_per_pair).map(|h| h[output * self.n_inputs + input]), first);
            }
        });
    }

    /// What was found, `[position][pair]`.
    pub fn finish(self) -> Vec<Vec<GridExtrema>> {
        let row = |p: usize| self.best[p * self.pairs.len()..][..self.pairs.len()].iter().map(|b| b.at).collect();
        (0..self.n_positions).map(row).collect()
    }
}

impl Best {
    fn look(&mut self, values: impl Iterator<Item = Complex<f64>>, first: usize) {
        for (k, h) in values.enumerate() {
            if h.norm_sqr() > self.squared {
                (self.squared, self.at.peak) = (h.norm_sqr(), first + k);
            }
            if h.re < self.real {
                (self.real, self.at.most_negative_real) = (h.re, first + k);
            }
        }
    }
}
