//! How stiff and how damped the joints are.

use super::Finding;
use super::joints::Place;
use super::motion::{LARGEST_LOSS, loss};
use super::range::{LENGTHS, Usual, number};
use crate::machine::{Contact, Joint, JointKind, Machine, Motion, Spring, SpringStiffness};

const SOFTER: [(f64, &str); 4] = [
    (1e6, "N/m for N/um: a number without quotes is in N/m, write \"150 N/um\""),
    (1e3, "N/mm for N/um"),
    (1e-6, "N/um given twice: the number is already in N/m"),
    (1e-3, "kN/um for N/um"),
];
const STIFFNESS: [(&str, f64); 2] = [("N/m", 1.0), ("N/um", 1e6)];
const TURNING: [(f64, &str); 4] = [
    (1e3, "kN m/rad given as N m/rad"),
    (1e6, "MN m/rad given as N m/rad"),
    (1e-3, "N mm/rad given as N m/rad"),
    (1e-6, "N um/rad given as N m/rad"),
];

/// A carriage of a rail has 50 to 5000 N/um; small aerostatic and large hydrostatic guides are a factor beyond.
const GUIDE: Usual = Usual { from: 2e5, to: 1e11, units: &STIFFNESS, of: "a guide's stiffness", slips: &SOFTER };
/// Radially 20 to 5000 N/um; magnetic and small air bearings are softer.
const RADIAL: Usual =
    Usual { from: 2e5, to: 1e11, units: &STIFFNESS, of: "a bearing's radial stiffness", slips: &SOFTER };
/// A floating bearing is held axially by a preload spring alone.
const AXIAL: Usual =
    Usual { from: 1e3, to: 1e11, units: &STIFFNESS, of: "a bearing's axial stiffness", slips: &SOFTER };
/// Bolted faces have 100 to 50,000 N/um, and are written stiffer where they shall count as rigid.
const BOLTED: Usual =
    Usual { from: 2e5, to: 1e14, units: &STIFFNESS, of: "a bolted joint's stiffness", slips: &SOFTER };
/// Hoses, mounts, struts, linear motors.
const SPRING: Usual = Usual { from: 1.0, to: 1e14, units: &STIFFNESS, of: "a spring's stiffness", slips: &SOFTER };
/// Springs about an axis, of joints that are screwed or roll.
const ROTATION: Usual =
    Usual { from: 10.0, to: 1e13, units: &[("N m/rad", 1.0)], of: "a joint's rotational stiffness", slips: &TURNING };
/// The same of a spring-damper, which may be a hose.
const TURNING_SPRING: Usual =
    Usual { from: 1e-3, to: 1e13, units: &[("N m/rad", 1.0)], of: "a spring's rotational stiffness", slips: &TURNING };

/// A damper's c / (2 sqrt(k m)) with the stiffness beside it and the heavier part that moves. Joints of machines have
/// 0.001 to 0.1, squeeze-film dampers up to 1.
const LARGEST_RATIO: f64 = 5.0;

/// Friction of all guides of a machine is below 10 kN.
const FRICTION: Usual = Usual {
    from: 0.0,
    to: 1e5,
    units: &[("N", 1.0), ("kN", 1e3)],
    of: "a guide's friction",
    slips: &[(1e-3, "N for kN, or mN for N")],
};
/// The Stribeck speed of a guide is 0.1 to 50 mm/s.
const STRIBECK: Usual = Usual {
    from: 1e-7,
    to: 2.0,
    units: &[("um/s", 1e-6), ("mm/s", 1e-3), ("m/s", 1.0)],
    of: "a guide's Stribeck speed",
    slips: &[(1e-3, "m/s for mm/s: a number without quotes is in m/s, write \"5 mm/s\"")],
};
/// The backlash of a worn screw is 0.1 mm.
const BACKLASH: Usual = Usual {
    from: 0.0,
    to: 2e-3,
    units: &LENGTHS,
    of: "a screw's backlash",
    slips: &[
        (1e-3, "mm for um: write \"10 um\""),
        (1e-6, "metres for micrometres: a number without quotes is in m, write \"10 um\""),
    ],
};

pub(super) fn findings(at: &Place<'_>) -> Vec<Finding> {
    let mut found = Vec::new();
    for spring in at.joint.springs.iter().filter(|spring| spring.label != "radial 2") {
        if let SpringStiffness::Constant(k) = spring.stiffness
            && k != 0.0
        {
            found.extend(
                usual(at.joint.kind, spring).check(|| format!("{}{}", at.key, key("stiffness", at, spring)), k),
            );
        }
        found.extend(damper(at, spring));
    }
    found.extend(at.joint.loss_factor.and_then(|eta| loss(format!("{}.loss_factor", at.key), eta, LARGEST_LOSS)));
    match at.joint.contact {
        Some(Contact::Friction(law)) => {
            let key = |name: &str| format!("{}.friction.{name}", at.key);
            found.extend(FRICTION.check(|| key("coulomb"), law.coulomb));
            if law.breakaway != law.coulomb {
                found.extend(FRICTION.check(|| key("breakaway"), law.breakaway));
                found.extend(STRIBECK.check(|| key("stribeck"), law.stribeck));
            }
        }
        Some(Contact::Backlash(gap)) => found.extend(BACKLASH.check(|| format!("{}.backlash", at.key), gap)),
        None => {}
    }
    found
}

fn usual(kind: JointKind, spring: &Spring) -> &'static Usual {
    match (kind, spring.motion) {
        (JointKind::SpringDamper, Motion::Rotation) => &TURNING_SPRING,
        (_, Motion::Rotation) => &ROTATION,
        (JointKind::LinearGuide, _) => &GUIDE,
        (JointKind::Bearing, _) if spring.label == "axial" => &AXIAL,
        (JointKind::Bearing, _) => &RADIAL,
        (JointKind::Bolted, _) => &BOLTED,
        (JointKind::SpringDamper | JointKind::BallScrew, _) => &SPRING,
    }
}

/// `.stiffness.x` as the machine file has it; a single spring along `direction` and a screw have plain values.
fn key(table: &str, at: &Place<'_>, spring: &Spring) -> String {
    let plain = matches!(at.joint.kind, JointKind::SpringDamper | JointKind::BallScrew) && spring.label == "axial";
    let label = if spring.label == "radial 1" { "radial" } else { &spring.label };
    if plain { format!(".{table}") } else { format!(".{table}.{label}") }
}

/// A damper beside which the parts could not swing.
fn damper(at: &Place<'_>, spring: &Spring) -> Option<Finding> {
    if spring.damping == 0.0 {
        return None;
    }
    // A stiffness that is told to be wrong says nothing about its damper.
    let range = usual(at.joint.kind, spring);
    let stiffness = beside(at.machine, at.joint, spring).filter(|k| (range.from..=range.to).contains(k))?;
    let inertia = inertia(at, spring.motion);
    let ratio = spring.damping / (2.0 * (stiffness * inertia).sqrt());
    if !ratio.is_finite() || ratio <= LARGEST_RATIO {
        return None;
    }
    let (unit, of) = match spring.motion {
        Motion::Translation => ("N s/m", format!("{} kg on {} N/um", number(inertia), number(stiffness * 1e-6))),
        Motion::Rotation => ("N m s/rad", format!("{} kg m2 on {} N m/rad", number(inertia), number(stiffness))),
    };
    let critical = 2.0 * (stiffness * inertia).sqrt();
    Some(Finding {
        key: format!("{}{}", at.key, key("damping", at, spring)),
        seen: format!("{} {unit}, a damping ratio of {} for {of}", number(spring.damping), number(ratio)),
        usual: format!("0.001 to 0.1 of the critical {} {unit}, at most {LARGEST_RATIO} times it", number(critical)),
        slip: "likely N s/mm for N s/m".to_owned(),
    })
}

/// Stiffness that acts beside a damper: its own spring's, else the stiffest of its joint, else of the machine.
fn beside(machine: &Machine, joint: &Joint, spring: &Spring) -> Option<f64> {
    let stiffest = |joint: &Joint| {
        let same = joint.springs.iter().filter(|s| s.motion == spring.motion);
        same.map(|s| stiffness(machine, s)).fold(0.0, f64::max)
    };
    let own = [stiffness(machine, spring), stiffest(joint)].into_iter().find(|k| *k > 0.0);
    own.or_else(|| machine.joints.iter().map(stiffest).max_by(f64::total_cmp).filter(|k| *k > 0.0))
}

/// Stiffness of a spring, of a screw with some length that it may have.
fn stiffness(machine: &Machine, spring: &Spring) -> f64 {
    match spring.stiffness {
        SpringStiffness::Constant(k) => k,
        SpringStiffness::BallScrew { young, diameter, free_length, .. } => {
            let travel = (machine.axis.travel[1] - machine.axis.travel[0]).abs();
            let length = free_length.unwrap_or(travel).max(diameter);
            young * std::f64::consts::PI * diameter * diameter / (4.0 * length)
        }
    }
}

/// Mass, kg, or moment of inertia, kg m^2, of the heavier of the parts that can move.
fn inertia(at: &Place<'_>, motion: Motion) -> f64 {
    let parts = at.joint.between.map(|side| &at.survey.parts[side.part]);
    let free = parts.iter().filter(|part| !part.held);
    let all = if parts.iter().all(|part| part.held) { parts.to_vec() } else { free.copied().collect() };
    all.iter()
        .map(|part| match motion {
            Motion::Translation => part.mass,
            Motion::Rotation => part.mass * part.size().powi(2) / 12.0,
        })
        .fold(0.0, f64::max)
}
