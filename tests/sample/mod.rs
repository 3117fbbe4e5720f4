//! A made-up mill: modes whose frequencies move with the position, some crossing.

use nalgebra::Complex;
use stiffmap::frf::{ComplianceMap, Quantity};
use stiffmap::modal::{ModeFamilies, TrackedMode};

/// Number of elastic modes.
const MODES: usize = 30;

/// A number between 0 and 1 that only depends on `k`.
fn noise(k: usize) -> f64 {
    ((12.9898 * (k as f64 + 1.0)).sin() * 43758.5453).rem_euclid(1.0)
}

/// Frequency of a mode at a position between 0 and 1, Hz: moves by up to 30 %.
fn frequency(mode: usize, t: f64) -> f64 {
    let base = 14.0 + 23.0 * mode as f64 + 6.0 * noise(mode);
    let change = 0.3 * (noise(mode + 100) - 0.5) * if mode.is_multiple_of(3) { 1.0 } else { 0.4 };
    base * (1.0 + change * (2.2 * t + 0.6 * noise(mode + 200)).sin())
}

/// Families and receptances of the made-up mill, damping 2 %, positions from 0 down to -0.6 m.
pub fn mill(n_position: usize, n_frequency: usize) -> (ModeFamilies, ComplianceMap) {
    let place = |k: usize, n: usize| {
        if n > 1 { k as f64 / (n - 1) as f64 } else { 0.0 }
    };
    let positions: Vec<f64> = (0..n_position).map(|p| -0.6 * place(p, n_position)).collect();
    let frequencies: Vec<f64> = (0..n_frequency).map(|f| 900.0 * place(f, n_frequency)).collect();
    let zeta = 0.02;
    let mut modes = Vec::new();
    let mut values = Vec::with_capacity(9 * n_position * n_frequency);
    for position in &positions {
        let t = -position / 0.6;
        let found: Vec<f64> = (0..MODES).map(|m| frequency(m, t)).collect();
        let mut ranked: Vec<(usize, f64)> = std::iter::once(0.0).chain(found.iter().copied()).enumerate().collect();
        ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
        let tracked = ranked.iter().enumerate().map(|(rank, (family, frequency))| TrackedMode {
            family: family + 1,
            rank: rank + 1,
            frequency: *frequency,
            damping_ratio: zeta,
        });
        modes.push(tracked.collect());
        let shape = |m: usize, i: usize| {
            let sign = noise(7 * m + i) - 0.5;
            let place = 1.0 + 0.8 * t * noise(m + 31 * i);
            0.02 * sign * place * (1.0 + 0.6 * m as f64).powf(0.8)
        };
        let shapes: Vec<[f64; 3]> = (0..MODES).map(|m| [0, 1, 2].map(|i| shape(m, i))).collect();
        for f in &frequencies {
            let omega = std::f64::consts::TAU * f;
            let terms: Vec<Complex<f64>> = found
                .iter()
                .map(|own| {
                    let own = std::f64::consts::TAU * own;
                    Complex::new(own * own - omega * omega, 2.0 * zeta * own * omega).inv()
                })
                .collect();
            for i in 0..3 {
                for j in 0..3 {
                    values.push(terms.iter().zip(&shapes).map(|(t, s)| t * s[i] * s[j]).sum());
                }
            }
        }
    }
    let names: Vec<String> = ["tool.x", "tool.y", "tool.z"].map(String::from).into();
    let families = ModeFamilies { positions: positions.clone(), modes, veerings: Vec::new() };
    let quantity = Quantity::Receptance;
    let (outputs, inputs) = (names.clone(), names);
    (families, ComplianceMap { positions, frequencies, outputs, inputs, quantity, values })
}
