//! No trust without a look: a device's numbers against f64 before they are used.
//!
//! Shader compilers may reassociate floats and lose the frequencies' low parts; then f32 is wrong by 1e-7 / zeta and
//! nothing says so. A few hundred pairs at and beside resonances, at dampings from 1e-4 to 0.1, show it in milliseconds.

use std::f64::consts::TAU;
use std::time::Instant;

use nalgebra::{Complex, DMatrix};
use serde::{Deserialize, Serialize};

use crate::frf::{self, ComplianceMap, FrfRequest, ModalSystem, Quantity};

use super::{Gpu, GpuError, Precision, modal_sum};

/// What the look at a device found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrustFigures {
    /// Precision that was looked at.
    pub precision: Precision,
    /// (position, frequency) pairs compared.
    pub pairs: usize,
    /// Largest |dH_ij| / sum_r |term_r|.
    pub entry: f64,
    /// Its bound.
    pub entry_bound: f64,
    /// Largest Frobenius relative difference of a pair.
    pub frobenius: f64,
    /// Its bound.
    pub frobenius_bound: f64,
    /// Seconds that it took.
    pub seconds: f64,
}

/// The bounds of a precision: (entry, Frobenius).
pub fn bounds(precision: Precision) -> (f64, f64) {
    match precision {
        Precision::F32 => (8.0 * f64::from(f32::EPSILON), 2e-6),
        Precision::F64 => (1e-12, 1e-12),
    }
}

/// Compares the device with f64.
///
/// # Errors
/// [`GpuError::Inaccurate`] with the figure and its bound, and as [`modal_sum`].
pub fn check(gpu: &Gpu, precision: Precision) -> Result<TrustFigures, GpuError> {
    let start = Instant::now();
    let case = Case::new();
    let request = case.request();
    let map = modal_sum(gpu, &request, precision)?;
    let figures = figures(&request, &map, precision, start)?;
    let inaccurate =
        |what, figure, bound| Err(GpuError::Inaccurate { adapter: gpu.adapter().name.clone(), what, figure, bound });
    let exceeds = |figure: f64, bound: f64| figure.is_nan() || figure > bound;
    if exceeds(figures.entry, figures.entry_bound) {
        return inaccurate("of an entry's terms", figures.entry, figures.entry_bound);
    }
    if exceeds(figures.frobenius, figures.frobenius_bound) {
        return inaccurate("Frobenius difference", figures.frobenius, figures.frobenius_bound);
    }
    Ok(figures)
}

/// The figures of any map of the look's request; for tests, which feed it a broken one.
#[doc(hidden)]
pub fn figures_of(map: impl FnOnce(&FrfRequest) -> Result<ComplianceMap, GpuError>) -> Result<TrustFigures, GpuError> {
    let case = Case::new();
    let map = map(&case.request())?;
    figures(&case.request(), &map, Precision::F32, Instant::now())
}

fn figures(
    request: &FrfRequest,
    map: &ComplianceMap,
    precision: Precision,
    start: Instant,
) -> Result<TrustFigures, GpuError> {
    let reference = frf::modal_sum(request)?;
    let (mut entry, mut frobenius) = (0.0f64, 0.0f64);
    for (p, system) in request.systems.iter().enumerate() {
        for (k, &f) in request.frequencies.iter().enumerate() {
            let exact = reference.matrix(p, k);
            let difference = map.matrix(p, k) - &exact;
            let magnitudes = sum_of_magnitudes(system, f);
            for (d, m) in difference.iter().zip(magnitudes.iter()) {
                entry = worst(entry, d.norm() / m);
            }
            let norm = |m: &DMatrix<Complex<f64>>| m.iter().map(|x| x.norm_sqr()).sum::<f64>().sqrt();
            frobenius = worst(frobenius, norm(&difference) / norm(&exact));
        }
    }
    let (entry_bound, frobenius_bound) = bounds(precision);
    let pairs = request.positions.len() * request.frequencies.len();
    let seconds = start.elapsed().as_secs_f64();
    Ok(TrustFigures { precision, pairs, entry, entry_bound, frobenius, frobenius_bound, seconds })
}

/// The larger; NaN wins.
fn worst(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// sum_r |term_r| of each entry of a receptance, residual powers included.
fn sum_of_magnitudes(system: &ModalSystem, f: f64) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(system.outputs.nrows(), system.inputs.nrows());
    for r in 0..system.frequencies.len() {
        let f_r = system.frequencies[r];
        let v = system.loss_factors[r] * f_r * f_r + 2.0 * system.damping_ratios[r] * f_r * f;
        let d = TAU * TAU * ((f_r - f) * (f_r + f)).hypot(v);
        sum += (system.outputs.column(r) * system.inputs.column(r).transpose()).abs() / d;
    }
    for (k, c) in system.residual.iter().enumerate() {
        sum += c.map(|x| x.norm()) * (TAU * f).powi(k as i32);
    }
    sum
}

/// Two systems of twelve modes and frequencies on and beside each of them.
struct Case {
    systems: Vec<ModalSystem>,
    frequencies: Vec<f64>,
    names: Vec<String>,
}

impl Case {
    fn new() -> Case {
        const DAMPINGS: [f64; 4] = [1e-4, 1e-3, 1e-2, 1e-1];
        // Frequencies that no f32 holds, and shapes without pattern, from irrational multiples.
        let natural: Vec<f64> = (0..12).map(|r| 14.1 * 1.431f64.powi(r) * (1.0 + 0.01 * (r as f64).sin())).collect();
        let systems: Vec<ModalSystem> = (0..2)
            .map(|p| {
                let shapes = DMatrix::from_fn(3, 12, |i, r| 0.05 * (1.7 * (1 + i + 3 * r + 40 * p) as f64).sin());
                let structural = p == 1;
                let damping: Vec<f64> = (0..12).map(|r| DAMPINGS[(r + p) % 4]).collect();
                ModalSystem {
                    frequencies: natural.iter().map(|f| f * (1.0 + 1e-3 * p as f64)).collect(),
                    damping_ratios: damping.iter().map(|z| if structural { z / 2.0 } else { *z }).collect(),
                    loss_factors: damping.iter().map(|z| if structural { *z } else { 0.0 }).collect(),
                    residual: vec![DMatrix::from_diagonal_element(3, 3, Complex::from(1e-9)); p],
                    outputs: shapes.clone(),
                    inputs: shapes,
                    exact: None,
                }
            })
            .collect();
        let mut frequencies: Vec<f64> = systems
            .iter()
            .flat_map(|s| &s.frequencies)
            .flat_map(|f| [0.0, 1e-7, -1e-6, 1e-5, -1e-4, 1e-3, 1e-2, -1e-1].map(|offset| f * (1.0 + offset)))
            .collect();
        frequencies.sort_by(f64::total_cmp);
        frequencies.dedup();
        Case { systems, frequencies, names: ["x", "y", "z"].map(String::from).to_vec() }
    }

    fn request(&self) -> FrfRequest<'_> {
        FrfRequest {
            positions: &[0.0, 1.0],
            systems: &self.systems,
            frequencies: &self.frequencies,
            outputs: &self.names,
            inputs: &self.names,
            quantity: Quantity::Receptance,
        }
    }
}
