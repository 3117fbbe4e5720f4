//! The answer to a short push in all directions at once, over time and over frequency (the paper's
//! figures 9 and 10).
//!
//! A rectangle of 1 N and 1 ms on every input. Each mode answers a step with
//!
//! ```text
//! s(t) = (1 - e^(-zeta omega t) (cos omega_d t + zeta/sqrt(1 - zeta^2) sin omega_d t)) / omega^2
//! ```
//!
//! and the rectangle with s(t) - s(t - 1 ms): exact, no time step. A loss factor counts as half as
//! much viscous ratio. The spectrum is the sum of the receptances over the inputs, which is what
//! division by the pulse's spectrum leaves; the paper's mean of five samples cuts peaks and is left out.

use super::canvas::{Canvas, Point};
use super::colour;
use super::frame::{Frame, HEIGHT, THIN, WIDTH};
use super::scale::{Scale, plain};
use super::text::{Align, SMALL, Typeface};
use super::{FREQUENCY_LABEL, FigureError, write_both};
use crate::frf::{FrfRequest, ModalSystem, Quantity, modal_sum};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// Length of the push, s.
pub const PULSE: f64 = 1e-3;
/// Time shown, s, and samples.
const SHOWN: f64 = 0.25;
const SAMPLES: usize = 2500;
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

/// Displacements of the outputs after the push, `[output][sample]`, m.
pub fn pulse_response(system: &ModalSystem, times: &[f64]) -> Vec<Vec<f64>> {
    let n_out = system.outputs.nrows();
    let mut out = vec![vec![0.0; times.len()]; n_out];
    for r in 0..system.frequencies.len() {
        let force: f64 = system.inputs.column(r).iter().sum();
        let omega = TAU * system.frequencies[r];
        let zeta = (system.damping_ratios[r] + 0.5 * system.loss_factors[r]).min(0.999);
        for (k, &t) in times.iter().enumerate() {
            let amplitude = force * (step(omega, zeta, t) - step(omega, zeta, t - PULSE));
            for (o, row) in out.iter_mut().enumerate() {
                row[k] += system.outputs[(o, r)] * amplitude;
            }
        }
    }
    if let Some(direct) = system.residual.first() {
        for (k, _) in times.iter().enumerate().filter(|(_, t)| (0.0..PULSE).contains(*t)) {
            for (o, row) in out.iter_mut().enumerate() {
                row[k] += direct.row(o).iter().map(|v| v.re).sum::<f64>();
            }
        }
    }
    out
}

/// Answer of an oscillator of unit mass to a unit step at 0.
fn step(omega: f64, zeta: f64, t: f64) -> f64 {
    if t <= 0.0 {
        return 0.0;
    }
    if omega == 0.0 {
        return 0.5 * t * t;
    }
    let root = (1.0 - zeta * zeta).sqrt();
    let (sin, cos) = (omega * root * t).sin_cos();
    (1.0 - (-zeta * omega * t).exp() * (cos + zeta / root * sin)) / (omega * omega)
}

/// Draws `impulse_time` and `impulse_frequency` as PNG and SVG; returns the files.
///
/// # Errors
/// [`FigureError::NotFinite`] with the time, [`FigureError::Frf`] if the spectrum cannot be computed,
/// [`FigureError::Encode`] and [`FigureError::Export`] if a file cannot be written.
pub fn draw_impulse(input: &ImpulseInput, folder: &Path) -> Result<Vec<PathBuf>, FigureError> {
    let place = format!("{} = {} mm", input.axis, plain(1e3 * input.position, 1.0));
    let times: Vec<f64> = (0..=SAMPLES).map(|k| SHOWN * k as f64 / SAMPLES as f64).collect();
    let nanometres: Vec<Vec<f64>> =
        pulse_response(input.system, &times).iter().map(|row| row.iter().map(|v| 1e9 * v).collect()).collect();
    for (k, value) in nanometres.iter().flat_map(|row| row.iter().enumerate()) {
        if !value.is_finite() {
            let what = format!("the displacement at {} s", times[k]);
            return Err(FigureError::NotFinite { figure: "impulse_time".into(), what, value: *value });
        }
    }
    let all = || nanometres.iter().flatten().copied();
    let (low, high) = (all().fold(0.0, f64::min), all().fold(0.0, f64::max));
    let margin = 0.05 * (high - low);
    let milliseconds: Vec<f64> = times.iter().map(|t| 1e3 * t).collect();
    let heading = format!("{}: 1 N for 1 ms in all directions, {place}", input.machine);
    let time = Curves {
        heading: &heading,
        labels: ["Time [ms]", "Displacement [nm]"],
        x: &milliseconds,
        y: Scale::linear(low - margin, high + margin),
        curves: &nanometres,
        names: input.outputs,
    };

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
    let sum = |k: usize, o: usize| (0..input.inputs.len()).map(|i| map.at(0, k, o, i)).sum::<nalgebra::Complex<f64>>();
    let spectra: Vec<Vec<f64>> =
        (0..input.outputs.len()).map(|o| (0..frequencies.len()).map(|k| 1e6 * sum(k, o).norm()).collect()).collect();
    let all = || spectra.iter().flatten().copied().filter(|v| *v > 0.0);
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    let heading = format!("{}: response to forces in all directions, {place}", input.machine);
    let frequency = Curves {
        heading: &heading,
        labels: [FREQUENCY_LABEL, "|response| [µm/N]"],
        x: &frequencies,
        y: Scale::logarithmic(low.max(high / 1e4) / 1.2, high * 1.2),
        curves: &spectra,
        names: input.outputs,
    };
    let mut files = Vec::new();
    for (name, curves) in [("impulse_time.png", time), ("impulse_frequency.png", frequency)] {
        files.extend(write_both(&folder.join(name), &curves.draw())?);
    }
    Ok(files)
}

/// Curves over one axis with a key.
struct Curves<'a> {
    heading: &'a str,
    labels: [&'a str; 2],
    x: &'a [f64],
    y: Scale,
    curves: &'a [Vec<f64>],
    names: &'a [String],
}

impl Curves<'_> {
    fn draw(&self) -> Canvas {
        let font = Typeface::bundled();
        let mut canvas = Canvas::new(WIDTH, HEIGHT);
        let x = Scale::linear(self.x[0], self.x[self.x.len() - 1]);
        let frame = Frame::new(&font, HEIGHT, x, self.y, 60.0);
        frame.grid(&mut canvas);
        for (k, curve) in self.curves.iter().enumerate() {
            let lowest = if self.y.logarithmic { self.y.low } else { f64::NEG_INFINITY };
            let points: Vec<Point> = self.x.iter().zip(curve).map(|(x, y)| frame.place(*x, y.max(lowest))).collect();
            canvas.curve(&points, 3.0, colour::family(k + 1));
        }
        frame.axes(&mut canvas, &font, self.heading, self.labels[0], self.labels[1]);
        for (k, name) in self.names.iter().enumerate() {
            let (left, y) = (frame.right - 220.0, frame.top + 40.0 + 44.0 * k as f64);
            canvas.line((left, y), (left + 60.0, y), 3.0 * THIN, colour::family(k + 1));
            font.draw(&mut canvas, name, (left + 76.0, y), SMALL, Align::Start);
        }
        canvas
    }
}
