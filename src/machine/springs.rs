//! The springs of a joint, from its `stiffness` and `damping` keys.

use super::axis::GLOBAL_AXES;
use super::error::MachineError;
use super::model::{Motion, Spring, SpringStiffness};
use super::quantity::Dimension;
use super::table::{Bound, Item, Table};

type Result<T> = std::result::Result<T, MachineError>;

/// A key of `stiffness` and `damping`, and the springs that it stands for.
pub(super) struct Way {
    pub key: &'static str,
    pub motion: Motion,
    /// Label and unit vector of each spring.
    pub springs: Vec<(&'static str, [f64; 3])>,
}

/// Translations along the global axes `x`, `y`, `z` and rotations about them, `rx`, `ry`, `rz`.
pub(super) fn global_ways() -> Vec<Way> {
    let turned = ["rx", "ry", "rz"].into_iter().zip(GLOBAL_AXES);
    let translations = GLOBAL_AXES.into_iter().map(|(key, v)| (key, Motion::Translation, v));
    let rotations = turned.map(|(key, (_, v))| (key, Motion::Rotation, v));
    translations.chain(rotations).map(|(key, motion, v)| Way { key, motion, springs: vec![(key, v)] }).collect()
}

/// One spring for every way that `stiffness` or `damping` names; a way that only `damping` names is a
/// damper without stiffness.
///
/// `expected` is an example of `stiffness` that serves this joint.
pub(super) fn read_springs(joint: &Table<'_>, ways: &[Way], expected: &'static str) -> Result<Vec<Spring>> {
    let damping_item = joint.get("damping");
    let stiffness_item = match joint.get("stiffness") {
        None if damping_item.is_some() => None,
        _ => Some(joint.need("stiffness", expected)?),
    };
    let stiffness = stiffness_item.as_ref().map(Item::table).transpose()?;
    let damping = damping_item.as_ref().map(Item::table).transpose()?;
    let mut springs = Vec::new();
    for way in ways {
        let k = stiffness.as_ref().and_then(|table| table.get(way.key));
        let c = damping.as_ref().and_then(|table| table.get(way.key));
        if k.is_none() && c.is_none() {
            continue;
        }
        let k = k.map_or(Ok(0.0), |item| read_stiffness(&item, way.motion))?;
        let c = c.map_or(Ok(0.0), |item| read_damper(&item, way.motion))?;
        springs.extend(way.springs.iter().map(|(label, direction)| Spring {
            motion: way.motion,
            direction: *direction,
            stiffness: SpringStiffness::Constant(k),
            damping: c,
            label: (*label).to_owned(),
        }));
    }
    for table in [stiffness, damping].into_iter().flatten() {
        table.finish()?;
    }
    if springs.is_empty() {
        let keys: Vec<&str> = ways.iter().map(|way| way.key).collect();
        let empty = stiffness_item.or(damping_item).unwrap_or_else(|| joint.item.clone());
        return Err(empty.refuse(
            format!("at least one of {}", keys.join(", ")),
            format!("give a value for a direction: {expected}"),
        ));
    }
    Ok(springs)
}

/// A single spring along `direction`, from plain values of `stiffness` and `damping`.
pub(super) fn read_single_spring(joint: &Table<'_>, label: &str, direction: [f64; 3]) -> Result<Spring> {
    let damping = joint.get("damping").map(|item| read_damper(&item, Motion::Translation)).transpose()?;
    let stiffness = match joint.get("stiffness") {
        None if damping.is_some() => 0.0,
        _ => read_stiffness(&joint.need("stiffness", "stiffness = \"100 N/um\"")?, Motion::Translation)?,
    };
    Ok(Spring {
        motion: Motion::Translation,
        direction,
        stiffness: SpringStiffness::Constant(stiffness),
        damping: damping.unwrap_or(0.0),
        label: label.to_owned(),
    })
}

fn read_stiffness(item: &Item<'_>, motion: Motion) -> Result<f64> {
    let dimension = match motion {
        Motion::Translation => Dimension::Stiffness,
        Motion::Rotation => Dimension::RotationalStiffness,
    };
    item.quantity(dimension, Bound::Positive)
}

/// A viscous damper's constant.
pub(super) fn read_damper(item: &Item<'_>, motion: Motion) -> Result<f64> {
    let dimension = match motion {
        Motion::Translation => Dimension::Damping,
        Motion::Rotation => Dimension::RotationalDamping,
    };
    item.quantity(dimension, Bound::NotNegative)
}
