//! Whether what was read can be a machine: warnings about values far from any machine in use.
//!
//! A machine file in the wrong units, or with a stiffness in N/m where N/um was meant, is a valid file: it computes,
//! and every number that comes out is wrong. [`Survey`] measures the parts (mass, size, surfaces), [`findings`] sets
//! every value of the machine beside what machines have, and [`modal_findings`] does the same with the first modes. A
//! [`Finding`] says where, what was seen, what is usual and which slip would explain it.
//!
//! A finding is a warning and never a refusal: somebody may build such a machine. So that a warning is worth reading,
//! the ranges are generous. They reach at least a factor of ten beyond machines in use, from a micro-milling machine
//! of 20 kg to a gantry of 500 t.
//!
//! One file a subject: `survey` measures, `geometry` holds its distances; `parts`, `joints` (where the two sides
//! are), `springs` (how stiff, how damped), `screws` and `motion` (travel, frequencies, damping, ports) judge.

mod geometry;
mod joints;
mod modes;
mod motion;
mod parts;
mod range;
mod screws;
mod springs;
mod survey;

pub use modes::modal_findings;
pub use survey::{PartSurvey, Patch, Survey};

use crate::machine::Machine;
use std::fmt;

/// A value far from any machine in use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Key of the machine file, such as `joints[3] "front bearing".at` (joints are counted from 1); several with commas
    /// where they share one finding.
    pub key: String,
    /// The value seen, with its unit.
    pub seen: String,
    /// What is usual, with its unit.
    pub usual: String,
    /// The slip that would explain it, and what to write.
    pub slip: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; usual: {}; {}", self.key, self.seen, self.usual, self.slip)
    }
}

/// Everything about a machine that is far from any machine in use, in the order of the file.
///
/// `survey` is of the same machine, or of one that differs in its joints' values and damping alone. Where an interface
/// has no surface, its part is judged by mass, size and material alone.
pub fn findings(machine: &Machine, survey: &Survey) -> Vec<Finding> {
    let mut found = parts::findings(machine, survey);
    found.extend(motion::analysis_findings(machine));
    if !survey.has_interfaces() {
        return together(found);
    }
    found.extend(motion::axis_findings(machine, survey));
    for (index, joint) in machine.joints.iter().enumerate() {
        let at = joints::Place { machine, survey, joint, key: joint_key(index, &joint.name) };
        found.extend(joints::findings(&at));
        found.extend(springs::findings(&at));
        found.extend(screws::findings(&at));
    }
    found.extend(motion::port_findings(machine, survey));
    together(found)
}

/// One finding in place of several that say the same of several keys: a slip in four guides is told once.
fn together(found: Vec<Finding>) -> Vec<Finding> {
    let mut merged: Vec<Finding> = Vec::new();
    for finding in found {
        let says_the_same = |other: &&mut Finding| {
            (&other.seen, &other.usual, &other.slip) == (&finding.seen, &finding.usual, &finding.slip)
        };
        match merged.iter_mut().find(says_the_same) {
            Some(other) => other.key += &format!(", {}", finding.key),
            None => merged.push(finding),
        }
    }
    merged
}

/// Key of a joint as messages write it.
fn joint_key(index: usize, name: &str) -> String {
    format!("joints[{}] {name:?}", index + 1)
}
