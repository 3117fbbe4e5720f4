//! Friction of a guide and backlash of a screw.

use super::*;

const FOOTPRINT: &str = "footprint = \"90 mm\"";
const DIAMETER: &str = "diameter = \"40 mm\"";

fn with_friction(value: &str) -> String {
    changed(FOOTPRINT, &format!("{FOOTPRINT}\nfriction = {value}"))
}

#[test]
fn friction_adds_a_row_along_the_travel_and_backlash_a_length() {
    let machine = accepted(
        FOOTPRINT,
        "footprint = \"90 mm\"\nfriction = { coulomb = \"50 N\", breakaway = \"0.08 kN\", stribeck = \"1 mm/s\" }",
    );
    let friction = Friction { coulomb: 50.0, breakaway: 80.0, stribeck: 1e-3 };
    assert_eq!(machine.joints[0].contact, Some(Contact::Friction(friction)));
    let row = machine.joints[0].springs.last().unwrap();
    assert_eq!((row.label.as_str(), row.direction), ("travel", [0.0, 0.0, 1.0]));
    assert_eq!(row.stiffness, SpringStiffness::Constant(0.0));
    let plain = accepted(DIAMETER, "diameter = \"40 mm\"\nbacklash = \"10 um\"");
    assert_eq!(plain.joints[1].contact, Some(Contact::Backlash(1e-5)));
    assert_eq!(plain.joints[0].contact, None);
    assert_eq!(plain.joints[0].springs.len() + 1, machine.joints[0].springs.len());
    let coulomb = read(&with_friction("{ coulomb = 50 }")).unwrap();
    let Some(Contact::Friction(law)) = coulomb.joints[0].contact else { panic!("{:?}", coulomb.joints[0].contact) };
    assert_eq!((law.breakaway, law.at(0.3)), (50.0, 50.0));
}

#[test]
fn laws_that_are_none_are_refused() {
    refused(
        &with_friction("{ coulomb = \"-1 N\" }"),
        &["friction.coulomb: found \"-1 N\"", "zero or a positive value"],
    );
    refused(&with_friction("{ coulomb = \"1 N/m\" }"), &["friction.coulomb", "a force in N, kN"]);
    refused(&with_friction("{ breakaway = \"1 N\" }"), &["the key `coulomb` is missing"]);
    refused(
        &with_friction("{ coulomb = \"5 N\", breakaway = \"8 N\" }"),
        &["friction.breakaway", "`breakaway` and `stribeck` together, or neither"],
    );
    refused(
        &with_friction("{ coulomb = \"5 N\", breakaway = \"4 N\", stribeck = \"1 mm/s\" }"),
        &["friction.breakaway", "at least `coulomb`, 5 N"],
    );
    refused(
        &with_friction("{ coulomb = \"5 N\", breakaway = \"8 N\", stribeck = 0 }"),
        &["friction.stribeck: found 0", "a speed in m/s"],
    );
    refused(&with_friction("{ coulomb = \"5 N\", viscous = 3 }"), &["unknown key `viscous`"]);
    refused_change(DIAMETER, "diameter = \"40 mm\"\nbacklash = \"-1 um\"", &["backlash: found \"-1 um\""]);
    refused_change(DIAMETER, "diameter = \"40 mm\"\nfriction = { coulomb = 1 }", &["unknown key `friction`"]);
}
