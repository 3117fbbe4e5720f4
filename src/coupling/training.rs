//! What each part's reduction has to know of the joints: which interfaces are rails, and the
//! footprints that travel along them.

use crate::machine::{JointPoint, Machine, Motion};
use crate::reduction::{RailSpring, RailTraining, ReductionRequest};
use crate::solid::{InterfaceMotion, Surface};

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
/// `interfaces[part][interface]` are the interfaces' surfaces and motions in the drawn pose, as
/// [`crate::solid::interface_motions`] gives them.
pub fn reduction_requests(machine: &Machine, interfaces: &[Vec<(Surface, InterfaceMotion)>]) -> Vec<ReductionRequest> {
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
            JointPoint::Centroid(side) => {
                interfaces[joint.between[side].part][joint.between[side].interface].1.centroid
            }
        };
        let relative = f64::from(axis.moves[carriage.part]) - f64::from(axis.moves[rail.part]);
        let ends = axis.travel.map(|p| along(point) + relative * p);
        let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let mesh = RailMesh::new(&interfaces[rail.part][rail.interface].0, axis.direction, [from, to], footprint);
        let s0 = along(point);
        let springs = joint.springs.iter().map(|spring| RailSpring {
            point: [0, 1, 2].map(|c| point[c] - s0 * axis.direction[c]),
            direction: spring.direction,
            rotation: spring.motion == Motion::Rotation,
        });
        let centres = mesh.centres(from, to, footprint);
        requests[rail.part].rails.push(RailTraining {
            interface: rail.interface,
            direction: axis.direction,
            footprint,
            centres,
            springs: springs.collect(),
        });
    }
    for request in &mut requests {
        let part = machine.parts.iter().position(|part| part.name == request.part.name);
        let surfaces = part.map_or(&[][..], |part| &interfaces[part]);
        request.rails = merged(std::mem::take(&mut request.rails), surfaces);
    }
    requests
}

/// What the mesh of a rail can tell apart along the travel.
///
/// A footprint shorter than the rail's elements loads them as any other footprint inside the same element does: the
/// weights of its nodes are polynomials of its place there. Footprints closer together than the elements allow
/// would repeat each other, and a footprint of 0.5 mm on elements of 30 mm would ask for sixty times the vectors.
struct RailMesh {
    /// Ranges of the faces along the travel, m; none where footprints are the coarser measure.
    faces: Vec<(f64, f64)>,
}

impl RailMesh {
    /// `range` is where the centres run, m.
    fn new(surface: &Surface, direction: [f64; 3], [from, to]: [f64; 2], footprint: f64) -> Self {
        let mut faces = surface.face_ranges(direction);
        faces.retain(|(lo, hi)| hi > lo && *hi >= from - footprint && *lo <= to + footprint);
        let mean = faces.iter().map(|(lo, hi)| hi - lo).sum::<f64>() / faces.len().max(1) as f64;
        if footprint >= mean {
            faces.clear();
        }
        Self { faces }
    }

    /// Centres of training footprints over a range: evenly spaced by the footprint's length or, where the elements
    /// are longer, by the mean length of those that a footprint there touches. Never more than four an element.
    fn centres(&self, from: f64, to: f64, footprint: f64) -> Vec<f64> {
        if self.faces.is_empty() {
            return evenly(from, to, SPACING * footprint);
        }
        let least = (to - from) / (4 * self.faces.len()) as f64;
        let half = 0.5 * footprint;
        let mut centres = vec![from];
        let mut last = from;
        while last < to {
            let touched = self.faces.iter().filter(|(lo, hi)| *lo <= last + half && *hi >= last - half);
            let (count, sum) = touched.fold((0, 0.0), |(count, sum), (lo, hi)| (count + 1, sum + (hi - lo)));
            let length = if count > 0 { sum / f64::from(count) } else { footprint };
            last = (last + (SPACING * length.max(footprint)).max(least)).min(to);
            centres.push(last);
        }
        centres
    }
}

/// Evenly spaced numbers over a range, its ends among them, at most `spacing` apart.
fn evenly(from: f64, to: f64, spacing: f64) -> Vec<f64> {
    let intervals = ((to - from) / spacing).ceil().max(1.0) as usize;
    (0..=intervals).map(|i| from + (to - from) * i as f64 / intervals as f64).collect()
}

/// Carriages that run on one rail with the same footprint and the same springs share their training.
fn merged(rails: Vec<RailTraining>, surfaces: &[(Surface, InterfaceMotion)]) -> Vec<RailTraining> {
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
            Some(shared) => shared.centres = union(shared, &rail, &surfaces[rail.interface].0),
            None => out.push(rail),
        }
    }
    out
}

/// Centres over the ranges that two trainings of one rail cover; ranges that lie apart stay apart.
fn union(one: &RailTraining, other: &RailTraining, surface: &Surface) -> Vec<f64> {
    let (a, b, footprint) = (&one.centres, &other.centres, one.footprint);
    let spacing = SPACING * footprint;
    let (a0, a1, b0, b1) = (a[0], a[a.len() - 1], b[0], b[b.len() - 1]);
    if a1 + spacing < b0 || b1 + spacing < a0 {
        return a.iter().chain(b).copied().collect();
    }
    let (from, to) = (a0.min(b0), a1.max(b1));
    RailMesh::new(surface, one.direction, [from, to], footprint).centres(from, to, footprint)
}
