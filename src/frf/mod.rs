//! The modal sum: frequency response of modal models over positions and frequencies.

use nalgebra::{Complex, DMatrix};

/// Modal model of the machine at one position, as the sums see it.
///
/// ```text
///             n           L_ir R_jr                                d
/// H_ij(omega) = sum ------------------------------------------------ + sum C_k,ij (j omega)^k   [m/N]
///            r=1  omega_r^2 (1 + j eta_r) - omega^2 + 2 j zeta_r omega_r omega   k=0
/// ```
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
}

/// What the map holds: displacement, velocity or acceleration over force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Quantity {
    /// Displacement over force, m/N.
    #[default]
    Receptance,
    /// Velocity over force, m/(s N).
    Mobility,
    /// Acceleration over force, m/(s^2 N).
    Accelerance,
}

/// A request for a map: one modal system a position, one frequency grid for all.
#[derive(Clone, Debug)]
pub struct FrfRequest<'a> {
    /// Positions, m.
    pub positions: &'a [f64],
    /// One modal system a position, all with the same outputs and inputs.
    pub systems: &'a [ModalSystem],
    /// Frequencies, Hz, not negative.
    pub frequencies: &'a [f64],
    /// Names of the outputs.
    pub outputs: &'a [String],
    /// Names of the inputs.
    pub inputs: &'a [String],
    /// What the map holds.
    pub quantity: Quantity,
}

/// Frequency responses over positions and frequencies.
#[derive(Clone, Debug)]
pub struct ComplianceMap {
    /// Positions, m.
    pub positions: Vec<f64>,
    /// Frequencies, Hz.
    pub frequencies: Vec<f64>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// What the map holds.
    pub quantity: Quantity,
    /// `[position, frequency, output, input]`, last index fastest.
    pub values: Vec<Complex<f64>>,
}
