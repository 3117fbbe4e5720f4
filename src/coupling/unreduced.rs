//! The machine at one position before any reduction: its springs as rows over the meshes' nodes.
//!
//! What [`super::couple`] does with superelements is said here with the parts' own displacements, for
//! exports that another solver can check: interface motions q = W u (the same area weights), and
//! springs whose elongation is a combination of the motions of two interfaces.

use super::CouplingError;
use super::joint::{check_screw, free_length};
use crate::machine::{JointPoint, Machine, Motion, SpringStiffness, SurfaceCoupling};
use crate::mesh::Mesh;
use crate::reduction::LEAST_SHARE;
use crate::solid::{InterfaceMotion, Surface, rotation_arm};

/// An interface, or the footprint of a carriage on a rail, with its motion over the part's nodes.
#[derive(Clone, Debug)]
pub struct PlacedInterface {
    /// `part.interface`, for a footprint with the joint's name.
    pub name: String,
    /// Part.
    pub part: usize,
    /// Its rigid motion, in the coordinates in which the part is drawn.
    pub motion: InterfaceMotion,
    /// Whether its nodes follow a rigid surface.
    pub rigid: bool,
}

/// A spring between two interfaces.
#[derive(Clone, Debug)]
pub struct PlacedSpring {
    /// `joint, label`.
    pub name: String,
    /// N/m or N m/rad.
    pub stiffness: f64,
    /// For each side its interface, as an index into [`Unreduced::interfaces`], and the coefficients of
    /// the elongation over that interface's three translations and three rotations.
    pub sides: [(usize, [f64; 6]); 2],
}

/// The springs of a machine at one position, over the parts' nodes.
#[derive(Clone, Debug)]
pub struct Unreduced {
    /// Position, m.
    pub position: f64,
    /// By how much each part is moved from where it is drawn, m.
    pub moved: Vec<[f64; 3]>,
    /// Every interface of every part, then the footprints.
    pub interfaces: Vec<PlacedInterface>,
    /// Index into `interfaces` of the first one of each part.
    pub first_interface: Vec<usize>,
    /// Springs with a stiffness above zero.
    pub springs: Vec<PlacedSpring>,
}

impl Unreduced {
    /// The elongation of a spring over the nodes' displacements: (part, node, component, coefficient).
    pub fn elongation(&self, spring: &PlacedSpring) -> Vec<(usize, usize, usize, f64)> {
        let mut out = Vec::new();
        for (interface, coefficients) in &spring.sides {
            let placed = &self.interfaces[*interface];
            let rows = &placed.motion.rows;
            for (k, &node) in rows.nodes.iter().enumerate() {
                for c in 0..3 {
                    let value = (0..6).map(|q| coefficients[q] * rows.rows[(q, 3 * k + c)]).sum::<f64>();
                    out.push((placed.part, node, c, value));
                }
            }
        }
        out
    }
}

/// The machine's springs at a position; `surfaces[part]` are the interfaces of each part.
///
/// # Errors
/// [`CouplingError::OutsideTravel`], [`CouplingError::FootprintLeavesRail`],
/// [`CouplingError::ScrewLength`].
pub fn unreduced(
    machine: &Machine,
    meshes: &[&Mesh],
    surfaces: &[Vec<(Surface, InterfaceMotion)>],
    position: f64,
) -> Result<Unreduced, CouplingError> {
    let axis = &machine.axis;
    let [from, to] = axis.travel;
    if !(from.min(to) - 1e-9..=from.max(to) + 1e-9).contains(&position) {
        return Err(CouplingError::OutsideTravel { position, axis: axis.name.clone(), from, to });
    }
    let along = |x: [f64; 3]| (0..3).map(|c| x[c] * axis.direction[c]).sum::<f64>();
    let mut interfaces = Vec::new();
    let mut first_interface = Vec::new();
    for (p, (part, own)) in machine.parts.iter().zip(surfaces).enumerate() {
        first_interface.push(interfaces.len());
        interfaces.extend(part.interfaces.iter().zip(own).map(|(interface, (_, motion))| PlacedInterface {
            name: format!("{}.{}", part.name, interface.name),
            part: p,
            motion: motion.clone(),
            rigid: interface.coupling == SurfaceCoupling::Rigid,
        }));
    }
    let mut springs = Vec::new();
    for joint in &machine.joints {
        let drawn = joint.between.map(|side| surfaces[side.part][side.interface].1.centroid);
        let moves = joint.between.map(|side| axis.moves[side.part]);
        let point = match joint.at {
            JointPoint::Point(x) => x,
            JointPoint::Centroid(side) => drawn[side],
        };
        // The point in the coordinates in which each side's part is drawn.
        let points = moves.map(|own| {
            let travelled = (f64::from(moves[1]) - f64::from(own)) * position;
            [0, 1, 2].map(|c| point[c] + travelled * axis.direction[c])
        });
        let mut sides = joint.between.map(|side| first_interface[side.part] + side.interface);
        if let Some(length) = joint.footprint {
            let rail = joint.between[0];
            let (surface, mesh) = (&surfaces[rail.part][rail.interface].0, meshes[rail.part]);
            let centre = along(points[0]);
            let (rail_from, rail_to) = surface.extent(axis.direction);
            let (start, end) = (centre - 0.5 * length, centre + 0.5 * length);
            let weights = surface.weights_in_slab(axis.direction, centre, length);
            let share = (end.min(rail_to) - start.max(rail_from)) / length;
            let motion =
                if share < LEAST_SHARE { None } else { InterfaceMotion::from_weights(&weights, |n| mesh.nodes[n]) };
            let motion = motion.ok_or_else(|| CouplingError::FootprintLeavesRail {
                joint: joint.name.clone(),
                position,
                from: start,
                to: end,
                rail_from,
                rail_to,
            })?;
            let (part, whole) = (rail.part, &interfaces[sides[0]]);
            let name = format!("{} under {}", whole.name, joint.name);
            // A rigid rail moves as a whole; its motion is that of the whole surface.
            let placed = PlacedInterface { name, part, motion, rigid: false };
            sides[0] = interfaces.len();
            interfaces.push(placed);
        }
        for spring in &joint.springs {
            let stiffness = match spring.stiffness {
                SpringStiffness::Constant(k) => k,
                SpringStiffness::BallScrew { young, diameter, free_length: at_zero, support } => {
                    let length = free_length(drawn, moves, position, axis, spring.direction, at_zero);
                    check_screw(&joint.name, support, position, length)?;
                    support.stiffness(young, diameter, length)
                }
            };
            if stiffness <= 0.0 {
                continue;
            }
            let d = spring.direction;
            let side = |s: usize| {
                let sign = [-1.0, 1.0][s];
                let centroid = interfaces[sides[s]].motion.centroid;
                let coefficients = match spring.motion {
                    Motion::Translation => rotation_arm(d, [0, 1, 2].map(|c| points[s][c] - centroid[c])),
                    Motion::Rotation => [0.0, 0.0, 0.0, d[0], d[1], d[2]],
                };
                (sides[s], coefficients.map(|c| sign * c))
            };
            let name = format!("{}, {}", joint.name, spring.label);
            springs.push(PlacedSpring { name, stiffness, sides: [side(0), side(1)] });
        }
    }
    let moved = axis.moves.iter().map(|&own| axis.direction.map(|d| f64::from(own) * position * d)).collect();
    Ok(Unreduced { position, moved, interfaces, first_interface, springs })
}
