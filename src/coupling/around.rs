//! The machine at one position around a base design, in that design's own modes.
//!
//! With the base's modes kept up to 1.5 times the wanted frequency, the inertia of the static responses to
//! the springs that vary, and the static flexibility of everything else in series with them, a design
//! is a change of few springs in some 110 coordinates. With E the elongations and R the residual
//! flexibility of springs and ports in the base, and Delta = diag(k - k0),
//!
//! ```text
//! z'' + (Lambda0 + E^T Delta' E) z = P'^T f      Delta' = (I + Delta R)^-1 Delta
//! P' = P - R_PE Delta' E                         u = P' z + (R_PP - R_PE Delta' R_EP) f
//! ```

use super::basis::{inertia_columns, stiffness_axes};
use super::eigen::CoupledEigen;
use super::mechanism::free_motions;
use super::{AtPosition, CoupledModel, CouplingError};
use crate::linalg::{LinalgError, eigen_of_flexibility, multiply, multiply_transposed, orthonormal_span};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// How much of the base is kept.
///
/// On the bundled mill to 900 Hz, for designs between 0.3 and 3 times the nominal stiffness:
///
/// | band | tolerance | coordinates | frequencies keep |
/// |---|---|---|---|
/// | 2 | 1.5e-3 | 144 | 5e-7 |
/// | 1.5 | 5e-3 | 113 | 1e-6 |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AroundOptions {
    /// Modes of the base up to this multiple of the wanted frequency.
    pub band: f64,
    /// Inertia that may be cut, as in [`super::BasisOptions`].
    pub tolerance: f64,
}

impl AroundOptions {
    /// For eigenfrequencies and metrics of designs.
    pub const DESIGNS: Self = Self { band: 1.5, tolerance: 5e-3 };
    /// The same for designs whose springs are more than [`Self::FAR`] times as stiff as the base's.
    pub const FAR_DESIGNS: Self = Self { band: 2.0, tolerance: 1.5e-3 };
    /// Ratio of stiffnesses up to which [`Self::DESIGNS`] keeps every metric to a thousandth.
    pub const FAR: f64 = 10.0;
}

/// The machine at one position around a base design, for designs that change some of its springs.
#[derive(Clone, Debug)]
pub struct Around {
    /// Position, m.
    pub position: f64,
    /// The frequency that the machine's fixed basis is made for, Hz.
    pub frequency: f64,
    /// Eigenvalues of its m coordinates in the base design, (rad/s)^2.
    pub eigenvalues: DVector<f64>,
    /// How many of them, the first, are modes of the base; the others carry inertia above the band.
    pub modes: usize,
    /// Free motions of the base, the first of its modes.
    pub free: usize,
    /// The base's spring stiffnesses, N/m or N m/rad.
    pub base: Vec<f64>,
    /// The springs that designs may change, ascending.
    pub varied: Vec<usize>,
    /// Its coordinates in the fixed basis, n x m.
    pub basis: DMatrix<f64>,
    /// Elongations of all springs, n_springs x m.
    pub springs: DMatrix<f64>,
    /// Output rows, n_outputs x m.
    pub outputs: DMatrix<f64>,
    /// Input rows, n_inputs x m.
    pub inputs: DMatrix<f64>,
    /// Residual flexibility in the base between springs, then outputs, then inputs, m/N.
    pub residual: DMatrix<f64>,
    /// For each part with a loss factor of its own, twice its strain energy as a form in the coordinates and then
    /// loads on springs, outputs and inputs, square.
    pub strain_energy: Vec<Option<DMatrix<f64>>>,
    /// Shift of the eigenproblem, (rad/s)^2.
    shift: f64,
    /// Rows of all springs over the fixed basis, and its eigenvalues there: which motions are free hangs on them.
    rows: DMatrix<f64>,
    rigid: DVector<f64>,
}

/// A design at one position.
#[derive(Clone, Debug)]
pub struct AroundCoupled {
    /// The stiffnesses of all springs, N/m or N m/rad.
    pub stiffness: Vec<f64>,
    /// Output rows P', n_outputs x m.
    pub outputs: DMatrix<f64>,
    /// Input rows P', n_inputs x m.
    pub inputs: DMatrix<f64>,
    /// Static compliance that the coordinates do not carry, n_outputs x n_inputs, m/N.
    pub direct: DMatrix<f64>,
    /// The varied springs' tension beyond the base's for unit coordinates, Delta' E, n_varied x m.
    pub tension: DMatrix<f64>,
    /// Delta', n_varied x n_varied, N/m.
    pub series: DMatrix<f64>,
}

/// The base's coordinates above the band: rows over them, what is kept of them, and what is left.
struct Above {
    /// Rows of springs and ports, n_rows x n_above.
    rows: DMatrix<f64>,
    /// Eigenvalues, (rad/s)^2.
    eigenvalues: Vec<f64>,
    /// Orthonormal directions that are kept, n_above x n_kept; they diagonalise the stiffness.
    directions: DMatrix<f64>,
    /// Eigenvalues of the directions, (rad/s)^2.
    kept: DVector<f64>,
}

impl Above {
    fn new(
        rows: DMatrix<f64>,
        eigenvalues: Vec<f64>,
        wanted: &[(usize, f64)],
        omega_squared: f64,
        tolerance: f64,
    ) -> Result<Self, LinalgError> {
        let mut columns = Vec::new();
        for &(row, flexibility) in wanted {
            let row: Vec<f64> = rows.row(row).iter().copied().collect();
            columns.extend(inertia_columns(&row, &eigenvalues, flexibility, omega_squared).into_iter().flatten());
        }
        if columns.is_empty() {
            let directions = DMatrix::zeros(eigenvalues.len(), 0);
            return Ok(Self { rows, eigenvalues, directions, kept: DVector::zeros(0) });
        }
        let span = orthonormal_span(&DMatrix::from_columns(&columns), tolerance)?;
        let (directions, kept) = stiffness_axes(&span, &eigenvalues)?;
        Ok(Self { rows, eigenvalues, directions, kept })
    }

    /// Static response (Lambda^-1 - U Lambda_U^-1 U^T) R^T of what is left to forces on all rows.
    fn response(&self) -> DMatrix<f64> {
        let mut all = self.rows.transpose();
        for (mut row, l) in all.row_iter_mut().zip(&self.eigenvalues) {
            row /= *l;
        }
        let mut kept = multiply_transposed(&self.directions, &self.rows.transpose());
        for (mut row, l) in kept.row_iter_mut().zip(&self.kept) {
            row /= *l;
        }
        all - multiply(&self.directions, &kept)
    }
}

impl CoupledModel {
    /// The machine at a position around a base design, for results up to a frequency (Hz) and designs
    /// that change the `varied` springs only; an infinite frequency keeps all modes of the fixed basis.
    ///
    /// # Errors
    /// [`CouplingError::Basis`] if an eigenproblem fails.
    ///
    /// # Accuracy
    /// Exact at the base but for the inertia that is cut above 1.5 times the frequency ([`AroundOptions::DESIGNS`]), or
    /// above twice the frequency where designs are much stiffer ([`AroundOptions::FAR_DESIGNS`]).
    pub fn around(
        &self,
        at: &AtPosition,
        base: &[f64],
        varied: &[usize],
        frequency: f64,
    ) -> Result<Around, CouplingError> {
        let eigen = self.eigen(at, &self.coupled(at, base)?, base)?;
        let far = self.stiffest > AroundOptions::FAR;
        let options = if far { AroundOptions::FAR_DESIGNS } else { AroundOptions::DESIGNS };
        self.around_modes(at, base, &eigen, varied, frequency, options)
    }

    /// The same from all modes of the base in the fixed basis, mass-normalised and ascending.
    ///
    /// # Errors
    /// As [`Self::around`].
    pub fn around_modes(
        &self,
        at: &AtPosition,
        base: &[f64],
        eigen: &CoupledEigen,
        varied: &[usize],
        frequency: f64,
        options: AroundOptions,
    ) -> Result<Around, CouplingError> {
        let (s, o) = (at.springs.nrows(), at.outputs.nrows());
        let coupled = self.coupled(at, base)?;
        let edge = (TAU * options.band * frequency).powi(2);
        let low = eigen.values.iter().take_while(|l| **l <= edge).count();
        let rows = stacked(&[&coupled.elongations, &coupled.outputs, &coupled.inputs]);
        let mut modal = multiply(&rows, &eigen.vectors);
        // No spring reads a free motion: not even rounding is left of it for a stiff one.
        modal.view_mut((0, 0), (s, eigen.free)).fill(0.0);
        let eigenvalues: Vec<f64> = eigen.values.iter().skip(low).copied().collect();
        let stiffest = |spring: usize| if base[spring] > 0.0 { 1.0 / (self.stiffest * base[spring]) } else { 0.0 };
        let wanted: Vec<(usize, f64)> =
            varied.iter().map(|&v| (v, stiffest(v))).chain((s..rows.nrows()).map(|r| (r, 0.0))).collect();
        let omega_squared = (TAU * frequency).powi(2);
        let rows = modal.columns_range(low..).into_owned();
        let above = Above::new(rows, eigenvalues, &wanted, omega_squared, options.tolerance)?;

        let kept = beside(&modal.columns(0, low).into_owned(), &multiply(&above.rows, &above.directions));
        let response = above.response();
        let residual = self.residual_in_place(at, base)? + multiply(&above.rows, &response);
        let springs = kept.rows(0, s).into_owned();

        let upper = eigen.vectors.columns_range(low..).into_owned();
        let basis = beside(&eigen.vectors.columns(0, low).into_owned(), &multiply(&upper, &above.directions));
        let strain_energy = if self.parts.iter().all(|p| p.loss_factor.is_none()) {
            vec![None; self.parts.len()]
        } else {
            // The fixed basis's coordinates and what acts on its residual flexibility, from the coordinates and from
            // unit loads on all rows: a spring's tension is a load that pulls its sides together.
            let motion = beside(&basis, &multiply(&upper, &response));
            let mut loads = beside(&springs, &residual.rows(0, s).into_owned());
            for (mut row, k) in loads.row_iter_mut().zip(base) {
                row *= -*k;
            }
            let mut loads = loads.resize_vertically(residual.nrows(), 0.0);
            for row in 0..residual.nrows() {
                loads[(row, kept.ncols() + row)] += 1.0;
            }
            self.strain_energies(at, &motion, &loads)
        };
        let eigenvalues = eigen.values.iter().take(low).chain(above.kept.iter()).copied();
        Ok(Around {
            position: at.position,
            frequency: self.frequency,
            eigenvalues: DVector::from_vec(eigenvalues.collect()),
            modes: low,
            free: eigen.free,
            base: base.to_vec(),
            varied: varied.to_vec(),
            basis,
            outputs: kept.rows(s, o).into_owned(),
            inputs: kept.rows_range(s + o..).into_owned(),
            springs,
            residual,
            strain_energy,
            shift: self.shift(),
            rows: at.springs.clone(),
            rigid: self.eigenvalues.clone(),
        })
    }

    /// Twice the strain energy of each part with a loss factor, for coordinates of the fixed basis and loads on its
    /// residual flexibility that are given over other coordinates.
    fn strain_energies(
        &self,
        at: &AtPosition,
        motion: &DMatrix<f64>,
        loads: &DMatrix<f64>,
    ) -> Vec<Option<DMatrix<f64>>> {
        let one = |(part, residual): (&super::PartShare, &Option<super::ResidualEnergy>)| {
            let (Some(k), Some(c)) = (&part.stiffness, residual) else { return None };
            Some(c.strain_energy(k, motion, loads))
        };
        self.parts.iter().zip(&at.residual_of_part).map(one).collect()
    }
}

impl Around {
    /// Coordinates.
    pub fn n(&self) -> usize {
        self.eigenvalues.len()
    }

    /// The machine with given stiffnesses of all springs (N/m or N m/rad, not negative); those that are
    /// not varied are the base's.
    ///
    /// # Errors
    /// [`CouplingError::Basis`] if the change makes the machine unstable, which no stiffness of zero or above does.
    pub fn coupled(&self, stiffness: &[f64]) -> Result<AroundCoupled, CouplingError> {
        let (s, o) = (self.springs.nrows(), self.outputs.nrows());
        assert_eq!(stiffness.len(), s, "one stiffness a spring");
        let fixed = (0..s).filter(|spring| self.varied.binary_search(spring).is_err());
        for spring in fixed {
            assert_eq!(stiffness[spring], self.base[spring], "spring {spring} does not vary");
        }
        let v = self.varied.len();
        let change: Vec<f64> = self.varied.iter().map(|&i| stiffness[i] - self.base[i]).collect();
        let columns = self.residual.select_columns(&self.varied);
        let own = columns.select_rows(&self.varied);
        let inner = DMatrix::from_fn(v, v, |a, b| change[a] * own[(a, b)] + f64::from(u8::from(a == b)));
        let series = inner
            .lu()
            .solve(&DMatrix::from_diagonal(&DVector::from_vec(change)))
            .ok_or(CouplingError::Basis(LinalgError::Eigen { n: v }))?;
        let series = 0.5 * (&series + series.transpose());
        let elongations = self.springs.select_rows(&self.varied);
        let tension = multiply(&series, &elongations);
        let (out, input) = (columns.rows(s, o).into_owned(), columns.rows_range(s + o..).into_owned());
        let between = self.residual.view((s, s + o), (o, self.inputs.nrows())).into_owned();
        Ok(AroundCoupled {
            stiffness: stiffness.to_vec(),
            outputs: &self.outputs - multiply(&out, &tension),
            inputs: &self.inputs - multiply(&input, &tension),
            direct: between - multiply(&out, &multiply(&series, &input.transpose())),
            tension,
            series,
        })
    }

    /// K = Lambda0 + E^T Delta' E of a design, m x m.
    pub fn stiffness_matrix(&self, design: &AroundCoupled) -> DMatrix<f64> {
        let mut full = multiply_transposed(&self.springs.select_rows(&self.varied), &design.tension);
        full = 0.5 * (&full + full.transpose());
        for (k, value) in self.eigenvalues.iter().enumerate() {
            full[(k, k)] += value;
        }
        full
    }

    /// All modes of a design in the coordinates around its base.
    ///
    /// By the flexibility at the shift s, with L = (Lambda0 + s)^-1: H = L - L E^T X E L and
    /// X = (I + Delta (R + E L E^T))^-1 Delta, so a stiff spring is a small number.
    ///
    /// # Errors
    /// [`LinalgError::Eigen`].
    pub fn eigen(&self, design: &AroundCoupled) -> Result<CoupledEigen, LinalgError> {
        let v = self.varied.len();
        let failed = || LinalgError::Eigen { n: self.n() };
        let compliance: Vec<f64> = self.eigenvalues.iter().map(|l| (l + self.shift).recip()).collect();
        let elongations = self.springs.select_rows(&self.varied);
        let mut weighted = elongations.clone();
        for (mut column, l) in weighted.column_iter_mut().zip(&compliance) {
            column *= *l;
        }
        let own = self.residual.select_columns(&self.varied).select_rows(&self.varied)
            + multiply(&weighted, &elongations.transpose());
        let change: Vec<f64> = self.varied.iter().map(|&i| design.stiffness[i] - self.base[i]).collect();
        let inner = DMatrix::from_fn(v, v, |a, b| change[a] * own[(a, b)] + f64::from(u8::from(a == b)));
        let x = inner.lu().solve(&DMatrix::from_diagonal(&DVector::from_vec(change))).ok_or_else(failed)?;
        let mut flexibility = multiply_transposed(&weighted, &multiply(&(-0.5 * (&x + x.transpose())), &weighted));
        for (k, l) in compliance.iter().enumerate() {
            flexibility[(k, k)] += l;
        }
        let eigen = eigen_of_flexibility(&flexibility, self.shift)?;
        let mut out = CoupledEigen { values: eigen.values, vectors: eigen.vectors, free: self.free_motions_of(design) };
        out.values.rows_mut(0, out.free).fill(0.0);
        Ok(out)
    }

    /// Free motions of a design: the base's, unless a spring came or went.
    fn free_motions_of(&self, design: &AroundCoupled) -> usize {
        let acts = |k: &[f64]| k.iter().map(|k| *k > 0.0).collect::<Vec<_>>();
        if acts(&design.stiffness) == acts(&self.base) {
            return self.free;
        }
        free_motions(&self.rows, &self.rigid, &design.stiffness).ncols()
    }

    /// Loads on springs, outputs and inputs that a design's coordinates, then unit loads on these rows, put on the base:
    /// n_rows x (m + n_rows).
    pub fn loads_of(&self, design: &AroundCoupled) -> DMatrix<f64> {
        let n = self.residual.nrows();
        let varied = multiply(&design.series, &self.residual.select_rows(&self.varied));
        let mut loads = beside(&DMatrix::zeros(n, self.n()), &DMatrix::identity(n, n));
        let tension = beside(&design.tension, &varied);
        for (row, &spring) in self.varied.iter().enumerate() {
            let mut own = loads.row_mut(spring);
            own -= tension.row(row);
        }
        loads
    }

    /// Compliance that no coordinate of a design carries between springs, outputs and inputs, m/N.
    pub fn residual_of(&self, design: &AroundCoupled) -> DMatrix<f64> {
        let varied = self.residual.select_columns(&self.varied);
        &self.residual - multiply(&varied, &multiply(&design.series, &varied.transpose()))
    }

    /// Elongations of all springs for unit coordinates of a design, n_springs x m.
    pub fn elongations(&self, design: &AroundCoupled) -> DMatrix<f64> {
        let flexibility = self.residual.rows(0, self.springs.nrows()).into_owned().select_columns(&self.varied);
        &self.springs - multiply(&flexibility, &design.tension)
    }
}

fn stacked(blocks: &[&DMatrix<f64>]) -> DMatrix<f64> {
    let rows: Vec<_> = blocks.iter().flat_map(|b| b.row_iter()).collect();
    DMatrix::from_rows(&rows)
}

fn beside(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = a.clone().resize_horizontally(a.ncols() + b.ncols(), 0.0);
    out.columns_mut(a.ncols(), b.ncols()).copy_from(b);
    out
}
