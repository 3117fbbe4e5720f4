//! Free motions at 0 Hz.
//!
//! A motion that nothing resists has omega_r = 0. Its share of the receptance is L R^T / (-omega^2), which has no bound
//! as omega goes to 0; so has that of the mobility. Multiplied by -omega^2 it is L R^T at every frequency: accelerance is
//! finite, and at 0 Hz it is all there is, since every elastic mode and the residual are multiplied by 0:
//!
//! ```text
//! A_ij(0) = sum over free motions of L_ir R_jr      [1/kg]
//! ```
//!
//! A free point mass gives 1/m. The sums divide 0 by 0 there, so the value is put in its place afterwards.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::packing::{PackedSystem, Packing};
use super::request::Quantity;
use super::{FrfError, FrfRequest};

impl PackedSystem {
    /// The values `[output, input]` at 0 Hz of a system with free motions in an accelerance; `None` where the sums
    /// themselves hold at 0 Hz.
    pub fn at_rest(&self, packing: &Packing, quantity: Quantity) -> Option<Vec<Complex<f64>>> {
        let n_pairs = packing.pairs.len();
        let free = || self.modes.iter().zip(self.residues.chunks_exact(n_pairs)).filter(|(m, _)| m.frequency == 0.0);
        if quantity != Quantity::Accelerance || free().next().is_none() {
            return None;
        }
        let of_pair = |&pair: &usize| Complex::from(free().map(|(_, a)| a[pair]).sum::<f64>() * TAU * TAU);
        Some(packing.pair_of_value.iter().map(of_pair).collect())
    }
}

impl FrfRequest<'_> {
    /// Whether the map holds an accelerance at 0 Hz, which free motions make a case of its own.
    pub(crate) fn has_accelerance_at_rest(&self) -> bool {
        self.quantity == Quantity::Accelerance && self.frequencies.first() == Some(&0.0)
    }

    /// Refuses receptance and mobility at 0 Hz where free motions make them infinite. `names` says what moves, as
    /// [`crate::modal::Modes::free_motions`] does; an empty list where nobody knows.
    ///
    /// # Errors
    /// [`FrfError::FreeMotion`] for the first position with a free motion.
    pub fn check_at_rest(&self, names: &[String]) -> Result<(), FrfError> {
        if self.quantity == Quantity::Accelerance || self.frequencies.first() != Some(&0.0) {
            return Ok(());
        }
        for (system, &position) in self.systems.iter().zip(self.positions) {
            let count = system.frequencies.iter().filter(|f| **f == 0.0).count();
            if count > 0 {
                let mut moves: Vec<String> = Vec::new();
                names.iter().for_each(|name| {
                    if !moves.contains(name) {
                        moves.push(name.clone());
                    }
                });
                return Err(FrfError::FreeMotion { position, count, moves, quantity: self.quantity.name() });
            }
        }
        Ok(())
    }
}
