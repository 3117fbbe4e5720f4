//! Reproducible numbers: every number is a function of a seed and its place, the same on every platform.
//!
//! SplitMix64 (Steele, Lea, Flood 2014, Fast splittable pseudorandom number generators) as a hash of a counter, so
//! that the design with index i is known without the i designs before it.

/// The output function of SplitMix64.
pub(super) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A number that depends on all of a list.
pub(super) fn hash(words: &[u64]) -> u64 {
    words.iter().fold(0, |state, word| {
        mix(state.wrapping_add(0x9e37_79b9_7f4a_7c15).wrapping_add(word.wrapping_mul(0xd134_2543_de82_ef95)))
    })
}

/// A number in [0, 1) with 53 bits.
pub(super) fn uniform(words: &[u64]) -> f64 {
    (hash(words) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Place of `i` in a pseudo-random permutation of 0..n: a Feistel network over the next power of four, walked until
/// it falls below n.
pub(super) fn permuted(mut i: u64, n: u64, words: &[u64]) -> u64 {
    assert!(i < n, "{i} of {n}");
    let key = hash(words);
    let half = (64 - n.saturating_sub(1).leading_zeros()).div_ceil(2).max(1);
    let mask = (1_u64 << half) - 1;
    loop {
        let (mut left, mut right) = (i >> half, i & mask);
        for round in 0..6 {
            (left, right) = (right, left ^ (hash(&[key, round, right]) & mask));
        }
        i = left << half | right;
        if i < n {
            return i;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{mix, permuted};

    #[test]
    fn the_published_sequence_of_seed_zero() {
        // Vigna's splitmix64.c from state 0.
        assert_eq!(mix(0x9e37_79b9_7f4a_7c15), 0xe220_a839_7b1d_cdaf);
        assert_eq!(mix(0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(2)), 0x6e78_9e6a_a1b9_65f4);
    }

    #[test]
    fn a_permutation_takes_every_place_once() {
        for n in [1, 2, 3, 7, 16, 200, 1023] {
            let mut seen: Vec<u64> = (0..n).map(|i| permuted(i, n, &[5, n])).collect();
            let kept = seen.iter().enumerate().filter(|(i, v)| *i as u64 == **v).count();
            assert!(n < 16 || kept < 10, "{kept} of {n} stay where they were");
            seen.sort_unstable();
            assert_eq!(seen, (0..n).collect::<Vec<_>>());
        }
    }
}
