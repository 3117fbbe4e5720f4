//! The result: frequency responses over positions and frequencies.

use nalgebra::{Complex, DMatrix};

use super::{FrfRequest, Quantity};

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

impl ComplianceMap {
    /// The map of a request around values in the map's order.
    pub(crate) fn around(request: &FrfRequest, values: Vec<Complex<f64>>) -> ComplianceMap {
        assert_eq!(values.len(), request.len(), "values of the map");
        ComplianceMap {
            positions: request.positions.to_vec(),
            frequencies: request.frequencies.to_vec(),
            outputs: request.outputs.to_vec(),
            inputs: request.inputs.to_vec(),
            quantity: request.quantity,
            values,
        }
    }

    /// Index in `values` of one entry.
    pub fn index(&self, position: usize, frequency: usize, output: usize, input: usize) -> usize {
        ((position * self.frequencies.len() + frequency) * self.outputs.len() + output) * self.inputs.len() + input
    }

    /// One entry.
    pub fn at(&self, position: usize, frequency: usize, output: usize, input: usize) -> Complex<f64> {
        self.values[self.index(position, frequency, output, input)]
    }

    /// The n_output x n_input matrix at one (position, frequency) pair.
    pub fn matrix(&self, position: usize, frequency: usize) -> DMatrix<Complex<f64>> {
        DMatrix::from_fn(self.outputs.len(), self.inputs.len(), |i, j| self.at(position, frequency, i, j))
    }
}
