//! Superelements side by side: the machine before its fixed basis, and the oracle for it.

use super::CouplingError;
use super::joint::{CoupledJoint, CoupledSpring, Side, SideSurface, overhang};
use crate::linalg::{
    count_negative, eigen_of_flexibility, independent_rows, lower_rows, multiply, multiply_transposed, orthonormal,
};
use crate::machine::{Axis, JointPoint, Machine};
use crate::reduction::Superelement;
use crate::solid::rotation_arm;
use nalgebra::{DMatrix, DVector, RowDVector};

/// A direction of a port in reduced coordinates.
#[derive(Clone, Debug)]
pub struct PortRow {
    /// `port.direction`, or the direction alone when the machine has one port.
    pub name: String,
    /// Row over the reduced coordinates.
    pub row: RowDVector<f64>,
}

/// Superelements side by side, with the joints that couple them.
#[derive(Clone, Debug)]
pub struct SideBySide {
    /// Ritz values of all superelements, (rad/s)^2.
    pub eigenvalues: DVector<f64>,
    /// First column of each part.
    pub first_column: Vec<usize>,
    /// Joints.
    pub joints: Vec<CoupledJoint>,
    /// Axis of travel.
    pub axis: Axis,
    /// Outputs.
    pub outputs: Vec<PortRow>,
    /// Inputs.
    pub inputs: Vec<PortRow>,
}

impl SideBySide {
    /// Couples superelements as the machine says.
    ///
    /// # Errors
    /// [`CouplingError`] if a footprint leaves its rail or a screw's length is not positive at a
    /// station of the travel.
    pub fn new(machine: &Machine, superelements: &[Superelement]) -> Result<Self, CouplingError> {
        let mut first_column = vec![0];
        for s in superelements {
            first_column.push(first_column[first_column.len() - 1] + s.n());
        }
        let n = first_column.pop().unwrap_or(0);
        let eigenvalues = DVector::from_iterator(n, superelements.iter().flat_map(|s| s.eigenvalues.iter().copied()));
        let joints = machine.joints.iter().map(|joint| {
            let side = |s: usize| {
                let at = joint.between[s];
                let part = &superelements[at.part];
                let rail =
                    part.rails.iter().find(|r| s == 0 && joint.footprint.is_some() && r.interface == at.interface);
                Side {
                    first_column: first_column[at.part],
                    moves: machine.axis.moves[at.part],
                    surface: rail.map_or_else(
                        || SideSurface::Fixed(part.interfaces[at.interface].clone()),
                        |rail| SideSurface::Rail(rail.clone()),
                    ),
                }
            };
            let centroids =
                [0, 1].map(|s| superelements[joint.between[s].part].interfaces[joint.between[s].interface].centroid);
            CoupledJoint {
                name: joint.name.clone(),
                kind: joint.kind,
                springs: joint
                    .springs
                    .iter()
                    .map(|s| CoupledSpring {
                        label: s.label.clone(),
                        motion: s.motion,
                        direction: s.direction,
                        stiffness: s.stiffness,
                        damping: s.damping,
                    })
                    .collect(),
                loss_factor: joint.loss_factor,
                contact: joint.contact,
                point: match joint.at {
                    JointPoint::Point(x) => x,
                    JointPoint::Centroid(side) => centroids[side],
                },
                sides: [side(0), side(1)],
                footprint: joint.footprint,
                centroids,
            }
        });
        let joints = joints.collect();
        let port_rows = |wanted: fn(&crate::machine::Port) -> bool| {
            let mut rows = Vec::new();
            for port in machine.ports.iter().filter(|p| wanted(p)) {
                let interface = &superelements[port.interface.part].interfaces[port.interface.interface];
                for (label, direction) in &port.directions {
                    let coefficients = RowDVector::from_row_slice(&rotation_arm(*direction, [0.0; 3]));
                    let mut row = RowDVector::zeros(n);
                    let local = coefficients * &interface.rows;
                    row.columns_mut(first_column[port.interface.part], local.ncols()).copy_from(&local);
                    let name = if machine.ports.len() == 1 { label.clone() } else { format!("{}.{label}", port.name) };
                    rows.push(PortRow { name, row });
                }
            }
            rows
        };
        let (outputs, inputs) = (port_rows(|p| p.output), port_rows(|p| p.input));
        let model = Self { eigenvalues, first_column, joints, axis: machine.axis.clone(), outputs, inputs };
        for position in machine.axis.stations() {
            model.stiffness(position)?;
            model.rows(position)?;
        }
        Ok(model)
    }

    /// The joints whose footprints hang over the end of their rail somewhere in the travel, in words.
    pub fn overhangs(&self) -> Vec<String> {
        let stations = self.axis.stations();
        let one = |joint: &CoupledJoint| {
            let SideSurface::Rail(rail) = &joint.sides[0].surface else { return None };
            let relative = f64::from(joint.sides[1].moves) - f64::from(joint.sides[0].moves);
            let along = |x: [f64; 3]| (0..3).map(|c| x[c] * self.axis.direction[c]).sum::<f64>();
            let centre = |p: f64| along(joint.point) + relative * p;
            overhang(&joint.name, rail.surface.extent(self.axis.direction), joint.footprint?, &stations, centre)
                .ok()
                .flatten()
        };
        self.joints.iter().filter_map(one).collect()
    }

    /// Lowest elastic frequency of any part on its own, Hz.
    pub fn lowest_elastic(&self) -> f64 {
        let lowest = self.eigenvalues.iter().copied().filter(|l| *l > 0.0).fold(f64::INFINITY, f64::min);
        if lowest.is_finite() { lowest.sqrt() / std::f64::consts::TAU } else { 1.0 }
    }

    /// Coordinates.
    pub fn n(&self) -> usize {
        self.eigenvalues.len()
    }

    /// Rows B(p) of all springs, n_springs x n.
    ///
    /// # Errors
    /// [`CouplingError::FootprintLeavesRail`].
    pub fn rows(&self, position: f64) -> Result<DMatrix<f64>, CouplingError> {
        stacked_rows(&self.joints, &self.axis, position, self.n())
    }

    /// Stiffness of all springs, N/m or N m/rad.
    ///
    /// # Errors
    /// [`CouplingError::ScrewLength`].
    pub fn stiffness(&self, position: f64) -> Result<Vec<f64>, CouplingError> {
        all_stiffness(&self.joints, &self.axis, position)
    }

    /// K(p), n x n.
    ///
    /// # Errors
    /// As [`Self::rows`] and [`Self::stiffness`].
    pub fn coupled_stiffness(&self, position: f64) -> Result<DMatrix<f64>, CouplingError> {
        Ok(coupled(&self.eigenvalues, &self.rows(position)?, &self.stiffness(position)?))
    }

    /// Number of coupled eigenvalues below `shift` (rad/s)^2, by the inertia of the pieces:
    /// #{Lambda_i < shift} minus the negative eigenvalues of G^-1 + V^T (Lambda - shift)^-1 V, where
    /// B^T diag(k) B = V G V^T.
    ///
    /// V are independent directions of the springs' rows: of two stiff springs that do the same, the difference
    /// would be rounding, and its sign chance.
    ///
    /// # Errors
    /// As [`Self::rows`] and [`Self::stiffness`].
    pub fn count_below(&self, position: f64, shift: f64) -> Result<usize, CouplingError> {
        let (v, inverse) = independent_rows(&self.roots(position)?)?;
        let mut weighted = v.clone();
        for (mut row, l) in weighted.row_iter_mut().zip(&self.eigenvalues) {
            row /= l - shift;
        }
        let mut small = inverse + multiply_transposed(&v, &weighted);
        // Scaled to a unit diagonal, which leaves the signs and brings bolts and mounts together.
        let scale: Vec<f64> = small.diagonal().iter().map(|d| d.abs().sqrt().max(f64::MIN_POSITIVE).recip()).collect();
        for (i, a) in scale.iter().enumerate() {
            for (j, b) in scale.iter().enumerate() {
                small[(i, j)] *= a * b;
            }
        }
        let uncoupled = self.eigenvalues.iter().filter(|l| **l < shift).count();
        Ok(uncoupled.saturating_sub(count_negative(&(0.5 * (&small + small.transpose())))?))
    }

    /// Rows sqrt(k) b of the springs with a stiffness, n_active x n.
    fn roots(&self, position: f64) -> Result<DMatrix<f64>, CouplingError> {
        let rows = self.rows(position)?;
        let stiffness = self.stiffness(position)?;
        let active: Vec<usize> = (0..stiffness.len()).filter(|&s| stiffness[s] > 0.0).collect();
        Ok(DMatrix::from_fn(active.len(), self.n(), |s, i| stiffness[active[s]].sqrt() * rows[(active[s], i)]))
    }

    /// The coupled eigenvalues (rad/s)^2, ascending, next to which the columns of `start` (n x m) lie: inverse
    /// iteration of all of them at once with the shift (rad/s)^2. Zero for free motions but for rounding.
    ///
    /// # Errors
    /// As [`Self::rows`] and [`Self::stiffness`]; [`CouplingError::Basis`] if the small eigenproblem fails.
    pub fn eigenvalues_near(
        &self,
        position: f64,
        start: &DMatrix<f64>,
        shift: f64,
    ) -> Result<DVector<f64>, CouplingError> {
        let root: Vec<f64> = self.eigenvalues.iter().map(|l| (l + shift).sqrt().recip()).collect();
        let lower = lower_rows(&root, &self.roots(position)?)?;
        let scaled = |x: &DMatrix<f64>| {
            let mut x = x.clone();
            for (mut row, r) in x.row_iter_mut().zip(&root) {
                row *= *r;
            }
            x
        };
        let flexibility = |x: &DMatrix<f64>| {
            let x = scaled(x);
            scaled(&(&x - multiply(&lower, &multiply_transposed(&lower, &x))))
        };
        let mut x = flexibility(start);
        for _ in 1..STEPS {
            x = flexibility(&orthonormal(&x));
        }
        x = orthonormal(&x);
        let ritz = multiply_transposed(&x, &flexibility(&x));
        Ok(eigen_of_flexibility(&ritz, shift)?.values)
    }
}

/// Steps of the inverse iteration: modes of the fixed basis are 1e-5 from those that they are compared
/// with, and each step squares what is left of the others.
const STEPS: usize = 2;

/// diag(lambda) + B^T diag(k) B.
fn coupled(eigenvalues: &DVector<f64>, rows: &DMatrix<f64>, stiffness: &[f64]) -> DMatrix<f64> {
    let mut scaled = rows.clone();
    for (mut row, k) in scaled.row_iter_mut().zip(stiffness) {
        row *= k.sqrt();
    }
    let mut out = scaled.transpose() * &scaled;
    for (i, value) in eigenvalues.iter().enumerate() {
        out[(i, i)] += value;
    }
    out
}

fn stacked_rows(joints: &[CoupledJoint], axis: &Axis, position: f64, n: usize) -> Result<DMatrix<f64>, CouplingError> {
    let mut out = DMatrix::zeros(joints.iter().map(|j| j.springs.len()).sum(), n);
    let mut at = 0;
    for joint in joints {
        out.rows_mut(at, joint.springs.len()).copy_from(&joint.rows(position, axis, n)?);
        at += joint.springs.len();
    }
    Ok(out)
}

fn all_stiffness(joints: &[CoupledJoint], axis: &Axis, position: f64) -> Result<Vec<f64>, CouplingError> {
    let mut out = Vec::new();
    for joint in joints {
        out.extend(joint.stiffness(position, axis)?);
    }
    Ok(out)
}
