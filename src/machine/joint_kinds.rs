//! The kinds of joint, each from the keys of its own.

use super::axis::{are_parallel, read_direction, read_point};
use super::contact::{read_backlash, read_friction};
use super::error::MachineError;
use super::interfaces::read_interface_ref;
use super::joints::{Surroundings, read_between};
use super::model::{
    Contact, Joint, JointKind, JointPoint, Motion, ScrewSupport, Spring, SpringStiffness, SurfaceCoupling,
};
use super::quantity::Dimension;
use super::springs::{Way, global_ways, read_damper, read_single_spring, read_springs};
use super::table::{Bound, Table};

type Result<T> = std::result::Result<T, MachineError>;

/// A joint of this kind, whose name and loss factor the caller fills in.
fn joint(kind: JointKind, between: [super::model::InterfaceRef; 2], at: JointPoint, springs: Vec<Spring>) -> Joint {
    Joint { name: String::new(), kind, between, footprint: None, at, springs, loss_factor: None, contact: None }
}

/// A carriage on a rail: springs at the centroid of the carriage's surface.
pub(super) fn read_linear_guide(table: &Table<'_>, around: &Surroundings<'_>) -> Result<Joint> {
    let rail_item = table.need("rail", "rail = \"PART.INTERFACE\"")?;
    let rail = read_interface_ref(&rail_item, around.parts)?;
    let carriage_item = table.need("carriage", "carriage = \"PART.INTERFACE\"")?;
    let carriage = read_interface_ref(&carriage_item, around.parts)?;
    around.check_slides(&carriage_item, [rail, carriage], "linear guide")?;
    if around.parts[rail.part].interfaces[rail.interface].coupling == SurfaceCoupling::Rigid {
        return Err(rail_item.refuse(
            "a rail whose coupling is \"distributing\"",
            "remove coupling = \"rigid\" from that interface: the footprint moves along the rail, a rigid rail would not bend",
        ));
    }
    let item = table.need("footprint", "footprint = \"90 mm\"")?;
    let footprint = item.quantity(Dimension::Length, Bound::Positive)?;
    if footprint < SHORTEST_FOOTPRINT {
        return Err(item.refuse(
            format!("a length of rail from {SHORTEST_FOOTPRINT:e} to 1e5 m"),
            "correct the value or its unit; it is the length of rail that carries the carriage",
        ));
    }
    let ways = global_ways();
    let springs = read_springs(table, &ways, across(around.axis.direction))?;
    let holds = |spring: &&Spring| {
        let along = are_parallel(spring.direction, around.axis.direction);
        spring.motion == Motion::Translation && along && spring.stiffness != SpringStiffness::Constant(0.0)
    };
    if let Some(spring) = springs.iter().find(holds) {
        return Err(table.need("stiffness", "")?.refuse(
            format!("no stiffness along {}, the direction of travel", spring.label),
            "remove it: a guide slides freely; what holds the position is the ball screw",
        ));
    }
    let friction = table.get("friction").map(|item| read_friction(&item)).transpose()?;
    let along = friction.map(|_| travel_row(around.axis.direction));
    let springs = springs.into_iter().chain(along).collect();
    let joint = joint(JointKind::LinearGuide, [rail, carriage], JointPoint::Centroid(1), springs);
    Ok(Joint { footprint: Some(footprint), contact: friction.map(Contact::Friction), ..joint })
}

/// The stiffnesses of a guide, as a message writes them: across the travel.
fn across(travel: [f64; 3]) -> &'static str {
    match (0..3).find(|&c| travel[c].abs() > 0.5) {
        Some(0) => "stiffness = { y = \"150 N/um\", z = \"150 N/um\" }",
        Some(1) => "stiffness = { x = \"150 N/um\", z = \"150 N/um\" }",
        _ => "stiffness = { x = \"150 N/um\", y = \"150 N/um\" }",
    }
}

/// A spring of no stiffness along the travel, whose motion is what friction sees.
fn travel_row(direction: [f64; 3]) -> Spring {
    let stiffness = SpringStiffness::Constant(0.0);
    Spring { motion: Motion::Translation, direction, stiffness, damping: 0.0, label: "travel".to_owned() }
}

/// A bearing: `radial` in two perpendicular directions, `axial` along its axis, at a point of it; without `at` at the
/// centroid of the first side, its seat.
pub(super) fn read_bearing(table: &Table<'_>, around: &Surroundings<'_>) -> Result<Joint> {
    let (item, between) = read_between(table, around)?;
    around.check_stays(&item, between, "bearing")?;
    let axis = read_direction(&table.need("axis", "axis = \"z\"")?)?;
    let at = read_point_or_centroid(table, 0)?;
    let [u, v] = perpendicular(axis);
    let ways = [
        Way { key: "radial", motion: Motion::Translation, springs: vec![("radial 1", u), ("radial 2", v)] },
        Way { key: "axial", motion: Motion::Translation, springs: vec![("axial", axis)] },
    ];
    let springs = read_springs(table, &ways, "stiffness = { radial = \"200 N/um\", axial = \"100 N/um\" }")?;
    Ok(joint(JointKind::Bearing, between, at, springs))
}

/// A ball screw: one spring along its axis, at the centroid of the nut.
pub(super) fn read_ball_screw(table: &Table<'_>, around: &Surroundings<'_>) -> Result<Joint> {
    let (item, between) = read_between(table, around)?;
    around.check_slides(&item, between, "ball screw")?;
    let axis_item = table.need("axis", "axis = \"z\"")?;
    let direction = read_direction(&axis_item)?;
    if !are_parallel(direction, around.axis.direction) {
        let allowed = format!("the direction of the axis of travel, {:?}", around.axis.direction);
        return Err(axis_item.refuse(allowed, "a screw lies along the travel it drives"));
    }
    let young = table.need("young", "young = \"210 GPa\"")?.quantity(Dimension::Pressure, Bound::Positive)?;
    let diameter = table.need("diameter", "diameter = \"40 mm\"")?.quantity(Dimension::Length, Bound::Positive)?;
    let free_length =
        table.get("free_length").map(|item| item.quantity(Dimension::Length, Bound::Positive)).transpose()?;
    let support = read_support(table)?;
    let damping = table.get("damping").map(|item| read_damper(&item, Motion::Translation)).transpose()?;
    let spring = Spring {
        motion: Motion::Translation,
        direction,
        stiffness: SpringStiffness::BallScrew { young, diameter, free_length, support },
        damping: damping.unwrap_or(0.0),
        label: "axial".to_owned(),
    };
    let contact = table.get("backlash").map(|item| read_backlash(&item)).transpose()?;
    let joint = joint(JointKind::BallScrew, between, JointPoint::Centroid(1), vec![spring]);
    Ok(Joint { contact, ..joint })
}

/// Which ends of a ball screw are held: `support`, and with both ends `span`.
fn read_support(table: &Table<'_>) -> Result<ScrewSupport> {
    let span = table.get("span");
    let both = match table.get("support") {
        None => false,
        Some(item) => match item.text()? {
            "one-end" => false,
            "both-ends" => true,
            _ => return Err(item.refuse("\"one-end\" or \"both-ends\"", "write one of them")),
        },
    };
    if both {
        let span = table.need(
            "span",
            "span = \"1200 mm\"  # distance between the two supports, longer than the screw is free anywhere",
        )?;
        return Ok(ScrewSupport::BothEnds { span: span.quantity(Dimension::Length, Bound::Positive)? });
    }
    if let Some(span) = span {
        return Err(span.refuse("no span without support = \"both-ends\"", "remove it, or add support = \"both-ends\""));
    }
    Ok(ScrewSupport::OneEnd)
}

/// A footprint shorter than this (m) cuts the faces of a rail of some metres below rounding.
const SHORTEST_FOOTPRINT: f64 = 1e-5;

/// The stiffnesses of a bolted connection, as a message writes them.
const SIX: &str = "stiffness = { x = \"1e10 N/m\", y = \"1e10 N/m\", z = \"1e10 N/m\", rx = \"1e8 N m/rad\", \
                   ry = \"1e8 N m/rad\", rz = \"1e8 N m/rad\" }";

/// A bolted connection: all six stiffnesses, at the centroid of the second side unless `at` says else.
pub(super) fn read_bolted(table: &Table<'_>, around: &Surroundings<'_>) -> Result<Joint> {
    let (item, between) = read_between(table, around)?;
    around.check_stays(&item, between, "bolted joint")?;
    let at = read_point_or_centroid(table, 1)?;
    let ways = global_ways();
    let springs = read_springs(table, &ways, SIX)?;
    let is_soft =
        |key: &&str| !springs.iter().any(|s| s.label == **key && s.stiffness != SpringStiffness::Constant(0.0));
    if let Some(missing) = ways.iter().map(|way| way.key).find(is_soft) {
        return Err(table.need("stiffness", SIX)?.refuse(
            format!("all six of x, y, z, rx, ry, rz ({missing} is missing)"),
            "add it; a connection that leaves a direction free is a spring-damper",
        ));
    }
    Ok(joint(JointKind::Bolted, between, at, springs))
}

/// Springs and dampers along one `direction`, or along and about the global axes.
pub(super) fn read_spring_damper(table: &Table<'_>, around: &Surroundings<'_>) -> Result<Joint> {
    let (_, between) = read_between(table, around)?;
    let at = read_point_or_centroid(table, 1)?;
    let springs = match table.get("direction") {
        Some(item) => vec![read_single_spring(table, "axial", read_direction(&item)?)?],
        None => read_springs(table, &global_ways(), "stiffness = { x = \"100 N/um\", y = \"100 N/um\" }")?,
    };
    Ok(joint(JointKind::SpringDamper, between, at, springs))
}

/// The point `at`, or the centroid of a side.
fn read_point_or_centroid(table: &Table<'_>, side: usize) -> Result<JointPoint> {
    let point = table.get("at").map(|item| read_point(&item)).transpose()?;
    Ok(point.map_or(JointPoint::Centroid(side), JointPoint::Point))
}

/// Two unit vectors that make a right-handed system with the unit vector `axis`; x and y for z.
fn perpendicular(axis: [f64; 3]) -> [[f64; 3]; 2] {
    let smallest = (0..3).fold(0, |best, i| if axis[i].abs() < axis[best].abs() { i } else { best });
    let mut u = axis.map(|a| -a * axis[smallest]);
    u[smallest] += 1.0;
    let length = u.iter().map(|c| c * c).sum::<f64>().sqrt();
    let u = u.map(|c| c / length + 0.0);
    let [a, b] = [axis, u];
    let v = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    [u, v.map(|c| c + 0.0)]
}

#[cfg(test)]
mod tests {
    use super::perpendicular;

    #[test]
    fn radial_directions_are_perpendicular_unit_vectors() {
        assert_eq!(perpendicular([0.0, 0.0, 1.0]), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.0, -0.8], [0.48, 0.6, 0.64]] {
            let [u, v] = perpendicular(axis);
            let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            for (a, b, expected) in [(u, u, 1.0), (v, v, 1.0), (u, v, 0.0), (u, axis, 0.0), (v, axis, 0.0)] {
                assert!((dot(a, b) - expected).abs() < 1e-15, "{a:?} . {b:?} for axis {axis:?}");
            }
        }
    }
}
