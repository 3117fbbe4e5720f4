//! Slips in the joints: which sides, how stiff, how damped, which screw, which bearing.

use super::slips::Slip;

const GUIDE_A: &str = "rail = \"bed.rail_left\"\ncarriage = \"slide.pad_a\"\nfootprint = \"100 mm\"";
const AT: &str = "at = [\"350 mm\", \"75 mm\", \"250 mm\"]";

pub const JOINTS: &[Slip] = &[
    // Guides.
    (
        "rails swapped",
        &[(
            "rail = \"bed.rail_left\"\ncarriage = \"slide.pad_a\"",
            "rail = \"bed.rail_right\"\ncarriage = \"slide.pad_a\"",
        )],
        &["joints[1] \"guide A\".rail", "rails swapped", "rail = \"bed.rail_left\""],
    ),
    (
        "the wrong carriage",
        &[("carriage = \"slide.pad_a\"", "carriage = \"slide.pad_b\"")],
        &["joints[1] \"guide A\".rail", "bed.rail_right is 20 mm from it"],
    ),
    (
        "a carriage above its rail",
        &[("mesh = \"slide.inp\"", "mesh = \"slide.inp\"\norigin = [0, 0, \"300 mm\"]")],
        &["joints[1] \"guide A\".carriage: slide.pad_a lies 320 mm from the rail bed.rail_left", "origin"],
    ),
    (
        "rail and carriage exchanged",
        &[(GUIDE_A, "rail = \"slide.pad_a\"\ncarriage = \"bed.rail_left\"\nfootprint = \"100 mm\"")],
        &["joints[1] \"guide A\".rail", "rail and carriage swapped"],
    ),
    (
        "footprint in centimetres",
        &[(GUIDE_A, "rail = \"bed.rail_left\"\ncarriage = \"slide.pad_a\"\nfootprint = \"10 mm\"")],
        &["joints[1] \"guide A\".footprint: 10 mm", "15 mm"],
    ),
    (
        "footprint in metres",
        &[(GUIDE_A, "rail = \"bed.rail_left\"\ncarriage = \"slide.pad_a\"\nfootprint = 100")],
        &["joints[1] \"guide A\".footprint: 100 m", "metres for millimetres"],
    ),
    (
        "N/m for N/um",
        &[("y = \"150 N/um\", z = \"250 N/um\", rx", "y = 150, z = \"250 N/um\", rx")],
        &["joints[1] \"guide A\".stiffness.y: 150 N/m", "N/m for N/um", "150 N/um was meant"],
    ),
    (
        "N/mm for N/um",
        &[("y = \"150 N/um\", z = \"250 N/um\", rx", "y = \"150 N/mm\", z = \"250 N/um\", rx")],
        &["joints[1] \"guide A\".stiffness.y", "N/mm for N/um"],
    ),
    (
        "N/m written as N/um",
        &[("y = \"150 N/um\", z = \"250 N/um\", rx", "y = \"150e6 N/um\", z = \"250 N/um\", rx")],
        &["joints[1] \"guide A\".stiffness.y", "already in N/m"],
    ),
    (
        "a stiffness of 1e30",
        &[("y = \"150 N/um\", z = \"250 N/um\", rx", "y = 1e30, z = \"250 N/um\", rx")],
        &["joints[1] \"guide A\".stiffness.y: found 1e30", "to 1e22 N/m"],
    ),
    (
        "kN m/rad as N m/rad",
        &[("rx = \"2e5 N m/rad\"", "rx = \"2 N m/rad\"")],
        &["joints[1] \"guide A\".stiffness.rx: 2 N m/rad", "kN m/rad"],
    ),
    (
        "N s/mm for N s/m",
        &[("{ y = \"2000 N s/m\"", "{ y = \"2000 N s/mm\"")],
        &["joints[1] \"guide A\".damping.y: 2e6 N s/m", "N s/mm for N s/m"],
    ),
    (
        "a damper of 1e7 N s/m",
        &[("{ y = \"2000 N s/m\"", "{ y = 1e7")],
        &["joints[1] \"guide A\".damping.y: 1e7 N s/m", "damping ratio of"],
    ),
    (
        "kN as N",
        &[("coulomb = \"50 N\", breakaway = \"80 N\"", "coulomb = \"50 N\", breakaway = \"800 kN\"")],
        &["joints[1] \"guide A\".friction.breakaway: 800 kN"],
    ),
    (
        "a Stribeck speed in m/s",
        &[("stribeck = \"1 mm/s\"", "stribeck = 5")],
        &["joints[1] \"guide A\".friction.stribeck: 5 m/s", "m/s for mm/s"],
    ),
    // Screw.
    (
        "diameter in metres",
        &[("diameter = \"25 mm\"", "diameter = 25")],
        &["joints[5] \"screw\".diameter: 25 m", "metres for millimetres"],
    ),
    (
        "diameter in micrometres",
        &[("diameter = \"25 mm\"", "diameter = \"25 um\"")],
        &["joints[5] \"screw\".diameter: 25 um", "um for mm"],
    ),
    (
        "a diameter of 1e305 m",
        &[("diameter = \"25 mm\"", "diameter = 1e305")],
        &["joints[5] \"screw\".diameter: found 1e305", "to 1e5 m"],
    ),
    (
        "diameter for length",
        &[("diameter = \"25 mm\"", "diameter = \"900 mm\"")],
        &["joints[5] \"screw\".diameter: 900 mm", "of `between`"],
    ),
    (
        "free length in metres",
        &[("free_length = \"200 mm\"", "free_length = 200")],
        &["joints[5] \"screw\".free_length: 200 m", "metres for millimetres"],
    ),
    (
        "free length in micrometres",
        &[("free_length = \"200 mm\"", "free_length = \"200 um\"")],
        &["joints[5] \"screw\".free_length: 0.2 mm", "um for mm"],
    ),
    (
        "span in metres",
        &[("span = \"900 mm\"", "span = 900")],
        &["joints[5] \"screw\".span: 900 m", "metres for millimetres"],
    ),
    (
        "MPa of a screw",
        &[("young = \"210 GPa\"\ndiameter", "young = \"210 MPa\"\ndiameter")],
        &["joints[5] \"screw\".young: 0.21 GPa", "MPa for GPa"],
    ),
    (
        "backlash in metres",
        &[("backlash = \"10 um\"", "backlash = 10")],
        &["joints[5] \"screw\".backlash: 10 m", "micrometres"],
    ),
    (
        "backlash in millimetres",
        &[("backlash = \"10 um\"", "backlash = \"10 mm\"")],
        &["joints[5] \"screw\".backlash: 10 mm", "mm for um"],
    ),
    (
        "the wrong nut",
        &[
            ("between = [\"bed.mount\", \"slide.nut\"]", "between = [\"bed.mount\", \"spindle.nose\"]"),
            (
                "mount = { nodes = \"MOUNT\" }",
                "mount = { nodes = \"MOUNT\", within = { axis = \"y\", from = \"150 mm\", to = \"250 mm\" } }",
            ),
        ],
        &["joints[5] \"screw\".between", "across the travel", "mount or the nut"],
    ),
    // Bolts and springs.
    (
        "bolts in N/um as N/m",
        &[("{ x = \"1e9 N/m\", y", "{ x = 1000, y")],
        &["joints[6] \"foot\".stiffness.x: 1000 N/m", "N/m for N/um"],
    ),
    (
        "bolts in N/m as N/um",
        &[("{ x = \"1e9 N/m\", y", "{ x = \"1e9 N/um\", y")],
        &["joints[6] \"foot\".stiffness.x", "already in N/m"],
    ),
    (
        "bolted to the wrong end",
        &[(
            "between = [\"slide.top\", \"head.foot\"]",
            "between = [\"slide.top\", \"head.foot\"]\nat = [350, 150, 170]",
        )],
        &["joints[6] \"foot\".at: (350, 150, 170) m", "metres for millimetres"],
    ),
    (
        "between two clamped faces",
        &[
            (
                "between = [\"bed.mount\", \"head.foot\"]\ndirection",
                "between = [\"bed.feet\", \"bed.feet_too\"]\ndirection",
            ),
            (
                "feet = { nodes = \"FEET\" }",
                "feet = { nodes = \"FEET\" }\nfeet_too = { nodes = \"FEET\", within = { axis = \"x\", from = \"0 mm\", to = \"500 mm\" } }",
            ),
        ],
        &["joints[9] \"counterweight\"", "fixed to ground"],
    ),
    // Bearings.
    (
        "a bearing across its bore",
        &[("axis = \"y\"\nat", "axis = \"x\"\nat")],
        &["joints[7] \"front bearing\".axis: x across the bore, which runs along y", "axis = \"y\""],
    ),
    (
        "a bearing across its bore, obliquely",
        &[("axis = \"y\"\nat", "axis = [1, 0, 1]\nat")],
        &["joints[7] \"front bearing\".axis", "axis = \"y\""],
    ),
    (
        "at in metres",
        &[(AT, "at = [350, 75, 250]")],
        &[
            "joints[7] \"front bearing\".at: (350, 75, 250) m",
            "metres for millimetres",
            "at = [\"350 mm\", \"75 mm\", \"250 mm\"]",
        ],
    ),
    (
        "at of an example",
        &[(AT, "at = [\"0 mm\", \"0 mm\", \"100 mm\"]")],
        &["joints[7] \"front bearing\".at", "leave `at` out for the seat's centroid"],
    ),
    (
        "at off the axis",
        &[(AT, "at = [\"380 mm\", \"75 mm\", \"250 mm\"]")],
        &["joints[7] \"front bearing\".at", "30 mm off the axis of head.seat_front"],
    ),
    (
        "at of 1e27 m",
        &[(AT, "at = [\"350 mm\", \"75 mm\", \"1e30 mm\"]")],
        &["machine.toml:", "joints[7] \"front bearing\".at[3]: found \"1e30 mm\"", "1e5 m"],
    ),
    (
        "radial in N/m",
        &[("{ radial = \"200 N/um\"", "{ radial = 200")],
        &["joints[7] \"front bearing\".stiffness.radial: 200 N/m", "N/m for N/um"],
    ),
    (
        "axial in N/m",
        &[("axial = \"100 N/um\"", "axial = 100")],
        &["joints[7] \"front bearing\".stiffness.axial: 100 N/m", "N/m for N/um"],
    ),
    (
        "a loss factor in per cent",
        &[("loss_factor = 0.02", "loss_factor = 2")],
        &["joints[7] \"front bearing\".loss_factor: 2", "write \"2 %\""],
    ),
    (
        "the wrong seat",
        &[("[\"head.seat_front\", \"spindle.journal_front\"]", "[\"head.seat_rear\", \"spindle.journal_front\"]")],
        &["joints[7] \"front bearing\"", "apart"],
    ),
];
