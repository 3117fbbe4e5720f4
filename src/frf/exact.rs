//! Exact responses where damping couples the modes.
//!
//! With the receptances of the machine without its dissipating springs' dampers and losses, between ports p and these
//! springs s, and G = diag(j eta k + j omega c) what the springs dissipate,
//!
//! ```text
//! H = H_pp - H_ps (G^-1 + H_ss)^-1 H_sp
//! ```
//!
//! at every frequency: the machine's damped equations, solved for the springs' forces. H_pp, H_ps and H_ss are modal
//! sums over the same modes, for which these springs are further ports. Parts with loss factors make the stiffness
//! complex; its modes are complex too, and the sum goes over them.
//!
//! Source: Ewins, Modal Testing, 2nd ed., sections 2.5 (complex stiffness) and 6.4 (structural modification).

use super::kernel::{Block, GROUP, Model, lay_out};
use super::packing::{PackedSystem, Packing};
use super::point::Response;
use super::request::{ModalSystem, Quantity};
use nalgebra::Complex;
use std::f64::consts::TAU;

/// Frequencies of which the sums are held at a time.
const BLOCK: usize = 8 * GROUP;
/// A mode that only springs damp has no damping in the sum over modes; this loss factor keeps the sum finite at its
/// frequency, and changes the mode's damping by its own small amount.
const FLOOR: f64 = 1e-9;

/// Damping that couples the modes of one position, as the sums see it.
#[derive(Clone, Debug)]
pub struct ExactDamping {
    /// The modes without the springs' dissipation. Rows: outputs (inputs), then springs; where `is_complex`, these
    /// are real parts, and the same rows follow for the imaginary parts.
    pub system: ModalSystem,
    /// Whether the rows of [`Self::system`] have imaginary parts.
    pub is_complex: bool,
    n_outputs: usize,
    n_inputs: usize,
    /// Damper of each spring, N s/m.
    pub viscous: Vec<f64>,
    /// Loss factor times stiffness of each spring, N/m.
    pub structural: Vec<f64>,
}

impl ExactDamping {
    /// From modes without the springs' dissipation, whose rows end with those of the springs.
    pub fn new(mut system: ModalSystem, is_complex: bool, viscous: Vec<f64>, structural: Vec<f64>) -> Self {
        let parts = if is_complex { 2 } else { 1 };
        let n_springs = viscous.len();
        let ports = |rows: usize| rows / parts - n_springs;
        let (n_outputs, n_inputs) = (ports(system.outputs.nrows()), ports(system.inputs.nrows()));
        for (eta, zeta) in system.loss_factors.iter_mut().zip(&system.damping_ratios) {
            if 2.0 * zeta + *eta < FLOOR {
                *eta = FLOOR;
            }
        }
        Self { system, is_complex, n_outputs, n_inputs, viscous, structural }
    }

    fn springs(&self) -> usize {
        self.viscous.len()
    }

    /// What a spring dissipates at a frequency, N/m.
    fn dissipation(&self, spring: usize, frequency: f64) -> Complex<f64> {
        Complex::new(0.0, self.structural[spring] + TAU * frequency * self.viscous[spring])
    }

    /// The packed modes; to be made once a position.
    pub(super) fn pack(&self) -> Packed<'_> {
        let packing = Packing::of_system(&self.system);
        let system = PackedSystem::new(&self.system, &packing);
        Packed { exact: self, packing, system }
    }
}

/// The modes of [`ExactDamping`] in the order in which sums read them.
pub(super) struct Packed<'a> {
    exact: &'a ExactDamping,
    packing: Packing,
    system: PackedSystem,
}

impl Packed<'_> {
    /// Responses at frequencies (Hz) into `[frequency, output, input]`, at 0 Hz as the sums give them.
    pub fn sum(&self, frequencies: &[f64], quantity: Quantity, values: &mut [Complex<f64>]) {
        let exact = self.exact;
        let (o, i, s) = (exact.n_outputs, exact.n_inputs, exact.springs());
        let (rows, columns) = (exact.system.outputs.nrows(), exact.system.inputs.nrows());
        let mut sums = vec![Complex::default(); BLOCK.min(frequencies.len().next_multiple_of(GROUP)) * rows * columns];
        let mut matrix = vec![Complex::default(); (o + s) * (i + s)];
        let model = Model { system: &self.system, packing: &self.packing, quantity: Quantity::Receptance };
        for (frequencies, out) in frequencies.chunks(BLOCK).zip(values.chunks_mut(BLOCK * o * i)) {
            let sums = &mut sums[..frequencies.len() * rows * columns];
            sums.fill(Complex::default());
            Block { model, frequencies: &lay_out(frequencies), stream: false, values: sums }.sum();
            for ((f, sums), out) in
                frequencies.iter().zip(sums.chunks_exact(rows * columns)).zip(out.chunks_exact_mut(o * i))
            {
                self.gather(sums, columns, &mut matrix);
                exact.eliminate(*f, &mut matrix);
                let factor = Complex::new(0.0, TAU * f).powu(quantity.power());
                for k in 0..o {
                    for l in 0..i {
                        out[k * i + l] = factor * matrix[k * (i + s) + l];
                    }
                }
            }
        }
    }

    /// Receptances between ports and springs from the sums over real and imaginary parts.
    fn gather(&self, sums: &[Complex<f64>], columns: usize, matrix: &mut [Complex<f64>]) {
        if !self.exact.is_complex {
            matrix.copy_from_slice(sums);
            return;
        }
        let own = columns / 2;
        let rows = matrix.len() / own;
        for k in 0..rows {
            for l in 0..own {
                let at = |a: usize, b: usize| sums[(k + a * rows) * columns + l + b * own];
                let (real, imaginary) = (at(0, 0) - at(1, 1), at(0, 1) + at(1, 0));
                matrix[k * own + l] = real + Complex::new(-imaginary.im, imaginary.re);
            }
        }
    }

    /// The response of one output and input at a frequency, with its derivatives.
    ///
    /// With Y = [1; -M^-1 H_s] on either side, M = G^-1 + H_ss and N the bordered matrix,
    /// H' = Y^T N' Y and H'' = Y^T N'' Y - 2 (N' Y)_s^T M^-1 (N' Y)_s.
    pub fn response(&self, frequency: f64, output: usize, input: usize, quantity: Quantity) -> Response {
        let exact = self.exact;
        let (o, i, s) = (exact.n_outputs, exact.n_inputs, exact.springs());
        let weights = super::point::Weights::new(&self.system, frequency);
        let columns = exact.system.inputs.nrows();
        // The bordered matrices of value, slope and curvature for this output and input, then the springs.
        let place = |k: usize, ports: usize, port: usize| if k == 0 { port } else { ports + k - 1 };
        let half = (exact.system.outputs.nrows() / 2, columns / 2);
        let n_pairs = self.packing.pairs.len();
        let entry = |row: usize, column: usize| {
            let pair = self.packing.pair_of_value[row * columns + column];
            weights.response(&self.system, n_pairs, pair, Quantity::Receptance)
        };
        let mut n = vec![[Complex::default(); 3]; (1 + s) * (1 + s)];
        for a in 0..=s {
            for b in 0..=s {
                if a > 0 && b > 0 && b < a {
                    n[a * (1 + s) + b] = n[b * (1 + s) + a];
                    continue;
                }
                let (row, column) = (place(a, o, output), place(b, i, input));
                let list = |r: Response| [r.value, r.slope, r.curvature];
                let mut value = list(entry(row, column));
                if exact.is_complex {
                    let both = list(entry(row + half.0, column + half.1));
                    let (first, second) = (list(entry(row, column + half.1)), list(entry(row + half.0, column)));
                    let rest = first.iter().zip(&second).zip(&both);
                    for (value, ((first, second), both)) in value.iter_mut().zip(rest) {
                        *value += Complex::new(0.0, 1.0) * (first + second) - both;
                    }
                }
                n[a * (1 + s) + b] = value;
            }
        }
        let h = exact.eliminated(frequency, &n);
        Response { value: h[0], slope: h[1], curvature: h[2] }.as_quantity(quantity, frequency)
    }
}

impl ExactDamping {
    /// Eliminates the springs from receptances between (outputs, springs) and (inputs, springs), by rows.
    ///
    /// No pivoting is needed: pivots are driving point receptances of a passive machine, and a spring's own 1/G adds
    /// to their imaginary part.
    pub(super) fn eliminate(&self, frequency: f64, matrix: &mut [Complex<f64>]) {
        let (o, i, s) = (self.n_outputs, self.n_inputs, self.springs());
        let columns = i + s;
        for k in 0..s {
            let g = self.dissipation(k, frequency);
            if g.im == 0.0 {
                continue;
            }
            let (row, column) = (o + k, i + k);
            let inverse = (matrix[row * columns + column] + g.inv()).inv();
            for r in (0..o).chain(row + 1..o + s) {
                let factor = matrix[r * columns + column] * inverse;
                for c in (0..i).chain(column + 1..columns) {
                    let below = matrix[row * columns + c];
                    matrix[r * columns + c] -= factor * below;
                }
            }
        }
    }

    /// [`Self::eliminate`] of a matrix.
    pub(super) fn eliminate_in(&self, frequency: f64, h: &mut nalgebra::DMatrix<Complex<f64>>) {
        let columns = h.ncols();
        let mut rows: Vec<Complex<f64>> = h.transpose().iter().copied().collect();
        self.eliminate(frequency, &mut rows);
        *h = nalgebra::DMatrix::from_row_slice(h.nrows(), columns, &rows);
    }

    /// Value, slope and curvature by frequency (Hz) of one response, from those of the receptances between the port and
    /// the springs, (1 + s) x (1 + s).
    fn eliminated(&self, frequency: f64, n: &[[Complex<f64>; 3]]) -> [Complex<f64>; 3] {
        let s = self.springs();
        let acting: Vec<usize> = (0..s).filter(|&k| self.dissipation(k, frequency).im != 0.0).collect();
        let m = acting.len();
        if m == 0 {
            return n[0];
        }
        let at = |a: usize, b: usize, d: usize| n[a * (1 + s) + b][d];
        let inner = nalgebra::DMatrix::from_fn(m, m, |a, b| {
            let own = if a == b { self.dissipation(acting[a], frequency).inv() } else { Complex::default() };
            at(acting[a] + 1, acting[b] + 1, 0) + own
        });
        // N's own derivatives carry those of 1/G on the diagonal: G' = j 2 pi c.
        let derivative = |a: usize, b: usize, d: usize| {
            let mut value = at(a, b, d);
            if a == b && a > 0 && d > 0 {
                let g = self.dissipation(a - 1, frequency);
                let rate = Complex::new(0.0, TAU * self.viscous[a - 1]);
                value += if d == 1 { -rate / (g * g) } else { rate * rate * 2.0 / (g * g * g) };
            }
            value
        };
        let index: Vec<usize> = std::iter::once(0).chain(acting.iter().map(|k| k + 1)).collect();
        let columns = nalgebra::DMatrix::from_fn(m, 2, |a, side| match side {
            0 => at(0, index[a + 1], 0),
            _ => at(index[a + 1], 0, 0),
        });
        let lu = inner.lu();
        let solved = lu.solve(&columns).unwrap_or_else(|| columns.map(|_| Complex::new(f64::NAN, f64::NAN)));
        let side = |side: usize, k: usize| if k == 0 { Complex::new(1.0, 0.0) } else { -solved[(k - 1, side)] };
        let value = at(0, 0, 0) - (0..m).map(|a| at(0, index[a + 1], 0) * solved[(a, 1)]).sum::<Complex<f64>>();
        let form = |d: usize| {
            let mut sum = Complex::default();
            for (a, &row) in index.iter().enumerate() {
                for (b, &column) in index.iter().enumerate() {
                    sum += side(0, a) * derivative(row, column, d) * side(1, b);
                }
            }
            sum
        };
        let rates = nalgebra::DMatrix::from_fn(m, 2, |a, which| {
            let row = index[a + 1];
            let product = |(b, &column): (usize, &usize)| match which {
                0 => side(0, b) * derivative(column, row, 1),
                _ => derivative(row, column, 1) * side(1, b),
            };
            index.iter().enumerate().map(product).sum::<Complex<f64>>()
        });
        let answer = lu.solve(&rates).unwrap_or_else(|| rates.map(|_| Complex::new(f64::NAN, f64::NAN)));
        let bend: Complex<f64> = (0..m).map(|a| rates[(a, 0)] * answer[(a, 1)]).sum();
        [value, form(1), form(2) - bend * 2.0]
    }
}
