//! Which (output, input) pairs are summed, and the numbers that the sums run over.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::{FrfRequest, ModalSystem};

/// The pairs that are computed; a symmetric map computes each pair once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packing {
    /// The (output, input) pairs that are summed.
    pub pairs: Vec<(usize, usize)>,
    /// For each of the outputs x inputs values, the pair that holds it.
    pub pair_of_value: Vec<usize>,
    /// Whether H is symmetric at every position.
    pub symmetric: bool,
}

impl Packing {
    /// Packing of a checked request: symmetric where at every position the inputs' shapes equal the outputs' and the
    /// residual is symmetric to rounding (64 eps of its largest entry; the mean of both entries is then used).
    pub fn new(request: &FrfRequest) -> Packing {
        let (rows, columns) = (request.outputs.len(), request.inputs.len());
        Packing::of(rows, columns, rows == columns && request.systems.iter().all(is_symmetric))
    }

    /// Packing of one system between all its rows.
    pub(super) fn of_system(system: &ModalSystem) -> Packing {
        Packing::of(system.outputs.nrows(), system.inputs.nrows(), is_symmetric(system))
    }

    fn of(rows: usize, columns: usize, symmetric: bool) -> Packing {
        let mut pairs = Vec::new();
        let mut pair_of_value = vec![0; rows * columns];
        for i in 0..rows {
            for j in if symmetric { i..columns } else { 0..columns } {
                pair_of_value[i * columns + j] = pairs.len();
                if symmetric {
                    pair_of_value[j * columns + i] = pairs.len();
                }
                pairs.push((i, j));
            }
        }
        Packing { pairs, pair_of_value, symmetric }
    }
}

fn is_symmetric(system: &ModalSystem) -> bool {
    system.outputs == system.inputs
        && system.residual.iter().all(|c| {
            let bound = 64.0 * f64::EPSILON * c.iter().map(|x| x.norm()).fold(0.0, f64::max);
            (0..c.nrows()).all(|i| (0..i).all(|j| (c[(i, j)] - c[(j, i)]).norm() <= bound))
        })
}

/// A mode's denominator in Hz^2: (f_r - f)(f_r + f) + j (loss + viscous f).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Denominator {
    /// Natural frequency f_r, Hz.
    pub frequency: f64,
    /// 2 zeta_r f_r, Hz.
    pub viscous: f64,
    /// eta_r f_r^2, Hz^2.
    pub loss: f64,
}

/// One position's numbers in the order in which the sums read them.
#[derive(Clone, Debug)]
pub struct PackedSystem {
    /// The modes' denominators.
    pub modes: Vec<Denominator>,
    /// L_ir R_jr / (4 pi^2), `[mode, pair]`, 1/kg.
    pub residues: Vec<f64>,
    /// C_k (2 pi j)^k, `[k, pair]`: the residual as a polynomial in f (Hz), m/N.
    pub residual: Vec<Complex<f64>>,
}

impl PackedSystem {
    /// Packs one position.
    pub fn new(system: &ModalSystem, packing: &Packing) -> PackedSystem {
        let modes = (0..system.frequencies.len())
            .map(|r| {
                let f = system.frequencies[r];
                let viscous = 2.0 * system.damping_ratios[r] * f;
                Denominator { frequency: f, viscous, loss: system.loss_factors[r] * f * f }
            })
            .collect();
        let residues = (0..system.frequencies.len())
            .flat_map(|r| packing.pairs.iter().map(move |&(i, j)| (r, i, j)))
            .map(|(r, i, j)| system.outputs[(i, r)] * system.inputs[(j, r)] / (TAU * TAU))
            .collect();
        let mut power = Complex::new(1.0, 0.0);
        let mut residual = Vec::with_capacity(system.residual.len() * packing.pairs.len());
        for c in &system.residual {
            residual.extend(packing.pairs.iter().map(|&(i, j)| {
                let value = if packing.symmetric { (c[(i, j)] + c[(j, i)]) * 0.5 } else { c[(i, j)] };
                value * power
            }));
            power *= Complex::new(0.0, TAU);
        }
        PackedSystem { modes, residues, residual }
    }
}
