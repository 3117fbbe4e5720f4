//! Frequency responses by way of time: the response's spectrum divided by the force's.
//!
//! All forces are one signal s(t) times a weight an input, over before the last sample; from then on
//! the machine rings freely, and the Fourier transform of that endless ring-down follows in closed form
//! from the last sample's state, so that no length of record cuts it:
//!
//! ```text
//! Y(f) = h ( sum_(k<N) y_k z^-k + sum_r L_r [1 0] (I - Phi_r / z)^-1 Phi_r x_r(N-1) z^-N )    z = e^(j 2 pi f h)
//! S(f) = h sinc^2(pi f h) sum_k s_k z^-k        (less half a triangle where s_0 is not zero)
//! H(f) = Y(f) / S(f)
//! ```
//!
//! S is the exact transform of straight lines between the samples. What follows the force without
//! delay (D u) is straight too and is divided by the transform of its samples. The frequencies are
//! k / (N h).
//!
//! # Accuracy
//! What the sampling folds down from above half the rate: with a 1 ms pulse at 20 kHz below 1e-4 of
//! the peak up to 900 Hz.

use super::{Forces, History, Plant, ResponseError};
use crate::frf::{ComplianceMap, Quantity};
use crate::state_space::{DampedSum, ModeStep};
use nalgebra::{Complex, DMatrix, DVector};
use rayon::prelude::*;
use realfft::{RealFftPlanner, RealToComplex};
use std::f64::consts::{PI, TAU};

/// Share of the force's largest spectral line below which a frequency counts as a zero of the pulse.
const ZERO: f64 = 1e-3;

/// The signal that all forces share, and its weight at each input.
pub struct Signal {
    samples: Vec<f64>,
    weights: Vec<f64>,
}

impl Signal {
    /// The common signal of all inputs: that of the input with the largest force.
    ///
    /// # Errors
    /// [`ResponseError::Spectrum`] if there is no force, if two inputs have forces that are not
    /// multiples of each other, or if the force is not zero at the last two samples.
    pub fn of(forces: &Forces) -> Result<Self, ResponseError> {
        let columns: Vec<Vec<f64>> = (0..forces.inputs.len()).map(|j| forces.input(j)).collect();
        let size = |c: &[f64]| c.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let largest = (0..columns.len()).max_by(|a, b| size(&columns[*a]).total_cmp(&size(&columns[*b])));
        let samples = largest.map(|j| columns[j].clone()).unwrap_or_default();
        let peak = size(&samples);
        if peak == 0.0 {
            return Err(ResponseError::Spectrum("there is no force".into()));
        }
        let at = samples.iter().position(|v| v.abs() == peak).unwrap_or(0);
        let weights: Vec<f64> = columns.iter().map(|c| c[at] / samples[at]).collect();
        for (c, (weight, name)) in columns.iter().zip(weights.iter().zip(&forces.inputs)) {
            let apart = c.iter().zip(&samples).map(|(x, s)| (x - weight * s).abs()).fold(0.0, f64::max);
            if apart > 1e-12 * peak {
                let problem = format!("the force at {name} is not a multiple of that at the other inputs");
                return Err(ResponseError::Spectrum(problem));
            }
        }
        if samples.iter().rev().take(2).any(|v| v.abs() > 1e-12 * peak) {
            let problem = "the force must be over before the last sample; lengthen --duration or shorten the pulse";
            return Err(ResponseError::Spectrum(problem.into()));
        }
        Ok(Self { samples, weights })
    }

    /// Exact transform of the straight lines at any frequency (Hz), N s.
    fn line(&self, frequency: f64, step: f64) -> Complex<f64> {
        let theta = TAU * frequency * step;
        let last = self.samples.iter().rposition(|s| *s != 0.0).unwrap_or(0);
        let turn = |k: usize| Complex::new(0.0, -theta * k as f64).exp();
        let plain: Complex<f64> = self.samples[..=last].iter().enumerate().map(|(k, s)| turn(k) * *s).sum();
        let half = 0.5 * theta;
        let sinc = if theta == 0.0 { 1.0 } else { half.sin() / half };
        (plain * sinc * sinc - half_triangle(theta) * self.samples[0]) * step
    }

    /// Exact transform of the straight lines at the lines of the spectrum (N s), and the plain sum h sum s_k z^-k.
    fn transforms(&self, plan: &dyn RealToComplex<f64>, step: f64) -> (Vec<Complex<f64>>, Vec<Complex<f64>>) {
        let n = self.samples.len();
        let plain: Vec<Complex<f64>> = transform(plan, &self.samples).into_iter().map(|v| v * step).collect();
        let exact = plain.iter().enumerate().map(|(k, v)| {
            let theta = TAU * k as f64 / n as f64;
            let half = 0.5 * theta;
            let sinc = if k == 0 { 1.0 } else { half.sin() / half };
            v * sinc * sinc - half_triangle(theta) * (step * self.samples[0])
        });
        (exact.collect(), plain)
    }
}

/// Transform of the left half of a triangle of height and half-width one, which the first sample lacks.
fn half_triangle(theta: f64) -> Complex<f64> {
    if theta == 0.0 {
        return Complex::new(0.5, 0.0);
    }
    (Complex::new(1.0, theta) - Complex::new(0.0, theta).exp()) / (theta * theta)
}

/// sum_k x_k e^(-j 2 pi k m / n), m = 0 .. n/2.
fn transform(plan: &dyn RealToComplex<f64>, x: &[f64]) -> Vec<Complex<f64>> {
    let (mut input, mut output) = (x.to_vec(), plan.make_output_vec());
    plan.process(&mut input, &mut output).expect("buffers made by the plan");
    output.into_iter().map(|c| Complex::new(c.re, c.im)).collect()
}

/// Responses to the weighted signal at all positions, up to `highest` Hz: one input named after the
/// excited ones. Lines at zeros of the force's spectrum are left out.
///
/// # Errors
/// [`ResponseError::Spectrum`] as [`Signal::of`], or if no line is left.
pub fn spectra(
    plants: &[Plant],
    histories: &[History],
    forces: &Forces,
    outputs: &[String],
    highest: f64,
) -> Result<ComplianceMap, ResponseError> {
    let signal = Signal::of(forces)?;
    let samples = forces.samples();
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(samples);
    let (exact, plain) = signal.transforms(plan.as_ref(), forces.step);
    let width = 1.0 / (samples as f64 * forces.step);
    let largest = exact.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let lines: Vec<usize> = (0..exact.len())
        .take_while(|k| width * *k as f64 <= highest * (1.0 + 1e-12))
        .filter(|&k| exact[k].norm() > ZERO * largest)
        .collect();
    // A line at 0 Hz has no meaning beside an unbound free motion.
    let lines: Vec<usize> = lines.into_iter().filter(|k| *k > 0).collect();
    if lines.is_empty() {
        return Err(ResponseError::Spectrum(format!("no line of width {width} Hz up to {highest} Hz is left")));
    }
    let values = plants
        .par_iter()
        .zip(histories)
        .flat_map_iter(|(plant, history)| position(plan.as_ref(), plant, history, &signal, &lines, [&exact, &plain]));
    let values: Vec<Complex<f64>> = values.collect();
    let excited: Vec<&str> =
        forces.inputs.iter().zip(&signal.weights).filter(|(_, w)| **w != 0.0).map(|(n, _)| n.as_str()).collect();
    Ok(ComplianceMap {
        positions: plants.iter().map(|p| p.position).collect(),
        frequencies: lines.iter().map(|k| width * *k as f64).collect(),
        outputs: outputs.to_vec(),
        inputs: vec![excited.join("+")],
        quantity: Quantity::Receptance,
        values,
    })
}

/// `[line, output]` at one position.
fn position(
    plan: &dyn RealToComplex<f64>,
    plant: &Plant,
    history: &History,
    signal: &Signal,
    lines: &[usize],
    [exact, plain]: [&[Complex<f64>]; 2],
) -> Vec<Complex<f64>> {
    let (step, n) = (history.step, history.samples());
    let steps = plant.steps(step);
    let direct: Vec<f64> = (0..history.n_outputs)
        .map(|i| signal.weights.iter().enumerate().map(|(j, w)| plant.direct[(i, j)] * w).sum())
        .collect();
    let mut sums: Vec<Complex<f64>> = vec![Complex::default(); lines.len() * history.n_outputs];
    for i in 0..history.n_outputs {
        let of_record = transform(plan, &history.output(i));
        for (at, &k) in lines.iter().enumerate() {
            sums[at * history.n_outputs + i] = of_record[k] * step - plain[k] * direct[i];
        }
    }
    let [q, v] = &history.last;
    let rings: Vec<Ring> = steps.iter().zip(q.iter().zip(v)).map(|(s, (q, v))| Ring::new(s, *q, *v)).collect();
    for (at, &k) in lines.iter().enumerate() {
        let inverse = Complex::new(0.0, -2.0 * PI * k as f64 / n as f64).exp();
        let mut tail: Vec<Complex<f64>> = vec![Complex::default(); history.n_outputs];
        let square = inverse * inverse;
        for (r, s) in rings.iter().enumerate() {
            let first = s.first(inverse, square);
            for (i, t) in tail.iter_mut().enumerate() {
                *t += first * plant.outputs[(i, r)];
            }
        }
        for i in 0..history.n_outputs {
            let y = &mut sums[at * history.n_outputs + i];
            // z^-N is 1 on these lines.
            *y = (*y + tail[i] * step) / exact[k] + direct[i];
        }
    }
    sums
}

/// A mode that rings on: the displacement of (I - Phi / z)^-1 Phi [q, v] as a fraction in 1/z.
struct Ring {
    constant: f64,
    linear: f64,
    trace: f64,
    determinant: f64,
}

impl Ring {
    fn new(step: &ModeStep, q: f64, v: f64) -> Self {
        let [[a, b], [c, d]] = step.phi;
        let (x, y) = (a * q + b * v, c * q + d * v);
        Self { constant: x, linear: b * y - d * x, trace: a + d, determinant: a * d - b * c }
    }

    fn first(&self, inverse: Complex<f64>, square: Complex<f64>) -> Complex<f64> {
        let den = Complex::from(1.0) - inverse * self.trace + square * self.determinant;
        (inverse * self.linear + self.constant) * den.conj() / den.norm_sqr()
    }
}

/// The same response from the modes themselves: L (omega_r^2 - omega^2 + 2 j zeta_r omega_r omega)^-1 R^T w + D w,
/// with the dampers between the modes.
pub fn modal_response(plant: &Plant, weights: &[f64], frequency: f64) -> Vec<Complex<f64>> {
    let w = DMatrix::from_column_slice(weights.len(), 1, weights);
    let sum = DampedSum {
        omega: &plant.omega,
        zeta: &plant.zeta,
        outputs: &plant.outputs,
        inputs: &(w.transpose() * &plant.inputs),
        dampers: &plant.dampers,
    };
    let direct = &plant.direct * &w;
    sum.at(frequency).iter().zip(direct.iter()).map(|(h, d)| h + d).collect()
}

/// Largest difference between spectra by way of time and the modal sum from `lowest` Hz up, as a
/// share of each output's peak over the frequencies at its position.
///
/// # Errors
/// As [`Signal::of`].
pub fn difference_to_modes(
    map: &ComplianceMap,
    plants: &[Plant],
    forces: &Forces,
    lowest: f64,
) -> Result<f64, ResponseError> {
    Ok(compare(map, plants, forces, lowest, 0)?[0])
}

/// Images of half the rate that [`difference_less_folding`] takes on each side. What is left out falls as the fourth
/// power of the frequency.
const IMAGES: i32 = 4;

/// The same with what the sampling folds down taken off, and the largest share that it folds.
///
/// The sum over a record's samples is the sum of its transform at f + m / h for all whole m (Poisson). A force shorter
/// than some samples moves modes above half the rate, whose motion then shows at frequencies below.
///
/// # Errors
/// As [`Signal::of`].
pub fn difference_less_folding(
    map: &ComplianceMap,
    plants: &[Plant],
    forces: &Forces,
    lowest: f64,
) -> Result<[f64; 2], ResponseError> {
    compare(map, plants, forces, lowest, IMAGES)
}

/// Largest difference and largest share folded down, as shares of each output's peak; with images of half the rate on
/// each side.
fn compare(
    map: &ComplianceMap,
    plants: &[Plant],
    forces: &Forces,
    lowest: f64,
    images: i32,
) -> Result<[f64; 2], ResponseError> {
    let signal = Signal::of(forces)?;
    let n_o = map.outputs.len();
    let one = |(p, plant): (usize, &Plant)| {
        let [mut largest, mut peak, mut folds] = [(); 3].map(|()| vec![0.0f64; n_o]);
        let direct = &plant.direct * DVector::from_column_slice(&signal.weights);
        for (k, &f) in map.frequencies.iter().enumerate() {
            let exact = modal_response(plant, &signal.weights, f);
            let mut folded = vec![Complex::<f64>::default(); n_o];
            for m in (-images..=images).filter(|m| *m != 0) {
                let image = f + f64::from(m) / forces.step;
                let share = signal.line(image, forces.step) / signal.line(f, forces.step);
                let there = modal_response(plant, &signal.weights, image);
                for i in 0..n_o {
                    folded[i] += (there[i] - direct[i]) * share;
                }
            }
            for i in 0..n_o {
                peak[i] = peak[i].max(exact[i].norm());
                if f >= lowest {
                    largest[i] = largest[i].max((map.at(p, k, i, 0) - exact[i] - folded[i]).norm());
                    folds[i] = folds[i].max(folded[i].norm());
                }
            }
        }
        let share =
            |of: &[f64]| of.iter().zip(&peak).map(|(l, p)| if *p > 0.0 { l / p } else { 0.0 }).fold(0.0, f64::max);
        [share(&largest), share(&folds)]
    };
    let worse = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
    Ok(plants.par_iter().enumerate().map(one).reduce(|| [0.0; 2], worse))
}

/// The mean of `width` neighbouring magnitudes, for pictures only: it cuts a peak by up to a quarter.
pub fn smoothed(map: &ComplianceMap, width: usize) -> ComplianceMap {
    let (n_f, n_o) = (map.frequencies.len(), map.outputs.len() * map.inputs.len());
    let reach = width / 2;
    let mut out = map.clone();
    for (p, block) in map.values.chunks_exact(n_f * n_o).enumerate() {
        for f in 0..n_f {
            let near = f.saturating_sub(reach)..(f + reach + 1).min(n_f);
            for i in 0..n_o {
                let mean = near.clone().map(|g| block[g * n_o + i].norm()).sum::<f64>() / near.len() as f64;
                out.values[(p * n_f + f) * n_o + i] = Complex::new(mean, 0.0);
            }
        }
    }
    out
}
