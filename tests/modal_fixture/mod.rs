//! Modal systems for the tests of the sums, and the plain sum that they are compared with.
#![allow(dead_code, reason = "each test binary uses its own part")]

pub mod device;
pub mod springs;

use nalgebra::{Complex, DMatrix};
use stiffmap::frf::{ComplianceMap, FrfRequest, ModalSystem, Quantity};

/// Reproducible numbers (SplitMix64).
pub struct Numbers(pub u64);

impl Numbers {
    /// Uniform in [low, high).
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A matrix of numbers in [-scale, scale).
    pub fn matrix(&mut self, rows: usize, columns: usize, scale: f64) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |_, _| self.within(-scale, scale))
    }
}

/// A machine-like system: `n` modes between 14 and 900 Hz, shapes of some 0.05 kg^(-1/2), the same at outputs and inputs.
pub fn symmetric_system(numbers: &mut Numbers, n_ports: usize, n: usize, zeta: f64) -> ModalSystem {
    let mut frequencies: Vec<f64> = (0..n).map(|_| numbers.within(14.0, 900.0)).collect();
    frequencies.sort_by(f64::total_cmp);
    let shapes = numbers.matrix(n_ports, n, 0.05);
    ModalSystem {
        frequencies,
        damping_ratios: vec![zeta; n],
        loss_factors: vec![0.0; n],
        outputs: shapes.clone(),
        inputs: shapes,
        residual: Vec::new(),
        exact: None,
    }
}

/// A symmetric residual polynomial with passive signs: static compliance, a loss, a mass term.
pub fn residual(numbers: &mut Numbers, n_ports: usize) -> Vec<DMatrix<Complex<f64>>> {
    [1e-9, -1e-13, 1e-16]
        .iter()
        .map(|scale| {
            let a = numbers.matrix(n_ports, n_ports, 1.0);
            (&a * a.transpose()).map(|x| Complex::new(x * scale, 0.0))
        })
        .collect()
}

/// A case with everything: both dampings, a residual, different numbers of modes a position.
pub fn rich(n_ports: usize) -> Case {
    let mut numbers = Numbers(21);
    let systems = (0..5)
        .map(|p| {
            let mut system = symmetric_system(&mut numbers, n_ports, 6 + p, 0.01);
            system.loss_factors.iter_mut().for_each(|eta| *eta = numbers.within(0.0, 0.03));
            system.residual = residual(&mut numbers, n_ports);
            system
        })
        .collect();
    Case::new(systems, (0..700).map(|i| 1.3 * i as f64).collect())
}

/// Owned parts of a request.
pub struct Case {
    pub positions: Vec<f64>,
    pub systems: Vec<ModalSystem>,
    pub frequencies: Vec<f64>,
    pub outputs: Vec<String>,
    pub inputs: Vec<String>,
    pub quantity: Quantity,
}

impl Case {
    pub fn new(systems: Vec<ModalSystem>, frequencies: Vec<f64>) -> Case {
        let name = |n: usize| (0..n).map(|i| format!("port {i}")).collect();
        Case {
            positions: (0..systems.len()).map(|i| -0.005 * i as f64).collect(),
            outputs: name(systems[0].outputs.nrows()),
            inputs: name(systems[0].inputs.nrows()),
            systems,
            frequencies,
            quantity: Quantity::Receptance,
        }
    }

    pub fn request(&self) -> FrfRequest<'_> {
        FrfRequest {
            positions: &self.positions,
            systems: &self.systems,
            frequencies: &self.frequencies,
            outputs: &self.outputs,
            inputs: &self.inputs,
            quantity: self.quantity,
        }
    }
}

/// The oracle: the sum as it is written, matrix by matrix, in rad/s.
pub fn plain_sum(system: &ModalSystem, frequency: f64, quantity: Quantity) -> DMatrix<Complex<f64>> {
    let tau = std::f64::consts::TAU;
    let j_omega = Complex::new(0.0, tau * frequency);
    let mut h = DMatrix::zeros(system.outputs.nrows(), system.inputs.nrows());
    for r in 0..system.frequencies.len() {
        let omega_r = tau * system.frequencies[r];
        let stiffness = Complex::new(1.0, system.loss_factors[r]) * omega_r * omega_r;
        let d = stiffness + j_omega * j_omega + j_omega * (2.0 * system.damping_ratios[r] * omega_r);
        let product = system.outputs.column(r) * system.inputs.column(r).transpose();
        h += product.map(|x| Complex::from(x) / d);
    }
    for (k, c) in system.residual.iter().enumerate() {
        h += c * j_omega.powu(k as u32);
    }
    h * j_omega.powu(quantity.power())
}

/// sum_r |term_r| of each entry, the measure of an entry's rounding.
pub fn sum_of_magnitudes(system: &ModalSystem, frequency: f64, quantity: Quantity) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(system.outputs.nrows(), system.inputs.nrows());
    for r in 0..system.frequencies.len() {
        let one = ModalSystem {
            frequencies: vec![system.frequencies[r]],
            damping_ratios: vec![system.damping_ratios[r]],
            loss_factors: vec![system.loss_factors[r]],
            outputs: system.outputs.columns(r, 1).into(),
            inputs: system.inputs.columns(r, 1).into(),
            residual: Vec::new(),
            exact: None,
        };
        sum += plain_sum(&one, frequency, quantity).map(|x| x.norm());
    }
    let omega = std::f64::consts::TAU * frequency;
    for (k, c) in system.residual.iter().enumerate() {
        sum += c.map(|x| x.norm()) * omega.powi(k as i32 + quantity.power() as i32);
    }
    sum
}

/// Largest |dH_ij| / sum_r |term_r| and largest Frobenius relative difference of a map against the oracle.
pub fn differences(case: &Case, map: &ComplianceMap) -> (f64, f64) {
    let (mut entry, mut frobenius) = (0.0f64, 0.0f64);
    for (p, system) in case.systems.iter().enumerate() {
        for (k, &f) in case.frequencies.iter().enumerate() {
            let reference = plain_sum(system, f, case.quantity);
            let magnitudes = sum_of_magnitudes(system, f, case.quantity);
            let difference = map.matrix(p, k) - &reference;
            for (d, m) in difference.iter().zip(magnitudes.iter()) {
                // 0 / 0 is no difference (accelerance at 0 Hz); x / 0 is infinite, and a NaN must not pass as small.
                let ratio = if d.norm() == 0.0 { 0.0 } else { d.norm() / m };
                entry = if ratio.is_nan() { f64::INFINITY } else { entry.max(ratio) };
            }
            let norm = |m: &DMatrix<Complex<f64>>| m.iter().map(|x| x.norm_sqr()).sum::<f64>().sqrt();
            if norm(&difference) != 0.0 {
                let ratio = norm(&difference) / norm(&reference);
                frobenius = if ratio.is_nan() { f64::INFINITY } else { frobenius.max(ratio) };
            }
        }
    }
    (entry, frobenius)
}
