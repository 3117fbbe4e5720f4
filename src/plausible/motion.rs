//! Travel, frequencies, damping of the whole machine, and ports.

use super::joints::side_name;
use super::range::{Usual, length, number};
use super::survey::diagonal;
use super::{Finding, Survey};
use crate::machine::{Axis, Grid, Joint, Machine, Motion, SpringStiffness};
use std::f64::consts::TAU;

/// A travel longer than this many times the machine is none of its own.
const LONGEST_TRAVEL: f64 = 5.0;

pub(super) fn axis_findings(machine: &Machine, survey: &Survey) -> Vec<Finding> {
    let axis = &machine.axis;
    let mut found = Vec::new();
    let travel = (axis.travel[1] - axis.travel[0]).abs();
    let size = diagonal(survey.bounds);
    let farthest = axis.travel.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
    if farthest > LONGEST_TRAVEL * size {
        found.push(Finding {
            key: format!("axes.{}.travel", axis.name),
            seen: format!("positions up to {} of a machine that is {} across", length(farthest), length(size)),
            usual: format!("at most {LONGEST_TRAVEL} times the machine"),
            slip: "likely metres for millimetres: a number without quotes is in m, write \"600 mm\"".to_owned(),
        });
    }
    if travel > 0.0 && axis.step > 1.000_001 * travel {
        found.push(Finding {
            key: format!("axes.{}.step", axis.name),
            seen: format!("{}, longer than the travel of {}", length(axis.step), length(travel)),
            usual: "a fraction of the travel".to_owned(),
            slip: "likely metres for millimetres: a number without quotes is in m, write \"5 mm\"".to_owned(),
        });
    }
    if travel > 0.0 {
        found.extend(unheld(machine, survey));
    }
    found
}

/// Moving parts that no screw or spring holds along the travel: they slide away freely.
///
/// Moving parts that are joined to each other along the travel hold each other, so each such group needs one spring to
/// what stands.
fn unheld(machine: &Machine, survey: &Survey) -> Option<Finding> {
    let Axis { name, moves, direction, .. } = &machine.axis;
    let holds = |joint: &Joint| {
        joint.springs.iter().any(|s| {
            let along: f64 = s.direction.iter().zip(direction).map(|(a, b)| a * b).sum();
            s.motion == Motion::Translation && along.abs() > 1e-3 && s.stiffness != SpringStiffness::Constant(0.0)
        })
    };
    let mut held: Vec<bool> = moves.iter().zip(&survey.parts).map(|(moves, part)| !moves || part.held).collect();
    let standing = held.clone();
    // Being held spreads over the joints until nothing changes.
    loop {
        let before = held.clone();
        for joint in machine.joints.iter().filter(|joint| holds(joint)) {
            let [a, b] = joint.between.map(|side| side.part);
            (held[a], held[b]) = (held[a] || held[b], held[a] || held[b]);
        }
        if held == before {
            break;
        }
    }
    // A part that stands and is reached by nothing is the machine's own freedom, not the axis's.
    let free: Vec<&str> = machine
        .parts
        .iter()
        .zip(held.iter().zip(&standing))
        .filter(|(_, (held, standing))| !*held && !*standing)
        .map(|(part, _)| part.name.as_str())
        .collect();
    if free.is_empty() {
        return None;
    }
    Some(Finding {
        key: format!("axes.{name}"),
        seen: format!("nothing holds {} along the travel", free.join(", ")),
        usual: "a ball screw, or a spring along the travel, between what moves and what stands".to_owned(),
        slip: "likely a forgotten joint: add type = \"ball-screw\", or a spring-damper for a linear motor's control"
            .to_owned(),
    })
}

/// Machine tools vibrate between some 5 Hz and some 5 kHz, ultrasonic spindles at 20 to 50 kHz.
const HIGHEST: Usual = Usual {
    from: 5.0,
    to: 2e5,
    units: &[("Hz", 1.0), ("kHz", 1e3)],
    of: "the highest frequency of a machine tool's map",
    slips: &[(1e3, "kHz given as Hz: write \"0.9 kHz\" or \"900 Hz\""), (1e-3, "kHz for Hz")],
};

/// Damping ratios of machine structures are 0.005 to 0.1.
const LARGEST_RATIO: f64 = 0.3;
/// Loss factors of machines are twice that; rubber alone reaches 1.
pub(super) const LARGEST_LOSS: f64 = 1.0;

pub(super) fn analysis_findings(machine: &Machine) -> Vec<Finding> {
    let analysis = &machine.analysis;
    let mut found = Vec::new();
    let highest = analysis.frequencies.iter().copied().fold(0.0, f64::max);
    // A low list asks for the static flexibility, and a narrow grid looks at one mode; a grid from 0 shows the machine.
    let lowest = analysis.frequencies.first().copied().unwrap_or(0.0);
    if highest > HIGHEST.to || (analysis.grid != Grid::Listed && lowest < 0.1 * highest) {
        found.extend(HIGHEST.check(|| "analysis.frequencies".to_owned(), highest));
    }
    let band = analysis.component.band;
    if band < highest {
        found.push(Finding {
            key: "analysis.component.band".to_owned(),
            seen: format!("{} Hz, below the grid's highest frequency of {} Hz", number(band), number(highest)),
            usual: "at least the grid's highest frequency, better 1.5 times it".to_owned(),
            slip: "likely Hz for kHz, or a grid that was extended: raise the band or leave it out".to_owned(),
        });
    }
    let damping = &analysis.damping;
    let largest = damping.ratios.iter().copied().fold(0.0, f64::max);
    if largest > LARGEST_RATIO {
        let key = if damping.ratios.len() > 1 { "analysis.damping.ratios" } else { "analysis.damping.ratio" };
        found.push(Finding {
            key: key.to_owned(),
            seen: number(largest),
            usual: format!("0.001 to 0.1, at most {LARGEST_RATIO} for a machine's modes"),
            slip: format!("likely per cent for share: write \"{} %\"", number(largest)),
        });
    }
    found.extend(loss("analysis.damping.loss_factor".to_owned(), damping.loss_factor, 2.0 * LARGEST_RATIO));
    found.extend(rayleigh(damping.rayleigh, highest));
    for part in &machine.parts {
        let key = format!("parts.{}.loss_factor", part.name);
        found.extend(part.loss_factor.and_then(|eta| loss(key, eta, LARGEST_LOSS)));
    }
    found
}

/// A loss factor that no material has.
pub(super) fn loss(key: String, eta: f64, largest: f64) -> Option<Finding> {
    (eta > largest).then(|| Finding {
        key,
        seen: number(eta),
        usual: format!("0.001 to 0.2, at most {largest}"),
        slip: format!("likely per cent for share: write \"{} %\"", number(eta)),
    })
}

/// The damping ratio that C = alpha M + beta K gives: alpha / (2 omega) + beta omega / 2.
fn rayleigh(given: Option<[f64; 2]>, highest: f64) -> Option<Finding> {
    /// Where alpha is judged, Hz: below the first elastic modes of most machines.
    const LOW: f64 = 20.0;
    const LARGEST: f64 = 3.0;
    let [alpha, beta] = given?;
    let (low, high) = (alpha / (2.0 * TAU * LOW), beta * TAU * highest / 2.0);
    let (key, frequency, ratio, slip) = if low > LARGEST {
        ("alpha", LOW, low, "likely another unit of time: alpha is in 1/s")
    } else if high > LARGEST {
        ("beta", highest, high, "likely milliseconds for microseconds: beta is in s, some 1e-6 to 1e-4")
    } else {
        return None;
    };
    Some(Finding {
        key: format!("analysis.damping.rayleigh.{key}"),
        seen: format!("a damping ratio of {} at {} Hz", number(ratio), number(frequency)),
        usual: "0.001 to 0.1 for a machine's modes".to_owned(),
        slip: slip.to_owned(),
    })
}

pub(super) fn port_findings(machine: &Machine, survey: &Survey) -> Vec<Finding> {
    let held = machine.ports.iter().filter(|port| survey.patch(port.interface).held);
    held.map(|port| Finding {
        key: format!("ports.{}.interface", port.name),
        seen: format!("{}, whose nodes are all fixed to ground", side_name(machine, port.interface)),
        usual: "an interface that moves".to_owned(),
        slip: "its receptance is 0: name another interface, or correct `clamped`".to_owned(),
    })
    .collect()
}
