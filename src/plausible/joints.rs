//! Where the two sides of a joint are: on each other, a rail below its carriage, a bearing in its bore.

use super::geometry::{across, dot, minus, norm};
use super::range::{length, number, point};
use super::{Finding, Patch, Survey, parts};
use crate::machine::{InterfaceRef, Joint, JointKind, JointPoint, Machine};

/// A joint with what the checks need around it.
pub(super) struct Place<'a> {
    pub machine: &'a Machine,
    pub survey: &'a Survey,
    pub joint: &'a Joint,
    /// Its key, such as `joints[2] "screw"`.
    pub key: String,
}

/// An interface as the machine file names it.
pub(super) fn side_name(machine: &Machine, side: InterfaceRef) -> String {
    let part = &machine.parts[side.part];
    format!("{}.{}", part.name, part.interfaces[side.interface].name)
}

impl Place<'_> {
    pub fn patch(&self, side: usize) -> &Patch {
        self.survey.patch(self.joint.between[side])
    }

    pub fn name(&self, side: usize) -> String {
        side_name(self.machine, self.joint.between[side])
    }

    /// Whether one of the parts is told already to be in the wrong units: then nothing fits, and no distance says more.
    pub fn is_out_of_scale(&self) -> bool {
        self.joint.between.iter().any(|side| parts::is_out_of_scale(self.machine, self.survey, side.part))
    }

    /// The larger of the two sides, m.
    fn size(&self) -> f64 {
        self.patch(0).size().max(self.patch(1).size())
    }

    /// The point `at`, where the file gives one.
    fn given_point(&self) -> Option<[f64; 3]> {
        match self.joint.at {
            JointPoint::Point(x) => Some(x),
            JointPoint::Centroid(_) => None,
        }
    }
}

pub(super) fn findings(at: &Place<'_>) -> Vec<Finding> {
    let mut found = Vec::new();
    if at.is_out_of_scale() {
        return found;
    }
    match at.joint.kind {
        JointKind::LinearGuide => found.extend(guide(at)),
        JointKind::Bearing => {
            // Between the rings of a bearing there is less than its radius.
            found.extend(apart(at, 0.75));
            found.extend(bearing(at));
        }
        JointKind::Bolted => found.extend(apart(at, 1.5)),
        // A strut may reach across the machine, but not beyond.
        JointKind::SpringDamper => found.extend(far_strut(at)),
        JointKind::BallScrew => {}
    }
    if matches!(at.joint.kind, JointKind::Bolted | JointKind::SpringDamper) {
        found.extend(far_point(at));
    }
    if at.patch(0).held && at.patch(1).held {
        found.push(Finding {
            key: at.key.clone(),
            seen: format!("{} and {}, whose nodes are all fixed to ground", at.name(0), at.name(1)),
            usual: "at least one side that can move".to_owned(),
            slip: "the joint does nothing: correct `clamped` or the sides".to_owned(),
        });
    }
    found
}

/// Two sides that should touch and do not, with the largest gap in sizes of the larger side.
fn apart(at: &Place<'_>, sizes: f64) -> Option<Finding> {
    let [a, b] = [at.patch(0), at.patch(1)];
    let gap = a.gap(b).min(b.gap(a));
    let size = at.size();
    if size <= 0.0 || gap <= sizes * size {
        return None;
    }
    Some(Finding {
        key: format!("{}.between", at.key),
        seen: format!("{} and {} are {} apart", at.name(0), at.name(1), length(gap)),
        usual: format!("sides that touch, or a gap below {}", length(sizes * size)),
        slip: "likely the wrong interface, or a part in the wrong units, orientation or origin".to_owned(),
    })
}

/// A strut longer than the two parts that it joins.
fn far_strut(at: &Place<'_>) -> Option<Finding> {
    let [a, b] = [at.patch(0), at.patch(1)];
    let gap = norm(minus(a.centroid, b.centroid));
    let size = at.joint.between.iter().map(|side| at.survey.parts[side.part].size()).sum::<f64>();
    (size > 0.0 && gap > 2.0 * size).then(|| Finding {
        key: format!("{}.between", at.key),
        seen: format!("{} and {} are {} apart", at.name(0), at.name(1), length(gap)),
        usual: format!("a strut no longer than its two parts together, {}", length(size)),
        slip: "likely the wrong interface, or a part in the wrong units, orientation or origin".to_owned(),
    })
}

/// A point `at` that lies far outside both parts: their springs act with a lever that no machine has.
fn far_point(at: &Place<'_>) -> Option<Finding> {
    let given = at.given_point()?;
    let distance = at.patch(0).distance(given).min(at.patch(1).distance(given));
    let size = at.joint.between.iter().map(|side| at.survey.parts[side.part].size()).fold(0.0, f64::max);
    (size > 0.0 && distance > 3.0 * size).then(|| Finding {
        key: format!("{}.at", at.key),
        seen: format!("{}, {} from both sides", point(given), length(distance)),
        usual: format!("a point of the joint; its larger part is {} across", length(size)),
        slip: "likely metres for millimetres: write at = [\"0 mm\", \"-400 mm\", \"1030 mm\"], or leave `at` out for \
               the centroid of the second side"
            .to_owned(),
    })
}

/// A carriage that is not on its rail, a rail shorter than its carriage, a footprint unlike the carriage.
fn guide(at: &Place<'_>) -> Vec<Finding> {
    let mut found = Vec::new();
    let direction = at.machine.axis.direction;
    let [rail, carriage] = [at.patch(0), at.patch(1)];
    let footprint = at.joint.footprint.unwrap_or(0.0);
    let [from, to] = rail.extent(direction);
    let [low, high] = carriage.extent(direction);
    let own = high - low;
    // The largest gap that a block between rail and carriage, left out of the meshes, would explain.
    let allowed = own.max(1.5 * footprint);
    // Wherever the carriage is drawn along the travel, it is set over the rail: what counts is the distance across.
    let over = |rail: &Patch| {
        let [from, to] = rail.extent(direction);
        let middle = dot(carriage.centroid, direction);
        let shift = middle.clamp(from.min(to), to.max(from)) - middle;
        rail.rail_gap(carriage, direction.map(|c| c * shift))
    };
    let gap = over(rail);
    let nearer = other_rail(at, &over, gap, carriage.size());
    if let Some((name, distance)) = &nearer {
        found.push(Finding {
            key: format!("{}.rail", at.key),
            seen: format!("{} lies {} from {}", at.name(1), length(gap), at.name(0)),
            usual: format!("a carriage on its rail; {name} is {} from it", length(*distance)),
            slip: format!("likely two rails swapped: rail = \"{name}\""),
        });
    } else if gap > allowed {
        found.push(Finding {
            key: format!("{}.carriage", at.key),
            seen: format!(
                "{} lies {} from the rail {}, measured across the travel",
                at.name(1),
                length(gap),
                at.name(0)
            ),
            usual: format!("a carriage on its rail, or a gap for its block below {}", length(allowed)),
            slip: "likely the wrong interface, or a part in the wrong units, orientation or origin".to_owned(),
        });
    }
    // Nodes alone have no length.
    if own <= 0.0 || to <= from {
        return found;
    }
    if to - from < 0.9 * own {
        found.push(Finding {
            key: format!("{}.rail", at.key),
            seen: format!("{} is {} long, its carriage {} {}", at.name(0), length(to - from), at.name(1), length(own)),
            usual: "a rail longer than its carriage".to_owned(),
            slip: "likely rail and carriage swapped: exchange the two".to_owned(),
        });
    }
    let element = rail.element_length(direction);
    if footprint > 0.0 && footprint < element {
        found.push(Finding {
            key: format!("{}.footprint", at.key),
            seen: format!(
                "{} on a rail whose elements are {} long along the travel",
                length(footprint),
                length(element)
            ),
            usual: "a footprint at least as long as the rail's elements".to_owned(),
            slip: "the mesh cannot tell shorter footprints apart: refine the rail's mesh, or write the length of rail \
                   that carries the carriage"
                .to_owned(),
        });
    }
    let ratio = footprint / own;
    if !(0.15..=7.0).contains(&ratio) {
        let unit = if ratio > 100.0 {
            "likely metres for millimetres: write footprint = \"60 mm\""
        } else {
            "check its unit: the footprint is the length of rail that carries the carriage"
        };
        found.push(Finding {
            key: format!("{}.footprint", at.key),
            seen: format!("{} for a carriage of {}", length(footprint), length(own)),
            usual: format!("about the carriage's length, {} to {}", length(0.15 * own), length(7.0 * own)),
            slip: unit.to_owned(),
        });
    }
    found
}

/// Another rail of the same part that lies much nearer to the carriage: its name and its distance.
fn other_rail(at: &Place<'_>, over: &dyn Fn(&Patch) -> f64, gap: f64, size: f64) -> Option<(String, f64)> {
    // Most carriages are on their rail, and need no other one measured.
    if gap <= 0.5 * size {
        return None;
    }
    let rail = at.joint.between[0];
    let guides = at.machine.joints.iter().filter(|j| j.kind == JointKind::LinearGuide).map(|j| j.between[0]);
    let others = guides.filter(|other| other.part == rail.part && other.interface != rail.interface);
    let nearest = others
        .map(|other| (other, over(at.survey.patch(other))))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, distance)| gap > 5.0 * distance)?;
    Some((side_name(at.machine, nearest.0), nearest.1))
}

/// A bearing across its bore, or whose point is not in it.
fn bearing(at: &Place<'_>) -> Vec<Finding> {
    let mut found = Vec::new();
    let axial = at.joint.springs.iter().find(|s| s.label == "axial").map(|s| s.direction);
    let axis = axial.unwrap_or_else(|| radial_normal(at.joint));
    let bores = [at.patch(0).bore(), at.patch(1).bore()];
    let crossed = |bore: &super::geometry::Bore| dot(bore.axis, axis).abs() < 0.7;
    let round: Vec<_> = bores.iter().flatten().collect();
    if !round.is_empty() && round.iter().all(|bore| crossed(bore)) {
        found.push(Finding {
            key: format!("{}.axis", at.key),
            seen: format!("{} across the bore, which runs along {}", direction(axis), direction(round[0].axis)),
            usual: "a bearing's axis along the axis of its seat".to_owned(),
            slip: format!("likely the wrong letter: axis = {}", written(round[0].axis)),
        });
    }
    let Some(given) = at.given_point() else { return found };
    let far = |patch: &Patch| norm(minus(given, patch.centroid));
    let nearest = far(at.patch(0)).min(far(at.patch(1)));
    let leave = "or leave `at` out for the seat's centroid";
    let size = at.size();
    if size > 0.0 && nearest > 1.5 * size {
        let centroid = at.patch(0).centroid;
        let slip =
            if nearest > 50.0 * size { "likely metres for millimetres" } else { "likely another bearing's point" };
        found.push(Finding {
            key: format!("{}.at", at.key),
            seen: format!("{}, {} from {}", point(given), length(nearest), at.name(0)),
            usual: format!("a point inside the seat, whose centroid is {}", point(centroid)),
            slip: format!("{slip}: write {}, {leave}", example(centroid)),
        });
        return found;
    }
    for (side, bore) in bores.iter().enumerate() {
        let Some(bore) = bore.as_ref().filter(|bore| bore.closed && !crossed(bore)) else { continue };
        let centroid = at.patch(side).centroid;
        let off = across(minus(given, centroid), bore.axis);
        if off > 0.5 * bore.radius {
            found.push(Finding {
                key: format!("{}.at", at.key),
                seen: format!("{}, {} off the axis of {}", point(given), length(off), at.name(side)),
                usual: format!("a point on the axis of its seat of radius {}", length(bore.radius)),
                slip: format!("likely a wrong coordinate: write {}, {leave}", example(centroid)),
            });
            break;
        }
    }
    found
}

/// The axis of a bearing of radial springs alone.
fn radial_normal(joint: &Joint) -> [f64; 3] {
    match joint.springs.as_slice() {
        [a, b, ..] => {
            let (a, b) = (a.direction, b.direction);
            std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
        }
        _ => [0.0; 3],
    }
}

/// A point as the machine file writes it.
fn example(x: [f64; 3]) -> String {
    let quoted = x.map(|c| format!("\"{} mm\"", number((c * 1e5).round() * 1e-2 + 0.0)));
    format!("at = [{}]", quoted.join(", "))
}

/// The global axis that a direction is along, if it is.
fn axis_letter(v: [f64; 3]) -> Option<&'static str> {
    (0..3).find(|&c| v[c].abs() > 0.999).map(|c| ["x", "y", "z"][c])
}

fn direction(v: [f64; 3]) -> String {
    axis_letter(v).map_or_else(|| format!("({})", v.map(number).join(", ")), str::to_owned)
}

/// A direction as the machine file writes it.
fn written(v: [f64; 3]) -> String {
    axis_letter(v).map_or_else(|| format!("[{}]", v.map(number).join(", ")), |letter| format!("\"{letter}\""))
}
