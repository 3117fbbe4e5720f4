//! Forces over time, sampled.

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
        /// The same seed gives the same force on every machine.
        seed: u64,
    },
}

impl Shape {
    /// Value at a sample; `duration` is that of the whole history.
    fn at(&self, t: f64, duration: f64, step: f64) -> f64 {
        match *self {
            Self::Impulse(pulse) => pulse.at(t, step),
            Self::Step { amplitude, start } => {
                if t >= start - 1e-9 * step {
                    amplitude
                } else {
                    0.0
                }
            }
            Self::Sine { amplitude, frequency, phase } => amplitude * (TAU * frequency * t + phase.to_radians()).sin(),
            Self::Chirp { amplitude, from, to } => {
                amplitude * (TAU * (from + 0.5 * (to - from) * t / duration) * t).sin()
            }
            Self::Random { .. } => 0.0,
        }
    }
}

impl Pulse {
    fn at(&self, t: f64, step: f64) -> f64 {
        let s = (t - self.start) / self.length;
        // A sample that rounding puts beside an edge belongs to it.
        let slack = 1e-9 * step / self.length;
        if s < -slack || s > 1.0 + slack {
            return 0.0;
        }
        let s = s.clamp(0.0, 1.0);
        self.amplitude
            * match self.shape {
                PulseShape::HalfSine => (PI * s).sin(),
                PulseShape::Rectangle => 1.0,
                PulseShape::Triangle => 1.0 - (2.0 * s - 1.0).abs(),
            }
    }
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
    pub fn add(&mut self, input: usize, shape: &Shape) {
        let duration = self.time(self.samples());
        let (step, n) = (self.step, self.inputs.len());
        let mut normal = match shape {
            Shape::Random { rms, seed } => Some((Normal::new(*seed), *rms)),
            _ => None,
        };
        for k in 0..self.samples() {
            self.values[k * n + input] += match &mut normal {
                Some((numbers, rms)) => *rms * numbers.next(),
                None => shape.at(step * k as f64, duration, step),
            };
        }
    }

    /// Adds a milling force in its feed and normal directions.
    ///
    /// # Errors
    /// [`ResponseError::NotAllowed`] if a direction is no input.
    pub fn add_milling(&mut self, milling: &Milling) -> Result<(), ResponseError> {
        let (feed, normal) = (self.find(&milling.feed_input)?, self.find(&milling.normal_input)?);
        let n = self.inputs.len();
        for k in 0..self.samples() {
            let [f, g] = milling.at(self.time(k));
            self.values[k * n + feed] += f;
            self.values[k * n + normal] += g;
        }
        Ok(())
    }
}

/// Normal numbers by Box and Muller from SplitMix64.
struct Normal {
    state: u64,
    spare: Option<f64>,
}

impl Normal {
    fn new(seed: u64) -> Self {
        Self { state: seed, spare: None }
    }

    /// Uniform in (0, 1).
    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        let (sine, cosine) = (TAU * self.uniform()).sin_cos();
        self.spare = Some(radius * sine);
        radius * cosine
    }
}
