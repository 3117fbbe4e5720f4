//! A design as the values of a machine file.

use super::paths::{Target, catalogue};
use super::study::Study;
use super::table::number;
use crate::machine::{Dimension, ScrewSupport, SpringStiffness};
use std::fmt::Write as _;

/// The design with the given value of each variable as TOML: the keys of the machine file that the study varies, each
/// under its joint, part or section, to be put in place of the nominal ones.
pub fn machine_values(study: &Study, values: &[f64], origin: &str) -> String {
    let design = study.design(values);
    let entries = catalogue(&design.machine);
    let mut sections: Vec<(String, Vec<String>)> = Vec::new();
    let mut put = |section: String, line: String| match sections.iter_mut().find(|(s, _)| *s == section) {
        Some((_, lines)) => lines.push(line),
        None => sections.push((section, vec![line])),
    };
    for variable in &study.variables {
        for path in &variable.paths {
            let Some(entry) = entries.iter().find(|entry| entry.path == *path) else { continue };
            let steps: Vec<&str> = path.split('.').collect();
            let text = entry.nominal.map(|value| quantity(value, entry.dimension));
            match entry.targets[0] {
                Target::Support(j) => {
                    for line in support_lines(&design.machine.joints[j].springs[0].stiffness) {
                        put(joint_section(steps[1]), line);
                    }
                }
                Target::PartYoung(p) | Target::PartDensity(p) => {
                    let scale = design.parts[p];
                    let young = matches!(entry.targets[0], Target::PartYoung(_));
                    let factor = if young { scale.young } else { scale.density };
                    let key = steps[steps.len() - 1];
                    let line = match entry.nominal {
                        Some(own) => format!("{key} = {}", quantity(own * factor, entry.dimension)),
                        None => format!("# {key}: {} times the mesh's own", number(factor)),
                    };
                    put(format!("[{}]", steps[..steps.len() - 1].join(".")), line);
                }
                Target::Ratio | Target::LossFactor => {
                    let own = study.machine.analysis.damping.ratios.len();
                    let line = match &text {
                        Some(text) => format!("{} = {text}", steps[2]),
                        None => format!("# {}: {} times each of the {own} ratios", steps[2], number(values[0])),
                    };
                    put("[analysis.damping]".into(), line);
                }
                _ => {
                    let line = format!("{} = {}", steps[2..].join("."), text.unwrap_or_default());
                    put(joint_section(steps[1]), line);
                }
            }
        }
    }
    let mut out = format!("# {origin} of the study {:?}: values for {}.\n", study.name, file_name(study));
    for (section, lines) in &sections {
        // A string takes every write.
        let _ = write!(out, "\n{section}\n{}\n", lines.join("\n"));
    }
    out
}

fn file_name(study: &Study) -> String {
    study.machine.file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

fn joint_section(name: &str) -> String {
    format!("[[joints]]\nname = \"{name}\"")
}

fn support_lines(stiffness: &SpringStiffness) -> Vec<String> {
    match stiffness {
        SpringStiffness::BallScrew { support: ScrewSupport::BothEnds { span }, .. } => {
            vec!["support = \"both-ends\"".into(), format!("span = \"{} m\"", number(*span))]
        }
        _ => vec!["support = \"one-end\"".into()],
    }
}

fn quantity(value: f64, dimension: Option<Dimension>) -> String {
    match dimension {
        None | Some(Dimension::Ratio) => number(value),
        Some(dimension) => format!("\"{} {}\"", number(value), dimension.units()[0]),
    }
}
