//! A machine that stays at one position: every guide's footprint becomes an interface of its own.
//!
//! So a footprint can be rigid too, which a rail as a whole must not be.

use super::CouplingError;
use crate::machine::{JointPoint, Machine, Region, SurfaceCoupling};

/// The machine at a position, with all interfaces that joints use coupled in one way.
///
/// `centroids[part][interface]` are the interfaces' area centroids (m) in the drawn pose. With rigid
/// interfaces every frequency is at least that with distributing ones: the same springs read the same
/// motions, on fewer displacements.
///
/// # Errors
/// [`CouplingError::OutsideTravel`]; [`CouplingError::TravelAcross`] for a guide along no global axis.
pub fn at_fixed_position(
    machine: &Machine,
    centroids: &[Vec<[f64; 3]>],
    position: f64,
    coupling: SurfaceCoupling,
) -> Result<Machine, CouplingError> {
    let axis = &machine.axis;
    let [from, to] = axis.travel;
    if !(from.min(to) - 1e-9..=from.max(to) + 1e-9).contains(&position) {
        return Err(CouplingError::OutsideTravel { position, axis: axis.name.clone(), from, to });
    }
    let mut fixed = machine.clone();
    fixed.axis.travel = [position; 2];
    for joint in &mut fixed.joints {
        let moves = joint.between.map(|side| f64::from(axis.moves[side.part]));
        let point = match joint.at {
            JointPoint::Point(x) => x,
            JointPoint::Centroid(side) => centroids[joint.between[side].part][joint.between[side].interface],
        };
        joint.at = JointPoint::Point(point);
        if let Some(length) = joint.footprint.take() {
            let along = (0..3).find(|&c| axis.direction[c].abs() > 1.0 - 1e-9);
            let along = along.ok_or_else(|| CouplingError::TravelAcross { joint: joint.name.clone() })?;
            let rail = &mut joint.between[0];
            let centre = point[along] + axis.direction[along] * (moves[1] - moves[0]) * position;
            let interfaces = &mut fixed.parts[rail.part].interfaces;
            let mut footprint = interfaces[rail.interface].clone();
            let mut region =
                footprint.within.unwrap_or(Region { min: [f64::NEG_INFINITY; 3], max: [f64::INFINITY; 3] });
            region.min[along] = region.min[along].max(centre - 0.5 * length);
            region.max[along] = region.max[along].min(centre + 0.5 * length);
            footprint.within = Some(region);
            footprint.name = format!("{} under {}", footprint.name, joint.name);
            rail.interface = interfaces.len();
            interfaces.push(footprint);
        }
    }
    let given = fixed.parts.iter_mut().filter_map(|p| Some((p.interfaces.len(), p.matrices.as_mut()?)));
    given.for_each(|(n, matrices)| matrices.interfaces.resize_with(n, Default::default));
    for joint in &fixed.joints {
        for side in joint.between {
            fixed.parts[side.part].interfaces[side.interface].coupling = coupling;
        }
    }
    // A rail as a whole, now without a joint, stays as it moves.
    let used = |part, interface| {
        fixed.joints.iter().any(|j| j.between.iter().any(|s| (s.part, s.interface) == (part, interface)))
    };
    let unused: Vec<(usize, usize)> = fixed
        .parts
        .iter()
        .enumerate()
        .flat_map(|(p, part)| (0..part.interfaces.len()).map(move |i| (p, i)))
        .filter(|&(p, i)| !used(p, i))
        .collect();
    for (part, interface) in unused {
        fixed.parts[part].interfaces[interface].coupling = SurfaceCoupling::Distributing;
    }
    Ok(fixed)
}
