//! Joints: names, sides, and which sides may slide on each other.

use super::error::MachineError;
use super::interfaces::read_interface_ref;
use super::joint_kinds::{read_ball_screw, read_bearing, read_bolted, read_linear_guide, read_spring_damper};
use super::model::{Axis, InterfaceRef, Joint, Part};
use super::parts::read_loss_factor;
use super::table::{Item, Table, find_name};

type Result<T> = std::result::Result<T, MachineError>;

/// What a joint may refer to.
pub(super) struct Surroundings<'a> {
    pub parts: &'a [Part],
    pub axis: &'a Axis,
}

impl Surroundings<'_> {
    fn part_name(&self, side: InterfaceRef) -> &str {
        &self.parts[side.part].name
    }

    fn slides(&self, [a, b]: [InterfaceRef; 2]) -> bool {
        self.axis.moves[a.part] != self.axis.moves[b.part]
    }

    /// Refuses a joint whose two sides do not move against each other along the axis.
    pub fn check_slides(&self, item: &Item<'_>, between: [InterfaceRef; 2], kind: &str) -> Result<()> {
        if self.slides(between) {
            return Ok(());
        }
        let [a, b] = between.map(|side| self.part_name(side));
        let axis = &self.axis.name;
        let which = if self.axis.moves[between[0].part] { "both move" } else { "neither moves" };
        Err(item.refuse_seen(
            format!("a {kind} between {a:?} and {b:?}, of which {which} along the axis {axis:?}"),
            "two sides of which exactly one moves",
            format!("correct the side, or name the part that moves in axes.{axis}.moves"),
        ))
    }

    /// Refuses a joint whose two sides would slide away from each other.
    pub fn check_stays(&self, item: &Item<'_>, between: [InterfaceRef; 2], kind: &str) -> Result<()> {
        if !self.slides(between) {
            return Ok(());
        }
        let [a, b] = between.map(|side| self.part_name(side));
        let axis = &self.axis.name;
        Err(item.refuse_seen(
            format!("a {kind} between {a:?} and {b:?}, of which one moves along the axis {axis:?}"),
            "two sides that move together",
            format!("correct the side or axes.{axis}.moves; parts that slide are joined by a linear-guide"),
        ))
    }
}

pub(super) fn read_joints(root: &Table<'_>, around: &Surroundings<'_>) -> Result<Vec<Joint>> {
    let Some(list) = root.get("joints") else {
        return Ok(Vec::new());
    };
    let mut joints: Vec<Joint> = Vec::new();
    for mut item in list.list()? {
        let name_item = item.table()?.need("name", "name = \"my joint\"")?;
        let name = name_item.text()?;
        name_item.check_name(name)?;
        if joints.iter().any(|joint| joint.name == name) {
            let place = name_item.place();
            return Err(MachineError::Duplicate { place, kind: "joint", name: name.to_owned() });
        }
        item.key = format!("{} {name:?}", item.key);
        joints.push(read_joint(&item, name, around)?);
    }
    Ok(joints)
}

fn read_joint(item: &Item<'_>, name: &str, around: &Surroundings<'_>) -> Result<Joint> {
    const KINDS: [&str; 5] = ["linear-guide", "bearing", "ball-screw", "bolted", "spring-damper"];
    let table = item.table()?;
    table.get("name");
    let kind = table
        .need("type", "type = \"linear-guide\"  # or \"bearing\", \"ball-screw\", \"bolted\", \"spring-damper\"")?;
    let loss_factor = table.get("loss_factor").map(|item| read_loss_factor(&item)).transpose()?;
    let joint = match find_name(&kind, "joint type", kind.text()?, &KINDS)? {
        0 => read_linear_guide(&table, around)?,
        1 => read_bearing(&table, around)?,
        2 => read_ball_screw(&table, around)?,
        3 => read_bolted(&table, around)?,
        _ => read_spring_damper(&table, around)?,
    };
    table.finish()?;
    Ok(Joint { name: name.to_owned(), loss_factor, ..joint })
}

/// The two interfaces of `between`, in the file's order.
pub(super) fn read_between<'a>(table: &Table<'a>, around: &Surroundings<'_>) -> Result<(Item<'a>, [InterfaceRef; 2])> {
    let item = table.need("between", "between = [\"PART.INTERFACE\", \"PART.INTERFACE\"]")?;
    let [first, second] = item.array()?;
    let between = [read_interface_ref(&first, around.parts)?, read_interface_ref(&second, around.parts)?];
    check_distinct(&item, between)?;
    Ok((item, between))
}

/// Refuses a joint of an interface with itself.
fn check_distinct(item: &Item<'_>, between: [InterfaceRef; 2]) -> Result<()> {
    if between[0] != between[1] {
        return Ok(());
    }
    Err(item.refuse("two different interfaces", "correct one of the sides"))
}
