//! Checks of the whole travel from the meshes alone.

use super::PipelineError;
use crate::coupling::{CouplingError, check_screw};
use crate::machine::{InterfaceRef, Joint, JointPoint, Machine, Motion, SpringStiffness};
use crate::matrix::GivenNodes;
use crate::mesh::{Mesh, MeshFile};
use crate::solid::interface_motions;

/// Free length of a ball screw at a position, m: its own, or from the interfaces' centroids in the drawn pose.
pub fn screw_length(machine: &Machine, joint: &Joint, centroids: &[Vec<[f64; 3]>], position: f64) -> f64 {
    let axis = &machine.axis;
    let direction = joint.springs.first().map_or(axis.direction, |s| s.direction);
    let drawn = joint.between.map(|side| centroids[side.part][side.interface]);
    let moves = joint.between.map(|side| axis.moves[side.part]);
    let at_zero = joint.springs.iter().find_map(|s| match s.stiffness {
        SpringStiffness::BallScrew { free_length, .. } => free_length,
        SpringStiffness::Constant(_) => None,
    });
    crate::coupling::free_length(drawn, moves, position, axis, direction, at_zero)
}

/// Checks every station of the travel from the meshes alone: footprints on their rails, screws of
/// positive length. Returns what is allowed but worth knowing.
///
/// # Errors
/// [`PipelineError::Coupling`] with the joint and the position.
pub fn check_travel(
    machine: &Machine,
    meshes: &[MeshFile],
    centroids: &[Vec<[f64; 3]>],
) -> Result<Vec<String>, PipelineError> {
    let axis = &machine.axis;
    let mut warnings = Vec::new();
    for joint in &machine.joints {
        for spring in &joint.springs {
            let SpringStiffness::BallScrew { support, .. } = spring.stiffness else { continue };
            for &position in &axis.travel {
                let length = screw_length(machine, joint, centroids, position);
                check_screw(&joint.name, support, position, length)?;
            }
        }
        for side in joint.between {
            check_rotation(machine, joint, side, &meshes[side.part].mesh, centroids)?;
        }
        let Some(footprint) = joint.footprint else { continue };
        let [rail, carriage] = joint.between;
        let part = &machine.parts[rail.part];
        let surface = &interface_motions(part, &meshes[rail.part].mesh)?[rail.interface].0;
        if surface.faces.is_empty() {
            let rail = format!("{}.{}", part.name, part.interfaces[rail.interface].name);
            return Err(CouplingError::RailWithoutSurface { joint: joint.name.clone(), rail }.into());
        }
        let point = match joint.at {
            JointPoint::Point(x) => x,
            JointPoint::Centroid(side) => centroids[joint.between[side].part][joint.between[side].interface],
        };
        let relative = f64::from(axis.moves[carriage.part]) - f64::from(axis.moves[rail.part]);
        let centre = |p: f64| (0..3).map(|c| point[c] * axis.direction[c]).sum::<f64>() + relative * p;
        let extent = surface.extent(axis.direction);
        if let Some(warning) = crate::coupling::overhang(&joint.name, extent, footprint, &axis.stations(), centre)? {
            warnings.push(warning);
        }
    }
    Ok(warnings)
}

/// A single node without rotations must stand at the joint's point at both ends of the travel, and
/// carry no rotational spring.
fn check_rotation(
    machine: &Machine,
    joint: &Joint,
    side: InterfaceRef,
    mesh: &Mesh,
    centroids: &[Vec<[f64; 3]>],
) -> Result<(), PipelineError> {
    let Some(GivenNodes::Point(_)) = mesh.matrices.as_ref().map(|m| &m.interfaces[side.interface]) else {
        return Ok(());
    };
    let part = &machine.parts[side.part];
    if interface_motions(part, mesh)?[side.interface].1.rows.nodes.len() == 2 {
        return Ok(());
    }
    let point = match joint.at {
        JointPoint::Point(x) => x,
        JointPoint::Centroid(s) => centroids[joint.between[s].part][joint.between[s].interface],
    };
    let moves = |s: InterfaceRef| f64::from(machine.axis.moves[s.part]);
    for position in machine.axis.travel {
        let travelled = (moves(joint.between[1]) - moves(side)) * position;
        let node = centroids[side.part][side.interface];
        let offset = |c: usize| point[c] + travelled * machine.axis.direction[c] - node[c];
        let arm = (0..3).map(|c| offset(c).powi(2)).sum::<f64>().sqrt();
        if arm > 1e-6 || joint.springs.iter().any(|s| s.motion == Motion::Rotation) {
            let interface = format!("{}.{}", part.name, part.interfaces[side.interface].name);
            return Err(CouplingError::NoRotation { joint: joint.name.clone(), interface, arm, position }.into());
        }
    }
    Ok(())
}
