//! The answer to a short push at all inputs at once, over time and over frequency (the paper's figures 9 and 10).
//!
//! The push is the one of `simulate --impulse`. Its spectrum is the sum of the receptances over the inputs, which is what
//! division by the push's own spectrum leaves; the paper's mean of five samples cuts peaks and is left out.

use super::scale::plain;
use super::{FigureError, draw_history, draw_spectrum};
use crate::frf::{ComplianceMap, FrfRequest, ModalSystem, Quantity, modal_sum};
use crate::response::{Forces, Plant, Pulse, PulseShape, Recording, Shape, simulate};
use nalgebra::Complex;
use std::path::{Path, PathBuf};

/// One newton for a millisecond.
const PUSH: Pulse = Pulse { amplitude: 1.0, length: 1e-3, shape: PulseShape::HalfSine, start: 0.0 };
/// Time shown, s, and samples a second.
const SHOWN: f64 = 0.25;
const RATE: f64 = 20e3;
/// Frequencies of the spectrum.
const FREQUENCIES: usize = 1800;

/// What the pictures are made of.
#[derive(Clone, Copy, Debug)]
pub struct ImpulseInput<'a> {
    /// Name of the machine.
    pub machine: &'a str,
    /// Name of the axis.
    pub axis: &'a str,
    /// Position, m.
    pub position: f64,
    /// The modal system there.
    pub system: &'a ModalSystem,
    /// Names of the outputs.
    pub outputs: &'a [String],
    /// Names of the inputs.
    pub inputs: &'a [String],
    /// Highest frequency of the spectrum, Hz.
    pub highest: f64,
}

/// Draws `impulse_time` and `impulse_frequency` as PNG and SVG; returns the files.
///
/// # Errors
/// [`FigureError::NotFinite`], [`FigureError::Frf`] if the spectrum cannot be computed, [`FigureError::Encode`] and
/// [`FigureError::Export`] if a file cannot be written.
pub fn draw_impulse(input: &ImpulseInput, folder: &Path) -> Result<Vec<PathBuf>, FigureError> {
    let place = format!("{} = {} mm", input.axis, plain(1e3 * input.position, 1.0));
    let mut push = Forces::none(input.inputs, SHOWN, RATE).map_err(FigureError::Response)?;
    (0..input.inputs.len()).for_each(|i| push.add(i, &Shape::Impulse(PUSH)));
    let plant = Plant::of_modal_system(input.position, input.system);
    let history = simulate(&plant, &push, Recording::default());
    let heading = format!("{}: 1 N for 1 ms in all directions, {place}", input.machine);
    let mut files = draw_history(&folder.join("impulse_time.png"), &heading, &history, input.outputs)?.to_vec();
    let heading = format!("{}: response to forces in all directions, {place}", input.machine);
    let spectrum = summed(input)?;
    files.extend(draw_spectrum(&folder.join("impulse_frequency.png"), &heading, &spectrum, 0)?);
    Ok(files)
}

/// The receptance to equal forces at all inputs: a map of one position and one input.
fn summed(input: &ImpulseInput) -> Result<ComplianceMap, FigureError> {
    let frequencies: Vec<f64> =
        (1..=FREQUENCIES).map(|k| input.highest.max(1.0) * k as f64 / FREQUENCIES as f64).collect();
    let request = FrfRequest {
        positions: &[input.position],
        systems: std::slice::from_ref(input.system),
        frequencies: &frequencies,
        outputs: input.outputs,
        inputs: input.inputs,
        quantity: Quantity::Receptance,
    };
    let map = modal_sum(&request).map_err(FigureError::Frf)?;
    let values = map.values.chunks_exact(input.inputs.len()).map(|row| row.iter().sum::<Complex<f64>>()).collect();
    Ok(ComplianceMap { inputs: vec!["all".into()], values, ..map })
}
