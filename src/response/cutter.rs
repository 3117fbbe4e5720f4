//! Where a cutter may act: ports, their directions, and which of them lies along the spindle.

use super::ResponseError;
use crate::machine::{JointKind, Machine, Motion, Part};

/// A port that takes forces.
#[derive(Clone, Debug, PartialEq)]
pub struct CutterPort {
    /// Its name.
    pub name: String,
    /// Its inputs, by name, with their directions.
    pub inputs: Vec<(String, [f64; 3])>,
    /// The axis that the port's part turns about, if it is held by bearings alone.
    pub spindle: Option<[f64; 3]>,
}

impl CutterPort {
    /// The ports of a machine that take forces, with the names that inputs have everywhere.
    pub fn of(machine: &Machine) -> Vec<Self> {
        let one = machine.ports.len() == 1;
        let port = |p: &crate::machine::Port| Self {
            name: p.name.clone(),
            inputs: p
                .directions
                .iter()
                .map(|(d, v)| (if one { d.clone() } else { format!("{}.{d}", p.name) }, *v))
                .collect(),
            spindle: spindle_axis(machine, p.interface.part),
        };
        machine.ports.iter().filter(|p| p.input).map(port).collect()
    }

    /// The inputs across the spindle; none where its axis is not known.
    fn across(&self) -> Vec<&str> {
        let Some(axis) = self.spindle else { return Vec::new() };
        self.inputs.iter().filter(|(_, d)| dot(*d, axis).abs() < PERPENDICULAR).map(|(n, _)| n.as_str()).collect()
    }

    /// Whether an input lies along the spindle.
    pub fn is_along_spindle(&self, input: &str) -> bool {
        let along = |d: [f64; 3]| self.spindle.is_some_and(|axis| dot(d, axis).abs() > 1.0 - PERPENDICULAR);
        self.inputs.iter().any(|(n, d)| n == input && along(*d))
    }
}

/// Cosine below which two directions are perpendicular.
const PERPENDICULAR: f64 = 1e-6;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The axis that a part turns about: parts that are bolted together are one body, and a body that stands on no ground
/// and that bearings alone hold, all about one direction, is a spindle. A spring or damper beside them, such as a belt,
/// changes nothing; a guide or a screw does, as it holds what carries the spindle.
fn spindle_axis(machine: &Machine, part: usize) -> Option<[f64; 3]> {
    let mut body = vec![part];
    let mut at = 0;
    while at < body.len() {
        for joint in machine.joints.iter().filter(|j| j.kind == JointKind::Bolted) {
            let [a, b] = joint.between.map(|side| side.part);
            let other = if a == body[at] { b } else { a };
            if (a == body[at] || b == body[at]) && !body.contains(&other) {
                body.push(other);
            }
        }
        at += 1;
    }
    let grounded = |p: &Part| !p.clamped.is_empty() || !p.supported.is_empty();
    if body.iter().any(|&p| grounded(&machine.parts[p])) {
        return None;
    }
    let mut axis: Option<[f64; 3]> = None;
    for joint in &machine.joints {
        if joint.between.iter().filter(|side| body.contains(&side.part)).count() != 1 {
            continue;
        }
        match joint.kind {
            JointKind::Bearing => {
                let of = bearing_axis(joint)?;
                if axis.is_some_and(|known| dot(known, of).abs() < 1.0 - PERPENDICULAR) {
                    return None;
                }
                axis = Some(of);
            }
            JointKind::LinearGuide | JointKind::BallScrew => return None,
            JointKind::SpringDamper | JointKind::Bolted => {}
        }
    }
    axis
}

/// A bearing's axis: that of its axial spring, or across its two radial ones.
fn bearing_axis(joint: &crate::machine::Joint) -> Option<[f64; 3]> {
    let of = |label: &str| {
        joint.springs.iter().find(|s| s.motion == Motion::Translation && s.label == label).map(|s| s.direction)
    };
    of("axial").or_else(|| Some(cross(of("radial 1")?, of("radial 2")?)))
}

/// Feed and normal input of a cut, each with 1 or -1, from what was given of `port`, `along` and `across` (an input,
/// with a minus where the direction is against it).
///
/// # Errors
/// [`ResponseError::NotAllowed`] with the inputs there are, if one does not exist, both are one, or nothing says which.
pub(super) fn directions(
    ports: &[CutterPort],
    port: Option<&str>,
    along: Option<&str>,
    across: Option<&str>,
) -> Result<[(String, f64); 2], ResponseError> {
    let names = |ports: &[CutterPort]| {
        ports.iter().flat_map(|p| p.inputs.iter().map(|(n, _)| n.as_str())).collect::<Vec<_>>().join(", ")
    };
    let chosen = match port {
        Some(name) => Some(ports.iter().find(|p| p.name == name).ok_or_else(|| {
            let there = ports.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ");
            ResponseError::not_allowed("--milling: port", format!("{name:?}"), format!("a port with inputs: {there}"))
        })?),
        None => {
            let mut turning = ports.iter().filter(|p| p.spindle.is_some());
            turning.next().filter(|_| turning.next().is_none())
        }
    };
    let given = |key: &str, text: Option<&str>| -> Result<Option<(String, f64)>, ResponseError> {
        let Some(text) = text else { return Ok(None) };
        let (name, sign) = text.strip_prefix('-').map_or((text, 1.0), |rest| (rest, -1.0));
        let all = || ports.iter().filter(|p| port.is_none() || chosen == Some(p));
        let is = |p: &CutterPort, n: &str| n == name || n.strip_prefix(&format!("{}.", p.name)) == Some(name);
        // A direction without its port's name is of the port that was chosen.
        let found = all()
            .flat_map(|p| p.inputs.iter().map(move |(n, _)| (p, n)))
            .find(|(p, n)| n.as_str() == name || chosen == Some(*p) && is(p, n));
        let (_, found) = found.ok_or_else(|| {
            let allowed = format!("an input, {}, with a minus for its opposite", names(ports));
            ResponseError::not_allowed(format!("--milling: {key}"), format!("{text:?}"), allowed)
        })?;
        Ok(Some((found.clone(), sign)))
    };
    let (along, across) = (given("along", along)?, given("across", across)?);
    let free = chosen.map(CutterPort::across).unwrap_or_default();
    let other = |than: Option<&(String, f64)>| {
        let mut rest = free.iter().filter(|n| than.is_none_or(|(taken, _)| **n != taken));
        let next = rest.next().map(|n| ((*n).to_owned(), 1.0));
        if than.is_some() && rest.next().is_some() { None } else { next }
    };
    let two = free.len() == 2;
    let unknown = || {
        let why = match chosen {
            Some(_) if two => "the one that was given does not lie across the spindle, so that both are needed",
            Some(p) if p.spindle.is_some() => "the port has not two directions across the spindle",
            Some(_) => "the port's part is not held by bearings alone, so that nothing says where the spindle points",
            None => {
                "not one port alone is on a part that bearings alone hold, so that nothing says which is the tool's"
            }
        };
        let allowed = format!("along=INPUT,across=INPUT (feed and normal direction): {why}; inputs: {}", names(ports));
        ResponseError::not_allowed("--milling", "no directions of the cut", allowed)
    };
    let (feed, normal) = match (along, across) {
        (Some(a), Some(b)) => (a, b),
        (Some(a), None) => (a.clone(), other(Some(&a)).filter(|_| two).ok_or_else(unknown)?),
        (None, Some(b)) => (other(Some(&b)).filter(|_| two).ok_or_else(unknown)?, b),
        (None, None) if two => {
            let a = other(None).ok_or_else(unknown)?;
            (a.clone(), other(Some(&a)).ok_or_else(unknown)?)
        }
        (None, None) => return Err(unknown()),
    };
    if feed.0 == normal.0 {
        return Err(ResponseError::not_allowed("--milling: along and across", feed.0, "two different inputs"));
    }
    Ok([feed, normal])
}
