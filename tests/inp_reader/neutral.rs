//! What changes nothing is passed over by its value; what would change the result is refused.

use super::*;
use stiffmap::machine::Part;
use stiffmap::mesh::inp::{Deck, parse_deck};
use stiffmap::mesh::read_part_mesh;

fn deck(text: &str) -> Result<Deck, String> {
    parse_deck(text.as_bytes(), Path::new("tet.inp"), false, None).map_err(|error| error.to_string())
}

fn step(parameters: &str, frequency: &str, inside: &str) -> String {
    format!("{TET}*BOUNDARY\nBASE, 1, 3\n*STEP{parameters}\n*FREQUENCY{frequency}\n3\n{inside}*END STEP\n")
}

#[test]
fn parameters_are_judged_by_their_value() {
    let plain = deck(&step("", "", "")).unwrap();
    for (parameters, frequency) in [
        (
            ", name=Step-1, nlgeom=NO, perturbation",
            ", eigensolver=Lanczos, sim=NO, acoustic coupling=on, normalization=mass",
        ),
        (", INC=1000, AMPLITUDE=RAMP, unsymm=no", ", SOLVER=PASTIX, STORAGE=YES, GLOBAL=NO"),
        (
            ", NLGEOM=off",
            ", Acoustic Coupling=OFF, normalization=displacement, damping projection=on, residual modes=no",
        ),
    ] {
        let seen = deck(&step(parameters, frequency, "")).unwrap();
        assert_eq!((seen.frequency, seen.mesh.supports.len()), (plain.frequency, 6), "{parameters}{frequency}");
    }
    let damped = step("", "", "").replace("*DENSITY", "*DAMPING, ALPHA=1.\n*DENSITY");
    assert_eq!(deck(&damped).unwrap().frequency, plain.frequency);
    for (parameters, frequency, said) in [
        (", NLGEOM", "", "the parameter NLGEOM is not supported"),
        (", NLGEOM=YES", "", "NLGEOM=YES is not supported"),
        (", CYCLIC=1", "", "CYCLIC"),
        ("", ", residual modes", "RESIDUALMODES"),
        ("", ", CYCMPC=ACTIVE", "CYCMPC"),
        ("", ", property evaluation=20.", "PROPERTYEVALUATION"),
    ] {
        let message = deck(&step(parameters, frequency, "")).unwrap_err();
        assert!(message.contains(said) && message.contains("tet.inp:"), "{said} in {message}");
    }
}

/// CalculiX 2.20 on a clamped bar: loads of a frequency step leave 418.5537 Hz as it is, but in a step with
/// PERTURBATION a pressure makes it 315.7577 Hz.
#[test]
fn loads_of_a_frequency_step_matter_only_in_a_perturbation() {
    for load in ["*CLOAD\n8, 1, 1.\n", "*DLOAD\nEALL, P1, 100.\n"] {
        let seen = deck(&step("", "", load)).unwrap();
        assert!(seen.warnings.iter().any(|w| w.text.contains("does not change the modes")), "{:?}", seen.warnings);
        let message = deck(&step(", PERTURBATION", "", load)).unwrap_err();
        assert!(message.contains("PERTURBATION") && message.contains("tet.inp:31"), "{message}");
    }
}

#[test]
fn boundaries_of_a_step_replace_or_add() {
    let held = |inside: &str| deck(&step("", "", inside)).map(|deck| deck.mesh.supports);
    assert_eq!(held("*BOUNDARY, OP=MOD\n8, 1\n").unwrap().len(), 7);
    assert_eq!(held("*Boundary\n").unwrap().len(), 6);
    // OP=NEW lets go what was held before the step, once; later ones of the step add.
    let new = held("*Boundary, op=New\n*Boundary\n8, 1\n*Boundary, op=New\n9, 2, 2, 0.\n").unwrap();
    assert_eq!(new.into_iter().collect::<Vec<_>>(), [(7, [true, false, false]), (8, [false, true, false])]);
    assert_eq!(held("*BOUNDARY, AMPLITUDE=A, LOAD CASE=1\n8, 1\n").unwrap().len(), 7);
    for (lines, said) in [
        ("*BOUNDARY, OP=OLD\n", "OP=OLD"),
        ("*BOUNDARY, LOAD CASE=2\n8, 1\n", "LOADCASE=2"),
        ("*BOUNDARY, TYPE=VELOCITY\n8, 1\n", "TYPE=VELOCITY"),
        ("*BOUNDARY, AMPLITUDE=A\n8, 1, 1, 0.1\n", "no value but 0"),
        ("*BOUNDARY, USER\n8, 1\n", "USER"),
    ] {
        let message = held(lines).unwrap_err();
        assert!(message.contains(said), "{said} in {message}");
    }
    // Before the steps there is nothing to replace, unless something is held.
    assert_eq!(accepted(&format!("{TET}*BOUNDARY, OP=NEW\nBASE, 1\n")).mesh.supports.len(), 6);
    refused(&format!("{TET}*BOUNDARY\n8, 1\n*BOUNDARY, OP=NEW\nBASE, 1\n"), &["tet.inp:28", "OP=NEW before the steps"]);
}

#[test]
fn parameters_of_the_mesh_are_judged_by_their_value_too() {
    for (from, to) in [
        ("*NODE, NSET=Nall", "*NODE, NSET=Nall, SYSTEM=R"),
        ("*ELASTIC", "*ELASTIC, TYPE=ISOTROPIC, MODULI=LONG TERM, DEPENDENCIES=0"),
        ("*DENSITY", "*DENSITY, dependencies=0"),
        (
            "*MATERIAL",
            "*SURFACE INTERACTION, NAME=I\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD\n*FRICTION\n0.1, 1E6\n*MATERIAL",
        ),
        ("*MATERIAL", "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNall, 20.\n*MATERIAL"),
        ("*MATERIAL", "*SURFACE SECTION, ELSET=EALL\n*MATERIAL"),
        ("*MATERIAL", "*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n*MATERIAL"),
        ("MATERIAL=STEEL\n", "MATERIAL=STEEL, ORIENTATION=O\n"),
    ] {
        assert_eq!(format!("{:?}", accepted(&changed(from, to)).mesh), format!("{:?}", accepted(TET).mesh), "{to}");
    }
    for (from, to, said) in [
        ("*ELASTIC", "*ELASTIC, DEPENDENCIES=1", "DEPENDENCIES=1"),
        ("*NODE, NSET=Nall", "*NODE, SYSTEM=S", "SYSTEM=S"),
        ("*MATERIAL", "*INITIAL CONDITIONS, TYPE=STRESS\nEALL, 1.\n*MATERIAL", "INITIAL CONDITIONS"),
        ("*DENSITY", "*DAMPING, ALPHA=1.\n*DENSITY", "damping in the machine file"),
        ("*MATERIAL", "*CONTACT PAIR, INTERACTION=I\nA, B\n*MATERIAL", "contact"),
        ("*MATERIAL", "*SURFACE SECTION, ELSET=EALL, DENSITY=1.\n*MATERIAL", "DENSITY"),
    ] {
        refused_change(from, to, &[said]);
    }
}

#[test]
fn a_part_with_a_material_of_its_own_takes_a_static_deck_without_density() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("static.inp");
    let text = TET.replace("*DENSITY\n7850\n", "*PLASTIC\n200e6, 0.\n")
        + "*STEP, NLGEOM\n*STATIC\n*DLOAD\nEALL, GRAV, 9.81, 0., 0., -1.\n*END STEP\n";
    std::fs::write(&file, text).unwrap();
    let part = |material| Part { mesh: file.clone(), material, ..support::part("tet", &["BASE"], Vec::new()) };
    let steel = support::steel();
    let MeshFile { mesh, warnings } = read_part_mesh(&part(Some(steel.clone()))).unwrap();
    assert!(mesh.materials.is_empty() && mesh.cells[0].material.is_none());
    assert!(warnings.iter().any(|w| w.text.contains("the materials of the file are passed over")), "{warnings:?}");
    assert!(warnings.iter().any(|w| w.text.contains("*STEP to *END STEP is passed over")), "{warnings:?}");
    let mass = stiffmap::solid::assemble(&part(Some(steel)), &mesh).unwrap().total_mass;
    // A sixth of the brick over its three edges of 2 m.
    assert!((mass / (7850.0 * 8.0 / 6.0) - 1.0).abs() < 1e-12);
    let message = read_part_mesh(&part(None)).unwrap_err().to_string();
    assert!(message.contains("*PLASTIC"), "control: without a material it counts; {message}");
}
