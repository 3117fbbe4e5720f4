//! The units of a mesh file.

use super::error::MachineError;
use super::model::MeshUnits;
use super::table::Item;

/// Length units and their metres.
const LENGTHS: [(&str, f64); 7] =
    [("m", 1.0), ("dm", 1e-1), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6), ("in", 0.0254), ("ft", 0.3048)];
/// Mass units and their kilograms. A slinch is lbf s^2/in, a slug lbf s^2/ft.
const MASSES: [(&str, f64); 6] = [
    ("kg", 1.0),
    ("g", 1e-3),
    ("t", 1e3),
    ("lb", 0.453_592_37),
    ("slug", 4.448_221_615_260_5 / 0.3048),
    ("slinch", 4.448_221_615_260_5 / 0.0254),
];
/// Time units and their seconds.
const TIMES: [(&str, f64); 3] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6)];

/// `"m-kg-s"`, `"mm-t-s"`: length, mass and time, from which stress and density follow.
pub(super) fn read_units(item: &Item<'_>) -> Result<MeshUnits, MachineError> {
    let find = |table: &[(&str, f64)], name: &str| table.iter().find(|(n, _)| *n == name).map(|(_, factor)| *factor);
    let units = (|| {
        let mut names = item.text().ok()?.split('-');
        let (length, mass, time) = (names.next()?, names.next()?, names.next()?);
        let units =
            MeshUnits { length: find(&LENGTHS, length)?, mass: find(&MASSES, mass)?, time: find(&TIMES, time)? };
        names.next().is_none().then_some(units)
    })();
    let list = |table: &[(&str, f64)]| table.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    units.ok_or_else(|| {
        item.refuse(
            format!(
                "LENGTH-MASS-TIME, such as \"m-kg-s\" (N, Pa) or \"mm-t-s\" (N, MPa), of {}; {}; {}",
                list(&LENGTHS),
                list(&MASSES),
                list(&TIMES)
            ),
            "name the units that the mesh file is written in",
        )
    })
}
