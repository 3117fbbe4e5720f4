//! What the processor reaches at most, measured.

use std::hint::black_box;
use std::time::Instant;

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// What the processor reaches: operations and bytes written a second, all threads.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peaks {
    pub flops: f64,
    pub bytes: f64,
}

impl Peaks {
    pub(super) fn measure() -> Peaks {
        const ROUNDS: usize = 200_000;
        let threads = rayon::current_num_threads();
        let best = |run: &mut dyn FnMut() -> f64| (0..3).map(|_| run()).fold(0.0, f64::max);
        let flops = best(&mut || {
            let start = Instant::now();
            let flops: f64 =
                (0..threads).into_par_iter().map(|_| Arch::new().dispatch(MultiplyAdds { rounds: ROUNDS })).sum();
            flops / start.elapsed().as_secs_f64()
        });
        let mut memory = vec![0u64; 8 << 20];
        let bytes = best(&mut || {
            let start = Instant::now();
            let chunk = memory.len() / threads;
            memory.par_chunks_mut(chunk.max(1)).for_each(|chunk| chunk.fill(black_box(1)));
            size_of_val(&memory[..]) as f64 / start.elapsed().as_secs_f64()
        });
        Peaks { flops, bytes }
    }
}

/// The f64 lanes of a vector of the processor.
pub(super) struct Lanes;

impl WithSimd for Lanes {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F64_LANES
    }
}

/// Independent multiply-adds that never leave the registers; returns their number of operations.
struct MultiplyAdds {
    rounds: usize,
}

impl WithSimd for MultiplyAdds {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        const CHAINS: usize = 12;
        let factor = simd.splat_f64s(black_box(0.999));
        let mut sums = [simd.splat_f64s(black_box(1.0)); CHAINS];
        for _ in 0..self.rounds {
            for sum in &mut sums {
                *sum = simd.mul_add_f64s(*sum, factor, factor);
            }
        }
        let total = sums.iter().map(|s| simd.reduce_sum_f64s(*s)).sum::<f64>();
        black_box(total);
        (self.rounds * CHAINS * 2 * S::F64_LANES) as f64
    }
}
