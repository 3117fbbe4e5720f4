//! One joint in reduced coordinates: its rows and stiffness at any position.

use super::CouplingError;
use crate::machine::{Axis, Contact, JointKind, Motion, ScrewSupport, SpringStiffness};
use crate::reduction::{LEAST_SHARE, ReducedInterface, ReducedRail};
use crate::solid::rotation_arm;
use nalgebra::{DMatrix, RowDVector};

/// A spring of a joint.
#[derive(Clone, Debug)]
pub struct CoupledSpring {
    /// Name within the joint.
    pub label: String,
    /// What it resists.
    pub motion: Motion,
    /// Unit vector.
    pub direction: [f64; 3],
    /// How stiff.
    pub stiffness: SpringStiffness,
    /// Viscous damping, N s/m or N m s/rad.
    pub damping: f64,
}

/// A joint between two sides, over the coordinates of the superelements side by side.
#[derive(Clone, Debug)]
pub struct CoupledJoint {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: JointKind,
    /// Its springs.
    pub springs: Vec<CoupledSpring>,
    /// Structural loss factor, if it has its own.
    pub loss_factor: Option<f64>,
    /// What the time response adds to the springs.
    pub contact: Option<Contact>,
    /// The common point in the drawn pose, m; it travels with side 1.
    pub point: [f64; 3],
    pub(super) sides: [Side; 2],
    pub(super) footprint: Option<f64>,
    /// Centroids of both interfaces in the drawn pose, m.
    pub(super) centroids: [[f64; 3]; 2],
}

/// One side of a joint: which columns it occupies and how its rigid motion is read there.
#[derive(Clone, Debug)]
pub(super) struct Side {
    pub first_column: usize,
    pub moves: bool,
    pub surface: SideSurface,
}

#[derive(Clone, Debug)]
pub(super) enum SideSurface {
    Fixed(ReducedInterface),
    Rail(ReducedRail),
}

impl CoupledJoint {
    /// Rows b(p) of its springs, n_springs x n: motion of side 1 minus motion of side 0 at the joint's point.
    pub(super) fn rows(&self, position: f64, axis: &Axis, n: usize) -> Result<DMatrix<f64>, CouplingError> {
        let mut out = DMatrix::zeros(self.springs.len(), n);
        for (side, sign) in self.sides.iter().zip([-1.0, 1.0]) {
            // The point in the coordinates in which this side's part is drawn.
            let travelled = (f64::from(self.sides[1].moves) - f64::from(side.moves)) * position;
            let point = [0, 1, 2].map(|c| self.point[c] + travelled * axis.direction[c]);
            let footprint;
            let interface = match &side.surface {
                SideSurface::Fixed(interface) => interface,
                SideSurface::Rail(rail) => {
                    footprint = self.footprint_at(rail, point, position, axis)?;
                    &footprint
                }
            };
            let arm = [0, 1, 2].map(|c| point[c] - interface.centroid[c]);
            for (k, spring) in self.springs.iter().enumerate() {
                let d = spring.direction;
                let coefficients = match spring.motion {
                    Motion::Translation => rotation_arm(d, arm),
                    Motion::Rotation => [0.0, 0.0, 0.0, d[0], d[1], d[2]],
                };
                let row = sign * RowDVector::from_row_slice(&coefficients) * &interface.rows;
                let mut target = out.view_mut((k, side.first_column), (1, row.ncols()));
                target += row;
            }
        }
        Ok(out)
    }

    /// The shortest movement along its rail that changes what the joint feels, m: its footprint's length, or the mean
    /// length of the rail's elements if that is longer.
    pub(super) fn told_apart(&self, axis: &Axis) -> Option<f64> {
        let footprint = self.footprint?;
        let on_rail = |side: &Side| match &side.surface {
            SideSurface::Rail(rail) => rail.surface.element_length(axis.direction),
            SideSurface::Fixed(_) => 0.0,
        };
        Some(self.sides.iter().map(on_rail).fold(footprint, f64::max))
    }

    fn footprint_at(
        &self,
        rail: &ReducedRail,
        point: [f64; 3],
        position: f64,
        axis: &Axis,
    ) -> Result<ReducedInterface, CouplingError> {
        let centre = (0..3).map(|c| point[c] * axis.direction[c]).sum::<f64>();
        let length = self.footprint.unwrap_or_default();
        rail.footprint(axis.direction, centre, length).ok_or_else(|| {
            let (rail_from, rail_to) = rail.surface.extent(axis.direction);
            CouplingError::FootprintLeavesRail {
                joint: self.name.clone(),
                position,
                from: centre - 0.5 * length,
                to: centre + 0.5 * length,
                rail_from,
                rail_to,
            }
        })
    }

    /// Free length of a ball screw along a direction, m: `at_zero` at position 0, or as drawn without it.
    pub fn length(&self, position: f64, axis: &Axis, direction: [f64; 3], at_zero: Option<f64>) -> f64 {
        let moves = self.sides.each_ref().map(|side| side.moves);
        free_length(self.centroids, moves, position, axis, direction, at_zero)
    }

    /// Stiffness of each spring, N/m or N m/rad.
    ///
    /// # Errors
    /// [`CouplingError::ScrewLength`] and [`CouplingError::ScrewSpan`] if a screw's free length is not between 0 and
    /// the distance of its supports.
    pub fn stiffness(&self, position: f64, axis: &Axis) -> Result<Vec<f64>, CouplingError> {
        self.springs
            .iter()
            .map(|spring| self.stiffness_of(spring.stiffness, spring.direction, position, axis))
            .collect()
    }

    /// A stiffness as the value at a position, N/m or N m/rad; errors as of [`CoupledJoint::stiffness`].
    pub(super) fn stiffness_of(
        &self,
        stiffness: SpringStiffness,
        direction: [f64; 3],
        position: f64,
        axis: &Axis,
    ) -> Result<f64, CouplingError> {
        match stiffness {
            SpringStiffness::Constant(k) => Ok(k),
            SpringStiffness::BallScrew { young, diameter, free_length, support } => {
                let length = self.length(position, axis, direction, free_length);
                check_screw(&self.name, support, position, length)?;
                Ok(support.stiffness(young, diameter, length))
            }
        }
    }
}

/// Refuses a screw whose nut is not between its supports.
///
/// # Errors
/// [`CouplingError::ScrewLength`], [`CouplingError::ScrewSpan`].
pub(crate) fn check_screw(joint: &str, support: ScrewSupport, position: f64, length: f64) -> Result<(), CouplingError> {
    if length.is_nan() || length <= 0.0 {
        return Err(CouplingError::ScrewLength { joint: joint.to_owned(), position, length });
    }
    match support {
        ScrewSupport::BothEnds { span } if length >= span => {
            Err(CouplingError::ScrewSpan { joint: joint.to_owned(), position, length, span })
        }
        _ => Ok(()),
    }
}

/// Says where a footprint hangs over the end of its rail, if it does anywhere.
///
/// # Errors
/// [`CouplingError::FootprintLeavesRail`] at the first position where too little of it is left.
pub(crate) fn overhang(
    joint: &str,
    (rail_from, rail_to): (f64, f64),
    length: f64,
    positions: &[f64],
    centre: impl Fn(f64) -> f64,
) -> Result<Option<String>, CouplingError> {
    let mut least: Option<(f64, f64)> = None;
    for &position in positions {
        let (from, to) = (centre(position) - 0.5 * length, centre(position) + 0.5 * length);
        let share = ((to.min(rail_to) - from.max(rail_from)) / length).max(0.0);
        if share < LEAST_SHARE {
            return Err(CouplingError::FootprintLeavesRail {
                joint: joint.to_string(),
                position,
                from,
                to,
                rail_from,
                rail_to,
            });
        }
        if share < 1.0 - 1e-9 && least.is_none_or(|(l, _)| share < l) {
            least = Some((share, position));
        }
    }
    Ok(least.map(|(share, position)| {
        format!(
            "joint \"{joint}\": at {position} m only {:.0} % of the footprint lies on the rail; the part on it carries",
            100.0 * share
        )
    }))
}

/// Free length of a screw between two points that are drawn at position 0 and of which each may travel with the
/// axis, m; negative once they have passed each other. `at_zero` takes the place of the drawn distance.
pub(crate) fn free_length(
    drawn: [[f64; 3]; 2],
    moves: [bool; 2],
    position: f64,
    axis: &Axis,
    direction: [f64; 3],
    at_zero: Option<f64>,
) -> f64 {
    let along = |x: [f64; 3]| (0..3).map(|c| x[c] * direction[c]).sum::<f64>();
    let apart = along(drawn[0]) - along(drawn[1]);
    let travelled = along(axis.direction) * position * (f64::from(moves[0]) - f64::from(moves[1]));
    at_zero.unwrap_or(apart.abs()) + travelled * apart.signum()
}
