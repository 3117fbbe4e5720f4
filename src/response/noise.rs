//! Normal numbers that are the same on every machine.

use std::f64::consts::TAU;

/// Normal numbers by Box and Muller from SplitMix64.
pub(super) struct Normal {
    state: u64,
    spare: Option<f64>,
}

/// The last step of SplitMix64: numbers that differ in one bit come out unlike.
fn scrambled(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The seed of one of several sequences; number 0 has the seed itself. Seeds a multiple of the generator's increment
/// apart would give one sequence, shifted; scrambling keeps them from that.
pub(super) fn mixed(seed: u64, number: u64) -> u64 {
    if number == 0 { seed } else { scrambled(seed ^ scrambled(number)) }
}

impl Normal {
    pub fn new(seed: u64) -> Self {
        Self { state: seed, spare: None }
    }

    /// Uniform in (0, 1).
    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        ((scrambled(self.state) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    pub fn next(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        let (sine, cosine) = (TAU * self.uniform()).sin_cos();
        self.spare = Some(radius * sine);
        radius * cosine
    }
}
