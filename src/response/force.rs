//! Forces over time, sampled so that the straight lines between the samples push as the force does.

use super::noise::{Normal, mixed};
use super::sampling::{Piece, sample};
use super::{Milling, ResponseError};
use std::f64::consts::{PI, TAU};

/// Form of a pulse; all start and end at zero and reach their amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PulseShape {
    /// sin(pi t / length); the spectrum's first zero is at 1.5 / length.
    HalfSine,
    /// Constant; zeros at the multiples of 1 / length.
    Rectangle,
    /// Up and down in straight lines; zeros at the multiples of 2 / length.
    Triangle,
}

/// A single pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Largest force, N.
    pub amplitude: f64,
    /// Length, s.
    pub length: f64,
    /// Form.
    pub shape: PulseShape,
    /// When it starts, s.
    pub start: f64,
}

/// A force at one input as a function of time, N and s and Hz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A pulse.
    Impulse(Pulse),
    /// Zero, then a constant.
    Step {
        /// Force, N.
        amplitude: f64,
        /// When it starts, s.
        start: f64,
    },
    /// amplitude sin(2 pi frequency t + phase).
    Sine {
        /// Force, N.
        amplitude: f64,
        /// Frequency, Hz.
        frequency: f64,
        /// Phase, degrees.
        phase: f64,
    },
    /// A sine whose frequency runs linearly from one to the other over the whole duration.
    Chirp {
        /// Force, N.
        amplitude: f64,
        /// First frequency, Hz.
        from: f64,
        /// Last frequency, Hz.
        to: f64,
    },
    /// Independent normal samples.
    Random {
        /// Root mean square, N.
        rms: f64,
        /// The same seed gives the same force on every machine. Without one each input has a seed of its own.
        seed: Option<u64>,
    },
}

impl Shape {
    /// The force at one of several inputs. Random forces differ from input to input, with and without a given seed,
    /// and without one from the `earlier` random forces; everything else is the same at all inputs.
    pub fn at_input(&self, input: usize, earlier: u64) -> Self {
        match *self {
            Self::Random { rms, seed } => {
                let seed = mixed(seed.unwrap_or(1 + earlier), input as u64);
                Self::Random { rms, seed: Some(seed) }
            }
            other => other,
        }
    }

    /// Largest absolute value, N; of noise its root mean square.
    pub fn peak(&self) -> f64 {
        match *self {
            Self::Impulse(Pulse { amplitude, .. })
            | Self::Step { amplitude, .. }
            | Self::Sine { amplitude, .. }
            | Self::Chirp { amplitude, .. } => amplitude.abs(),
            Self::Random { rms, .. } => rms,
        }
    }
}

impl Pulse {
    /// Whether it is too short for samples to show its form at all: less than two of them.
    pub(super) fn is_lost(&self, step: f64) -> bool {
        self.length < 2.0 * step * (1.0 - 1e-9)
    }

    /// Whether its moments are worth more than its form.
    fn is_brief(&self, step: f64) -> bool {
        self.is_lost(step) || self.shape != PulseShape::Rectangle && self.length < 5.0 * step * (1.0 - 1e-9)
    }

    fn pieces(&self) -> Vec<Piece> {
        let (from, to, amplitude) = (self.start, self.start + self.length, self.amplitude);
        match self.shape {
            PulseShape::HalfSine => {
                vec![Piece { amplitude, omega: PI / self.length, ..Piece::constant(from, to, 0.0) }]
            }
            PulseShape::Rectangle => vec![Piece::constant(from, to, amplitude)],
            PulseShape::Triangle => {
                let middle = 0.5 * (from + to);
                vec![Piece::line(from, middle, [0.0, amplitude]), Piece::line(middle, to, [amplitude, 0.0])]
            }
        }
    }
}

/// The share that straight lines between samples leave of a sine of a frequency: sinc^2(pi f h).
fn kept_by_lines(frequency: f64, step: f64) -> f64 {
    let half = PI * frequency * step;
    if half == 0.0 { 1.0 } else { (half.sin() / half).powi(2) }
}

/// Sampled forces at all inputs, straight lines between the samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Forces {
    /// Time between samples, s.
    pub step: f64,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// `[sample, input]`, N, last index fastest.
    pub values: Vec<f64>,
}

/// A time without the last digits of a product, for messages and comparisons with what a user wrote.
pub(super) fn rounded(time: f64) -> f64 {
    (time * 1e12).round() / 1e12
}

/// Samples of a history at most.
const MOST_SAMPLES: f64 = 5e7;

impl Forces {
    /// No force, `duration` long at `rate` samples a second; the last sample is at or before the end.
    ///
    /// # Errors
    /// [`ResponseError::NotAllowed`] for a duration or rate that is not positive or too large.
    pub fn none(inputs: &[String], duration: f64, rate: f64) -> Result<Self, ResponseError> {
        if !(rate.is_finite() && rate > 0.0) {
            return Err(ResponseError::not_allowed("--rate", rate, "a positive number of samples a second"));
        }
        if !(duration.is_finite() && duration > 0.0 && duration * rate <= MOST_SAMPLES && duration * rate >= 1.0) {
            let allowed = format!("a positive time in s of 1 to {MOST_SAMPLES:e} samples at {rate} samples a second");
            return Err(ResponseError::not_allowed("--duration", duration, allowed));
        }
        let samples = (duration * rate * (1.0 + 1e-12)).floor() as usize;
        Ok(Self { step: rate.recip(), inputs: inputs.to_vec(), values: vec![0.0; samples * inputs.len()] })
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.values.len() / self.inputs.len().max(1)
    }

    /// Time of a sample, s.
    pub fn time(&self, sample: usize) -> f64 {
        self.step * sample as f64
    }

    /// Time of the last sample, s.
    pub fn end(&self) -> f64 {
        rounded(self.time(self.samples().max(1) - 1))
    }

    /// Forces at all inputs at a time that is counted in samples, straight between them.
    pub fn at(&self, sample: f64) -> nalgebra::DVector<f64> {
        let n = self.inputs.len();
        let last = self.samples() - 1;
        let before = (sample.floor().max(0.0) as usize).min(last);
        let after = (before + 1).min(last);
        let share = sample - before as f64;
        nalgebra::DVector::from_fn(n, |j, _| {
            let (a, b) = (self.values[before * n + j], self.values[after * n + j]);
            if share == 0.0 { a } else { a + share * (b - a) }
        })
    }

    /// The samples of one input.
    pub fn input(&self, input: usize) -> Vec<f64> {
        self.values.iter().skip(input).step_by(self.inputs.len()).copied().collect()
    }

    /// Index of an input by name.
    ///
    /// # Errors
    /// [`ResponseError::NotAllowed`] with the names there are.
    pub fn find(&self, name: &str) -> Result<usize, ResponseError> {
        self.inputs.iter().position(|n| n == name).ok_or_else(|| {
            ResponseError::not_allowed("the input of a force", format!("{name:?}"), self.inputs.join(", "))
        })
    }

    /// Adds a force at an input.
    ///
    /// Pulses and steps come as the means that keep their momentum. Sines and chirps are their own values over
    /// sinc^2(pi f h), so that the wave in the straight lines has the amplitude that was asked for. Noise is what its
    /// samples are.
    pub fn add(&mut self, input: usize, shape: &Shape) {
        let (step, samples) = (self.step, self.samples());
        let duration = self.time(samples);
        match *shape {
            Shape::Impulse(pulse) => {
                let (n, brief) = (self.inputs.len(), pulse.is_brief(step));
                let put = |k: usize, f: f64| self.values[k * n + input] += f;
                sample(pulse.pieces(), shape.peak(), brief, step, samples, put);
            }
            Shape::Step { amplitude, start } => {
                let piece = Piece::constant(start, duration.max(start) + step, amplitude);
                _ = self.add_pieces(input, [piece], shape.peak());
            }
            Shape::Sine { amplitude, frequency, phase } => {
                let amplitude = amplitude / kept_by_lines(frequency, step);
                self.add_values(input, |t| amplitude * (TAU * frequency * t + phase.to_radians()).sin());
            }
            Shape::Chirp { amplitude, from, to } => self.add_values(input, |t| {
                let rate = (to - from) / duration;
                amplitude * (TAU * (from + 0.5 * rate * t) * t).sin() / kept_by_lines(from + rate * t, step)
            }),
            Shape::Random { rms, seed } => {
                let mut numbers = Normal::new(seed.unwrap_or_else(|| mixed(1, input as u64)));
                self.add_values(input, |_| rms * numbers.next());
            }
        }
    }

    /// Adds a value a sample.
    fn add_values(&mut self, input: usize, mut value: impl FnMut(f64) -> f64) {
        let n = self.inputs.len();
        for k in 0..self.samples() {
            let time = self.time(k);
            self.values[k * n + input] += value(time);
        }
    }

    /// Adds a force of pieces in the order of time, of which `peak` is the largest absolute value; returns in how many
    /// steps its form is lost.
    pub(super) fn add_pieces(&mut self, input: usize, pieces: impl IntoIterator<Item = Piece>, peak: f64) -> usize {
        let (n, step, samples) = (self.inputs.len(), self.step, self.samples());
        sample(pieces, peak, false, step, samples, |k, f| self.values[k * n + input] += f)
    }

    /// Adds a milling force in its feed and normal directions.
    ///
    /// # Errors
    /// [`ResponseError::NotAllowed`] if a direction is no input.
    pub fn add_milling(&mut self, milling: &Milling) -> Result<(), ResponseError> {
        let inputs = [self.find(&milling.feed_input)?, self.find(&milling.normal_input)?];
        let end = self.time(self.samples());
        for (direction, input) in inputs.into_iter().enumerate() {
            self.add_pieces(input, milling.pieces(direction, end), milling.peak());
        }
        Ok(())
    }
}
