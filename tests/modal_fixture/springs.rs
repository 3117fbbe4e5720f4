//! Random machines whose springs change from design to design.

use super::Numbers;
use nalgebra::{Complex, DMatrix};
use stiffmap::frf::modification::{BaseMode, BaseReceptance, SpringChange};

/// Structural loss factor of parts and springs.
const ETA: f64 = 0.02;
/// Ports of each machine.
pub const PORTS: usize = 3;

/// A random machine with its springs: a free structure of many modes, held by springs of very different units.
pub struct Machine {
    /// Square of the free structure's angular frequencies.
    lambda: Vec<f64>,
    /// Elongations of the springs, then motions of the ports.
    rows: DMatrix<f64>,
    stiffness: Vec<f64>,
}

impl Machine {
    pub fn new(seed: u64, springs: usize) -> Machine {
        let mut numbers = Numbers(seed);
        let n = springs + 30;
        let mut rows = numbers.matrix(springs + PORTS, n, 0.05);
        let lambda: Vec<f64> = (0..n)
            .map(|r| (std::f64::consts::TAU * (20.0 + 25.0 * r as f64 + numbers.within(0.0, 20.0))).powi(2))
            .collect();
        // Every third spring turns instead of giving way: 1e-3 rad/m of it, 1e6 times the number.
        let mut stiffness: Vec<f64> = (0..springs).map(|_| numbers.within(2e7, 2e8)).collect();
        for s in (0..springs).step_by(3) {
            rows.row_mut(s).scale_mut(1e-3);
            stiffness[s] *= 1e6;
        }
        Machine { lambda, rows, stiffness }
    }

    /// Parts that nothing but their springs holds, stiff beside what else gives way.
    pub fn of_floating_parts(seed: u64, springs: usize) -> Machine {
        let mut machine = Machine::new(seed, springs);
        machine.lambda[..6].fill(0.1);
        machine.stiffness.iter_mut().for_each(|k| *k *= 30.0);
        machine
    }

    pub fn springs(&self) -> usize {
        self.stiffness.len()
    }

    /// Receptances of the machine with its springs times `factor`.
    pub fn base(&self, frequencies: &[f64], factor: f64) -> BaseReceptance {
        let springs = self.rows.rows(0, self.springs());
        let held = DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(&self.stiffness)) * factor;
        let k = DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(&self.lambda))
            + springs.transpose() * held * springs;
        let eigen = k.symmetric_eigen();
        let modes: Vec<BaseMode> = eigen
            .eigenvalues
            .iter()
            .map(|l| BaseMode { frequency: l.sqrt() / std::f64::consts::TAU, damping_ratio: 0.0, loss_factor: ETA })
            .collect();
        let n = self.rows.nrows();
        BaseReceptance::new(
            frequencies,
            &modes,
            &(&self.rows * eigen.eigenvectors),
            &DMatrix::zeros(n, n),
            self.springs(),
        )
    }

    /// Changes from the springs times `from` to random designs between 0.3 and 3 times nominal.
    pub fn designs(&self, seed: u64, count: usize, from: f64) -> Vec<Vec<SpringChange>> {
        let mut numbers = Numbers(seed);
        let mut one = |k: &f64| {
            let factor = 0.3 * 10f64.powf(numbers.within(0.0, 1.0));
            SpringChange { stiffness: Complex::new(1.0, ETA) * k * (factor - from), damping: 0.0 }
        };
        (0..count).map(|_| self.stiffness.iter().map(&mut one).collect()).collect()
    }
}

/// From 5 to 900 Hz with steps of half a half-power bandwidth.
pub fn grid() -> Vec<f64> {
    (0..1150).map(|k| 5.0 * (1.0f64 + 0.45 * 0.5 * ETA).powi(k)).take_while(|f| *f < 900.0).collect()
}

pub fn all_pairs() -> Vec<(usize, usize)> {
    (0..PORTS).flat_map(|i| (0..=i).map(move |j| (i, j))).collect()
}

/// Largest relative Frobenius difference over the ports of any design and frequency.
pub fn frobenius(found: &[Vec<Vec<Complex<f64>>>], exact: &[Vec<Vec<Complex<f64>>>]) -> f64 {
    let mut worst = 0.0f64;
    for (found, exact) in found.iter().zip(exact) {
        for k in 0..exact[0].len() {
            let norm = |of: &dyn Fn(usize) -> Complex<f64>| {
                let weight = |(p, (i, j)): (usize, (usize, usize))| of(p).norm_sqr() * if i == j { 1.0 } else { 2.0 };
                all_pairs().into_iter().enumerate().map(weight).sum::<f64>().sqrt()
            };
            let ratio = norm(&|p| found[p][k] - exact[p][k]) / norm(&|p| exact[p][k]);
            worst = if ratio.is_nan() { f64::INFINITY } else { worst.max(ratio) };
        }
    }
    worst
}

/// Factor by which nominal springs are multiplied in the base that designs between 0.3 and 3 start from.
pub const AROUND: f64 = 1.0;
