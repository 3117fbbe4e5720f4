//! What each part's reduction has to know of the joints: which interfaces are rails, and the
//! footprints that travel along them.

use crate::machine::{JointPoint, Machine, Motion};
use crate::reduction::{RailSpring, RailTraining, ReductionRequest};

/// Training footprints lie at most this share of a footprint apart.
///
/// Measured on the bundled mill between the training positions: 1.1 footprints apart leave 8e-4 of
/// a frequency, 0.55 leave 2e-5, 0.28 leave 7e-8.
const SPACING: f64 = 0.28;

/// Where the machine file gives no number, a part's modes are kept up to this multiple of the highest frequency.
///
/// On the bundled mill modes up to 1.5 times a frequency leave some 1e-5 of it, up to twice some 1e-6.
const REACH: f64 = 2.0;

/// One reduction request a part.
///
/// `centroids[part][interface]` are the interfaces' area centroids (m) in the drawn pose.
pub fn reduction_requests(machine: &Machine, centroids: &[Vec<[f64; 3]>]) -> Vec<ReductionRequest> {
    let axis = &machine.axis;
    let along = |x: [f64; 3]| (0..3).map(|c| x[c] * axis.direction[c]).sum::<f64>();
    let component = machine.analysis.component;
    let highest = machine.analysis.frequencies.iter().copied().fold(0.0, f64::max);
    let reach = if component.follows { REACH * highest } else { 0.0 };
    let mut requests: Vec<ReductionRequest> = machine
        .parts
        .iter()
        .map(|part| ReductionRequest { part: part.clone(), component, reach, rails: Vec::new() })
        .collect();
    for joint in &machine.joints {
        let Some(footprint) = joint.footprint else { continue };
        let [rail, carriage] = joint.between;
        let point = match joint.at {
            JointPoint::Point(x) => x,
            JointPoint::Centroid(side) => centroids[joint.between[side].part][joint.between[side].interface],
        };
        let relative = f64::from(axis.moves[carriage.part]) - f64::from(axis.moves[rail.part]);
        let ends = axis.travel.map(|p| along(point) + relative * p);
        let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let intervals = ((to - from) / (SPACING * footprint)).ceil().max(1.0) as usize;
        let s0 = along(point);
        let springs = joint.springs.iter().map(|spring| RailSpring {
            point: [0, 1, 2].map(|c| point[c] - s0 * axis.direction[c]),
            direction: spring.direction,
            rotation: spring.motion == Motion::Rotation,
        });
        let centres = (0..=intervals).map(|i| from + (to - from) * i as f64 / intervals as f64).collect();
        requests[rail.part].rails.push(RailTraining {
            interface: rail.interface,
            direction: axis.direction,
            footprint,
            centres,
            springs: springs.collect(),
        });
    }
    for request in &mut requests {
        request.rails = merged(std::mem::take(&mut request.rails));
    }
    requests
}

/// Carriages that run on one rail with the same footprint and the same springs share their training.
fn merged(rails: Vec<RailTraining>) -> Vec<RailTraining> {
    let mut out: Vec<RailTraining> = Vec::new();
    for rail in rails {
        let same = |a: &RailTraining| {
            a.interface == rail.interface
                && a.footprint == rail.footprint
                && a.springs.len() == rail.springs.len()
                && a.springs.iter().zip(&rail.springs).all(|(a, b)| {
                    let near = (0..3).all(|c| (a.point[c] - b.point[c]).abs() < 1e-3 * rail.footprint);
                    near && a.direction == b.direction && a.rotation == b.rotation
                })
        };
        match out.iter_mut().find(|a| same(a)) {
            Some(shared) => shared.centres = union(&shared.centres, &rail.centres, SPACING * rail.footprint),
            None => out.push(rail),
        }
    }
    out
}

/// Evenly spaced centres over the ranges that two lists cover.
fn union(a: &[f64], b: &[f64], spacing: f64) -> Vec<f64> {
    let (a0, a1, b0, b1) = (a[0], a[a.len() - 1], b[0], b[b.len() - 1]);
    if a1 + spacing < b0 || b1 + spacing < a0 {
        return a.iter().chain(b).copied().collect();
    }
    let (from, to) = (a0.min(b0), a1.max(b1));
    let intervals = ((to - from) / spacing).ceil().max(1.0) as usize;
    (0..=intervals).map(|i| from + (to - from) * i as f64 / intervals as f64).collect()
}
