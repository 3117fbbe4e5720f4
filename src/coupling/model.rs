//! The coupled machine in its fixed basis.
//!
//! With B, P the rows of springs and ports over the basis, C their residual flexibility and
//! D = diag(k), the springs' forces on the basis are f = D' (B z + C_BP f_P), where
//! D' = (D^-1 + C_BB)^-1 is the joint in series with the residual flexibility. Then
//!
//! ```text
//! z'' + (Lambda + B^T D' B) z = P'^T f_P        P' = P - C_PB D' B
//! u_P = P' z + (C_PP - C_PB D' C_BP) f_P
//! ```

use super::CouplingError;
use super::basis::{BasisOptions, FixedBasis, ResidualEnergy};
use super::eigen::shift_for;
use super::joint::CoupledJoint;
use super::series::Series;
use super::side_by_side::{PortRow, SideBySide};
use crate::linalg::{multiply, multiply_transposed};
use crate::machine::{Axis, Machine};
use crate::reduction::Superelement;
use nalgebra::{DMatrix, DVector, Matrix3};

/// The machine in its fixed basis.
#[derive(Clone, Debug)]
pub struct CoupledModel {
    /// Eigenvalues of the basis's coordinates without joints, (rad/s)^2.
    pub eigenvalues: DVector<f64>,
    /// The machine side by side: joints, ports, counts and checks.
    pub side_by_side: SideBySide,
    /// What free motions and loss factors need to know of each part.
    pub parts: Vec<PartShare>,
    /// Designs may stiffen a joint up to this factor.
    pub stiffest: f64,
    /// The fixed basis was made for results up to this frequency, Hz.
    pub frequency: f64,
    /// Shift of the eigenproblem, (rad/s)^2.
    shift: f64,
    basis: FixedBasis,
}

/// A part's share of the machine's coordinates.
#[derive(Clone, Debug)]
pub struct PartShare {
    /// Name.
    pub name: String,
    /// Structural loss factor, if it has its own.
    pub loss_factor: Option<f64>,
    /// Its rows of the basis, n_part x n.
    pub basis: DMatrix<f64>,
    /// Its stiffness in the basis, n x n, if it has a loss factor.
    pub stiffness: Option<DMatrix<f64>>,
    /// Impulses of its rigid motions about its centre of mass, 6 x n.
    pub impulses: DMatrix<f64>,
    /// Mass, kg.
    pub mass: f64,
    /// Inertia tensor about the centre of mass, kg m^2.
    pub inertia: Matrix3<f64>,
}

/// What the machine is at one position, for any joint stiffness.
#[derive(Clone, Debug)]
pub struct AtPosition {
    /// Position, m.
    pub position: f64,
    /// Spring rows B over the basis, n_springs x n.
    pub springs: DMatrix<f64>,
    /// Output rows over the basis, n_outputs x n.
    pub outputs: DMatrix<f64>,
    /// Input rows over the basis, n_inputs x n.
    pub inputs: DMatrix<f64>,
    /// Residual flexibility between springs, then outputs, then inputs, m/N.
    pub residual: DMatrix<f64>,
    /// A factor T of it, T^T T.
    pub(super) residual_factor: DMatrix<f64>,
    /// The parts' strain energy in the residual response to loads on springs, outputs and inputs, for parts with a loss
    /// factor.
    pub residual_of_part: Vec<Option<ResidualEnergy>>,
}

/// What the springs of a machine are at one position, spring by spring.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpringValues {
    /// Stiffness, N/m or N m/rad.
    pub stiffness: Vec<f64>,
    /// Viscous damping, N s/m or N m s/rad.
    pub damping: Vec<f64>,
    /// Structural loss factor of the joint itself.
    pub loss_factors: Vec<f64>,
}

impl SpringValues {
    /// The springs with a damper, or with a loss factor of their own and a stiffness.
    pub fn dissipating(&self) -> Vec<usize> {
        let acts = |s: &usize| self.damping[*s] > 0.0 || self.loss_factors[*s] > 0.0 && self.stiffness[*s] > 0.0;
        (0..self.stiffness.len()).filter(acts).collect()
    }

    /// Whether any spring has a damper or a loss factor.
    pub fn dissipate(&self) -> bool {
        self.damping.iter().chain(&self.loss_factors).any(|v| *v > 0.0)
    }
}

/// The machine at one position with given joint stiffnesses.
#[derive(Clone, Debug)]
pub struct Coupled {
    /// Rows W over the coordinates, n_active x n, with W^T W = B^T D' B: the joints' share of the stiffness. It is
    /// kept as a factor because a sum keeps only the digits that its largest term leaves.
    pub roots: DMatrix<f64>,
    /// Output rows P', n_outputs x n.
    pub outputs: DMatrix<f64>,
    /// Input rows P', n_inputs x n.
    pub inputs: DMatrix<f64>,
    /// Static compliance that the basis does not carry, n_outputs x n_inputs, m/N.
    pub direct: DMatrix<f64>,
    /// Spring forces for unit coordinates, D' B, n_springs x n.
    pub forces: DMatrix<f64>,
    /// Spring elongations for unit coordinates, (I - C_BB D') B, n_springs x n.
    pub elongations: DMatrix<f64>,
}

/// Couples superelements and forms the fixed basis.
///
/// # Errors
/// [`CouplingError`].
pub fn couple(
    machine: &Machine,
    superelements: &[Superelement],
    options: BasisOptions,
) -> Result<CoupledModel, CouplingError> {
    let side_by_side = SideBySide::new(machine, superelements)?;
    let basis = FixedBasis::new(&side_by_side, options)?;
    let q = basis.matrix();
    let share = |(i, part): (usize, &crate::machine::Part)| {
        let s = &superelements[i];
        let rows = q.rows(side_by_side.first_column[i], s.n()).into_owned();
        let stiffness = part.loss_factor.map(|_| {
            let mut scaled = rows.clone();
            for (mut row, value) in scaled.row_iter_mut().zip(&s.eigenvalues) {
                row *= value.max(0.0).sqrt();
            }
            multiply_transposed(&scaled, &scaled)
        });
        PartShare {
            name: part.name.clone(),
            loss_factor: part.loss_factor,
            impulses: multiply(&s.impulses, &rows),
            basis: rows,
            stiffness,
            mass: s.mass,
            inertia: s.inertia,
        }
    };
    let parts = machine.parts.iter().enumerate().map(share).collect();
    let lowest = side_by_side.lowest_elastic();
    Ok(CoupledModel {
        eigenvalues: basis.eigenvalues.clone(),
        side_by_side,
        parts,
        stiffest: options.stiffest,
        frequency: options.frequency,
        shift: shift_for(options.frequency.max(0.1 * lowest)),
        basis,
    })
}

impl CoupledModel {
    /// Coordinates of the fixed basis.
    pub fn n(&self) -> usize {
        self.eigenvalues.len()
    }

    /// Whether the basis holds every coordinate of the superelements.
    pub fn is_whole(&self) -> bool {
        self.n() >= self.side_by_side.n()
    }

    /// Mode shapes over the basis as shapes over the superelements side by side, with the static response to the
    /// joints' forces that the basis leaves out: n_side_by_side x m.
    ///
    /// # Errors
    /// As [`Self::at`] and [`Self::coupled`].
    pub fn whole_shapes(&self, position: f64, shapes: &DMatrix<f64>) -> Result<DMatrix<f64>, CouplingError> {
        let at = self.at(position)?;
        let coupled = self.coupled(&at, &self.stiffness(position)?)?;
        let forces = multiply(&coupled.forces, shapes);
        let rest = multiply(&self.basis.residual_response(&self.side_by_side.rows(position)?), &forces);
        let mut whole = self.over_parts(shapes);
        for (k, &i) in self.basis.high.iter().enumerate() {
            let mut row = whole.row_mut(i);
            row -= rest.row(k);
        }
        Ok(whole)
    }

    /// Shapes over the basis as shapes over the superelements side by side.
    pub fn over_parts(&self, shapes: &DMatrix<f64>) -> DMatrix<f64> {
        self.basis.over_parts(shapes)
    }

    /// Shift of the eigenproblem, (rad/s)^2.
    pub fn shift(&self) -> f64 {
        self.shift
    }

    /// The axis of travel.
    pub fn axis(&self) -> &Axis {
        &self.side_by_side.axis
    }

    /// The joints.
    pub fn joints(&self) -> &[CoupledJoint] {
        &self.side_by_side.joints
    }

    /// Names of the outputs.
    pub fn output_names(&self) -> Vec<String> {
        self.side_by_side.outputs.iter().map(|p| p.name.clone()).collect()
    }

    /// Names of the inputs.
    pub fn input_names(&self) -> Vec<String> {
        self.side_by_side.inputs.iter().map(|p| p.name.clone()).collect()
    }

    /// Refuses a position outside the travel.
    ///
    /// # Errors
    /// [`CouplingError::OutsideTravel`].
    pub fn check_position(&self, position: f64) -> Result<(), CouplingError> {
        let [from, to] = self.axis().travel;
        let slack = 1e-9;
        if position.is_finite() && position >= from.min(to) - slack && position <= from.max(to) + slack {
            return Ok(());
        }
        Err(CouplingError::OutsideTravel { position, axis: self.axis().name.clone(), from, to })
    }

    /// Stiffness of all springs at a position, N/m or N m/rad.
    ///
    /// # Errors
    /// [`CouplingError::ScrewLength`].
    pub fn stiffness(&self, position: f64) -> Result<Vec<f64>, CouplingError> {
        self.side_by_side.stiffness(position)
    }

    /// What the springs are at a position.
    ///
    /// # Errors
    /// [`CouplingError::ScrewLength`].
    pub fn springs(&self, position: f64) -> Result<SpringValues, CouplingError> {
        let stiffness = self.stiffness(position)?;
        let each = |j: &CoupledJoint| {
            let loss = j.loss_factor.unwrap_or(0.0);
            j.springs.iter().map(|s| (s.damping, loss)).collect::<Vec<_>>()
        };
        let (damping, loss_factors) = self.joints().iter().flat_map(each).unzip();
        Ok(SpringValues { stiffness, damping, loss_factors })
    }

    /// What a machine with other springs, dampers and loss factors than the coupled one gives the springs at a position.
    ///
    /// # Errors
    /// [`CouplingError::ScrewLength`].
    pub fn spring_values(&self, machine: &Machine, position: f64) -> Result<SpringValues, CouplingError> {
        let mut values = SpringValues::default();
        for (coupled, joint) in self.joints().iter().zip(&machine.joints) {
            for (own, spring) in coupled.springs.iter().zip(&joint.springs) {
                values.stiffness.push(coupled.stiffness_of(spring.stiffness, own.direction, position, self.axis())?);
                values.damping.push(spring.damping);
                values.loss_factors.push(joint.loss_factor.unwrap_or(0.0));
            }
        }
        Ok(values)
    }

    /// The machine at a position, for any joint stiffness.
    ///
    /// # Errors
    /// [`CouplingError::OutsideTravel`], [`CouplingError::FootprintLeavesRail`].
    pub fn at(&self, position: f64) -> Result<AtPosition, CouplingError> {
        self.check_position(position)?;
        let machine = &self.side_by_side;
        let springs = machine.rows(position)?;
        let (s, o, i) = (springs.nrows(), machine.outputs.len(), machine.inputs.len());
        let mut rows = springs.resize_vertically(s + o + i, 0.0);
        let ports: Vec<&PortRow> = machine.outputs.iter().chain(&machine.inputs).collect();
        for (k, port) in ports.iter().enumerate() {
            rows.row_mut(s + k).copy_from(&port.row);
        }
        let projected = self.basis.project(&rows);
        let residual_factor = self.basis.residual_factor(&rows);
        let residual_of_part = self.parts.iter().enumerate().map(|(p, part)| {
            part.loss_factor?;
            let first = machine.first_column[p];
            let own = first..first + part.basis.nrows();
            Some(self.basis.residual_energy(&rows, |i| own.contains(&i)))
        });
        Ok(AtPosition {
            position,
            springs: projected.rows(0, s).into_owned(),
            outputs: projected.rows(s, o).into_owned(),
            inputs: projected.rows(s + o, i).into_owned(),
            residual: multiply_transposed(&residual_factor, &residual_factor),
            residual_factor,
            residual_of_part: residual_of_part.collect(),
        })
    }

    /// The residual flexibility of springs, outputs and inputs with all springs in place, C - C_.s D' C_s., m/N.
    ///
    /// # Errors
    /// [`CouplingError::Basis`] if a stiffness is not finite.
    pub fn residual_in_place(&self, at: &AtPosition, stiffness: &[f64]) -> Result<DMatrix<f64>, CouplingError> {
        Ok(Series::new(&at.residual_factor, stiffness)?.residual_in_place(&at.residual_factor))
    }

    /// What acts on the residual flexibility for unit loads on springs, outputs and inputs with all springs in place:
    /// the load itself, less the tension that it makes in the springs; square over these rows.
    ///
    /// # Errors
    /// [`CouplingError::Basis`] if a stiffness is not finite.
    pub fn loads_in_place(&self, at: &AtPosition, stiffness: &[f64]) -> Result<DMatrix<f64>, CouplingError> {
        let (n, s) = (at.residual.nrows(), at.springs.nrows());
        let series = Series::new(&at.residual_factor, stiffness)?.stiffness();
        let mut loads = DMatrix::identity(n, n);
        let tension = multiply(&series, &at.residual.rows(0, s).into_owned());
        let mut own = loads.rows_mut(0, s);
        own -= tension;
        Ok(loads)
    }

    /// The machine at a position with given spring stiffnesses (N/m or N m/rad, not negative).
    ///
    /// # Errors
    /// [`CouplingError::Basis`] if a stiffness is not finite.
    pub fn coupled(&self, at: &AtPosition, stiffness: &[f64]) -> Result<Coupled, CouplingError> {
        let (s, o, i) = (at.springs.nrows(), at.outputs.nrows(), at.inputs.nrows());
        assert_eq!(stiffness.len(), s, "one stiffness a spring");
        let c = |row: usize, rows: usize, column: usize, columns: usize| {
            at.residual.view((row, column), (rows, columns)).into_owned()
        };
        let series = Series::new(&at.residual_factor, stiffness)?;
        let roots = multiply_transposed(&series.root, &at.springs);
        let forces = multiply(&series.root, &roots);
        let (out_spring, spring_in) = (c(s, o, 0, s), c(0, s, s + o, i));
        let in_spring = spring_in.transpose();
        Ok(Coupled {
            outputs: &at.outputs - multiply(&out_spring, &forces),
            inputs: &at.inputs - multiply(&in_spring, &forces),
            direct: c(s, o, s + o, i) - multiply(&out_spring, &multiply(&series.stiffness(), &spring_in)),
            elongations: series.elongations(&at.springs, &c(0, s, 0, s), &forces),
            forces,
            roots,
        })
    }

    /// The rows W of [`Coupled::roots`] in the one form that is smooth over the positions, n_active x n.
    ///
    /// # Errors
    /// [`CouplingError::Basis`] if a stiffness is not finite.
    pub fn smooth_roots(&self, at: &AtPosition, stiffness: &[f64]) -> Result<DMatrix<f64>, CouplingError> {
        Ok(multiply_transposed(&Series::new(&at.residual_factor, stiffness)?.smooth_root(), &at.springs))
    }

    /// K = Lambda + W^T W as one matrix, n x n, for those who need it whole; see [`Coupled::roots`].
    pub fn stiffness_matrix(&self, coupled: &Coupled) -> DMatrix<f64> {
        let mut full = multiply_transposed(&coupled.roots, &coupled.roots);
        for (k, value) in self.eigenvalues.iter().enumerate() {
            full[(k, k)] += value;
        }
        full
    }
}
