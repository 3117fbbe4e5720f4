//! The request that the CPU and the device answer alike, and its checks.

use nalgebra::{Complex, DMatrix};

use super::{ExactDamping, FrfError};
pub use crate::machine::Quantity;

/// Lowest frequency above 0 Hz that the sums accept.
pub const LOWEST_FREQUENCY: f64 = 1e-9;
/// Highest frequency that the sums accept.
pub const HIGHEST_FREQUENCY: f64 = 1e12;
/// 2 zeta + eta below which a mode counts as undamped.
const NO_DAMPING: f64 = 1e-16;

/// Modal model of the machine at one position, as the sums see it.
///
/// ```text
///             n           L_ir R_jr                                d
/// H_ij(omega) = sum ------------------------------------------------ + sum C_k,ij (j omega)^k   [m/N]
///            r=1  omega_r^2 (1 + j eta_r) - omega^2 + 2 j zeta_r omega_r omega   k=0
/// ```
///
/// Where damping couples the modes, these are the ratios and loss factors that projection gives; the sums then take
/// [`Self::exact`] in their place, and the modes here tell where to look for peaks.
#[derive(Clone, Debug)]
pub struct ModalSystem {
    /// Natural frequencies, Hz, ascending; modes at 0 Hz that the ports do not feel are left out.
    pub frequencies: Vec<f64>,
    /// Viscous damping ratio of each mode.
    pub damping_ratios: Vec<f64>,
    /// Structural loss factor of each mode.
    pub loss_factors: Vec<f64>,
    /// Shapes at the outputs, n_output x n_modes, kg^(-1/2).
    pub outputs: DMatrix<f64>,
    /// Shapes at the inputs, n_input x n_modes, kg^(-1/2).
    pub inputs: DMatrix<f64>,
    /// Coefficients C_k of the residual polynomial in j omega, k = 0.., each n_output x n_input.
    pub residual: Vec<DMatrix<Complex<f64>>>,
    /// Damping that couples the modes, where it is to be exact.
    pub exact: Option<std::sync::Arc<ExactDamping>>,
}

/// A request for a map: one modal system a position, one frequency grid for all.
#[derive(Clone, Debug)]
pub struct FrfRequest<'a> {
    /// Positions, m.
    pub positions: &'a [f64],
    /// One modal system a position, all with the same outputs and inputs.
    pub systems: &'a [ModalSystem],
    /// Frequencies, Hz, not negative, strictly ascending.
    pub frequencies: &'a [f64],
    /// Names of the outputs.
    pub outputs: &'a [String],
    /// Names of the inputs.
    pub inputs: &'a [String],
    /// What the map holds.
    pub quantity: Quantity,
}

impl FrfRequest<'_> {
    /// Values at one (position, frequency) pair: outputs times inputs.
    pub fn values_per_pair(&self) -> usize {
        self.outputs.len() * self.inputs.len()
    }

    /// Values of the whole map.
    pub fn len(&self) -> usize {
        self.positions.len() * self.frequencies.len() * self.values_per_pair()
    }

    /// Whether the map has no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The largest number of modes at a position.
    pub fn max_modes(&self) -> usize {
        self.systems.iter().map(|s| s.frequencies.len()).max().unwrap_or(0)
    }

    /// Whether damping couples the modes at any position: such sums are the processor's.
    pub fn is_coupled(&self) -> bool {
        self.systems.iter().any(|s| s.exact.is_some())
    }

    /// Checks everything that the sums take for granted.
    ///
    /// Shapes that do not fit each other are a caller's mistake and panic with both values.
    ///
    /// # Errors
    /// An empty list; a frequency that is NaN, negative or out of range; a grid that does not ascend; a mode with a
    /// frequency, damping or shape that is negative or not finite; an undamped mode whose own frequency is in the
    /// grid; a free motion where the grid holds 0 Hz and the quantity is no accelerance.
    pub fn check(&self) -> Result<(), FrfError> {
        let lengths = [
            ("positions", self.positions.len()),
            ("frequencies", self.frequencies.len()),
            ("outputs", self.outputs.len()),
            ("inputs", self.inputs.len()),
        ];
        if let Some(&(what, _)) = lengths.iter().find(|(_, length)| *length == 0) {
            return Err(FrfError::Empty { what });
        }
        assert_eq!(self.systems.len(), self.positions.len(), "one modal system a position");
        if let Some(index) = self.positions.iter().position(|p| !p.is_finite()) {
            return Err(FrfError::BadPosition { index, value: self.positions[index] });
        }
        check_grid(self.frequencies)?;
        for (position, system) in self.systems.iter().enumerate() {
            self.check_system(position, system)?;
        }
        self.check_at_rest(&[])
    }

    fn check_system(&self, position: usize, system: &ModalSystem) -> Result<(), FrfError> {
        let n = system.frequencies.len();
        assert_eq!(system.damping_ratios.len(), n, "one damping ratio a mode at position {position}");
        assert_eq!(system.loss_factors.len(), n, "one loss factor a mode at position {position}");
        assert_eq!(system.outputs.shape(), (self.outputs.len(), n), "shape of outputs at position {position}");
        assert_eq!(system.inputs.shape(), (self.inputs.len(), n), "shape of inputs at position {position}");
        for (degree, c) in system.residual.iter().enumerate() {
            let shape = (self.outputs.len(), self.inputs.len());
            assert_eq!(c.shape(), shape, "shape of residual coefficient {degree} at position {position}");
            if c.iter().any(|x| !x.re.is_finite() || !x.im.is_finite()) {
                return Err(FrfError::BadResidual { position, degree });
            }
        }
        for mode in 0..n {
            let bad = |what, value, allowed| FrfError::BadMode { position, mode, what, value, allowed };
            let (f, zeta, eta) = (system.frequencies[mode], system.damping_ratios[mode], system.loss_factors[mode]);
            if !in_range(f) {
                return Err(bad("the frequency in Hz", f, "0 and 1e-9 to 1e12"));
            }
            if !(0.0..=1e6).contains(&zeta) {
                return Err(bad("the damping ratio", zeta, "0 to 1e6"));
            }
            if !(0.0..=1e6).contains(&eta) {
                return Err(bad("the loss factor", eta, "0 to 1e6"));
            }
            for column in [system.outputs.column(mode), system.inputs.column(mode)] {
                if let Some(&value) = column.iter().find(|x| !x.is_finite()) {
                    return Err(bad("a shape", value, "finite numbers"));
                }
            }
            // Free motions are looked at by `check_at_rest`.
            let undamped = f > 0.0 && 2.0 * zeta + eta < NO_DAMPING;
            if undamped && self.frequencies.binary_search_by(|x| x.total_cmp(&f)).is_ok() {
                return Err(FrfError::Singular { position, mode, frequency: f });
            }
        }
        Ok(())
    }
}

/// Checks that a grid is not empty, in range and strictly ascending.
pub(crate) fn check_grid(frequencies: &[f64]) -> Result<(), FrfError> {
    if frequencies.is_empty() {
        return Err(FrfError::Empty { what: "frequencies" });
    }
    if let Some(index) = frequencies.iter().position(|f| !in_range(*f)) {
        return Err(FrfError::BadFrequency { index, value: frequencies[index] });
    }
    match frequencies.windows(2).position(|w| w[0] >= w[1]) {
        Some(i) => Err(FrfError::NotAscending { index: i + 1, previous: frequencies[i], value: frequencies[i + 1] }),
        None => Ok(()),
    }
}

/// -0.0 is refused too: a sign bit has no meaning here.
fn in_range(f: f64) -> bool {
    (f == 0.0 && f.is_sign_positive()) || (LOWEST_FREQUENCY..=HIGHEST_FREQUENCY).contains(&f)
}
