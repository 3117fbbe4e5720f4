//! Ball screws: diameter, length, span, material, and whether mount and nut lie on one line.

use super::Finding;
use super::geometry::{across, dot, minus};
use super::joints::Place;
use super::range::{LENGTHS, Usual, length};
use super::survey::diagonal;
use crate::machine::{JointKind, ScrewSupport, SpringStiffness};

/// Ball screws are 2 to 300 mm thick.
const DIAMETER: Usual = Usual {
    from: 3e-4,
    to: 2.0,
    units: &LENGTHS,
    of: "a ball screw's diameter",
    slips: &[
        (1e-3, "metres for millimetres: a number without quotes is in m, write \"25 mm\""),
        (1e3, "um for mm: write \"25 mm\""),
    ],
};
/// Steel has 210 GPa, ceramics 300.
const YOUNG: Usual = Usual {
    from: 2e10,
    to: 2e12,
    units: &[("Pa", 1.0), ("MPa", 1e6), ("GPa", 1e9)],
    of: "a ball screw's material",
    slips: &[
        (1e9, "GPa given as Pa: write young = \"210 GPa\""),
        (1e6, "N/mm2 given as Pa: write young = \"210 GPa\""),
        (1e3, "MPa for GPa: write young = \"210 GPa\""),
        (1e-3, "GPa for MPa: write young = \"210 GPa\""),
    ],
};
/// Free lengths are 5 to 150 diameters.
const SLENDER: [f64; 2] = [1.0, 2000.0];

pub(super) fn findings(at: &Place<'_>) -> Vec<Finding> {
    let mut found = Vec::new();
    let screw = at.joint.springs.first().filter(|_| at.joint.kind == JointKind::BallScrew);
    let Some(SpringStiffness::BallScrew { young, diameter, free_length, support }) = screw.map(|s| s.stiffness) else {
        return found;
    };
    let key = |name: &str| format!("{}.{name}", at.key);
    found.extend(DIAMETER.check(|| key("diameter"), diameter));
    found.extend(YOUNG.check(|| key("young"), young));
    if at.is_out_of_scale() {
        return found;
    }
    let [mount, nut] = [at.patch(0), at.patch(1)];
    let direction = at.machine.axis.direction;
    let between = minus(nut.centroid, mount.centroid);
    let drawn = dot(between, direction).abs();
    let [from, to] = at.machine.axis.travel;
    let longest = free_length.unwrap_or(drawn) + from.abs().max(to.abs());
    let machine = diagonal(at.survey.bounds);
    if found.is_empty() && !(SLENDER[0]..=SLENDER[1]).contains(&(longest / diameter)) {
        found.push(Finding {
            key: key("diameter"),
            seen: format!("{} of a screw that is up to {} long", length(diameter), length(longest)),
            usual: "a length of 5 to 150 diameters".to_owned(),
            slip: "check the unit of the diameter, and the sides of `between`".to_owned(),
        });
    }
    if let Some(own) = free_length
        && (own > 10.0 * machine || own > 10.0 * (drawn + machine) || 30.0 * own < drawn)
    {
        let slip = if own > drawn {
            "likely metres for millimetres: a number without quotes is in m, write \"360 mm\""
        } else {
            "likely um for mm, or the wrong mount: leave `free_length` out for the drawn distance"
        };
        found.push(Finding {
            key: key("free_length"),
            seen: format!("{}, where mount and nut are drawn {} apart", length(own), length(drawn)),
            usual: "about the drawn distance, from a thirtieth of it to ten times the machine".to_owned(),
            slip: slip.to_owned(),
        });
    }
    if let ScrewSupport::BothEnds { span } = support
        && span > 10.0 * machine
    {
        found.push(Finding {
            key: key("span"),
            seen: format!("{} in a machine that is {} across", length(span), length(machine)),
            usual: "the distance between the two supports, within the machine".to_owned(),
            slip: "likely metres for millimetres: a number without quotes is in m, write \"1200 mm\"".to_owned(),
        });
    }
    let off = across(between, direction);
    let size = mount.size().max(nut.size());
    if size > 0.0 && off > 1.5 * size && off > 0.5 * drawn {
        found.push(Finding {
            key: key("between"),
            seen: format!("{} and {} are {} apart across the travel", at.name(0), at.name(1), length(off)),
            usual: "a mount and a nut on one line along the travel".to_owned(),
            slip: "likely the wrong interface for the mount or the nut".to_owned(),
        });
    }
    found
}
