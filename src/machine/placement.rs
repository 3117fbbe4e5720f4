//! Where a part's mesh stands in the machine, and which displacements are fixed to ground.

use super::axis::GLOBAL_AXES;
use super::error::MachineError;
use super::model::{Placement, Support};
use super::quantity::Dimension;
use super::table::{Bound, Item, Table};

type Result<T> = std::result::Result<T, MachineError>;

/// Largest |cosine| between two mesh axes, and |length - 1|, that still counts as written in full.
const SQUARE: f64 = 1e-6;

/// `orientation` and `origin` of a part.
pub(super) fn read_placement(part: &Table<'_>) -> Result<Placement> {
    let mut placement = Placement::IDENTITY;
    if let Some(item) = part.get("orientation") {
        placement.rotation = read_orientation(&item)?;
    }
    if let Some(item) = part.get("origin") {
        for (place, item) in placement.origin.iter_mut().zip(item.array::<3>()?) {
            *place = item.quantity(Dimension::Length, Bound::Any)?;
        }
    }
    Ok(placement)
}

/// Two of the mesh's axes as vectors of the machine, `{ x = [0, 1, 0], z = [0, 0, 1] }`; the third follows.
fn read_orientation(item: &Item<'_>) -> Result<[[f64; 3]; 3]> {
    const ALLOWED: &str =
        "two of the mesh's axes at right angles, as vectors in the machine: { x = [0, 1, 0], z = [0, 0, 1] }";
    let table = item.table()?;
    let mut axes: [Option<[f64; 3]>; 3] = [None; 3];
    for (slot, (name, _)) in axes.iter_mut().zip(GLOBAL_AXES) {
        let Some(vector) = table.get(name) else { continue };
        let [x, y, z] = vector.array()?;
        let v = [x.plain_number()?, y.plain_number()?, z.plain_number()?];
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        if !(length.is_normal() && length < 1e150) {
            return Err(vector.refuse("a vector that is not zero", "give the axis's direction in the machine"));
        }
        *slot = Some(v.map(|c| c / length));
    }
    table.finish()?;
    let cross = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
    };
    let Some(missing) = (0..3).find(|&k| axes[k].is_none()) else {
        return Err(item.refuse(ALLOWED, "leave one of the three out"));
    };
    let (Some(a), Some(b)) = (axes[(missing + 1) % 3], axes[(missing + 2) % 3]) else {
        return Err(item.refuse(ALLOWED, "give two axes"));
    };
    let cosine: f64 = (0..3).map(|i| a[i] * b[i]).sum();
    if cosine.abs() > SQUARE {
        return Err(item.refuse(ALLOWED, format!("their cosine is {cosine:.1e}; make them perpendicular")));
    }
    // Exactly orthonormal: b without its part along a, then the third.
    let b: [f64; 3] = std::array::from_fn(|i| b[i] - cosine * a[i]);
    let length = b.iter().map(|c| c * c).sum::<f64>().sqrt();
    let b = b.map(|c| c / length);
    let mut columns = [[0.0; 3]; 3];
    (columns[(missing + 1) % 3], columns[(missing + 2) % 3], columns[missing]) = (a, b, cross(a, b));
    Ok(std::array::from_fn(|i| std::array::from_fn(|k| columns[k][i])))
}

/// `supported = [{ nodes = "EDGES", directions = ["z"] }]`.
pub(super) fn read_supports(item: &Item<'_>) -> Result<Vec<Support>> {
    item.list()?.iter().map(read_support).collect()
}

fn read_support(item: &Item<'_>) -> Result<Support> {
    let table = item.table()?;
    let nodes = table.need("nodes", "nodes = \"NODE_SET\"")?;
    let name = nodes.text()?;
    if name.trim().is_empty() {
        return Err(nodes.refuse("the name of a node set of the mesh", "name one"));
    }
    let list = table.need("directions", "directions = [\"z\"]")?;
    let mut directions = [false; 3];
    for entry in list.list()? {
        let axis = GLOBAL_AXES.iter().position(|(axis, _)| entry.text().is_ok_and(|text| text == *axis));
        let axis = axis.ok_or_else(|| entry.refuse("\"x\", \"y\" or \"z\"", "write the directions that are fixed"))?;
        directions[axis] = true;
    }
    table.finish()?;
    if directions == [false; 3] {
        return Err(list.refuse("at least one of \"x\", \"y\", \"z\"", "name a direction or remove the entry"));
    }
    Ok(Support { nodes: name.to_owned(), directions })
}
