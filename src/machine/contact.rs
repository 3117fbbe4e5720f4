//! Nonlinear laws of joints: friction of a guide, backlash of a screw.

use super::error::MachineError;
use super::model::{Contact, Friction};
use super::quantity::Dimension;
use super::table::{Bound, Item};

type Result<T> = std::result::Result<T, MachineError>;

/// `friction = { coulomb = "50 N", breakaway = "80 N", stribeck = "1 mm/s" }`; the last two go together.
pub(super) fn read_friction(item: &Item<'_>) -> Result<Friction> {
    let table = item.table()?;
    let coulomb = table.need("coulomb", "coulomb = \"50 N\"")?.quantity(Dimension::Force, Bound::NotNegative)?;
    let (breakaway, stribeck) = (table.get("breakaway"), table.get("stribeck"));
    let friction = match (&breakaway, &stribeck) {
        (None, None) => Friction { coulomb, breakaway: coulomb, stribeck: f64::INFINITY },
        (Some(force), Some(speed)) => {
            let breakaway = force.quantity(Dimension::Force, Bound::NotNegative)?;
            if breakaway < coulomb {
                return Err(force.refuse(format!("at least `coulomb`, {coulomb} N"), "exchange the two"));
            }
            Friction { coulomb, breakaway, stribeck: speed.quantity(Dimension::Speed, Bound::Positive)? }
        }
        (Some(one), None) | (None, Some(one)) => {
            return Err(one.refuse(
                "`breakaway` and `stribeck` together, or neither",
                format!("add the other: breakaway = \"{} N\" and stribeck = \"1 mm/s\"", 1.5 * coulomb),
            ));
        }
    };
    table.finish()?;
    Ok(friction)
}

/// `backlash = "10 um"`.
pub(super) fn read_backlash(item: &Item<'_>) -> Result<Contact> {
    Ok(Contact::Backlash(item.quantity(Dimension::Length, Bound::NotNegative)?))
}
