//! A fixed position whose modes are coupled by dampers: the exact recursion of the whole system, many samples at once.
//!
//! With x_(k+1) = Phi x_k + F u_k + T u_(k+1) the motions of the next samples are
//!
//! ```text
//! y_k = C Phi^k x_0 + sum_(m<k) C Phi^(k-1-m) (F u_m + T u_(m+1)) + D u_k
//! ```
//!
//! so that one sample costs the rows of C, and only every [`BLOCK`]-th the whole state.

use super::{Forces, Plant, Recording};
use crate::linalg::multiply;
use crate::state_space::{SystemStep, state_matrix};
use nalgebra::{DMatrix, DVector};

/// Samples from one state to the next.
const BLOCK: usize = 64;

/// The motions of a plant with dampers between its modes, without the direct compliance, `[sample, row]`, and the modal
/// displacements and rates at the last sample.
pub(super) fn simulate_coupled(plant: &Plant, forces: &Forces, recording: Recording) -> (Vec<f64>, [Vec<f64>; 2]) {
    let n = plant.omega.len();
    let (i, samples) = (plant.inputs.nrows(), forces.samples());
    let system = System::new(plant, recording);
    let step = SystemStep::new(&system.a, &system.b, &system.eigenvalues, forces.step);
    let length = BLOCK.min(samples.saturating_sub(1)).max(1);
    let blocks = Blocks::new(&step, &system.c, length);
    let u = |k: usize| DVector::from_column_slice(&forces.values[k * i..][..i]);
    let rows = system.c.nrows();
    let mut out = vec![0.0; rows * samples];
    let mut put = |k: usize, y: &DVector<f64>| {
        let y = y + &system.d * u(k);
        out[k * rows..][..rows].copy_from_slice(y.as_slice());
    };
    let mut x = DVector::zeros(2 * n);
    put(0, &DVector::zeros(rows));
    let mut first = 0;
    while first + 1 < samples {
        let count = length.min(samples - 1 - first);
        // Forces of the block: those at the beginning of each step, and those at its end.
        let own = DMatrix::from_fn(2 * i, count, |row, m| forces.values[(first + m + row / i) * i + row % i]);
        let free = blocks.outputs.rows(0, count * rows) * &x;
        for k in 1..=count {
            let mut y = free.rows((k - 1) * rows, rows).into_owned();
            for m in 0..k {
                y += blocks.to_outputs[k - 1 - m].clone() * own.column(m);
            }
            put(first + k, &y);
        }
        let mut next = if count == length { &blocks.over * &x } else { power(&step.phi, count) * &x };
        for m in 0..count {
            next += &blocks.to_states[count - 1 - m] * own.column(m);
        }
        x = next;
        first += count;
    }
    (out, [x.as_slice()[..n].to_vec(), x.as_slice()[n..].to_vec()])
}

/// The plant as x' = A x + B u, y = C x + D u, without the direct compliance.
struct System {
    eigenvalues: Vec<f64>,
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
}

impl System {
    fn new(plant: &Plant, recording: Recording) -> Self {
        let (n, o) = (plant.omega.len(), plant.outputs.nrows());
        let eigenvalues: Vec<f64> = plant.omega.iter().map(|w| w * w).collect();
        let a = state_matrix(&eigenvalues, &plant.zeta, &plant.dampers);
        let mut b = DMatrix::zeros(2 * n, plant.inputs.nrows());
        b.rows_mut(n, n).copy_from(&plant.inputs.transpose());
        let blocks = 1 + usize::from(recording.velocity) + usize::from(recording.acceleration);
        let (mut c, mut d) = (DMatrix::zeros(blocks * o, 2 * n), DMatrix::zeros(blocks * o, plant.inputs.nrows()));
        c.view_mut((0, 0), (o, n)).copy_from(&plant.outputs);
        if recording.velocity {
            c.view_mut((o, n), (o, n)).copy_from(&plant.outputs);
        }
        if recording.acceleration {
            let last = (blocks - 1) * o;
            c.rows_mut(last, o).copy_from(&multiply(&plant.outputs, &a.rows(n, n).into_owned()));
            d.rows_mut(last, o).copy_from(&multiply(&plant.outputs, &plant.inputs.transpose()));
        }
        Self { eigenvalues, a, b, c, d }
    }
}

/// The recursion over many samples.
struct Blocks {
    /// C Phi^k for k = 1 .. length, one below the other.
    outputs: DMatrix<f64>,
    /// C Phi^k [F T] for k = 0 .. length - 1.
    to_outputs: Vec<DMatrix<f64>>,
    /// Phi^k [F T] for k = 0 .. length - 1.
    to_states: Vec<DMatrix<f64>>,
    /// Phi^length.
    over: DMatrix<f64>,
}

impl Blocks {
    fn new(step: &SystemStep, c: &DMatrix<f64>, length: usize) -> Self {
        let mut forced = DMatrix::zeros(step.phi.nrows(), 2 * step.from.ncols());
        forced.columns_mut(0, step.from.ncols()).copy_from(&step.from);
        forced.columns_mut(step.from.ncols(), step.from.ncols()).copy_from(&step.to);
        let mut outputs = DMatrix::zeros(c.nrows() * length, c.ncols());
        let mut row = c.clone();
        let mut to_states = Vec::with_capacity(length);
        for k in 0..length {
            row = multiply(&row, &step.phi);
            outputs.rows_mut(k * c.nrows(), c.nrows()).copy_from(&row);
            to_states.push(forced.clone());
            forced = multiply(&step.phi, &forced);
        }
        let to_outputs = to_states.iter().map(|s| multiply(c, s)).collect();
        Self { outputs, to_outputs, to_states, over: power(&step.phi, length) }
    }
}

/// A matrix to a power of at least one.
fn power(of: &DMatrix<f64>, mut exponent: usize) -> DMatrix<f64> {
    let (mut out, mut square) = (None::<DMatrix<f64>>, of.clone());
    loop {
        if exponent % 2 == 1 {
            out = Some(out.map_or_else(|| square.clone(), |o| multiply(&o, &square)));
        }
        exponent /= 2;
        if exponent == 0 {
            return out.unwrap_or(square);
        }
        square = multiply(&square, &square);
    }
}
