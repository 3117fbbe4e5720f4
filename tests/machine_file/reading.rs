//! What is read from a machine file.

use super::*;
use std::path::{Path, PathBuf};

fn constant(spring: &Spring) -> f64 {
    match spring.stiffness {
        SpringStiffness::Constant(k) => k,
        SpringStiffness::BallScrew { .. } => panic!("{} is a ball screw", spring.label),
    }
}

fn bundled_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/vertical_mill")
}

#[test]
fn the_small_machine_is_read_in_si_with_names_resolved() {
    let machine = read(MACHINE).unwrap();
    assert_eq!(machine.name, "small mill");
    assert_eq!(machine.axis.direction, [0.0, 0.0, 1.0]);
    assert_eq!(machine.axis.travel, [0.0, -0.1]);
    assert_eq!(machine.axis.step, 0.005);
    assert_eq!(machine.axis.moves, [false, true]);
    assert_eq!(machine.axis.stations().len(), 21);
    let [guide, screw] = machine.joints.as_slice() else { panic!("two joints") };
    let side = |part, interface| InterfaceRef { part, interface };
    assert_eq!(guide.kind, JointKind::LinearGuide);
    assert_eq!(guide.between, [side(0, 0), side(1, 0)]);
    assert_eq!((guide.footprint, guide.at), (Some(0.09), JointPoint::Centroid(1)));
    let springs: Vec<_> =
        guide.springs.iter().map(|s| (s.label.as_str(), s.direction, constant(s), s.damping)).collect();
    assert_eq!(springs, [("x", [1.0, 0.0, 0.0], 77e6, 100.0), ("y", [0.0, 1.0, 0.0], 77e6, 0.0)]);
    assert_eq!(screw.between, [side(0, 1), side(1, 1)]);
    assert_eq!(
        screw.springs[0].stiffness,
        SpringStiffness::BallScrew { young: 210e9, diameter: 0.04, free_length: None, support: ScrewSupport::OneEnd }
    );
    let tip = &machine.parts[1].interfaces[2];
    let region = tip.within.unwrap();
    assert_eq!((region.min[2], region.max[2]), (0.01, 0.03));
    assert_eq!((region.min[0], region.max[1]), (f64::NEG_INFINITY, f64::INFINITY));
    assert_eq!(tip.coupling, SurfaceCoupling::Distributing);
    let port = &machine.ports[0];
    assert_eq!((port.interface, port.input, port.output), (side(1, 2), true, true));
    assert_eq!(port.directions, [("x".to_owned(), [1.0, 0.0, 0.0]), ("z".to_owned(), [0.0, 0.0, 1.0])]);
    assert_eq!(machine.analysis.frequencies, (0..=10).map(f64::from).collect::<Vec<_>>());
    assert_eq!(
        machine.analysis.damping,
        Damping { ratios: vec![0.02], rayleigh: None, loss_factor: 0.0, projected: false }
    );
    let component = machine.analysis.component;
    assert_eq!((component.modes, component.band, component.second_moment), (50, f64::INFINITY, true));
}

#[test]
fn the_bundled_mill_has_the_papers_17_springs_and_two_bolted_joints() {
    let machine = read_machine(&bundled_folder()).unwrap();
    let springs_of = |kind| -> Vec<&Spring> {
        machine.joints.iter().filter(|joint| joint.kind == kind).flat_map(|joint| &joint.springs).collect()
    };
    let (guides, bearings) = (springs_of(JointKind::LinearGuide), springs_of(JointKind::Bearing));
    // The paper counts a bearing's two radial directions as one radial element.
    let papers_bearings = bearings.iter().filter(|s| s.label != "radial 2").count();
    assert_eq!(guides.len() + papers_bearings + springs_of(JointKind::BallScrew).len(), 17);
    assert!(guides.iter().all(|s| constant(s) == 77e6));
    for spring in &bearings {
        assert_eq!(constant(spring), if spring.label == "axial" { 59.5e6 } else { 119.8e6 }, "{}", spring.label);
    }
    let bolts = springs_of(JointKind::Bolted);
    assert_eq!(bolts.len(), 12);
    for spring in bolts {
        assert_eq!(constant(spring), if spring.motion == Motion::Translation { 1e10 } else { 1e8 });
    }
    let heights: Vec<_> =
        machine.joints.iter().filter(|joint| joint.kind == JointKind::Bearing).map(|j| j.at).collect();
    assert_eq!(heights, [1.03, 1.09, 1.50, 1.56].map(|z| JointPoint::Point([0.0, -0.4, z])));
    for joint in machine.joints.iter().filter(|joint| joint.kind == JointKind::Bearing) {
        let JointPoint::Point([.., z]) = joint.at else { panic!("a bearing has a point") };
        for side in joint.between {
            let region = machine.parts[side.part].interfaces[side.interface].within.unwrap();
            assert!((region.min[2] - (z - 0.01)).abs() < 1e-12 && (region.max[2] - (z + 0.01)).abs() < 1e-12);
        }
    }
    let stations = machine.axis.stations();
    assert_eq!((stations.len(), stations[0], stations[1], stations[120]), (121, 0.0, -0.005, -0.6));
    assert_eq!(
        machine.parts.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(),
        ["column", "headstock", "spindle", "drive", "magazine"]
    );
    assert_eq!(machine.axis.moves, [false, true, true, true, false]);
}

#[test]
fn the_bundled_files_written_out_are_the_machine_of_the_repository() {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in bundled_vertical_mill() {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    let written = read_machine(&folder.path().join("machine.toml")).unwrap();
    let original = read_machine(&bundled_folder()).unwrap();
    assert_eq!(format!("{:?}", written.joints), format!("{:?}", original.joints));
    for (ours, theirs) in written.parts.iter().zip(&original.parts) {
        assert_eq!(std::fs::read(&ours.mesh).unwrap(), std::fs::read(&theirs.mesh).unwrap(), "{}", ours.name);
    }
}

#[test]
fn every_kind_of_joint_damper_and_material_override_is_read() {
    let extra = r#"
[[joints]]
name = "bearing"
type = "bearing"
between = ["head.tip", "head.nut"]
axis = "y"
at = ["1 mm", "2 mm", 0.003]
stiffness = { radial = "1 kN/mm", axial = "2 N/um" }
damping = { radial = "5 N s/m" }
loss_factor = "3 %"

[[joints]]
name = "damper"
type = "spring-damper"
between = ["column.mount", "head.tip"]
direction = [3, 4, 0]
damping = "100 N s/m"

[[joints]]
name = "pad"
type = "spring-damper"
between = ["column.mount", "head.tip"]
at = [0, 0, 0]
stiffness = { z = "1 MN/m", rx = "1e3 N m/rad" }
damping = { rx = "2 N m s/rad" }

[ports.tool]
"#;
    let text = changed("[ports.tool]\n", extra);
    let text = text.replace(
        "mesh = \"head.inp\"",
        "mesh = \"head.inp\"\nunits = \"mm-t-s\"\nmaterial = { young = \"70 GPa\", poisson = 0.33, density = \"2.7 g/cm3\" }",
    );
    let machine = read(&text).unwrap_or_else(|error| panic!("{error}"));
    let [_, _, bearing, damper, pad] = machine.joints.as_slice() else { panic!("five joints") };
    assert_eq!(bearing.at, JointPoint::Point([0.001, 0.002, 0.003]));
    assert_eq!(bearing.loss_factor, Some(0.03));
    let springs: Vec<_> =
        bearing.springs.iter().map(|s| (s.label.as_str(), s.direction, constant(s), s.damping)).collect();
    assert_eq!(
        springs,
        [
            ("radial 1", [1.0, 0.0, 0.0], 1e6, 5.0),
            ("radial 2", [0.0, 0.0, -1.0], 1e6, 5.0),
            ("axial", [0.0, 1.0, 0.0], 2e6, 0.0),
        ]
    );
    assert_eq!((constant(&damper.springs[0]), damper.springs[0].damping), (0.0, 100.0));
    assert!((damper.springs[0].direction[0] - 0.6).abs() < 1e-15);
    assert_eq!(
        (pad.springs[1].motion, constant(&pad.springs[1]), pad.springs[1].damping),
        (Motion::Rotation, 1e3, 2.0)
    );
    let head = &machine.parts[1];
    assert_eq!(head.mesh_units, MeshUnits::MILLIMETRE_TONNE_SECOND);
    let material = head.material.as_ref().unwrap();
    assert_eq!((material.young, material.poisson), (70e9, 0.33));
    assert!((material.density - 2700.0).abs() < 1e-9);
}

#[test]
fn the_other_forms_of_region_frequencies_and_damping_are_read() {
    let machine =
        accepted("{ axis = \"z\", from = \"10 mm\", to = \"30 mm\" }", "{ x = [0, \"1 m\"], z = [\"-1 mm\", 0] }");
    let region = machine.parts[1].interfaces[2].within.unwrap();
    assert_eq!((region.min, region.max), ([0.0, f64::NEG_INFINITY, -0.001], [1.0, f64::INFINITY, 0.0]));
    let machine = accepted("{ from = \"0 Hz\", to = \"10 Hz\", step = \"1 Hz\" }", "[1, \"0.01 kHz\", 12.5]");
    assert_eq!(machine.analysis.frequencies, [1.0, 10.0, 12.5]);
    let machine = accepted("to = \"10 Hz\", step = \"1 Hz\"", "to = 1, step = 0.3");
    assert_eq!(machine.analysis.frequencies.len(), 5, "the end belongs to the grid");
    assert_eq!(machine.analysis.frequencies[4], 1.0);
    let machine = accepted("to = \"10 Hz\", step = \"1 Hz\"", "to = 0.9, step = 0.1");
    assert_eq!(machine.analysis.frequencies.len(), 10, "rounding adds no point");
    let machine = accepted(
        "{ ratio = 0.02 }",
        "{ ratios = [\"1 %\", 0.03], rayleigh = { alpha = \"2 1/s\", beta = \"1 us\" }, loss_factor = 0.1 }",
    );
    assert_eq!(
        machine.analysis.damping,
        Damping { ratios: vec![0.01, 0.03], rayleigh: Some([2.0, 1e-6]), loss_factor: 0.1, projected: false }
    );
    let machine = accepted(
        "{ modes = 50 }",
        "{ modes = 40, band = \"1.4 kHz\", method = \"free-interface\", second_moment = false }",
    );
    let component = machine.analysis.component;
    assert_eq!((component.modes, component.band, component.second_moment), (40, 1400.0, false));
    assert_eq!(component.method, ReductionMethod::FreeInterface);
    assert_eq!(accepted("step = \"5 mm\"", "step = \"1 m\"").axis.stations(), [0.0, -0.1]);
}

#[test]
fn grids_and_quantities_are_read() {
    let table = "{ from = \"0 Hz\", to = \"10 Hz\", step = \"1 Hz\" }";
    let machine = accepted(table, "{ grid = \"uniform\", from = 0, to = 10, step = 5 }");
    assert_eq!((machine.analysis.grid, &machine.analysis.frequencies[..]), (Grid::Uniform, &[0.0, 5.0, 10.0][..]));
    let machine = accepted(table, "{ grid = \"logarithmic\", from = \"1 Hz\", to = \"0.1 kHz\", count = 3 }");
    let found = &machine.analysis.frequencies;
    assert_eq!((machine.analysis.grid, found.len(), found[0], found[2]), (Grid::Logarithmic, 3, 1.0, 100.0));
    assert!((found[1] - 10.0).abs() < 1e-12);
    let machine = accepted(table, "{ grid = \"clustered\", from = 0, to = 100 }");
    assert_eq!((machine.analysis.grid, machine.analysis.frequencies.len()), (Grid::Clustered { points: 13 }, 101));
    let machine = accepted(table, "{ grid = \"clustered\", from = 0, to = 1, points = 7, background = 3 }");
    let analysis = &machine.analysis;
    assert_eq!((analysis.grid, &analysis.frequencies[..]), (Grid::Clustered { points: 7 }, &[0.0, 0.5, 1.0][..]));
    assert_eq!(accepted(table, "[1, 2]").analysis.grid, Grid::Listed);
    assert_eq!(machine.analysis.quantity, Quantity::Receptance);
    let machine = accepted("damping = { ratio = 0.02 }", "damping = { ratio = 0.02 }\nquantity = \"accelerance\"");
    assert_eq!(machine.analysis.quantity, Quantity::Accelerance);
}

#[test]
fn a_ball_screws_free_length_and_second_support_are_read() {
    let screw = |machine: Machine| machine.joints[1].springs[0].stiffness;
    let read = screw(accepted("diameter = \"40 mm\"", "diameter = \"40 mm\"\nfree_length = \"350 mm\""));
    let expected =
        |free_length, support| SpringStiffness::BallScrew { young: 210e9, diameter: 0.04, free_length, support };
    assert_eq!(read, expected(Some(0.35), ScrewSupport::OneEnd));
    let both = "diameter = \"40 mm\"\nsupport = \"both-ends\"\nspan = \"1.2 m\"";
    let read = screw(accepted("diameter = \"40 mm\"", both));
    assert_eq!(read, expected(None, ScrewSupport::BothEnds { span: 1.2 }));
    assert_eq!(
        screw(accepted("diameter = \"40 mm\"", "diameter = \"40 mm\"\nsupport = \"one-end\"")),
        expected(None, ScrewSupport::OneEnd)
    );
}
