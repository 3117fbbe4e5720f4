//! What a variable changes in the machine.

use super::*;
use stiffmap::machine::{Machine, ScrewSupport, SpringStiffness};
use stiffmap::sweep::PartScale;
use stiffmap::sweep::machine_values::machine_values;

fn with_variable(variable: &str) -> Study {
    let text = changed("[sampling]", &format!("{variable}\n[sampling]"));
    read(&text).unwrap_or_else(|e| panic!("{e}"))
}

/// The machine and its parts' scales with the third variable at a value.
fn at(study: &Study, value: f64) -> (Machine, Vec<PartScale>) {
    let design = study.design(&[50e6, 0.016, value]);
    (design.machine, design.parts)
}

fn screw(machine: &Machine) -> SpringStiffness {
    machine.joints[1].springs[0].stiffness
}

#[test]
fn springs_take_their_values_and_the_rest_stays() {
    let study = read(STUDY).unwrap();
    let design = study.design(&[33e6, 0.02]);
    let stiffness = |m: &Machine| m.joints[0].springs.iter().map(|s| s.stiffness).collect::<Vec<_>>();
    let expected = [33e6, 90e6, 2e5, 3e5, 1e5].map(SpringStiffness::Constant);
    assert_eq!(stiffness(&design.machine), expected);
    assert!(matches!(screw(&design.machine), SpringStiffness::BallScrew { diameter: 0.02, young: 210e9, .. }));
    assert_eq!(design.parts, [PartScale::NOMINAL; 2]);
    assert_ne!(stiffness(&study.machine), expected, "the nominal machine is not touched");
}

#[test]
fn factors_multiply_the_machines_own_values() {
    let study =
        with_variable("[variables.preload]\npaths = [\"joints.guide A.stiffness.y\"]\nfactor = true\nrange = [0.5, 2]");
    assert_eq!(at(&study, 0.5).0.joints[0].springs[1].stiffness, SpringStiffness::Constant(45e6));
    assert_eq!(study.variables[2].unit(), "");
}

#[test]
fn a_factor_on_a_part_whose_mesh_gives_the_material_may_be_below_one() {
    // 0.5 as a modulus in Pa would be refused; as a factor on what the mesh file says it halves it.
    let study =
        with_variable("[variables.scale]\npath = \"parts.bed.material.young\"\nfactor = true\nvalues = [0.5, 2.0]");
    let (_, parts) = at(&study, 0.5);
    assert_eq!([parts[0].young, parts[0].density, parts[1].young], [0.5, 1.0, 1.0]);
    let text = changed(
        "[sampling]",
        "[variables.v]\npath = \"parts.carriage.material.young\"\nvalues = [0.5, 2.0]\n[sampling]",
    );
    assert!(read(&text).unwrap_err().to_string().contains("a modulus from"), "an absolute value is judged");
}

#[test]
fn every_kind_of_place_can_be_varied() {
    let length = with_variable("[variables.l]\npath = \"joints.screw.free_length\"\nrange = [\"400 mm\", \"1 m\"]");
    assert!(matches!(screw(&at(&length, 0.7).0), SpringStiffness::BallScrew { free_length: Some(0.7), .. }));

    let fixity =
        "[variables.f]\npath = \"joints.screw.support\"\nvalues = [\"one-end\", \"both-ends\"]\nspan = \"900 mm\"";
    let study = with_variable(fixity);
    let support = |value| match screw(&at(&study, value).0) {
        SpringStiffness::BallScrew { support, .. } => support,
        SpringStiffness::Constant(k) => panic!("{k}"),
    };
    assert_eq!((support(0.0), support(1.0)), (ScrewSupport::OneEnd, ScrewSupport::BothEnds { span: 0.9 }));
    assert_eq!((study.variables[2].text(1.0), study.variables[2].read("one-end")), ("both-ends".into(), Some(0.0)));

    let ratio = with_variable("[variables.z]\npath = \"analysis.damping.ratio\"\nrange = [\"1 %\", 0.05]");
    assert_eq!(at(&ratio, 0.03).0.analysis.damping.ratios, [0.03]);
    let loss = with_variable("[variables.e]\npath = \"analysis.damping.loss_factor\"\nrange = [0, 0.05]");
    assert_eq!(at(&loss, 0.03).0.analysis.damping.loss_factor, 0.03);
    let joint = with_variable("[variables.e]\npath = \"joints.guide A.loss_factor\"\nrange = [0, 0.1]");
    assert_eq!(at(&joint, 0.05).0.joints[0].loss_factor, Some(0.05));
    let damper = with_variable("[variables.c]\npath = \"joints.guide A.damping.x\"\nrange = [0, \"5 N s/mm\"]");
    assert_eq!(at(&damper, 100.0).0.joints[0].springs[0].damping, 100.0);

    // The carriage has its material in the machine file, the bed in its mesh.
    let young =
        with_variable("[variables.e]\npath = \"parts.carriage.material.young\"\nrange = [\"70 GPa\", \"210 GPa\"]");
    assert_eq!(at(&young, 105e9).1, [PartScale::NOMINAL, PartScale { young: 0.5, density: 1.0 }]);
    let density =
        with_variable("[variables.r]\npath = \"parts.bed.material.density\"\nfactor = true\nrange = [0.3, 1]");
    assert_eq!(at(&density, 0.3).1, [PartScale { young: 1.0, density: 0.3 }, PartScale::NOMINAL]);
}

#[test]
fn a_design_is_written_as_values_of_the_machine_file_that_it_reads_back() {
    let study =
        with_variable("[variables.y]\npath = \"parts.carriage.material.young\"\nrange = [\"70 GPa\", \"210 GPa\"]");
    let text = machine_values(&study, &[33e6, 0.0185, 105e9], "Design 3");
    assert!(text.starts_with("# Design 3 of the study \"slide study\""), "{text}");
    for line in [
        "name = \"guide A\"\nstiffness.x = \"33000000 N/m\"",
        "name = \"screw\"\ndiameter = \"0.0185 m\"",
        "[parts.carriage.material]\nyoung = \"105000000000 Pa\"",
    ] {
        assert!(text.contains(line), "{line:?} is not in {text}");
    }
    let parsed: toml::Table = text.parse().unwrap();
    assert_eq!(parsed["joints"].as_array().unwrap().len(), 2);
}
