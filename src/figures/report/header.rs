//! What a modal database says besides numbers: names, settings, which springs change together.

use super::accuracy::Accuracy;
use super::arrays::Entry;
use super::shapes::PartSkin;
use crate::machine::{JointKind, Machine, SpringStiffness};
use crate::modal::{ModeTableRow, Veering};
use serde::{Deserialize, Serialize};

/// What a database says besides numbers.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Header {
    /// Name of the machine.
    pub machine: String,
    /// Name of the axis.
    pub axis: String,
    /// Its direction.
    pub direction: [f64; 3],
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Whether inputs are the outputs.
    pub symmetric: bool,
    /// What the run's map holds: `receptance`, `mobility` or `accelerance`.
    pub quantity: String,
    /// Positions of the run, of which the database holds all or some.
    pub positions_of_run: usize,
    /// Highest frequency, Hz.
    pub highest_hz: f64,
    /// Viscous ratios, the last for all further modes.
    pub damping_ratios: Vec<f64>,
    /// Rayleigh's alpha and beta.
    pub rayleigh: Option<[f64; 2]>,
    /// Loss factor of the whole machine.
    pub loss_factor: f64,
    /// Parts with a loss factor of their own: their share cannot be followed when joints change.
    pub lossy_parts: Vec<String>,
    /// Whether dampers and loss factors of joints and parts are projected on the modes, as the machine file may ask.
    #[serde(default)]
    pub projected: bool,
    /// What couples the modes of the run's sums, where anything does and responses are exact.
    #[serde(default)]
    pub coupled: Option<CoupledEntry>,
    /// How far the page's own solutions hold; missing where an earlier version wrote the database.
    #[serde(default)]
    pub accuracy: Option<Accuracy>,
    /// Joints of one kind, which change together.
    pub groups: Vec<Group>,
    /// Springs of the local coordinates.
    pub springs: Vec<SpringEntry>,
    /// Range of each family.
    pub table: Vec<TableEntry>,
    /// Veerings.
    pub veerings: Vec<VeeringEntry>,
    /// Free motions in words.
    pub free_motions: Vec<String>,
    /// Hashes of the files that the run read, as in its manifest.
    #[serde(default)]
    pub input_hashes: Vec<(String, String)>,
    /// Places of the parts in the skins.
    pub parts: Vec<PartSkin>,
    /// Arrays.
    pub arrays: Vec<Entry>,
}

/// Sums between ports and dissipating springs, from which these springs are eliminated at every frequency
/// ([`crate::frf::ExactDamping`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoupledEntry {
    /// Springs that dissipate.
    pub springs: usize,
    /// Whether rows have imaginary parts, which follow all real parts.
    pub complex: bool,
    /// Whether rows of inputs are those of outputs.
    pub symmetric: bool,
}

/// Joints that change together.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Group {
    /// `guides`, `bearings`, `screws` or `dampers`.
    pub name: String,
    /// Their joints.
    pub joints: Vec<String>,
    /// Their springs by place in the list.
    pub springs: Vec<usize>,
    /// Diameter of a screw, m, where all have the same.
    pub diameter: Option<f64>,
    /// Least and largest setting of the slider: a factor of the stiffness, of a screw's diameter.
    #[serde(default = "stiffness_range")]
    pub range: [f64; 2],
}

/// Range of a slider that multiplies a stiffness.
fn stiffness_range() -> [f64; 2] {
    [0.25, 4.0]
}

/// Range of a slider that multiplies the diameter of a screw, whose stiffness goes with the square.
const DIAMETER_RANGE: [f64; 2] = [0.5, 2.0];

impl Group {
    /// What a setting of the slider multiplies the springs' stiffness by.
    pub fn stiffness_factor(&self, setting: f64) -> f64 {
        if self.name == SCREWS { setting * setting } else { setting }
    }
}

/// Name of the group whose slider is a diameter.
const SCREWS: &str = "screws";

/// The springs of a page with their places among all of the machine, and what changes together.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpringList<'a> {
    pub entries: &'a [SpringEntry],
    pub places: &'a [usize],
    pub groups: &'a [Group],
}

/// A spring of the local coordinates.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SpringEntry {
    /// Joint.
    pub joint: String,
    /// Name within the joint.
    pub label: String,
    /// Viscous damping, N s/m or N m s/rad.
    pub damping: f64,
    /// Loss factor of the joint; 0 without.
    pub loss_factor: f64,
}

/// As [`ModeTableRow`].
#[derive(Clone, Debug, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields of ModeTableRow")]
pub struct TableEntry {
    pub family: usize,
    pub min_hz: f64,
    pub max_hz: f64,
    pub difference_percent: f64,
    pub position_of_min_m: f64,
    pub position_of_max_m: f64,
    pub interior_extremum: bool,
    #[serde(default)]
    pub reduction_error: Option<f64>,
}

/// As [`Veering`].
#[derive(Clone, Debug, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields of Veering")]
pub struct VeeringEntry {
    pub from_m: f64,
    pub to_m: f64,
    pub families: [usize; 2],
    pub mac: f64,
}

pub(super) fn table_entry(row: &ModeTableRow) -> TableEntry {
    TableEntry {
        family: row.family,
        min_hz: row.min,
        max_hz: row.max,
        difference_percent: row.difference_percent,
        position_of_min_m: row.position_of_min,
        position_of_max_m: row.position_of_max,
        interior_extremum: row.interior_extremum,
        reduction_error: row.reduction_error,
    }
}

pub(super) fn veering_entry(v: &Veering) -> VeeringEntry {
    VeeringEntry { from_m: v.from, to_m: v.to, families: v.families, mac: v.mac }
}

/// The springs that can change or that damp, their groups, and their places among all springs.
pub(super) fn springs(machine: &Machine) -> (Vec<SpringEntry>, Vec<Group>, Vec<usize>) {
    let kinds = [
        ("guides", JointKind::LinearGuide),
        ("bearings", JointKind::Bearing),
        (SCREWS, JointKind::BallScrew),
        ("dampers", JointKind::SpringDamper),
    ];
    let mut groups: Vec<Group> = Vec::new();
    let (mut entries, mut selected, mut at) = (Vec::new(), Vec::new(), 0);
    for joint in &machine.joints {
        let kind = kinds.iter().find(|(_, kind)| *kind == joint.kind).map(|(name, _)| *name);
        for spring in &joint.springs {
            let loss_factor = joint.loss_factor.unwrap_or(0.0);
            if kind.is_some() || spring.damping > 0.0 || loss_factor > 0.0 {
                if let Some(name) = kind {
                    let group = match groups.iter_mut().find(|g| g.name == name) {
                        Some(group) => group,
                        None => {
                            let range = if name == SCREWS { DIAMETER_RANGE } else { stiffness_range() };
                            let (joints, springs) = (vec![], vec![]);
                            groups.push(Group { name: name.into(), joints, springs, diameter: None, range });
                            groups.last_mut().expect("one was pushed")
                        }
                    };
                    if let SpringStiffness::BallScrew { diameter, .. } = spring.stiffness {
                        let same = group.springs.is_empty() || group.diameter == Some(diameter);
                        group.diameter = same.then_some(diameter);
                    }
                    group.springs.push(entries.len());
                    if group.joints.last() != Some(&joint.name) {
                        group.joints.push(joint.name.clone());
                    }
                }
                let (joint, label) = (joint.name.clone(), spring.label.clone());
                entries.push(SpringEntry { joint, label, damping: spring.damping, loss_factor });
                selected.push(at);
            }
            at += 1;
        }
    }
    (entries, groups, selected)
}
