//! Typical slips, one a row: what is written instead of what, and the words that must be said.

use super::slips_of_joints::JOINTS;
use super::{mill, told};

/// Name, replacements in the machine file, words of one warning (or of the refusal).
pub type Slip = (&'static str, &'static [(&'static str, &'static str)], &'static [&'static str]);

const BED_MATERIAL: &str = "young = \"115 GPa\", poisson = 0.26, density = \"7200 kg/m3\" }\nclamped";
const GRID: &str = "{ from = \"0 Hz\", to = \"1500 Hz\", step = \"10 Hz\" }";
const RATIO: &str = "damping = { ratio = 0.02 }";

const PARTS_AND_ANALYSIS: &[Slip] = &[
    // Units of the meshes.
    ("metres for millimetres", &[("mm-t-s", "m-kg-s")], &["parts.bed: ", "kg", "units = \"mm-t-s\""]),
    (
        "one part in metres",
        &[("mesh = \"spindle.inp\"", "mesh = \"spindle.inp\"\nunits = \"m-kg-s\"")],
        &["parts.spindle: ", "metres for millimetres"],
    ),
    (
        "one part in micrometres",
        &[("mesh = \"head.inp\"", "mesh = \"head.inp\"\nunits = \"um-t-s\"")],
        &["parts.head: ", "millimetres for metres", "m-kg-s"],
    ),
    (
        "a part somewhere else",
        &[("mesh = \"head.inp\"", "mesh = \"head.inp\"\norigin = [0, 0, 3]")],
        &["joints[6] \"foot\".between", "apart", "origin"],
    ),
    // Materials.
    (
        "MPa for GPa",
        &[(BED_MATERIAL, "young = \"115 MPa\", poisson = 0.26, density = \"7200 kg/m3\" }\nclamped")],
        &["parts.bed.material.young", "MPa for GPa"],
    ),
    (
        "MPa as a plain number",
        &[(BED_MATERIAL, "young = 115e3, poisson = 0.26, density = \"7200 kg/m3\" }\nclamped")],
        &["parts.bed.material.young", "115 GPa was meant", "N/mm2 given as Pa"],
    ),
    (
        "GPa as a plain number",
        &[(BED_MATERIAL, "young = 115, poisson = 0.26, density = \"7200 kg/m3\" }\nclamped")],
        &["parts.bed.material.young", "GPa given as Pa"],
    ),
    (
        "kPa too many",
        &[(BED_MATERIAL, "young = \"115e9 MPa\", poisson = 0.26, density = \"7200 kg/m3\" }\nclamped")],
        &["parts.bed.material.young", "modulus from 1"],
    ),
    (
        "t/mm3 as a plain number",
        &[(BED_MATERIAL, "young = \"115 GPa\", poisson = 0.26, density = 7.2e-9 }\nclamped")],
        &["parts.bed.material.density", "density from"],
    ),
    (
        "g/cm3 as a plain number",
        &[(BED_MATERIAL, "young = \"115 GPa\", poisson = 0.26, density = 7.2 }\nclamped")],
        &["parts.bed.material.density", "g/cm3 for kg/m3"],
    ),
    (
        "kg/m3 as g/cm3",
        &[(BED_MATERIAL, "young = \"115 GPa\", poisson = 0.26, density = \"7200 g/cm3\" }\nclamped")],
        &["parts.bed.material.density", "7200 kg/m3 was meant"],
    ),
    (
        "a sign",
        &[(BED_MATERIAL, "young = \"115 GPa\", poisson = -0.26, density = \"7200 kg/m3\" }\nclamped")],
        &["parts.bed.material.poisson: -0.26", "sign"],
    ),
    (
        "Poisson's ratio of rubber on iron",
        &[(BED_MATERIAL, "young = \"115 GPa\", poisson = 0.49, density = \"7200 kg/m3\" }\nclamped")],
        &["poisson: 0.49", "steel 0.3"],
    ),
    (
        "a density of nothing",
        &[(BED_MATERIAL, "young = \"115 GPa\", poisson = 0.26, density = 1e-300 }\nclamped")],
        &["machine.toml:14: parts.bed.material.density", "1e-300", "from 1e-6 to 1e9 kg/m3"],
    ),
    (
        "a modulus of 1e300",
        &[(BED_MATERIAL, "young = 1e300, poisson = 0.26, density = \"7200 kg/m3\" }\nclamped")],
        &["parts.bed.material.young: found 1e300", "to 1e16 Pa"],
    ),
    // Axis.
    (
        "travel in metres",
        &[("[\"0 mm\", \"400 mm\"]", "[0, 400]")],
        &["axes.x.travel", "400 m", "metres for millimetres"],
    ),
    ("step in metres", &[("step = \"20 mm\"", "step = 20")], &["axes.x.step: 20 m", "metres for millimetres"]),
    (
        "no screw",
        &[
            ("type = \"ball-screw\"", "type = \"spring-damper\""),
            (
                "axis = \"x\"\nyoung = \"210 GPa\"\ndiameter = \"25 mm\"\nfree_length = \"200 mm\"\nsupport = \"both-ends\"\nspan = \"900 mm\"\nbacklash = \"10 um\"\ndamping = \"500 N s/m\"",
                "stiffness = { z = \"1 N/um\" }",
            ),
        ],
        &["axes.x: nothing holds slide, head, spindle along the travel", "ball-screw"],
    ),
    // Ports and analysis.
    (
        "a port on a clamped face",
        &[("interface = \"spindle.nose\"", "interface = \"bed.feet\"")],
        &["ports.tool.interface: bed.feet", "receptance is 0"],
    ),
    (
        "kHz as a plain number",
        &[(GRID, "{ from = 0, to = 1.5, step = 0.01 }")],
        &["analysis.frequencies: 1.5 Hz", "kHz given as Hz"],
    ),
    (
        "kHz for Hz",
        &[(GRID, "{ from = \"0 Hz\", to = \"1500 kHz\", step = \"10 kHz\" }")],
        &["analysis.frequencies: 1500 kHz", "kHz for Hz"],
    ),
    ("a band in kHz", &[("band = \"20 kHz\"", "band = 20")], &["analysis.component.band: 20 Hz", "1500 Hz"]),
    (
        "per cent for share",
        &[(RATIO, "damping = { ratio = 0.5 }")],
        &["analysis.damping.ratio: 0.5", "write \"0.5 %\""],
    ),
    ("per cent in a list", &[(RATIO, "damping = { ratios = [0.02, 0.5] }")], &["analysis.damping.ratios: 0.5"]),
    (
        "per cent for share, refused",
        &[(RATIO, "damping = { ratio = 2 }")],
        &["analysis.damping.ratio: found 2", "\"2 %\""],
    ),
    (
        "a loss factor of the machine in per cent",
        &[(RATIO, "damping = { loss_factor = 2 }")],
        &["analysis.damping.loss_factor: 2", "per cent"],
    ),
    (
        "beta in milliseconds",
        &[(RATIO, "damping = { rayleigh = { alpha = 1, beta = 0.01 } }")],
        &["analysis.damping.rayleigh.beta", "milliseconds"],
    ),
    (
        "alpha of 1e5",
        &[(RATIO, "damping = { rayleigh = { alpha = 1e5, beta = 0 } }")],
        &["analysis.damping.rayleigh.alpha"],
    ),
    (
        "a part's loss factor in per cent",
        &[("loss_factor = 0.004", "loss_factor = 1.5")],
        &["parts.bed.loss_factor: 1.5", "write \"1.5 %\""],
    ),
];

fn all() -> impl Iterator<Item = &'static Slip> {
    PARTS_AND_ANALYSIS.iter().chain(JOINTS)
}

#[test]
fn the_machine_as_it_is_gets_no_warning() {
    assert_eq!(told(mill(&[]).path()), Ok(Vec::new()));
}

#[test]
fn each_slip_is_told_with_its_place_and_its_likely_cause() {
    assert!(all().count() > 60);
    let mut missed = Vec::new();
    for (name, edits, words) in all() {
        let lines = told(mill(edits).path()).unwrap_or_else(|refusal| vec![refusal]);
        // All words must stand in one line: several warnings that share them out explain nothing.
        if !lines.iter().any(|line| words.iter().all(|word| line.contains(word))) {
            missed.push(format!("{name}: {words:?} not in {lines:#?}"));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

#[test]
fn a_slip_that_is_made_in_four_guides_is_told_once() {
    let lines = told(mill(&[("y = \"150 N/um\"", "y = 150")]).path()).unwrap();
    let [line] = lines.as_slice() else { panic!("{lines:#?}") };
    for (index, guide) in ["A", "B", "C", "D"].iter().enumerate() {
        assert!(line.contains(&format!("joints[{}] \"guide {guide}\".stiffness.y", index + 1)), "{line}");
    }
}

#[test]
fn one_slip_makes_few_warnings() {
    for (name, edits, _) in all().filter(|(_, edits, _)| edits.len() == 1) {
        let Ok(lines) = told(mill(edits).path()) else { continue };
        assert!(lines.len() <= 5, "{name}: {lines:#?}");
    }
}
