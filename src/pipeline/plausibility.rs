//! The warnings of [`crate::plausible`] as lines, for a machine and for the designs of a study.

use crate::machine::Machine;
use crate::mesh::MeshFile;
use crate::plausible::{Finding, Survey, findings, modal_findings};
use crate::sweep::Design;

/// Values of a machine far from any machine in use, one line each, from the file and the meshes alone.
pub fn plausibility(machine: &Machine, meshes: &[MeshFile]) -> Vec<String> {
    findings(machine, &Survey::of(machine, meshes)).iter().map(Finding::to_string).collect()
}

/// [`plausibility`] of a study's machine, and what some of its designs add to it: each place of the file once.
pub fn study_plausibility(machine: &Machine, designs: &[Design], meshes: &[MeshFile]) -> Vec<String> {
    let survey = Survey::of(machine, meshes);
    let mut told = findings(machine, &survey);
    let nominal = told.len();
    for design in designs {
        let scaled = survey.scaled(design.parts.iter().map(|part| (part.young, part.density)));
        for finding in findings(&design.machine, &scaled) {
            if !told.iter().any(|other| other.key == finding.key) {
                told.push(finding);
            }
        }
    }
    let line = |(index, finding): (usize, &Finding)| {
        if index < nominal { finding.to_string() } else { format!("at an end of the study's ranges, {finding}") }
    };
    told.iter().enumerate().map(line).collect()
}

/// What is far from any machine in the modes of one position: (frequency in Hz, damping ratio) of each.
pub fn modal_plausibility(position: f64, modes: impl IntoIterator<Item = (f64, f64)>) -> Vec<String> {
    modal_findings(position, modes).iter().map(Finding::to_string).collect()
}
