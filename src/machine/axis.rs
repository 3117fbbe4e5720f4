//! The axis of travel, and directions.

use super::error::MachineError;
use super::model::{Axis, Part};
use super::quantity::Dimension;
use super::table::{Bound, Item, Table, find_name};

type Result<T> = std::result::Result<T, MachineError>;

/// Most positions a travel may be divided into.
const MOST_POSITIONS: f64 = 100_000.0;

/// The global axes by name.
pub(super) const GLOBAL_AXES: [(&str, [f64; 3]); 3] =
    [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])];

pub(super) fn read_axis(root: &Table<'_>, parts: &[Part]) -> Result<Axis> {
    let axes = root.need("axes", "an [axes.NAME] section with direction, travel, step and moves")?;
    let entries = axes.table()?.entries()?;
    let [(name, item)] = entries.as_slice() else {
        let names: Vec<&str> = entries.iter().map(|(name, _)| *name).collect();
        return Err(axes.refuse_seen(
            format!("{} axes ({})", names.len(), names.join(", ")),
            "exactly one axis",
            "keep the axis whose positions you want, and draw the meshes where the others stand",
        ));
    };
    let table = item.table()?;
    let direction = read_direction(&table.need("direction", "direction = [0, 0, 1]")?)?;
    let travel_item = table
        .need("travel", "travel = [\"0 mm\", \"-600 mm\"]  # first and last position; the meshes are drawn at 0")?;
    let [from, to] = travel_item.array()?;
    let travel = [from.quantity(Dimension::Length, Bound::Any)?, to.quantity(Dimension::Length, Bound::Any)?];
    let step_item = table.need("step", "step = \"5 mm\"")?;
    let step = step_item.quantity(Dimension::Length, Bound::Positive)?;
    let length = (travel[1] - travel[0]).abs();
    if length / step > MOST_POSITIONS {
        return Err(step_item.refuse(
            format!("a step that divides the travel of {length} m into at most {MOST_POSITIONS} intervals"),
            "make the step larger, or the travel shorter (a number without quotes is in m)",
        ));
    }
    let moves_item = table.need("moves", "moves = [\"PART\"]  # every part that travels")?;
    let moves = read_moves(&moves_item, parts)?;
    if length > 0.0 && moves.iter().all(|&moved| moved == moves[0]) {
        return Err(moves_item.refuse(
            "some of the parts, not none and not all",
            "name the parts that move along this axis and leave out those that stand",
        ));
    }
    table.finish()?;
    Ok(Axis { name: (*name).to_owned(), direction, travel, step, moves })
}

fn read_moves(item: &Item<'_>, parts: &[Part]) -> Result<Vec<bool>> {
    let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
    let mut moves = vec![false; parts.len()];
    for entry in item.list()? {
        let name = entry.text()?;
        let part = find_name(&entry, "part", name, &names)?;
        if std::mem::replace(&mut moves[part], true) {
            let place = entry.place();
            return Err(MachineError::Duplicate { place, kind: "part", name: name.to_owned() });
        }
    }
    Ok(moves)
}

/// A unit vector, from `"x"`, `"y"`, `"z"` or three numbers of any length.
pub(super) fn read_direction(item: &Item<'_>) -> Result<[f64; 3]> {
    const ALLOWED: &str = "\"x\", \"y\", \"z\" or a vector such as [0, 0, 1]";
    if item.is_text() {
        let name = item.text()?;
        let known = GLOBAL_AXES.iter().find(|(axis, _)| *axis == name);
        return known.map(|(_, v)| *v).ok_or_else(|| item.refuse(ALLOWED, "write one of them"));
    }
    if !item.is_list() {
        return Err(item.refuse(ALLOWED, "write one of them"));
    }
    let [x, y, z] = item.array()?;
    let vector = [x.plain_number()?, y.plain_number()?, z.plain_number()?];
    let largest = vector.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    if largest == 0.0 {
        return Err(item.refuse(ALLOWED, "a direction needs a component that is not zero"));
    }
    let scaled = vector.map(|v| v / largest);
    let length = scaled.iter().map(|v| v * v).sum::<f64>().sqrt();
    Ok(scaled.map(|v| v / length))
}

/// A point, from three lengths.
pub(super) fn read_point(item: &Item<'_>) -> Result<[f64; 3]> {
    let [x, y, z] = item.array()?;
    let length = |item: Item<'_>| item.quantity(Dimension::Length, Bound::Any);
    Ok([length(x)?, length(y)?, length(z)?])
}

/// Whether two unit vectors lie along one line, to a hundredth of a degree.
pub(super) fn are_parallel(a: [f64; 3], b: [f64; 3]) -> bool {
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    1.0 - dot.abs() < 1.5e-8
}
