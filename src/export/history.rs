//! Time histories as CSV and MAT-file.

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

use super::mat5::{self, Value};
use super::response::safe;
use super::{ExportError, atomic, finite, length};
use crate::response::moving::Energy;
use crate::response::{Forces, History};

/// What joints with friction or backlash did at one position, `[sample, joint]`, last index fastest.
#[derive(Clone, Copy, Debug)]
pub struct Contacts<'a> {
    /// Names of the joints.
    pub joints: &'a [String],
    /// Motion of side 1 against side 0, m.
    pub slip: &'a [f64],
    /// Its rate, m/s.
    pub speed: &'a [f64],
    /// Force that draws side 1 back to side 0, N.
    pub force: &'a [f64],
}

impl<'a> Contacts<'a> {
    /// Name of the variable, end of the heading, values.
    fn columns(&self) -> [(&'static str, &'static str, &'a [f64]); 3] {
        [
            ("contact_slip", "slip_m", self.slip),
            ("contact_speed", "slip_m_per_s", self.speed),
            ("contact_force", "contact_force_N", self.force),
        ]
    }

    fn check(&self, path: &Path, forces: &Forces) -> Result<(), ExportError> {
        for (name, _, values) in self.columns() {
            length(path, name, values.len(), forces.samples() * self.joints.len())?;
            if let Some(at) = values.iter().position(|v| !v.is_finite()) {
                let (k, i) = (at / self.joints.len(), at % self.joints.len());
                let what = format!("the {name} of {} at {} s", self.joints[i], forces.time(k));
                return Err(ExportError::NotFinite { path: path.into(), what, value: values[at] });
            }
        }
        Ok(())
    }
}

/// Writes `time_history.csv`: `time_s`, `position_m` along a path, `force_<input>_N`, `<output>_m`, and
/// `<output>_m_per_s`, `<output>_m_per_s2` where they were recorded, then `<joint>_slip_m`, `<joint>_slip_m_per_s` and
/// `<joint>_contact_force_N` of joints with friction or backlash; characters of a joint's name other than letters, digits
/// and `-` become `_`. Numbers read back to the last bit.
///
/// # Errors
/// [`ExportError::Shape`] if the parts do not fit, [`ExportError::NotFinite`] with the place,
/// [`ExportError::Io`] if the file cannot be written.
pub fn write_csv(
    path: &Path,
    history: &History,
    forces: &Forces,
    outputs: &[String],
    positions: Option<&[f64]>,
    contacts: Option<&Contacts<'_>>,
) -> Result<(), ExportError> {
    check(path, history, forces, outputs, positions)?;
    let more = contacts.map(Contacts::columns);
    let n_joints = contacts.map_or(0, |c| c.joints.len());
    contacts.map_or(Ok(()), |c| c.check(path, forces))?;
    let mut heading = vec!["time_s".to_owned()];
    heading.extend(positions.map(|_| "position_m".to_owned()));
    heading.extend(forces.inputs.iter().map(|n| format!("force_{n}_N")));
    let blocks: Vec<(&[f64], &str)> = blocks(history).into_iter().map(|(_, unit, values)| (values, unit)).collect();
    heading.extend(blocks.iter().flat_map(|(_, unit)| outputs.iter().map(move |n| format!("{n}_{unit}"))));
    for (_, end, _) in more.iter().flatten() {
        heading.extend(contacts.iter().flat_map(|c| c.joints).map(|joint| format!("{}_{end}", safe(joint))));
    }
    let (n_in, n_out) = (forces.inputs.len(), outputs.len());
    atomic::write_atomic(path, |file| {
        let fail = atomic::io(path, "write");
        writeln!(file, "{}", heading.join(",")).map_err(&fail)?;
        let mut line = String::new();
        for k in 0..history.samples() {
            use std::fmt::Write as _;
            line.clear();
            // Writing to a text cannot fail.
            let _ = write!(line, "{}", ((forces.time(k)) * 1e12).round() / 1e12);
            positions.iter().for_each(|p| _ = write!(line, ",{}", p[k]));
            forces.values[k * n_in..][..n_in].iter().for_each(|v| _ = write!(line, ",{v:e}"));
            for (values, _) in &blocks {
                values[k * n_out..][..n_out].iter().for_each(|v| _ = write!(line, ",{v:e}"));
            }
            for (_, _, values) in more.iter().flatten() {
                values[k * n_joints..][..n_joints].iter().for_each(|v| _ = write!(line, ",{v:e}"));
            }
            line.push('\n');
            file.write_all(line.as_bytes()).map_err(&fail)?;
        }
        Ok(())
    })
}

/// Writes `time_history.mat`.
///
/// | variable | shape | unit |
/// |---|---|---|
/// | `time_s` | n_sample x 1 | s |
/// | `position_m` | n_position x 1; along a path n_sample x 1 | m |
/// | `force` | n_sample x n_input | N |
/// | `displacement` (`velocity`, `acceleration`) | n_sample x n_output x n_position; along a path n_position is 1 | m (m/s, m/s^2) |
/// | `input`, `output` | cell columns of names | |
/// | `contact` | cell column of the joints with friction or backlash, if there are any | |
/// | `contact_slip`, `contact_speed`, `contact_force` | n_sample x n_joint x n_position | m, m/s, N |
/// | `energy` (along a path) | struct of n_sample x 1: kinetic, potential, force, dissipated, travel | J |
///
/// # Errors
/// As [`write_csv`], and [`ExportError::TooLarge`] past 2^31 bytes a variable.
pub fn write_mat(
    path: &Path,
    positions: &[f64],
    histories: &[History],
    forces: &Forces,
    outputs: &[String],
    energy: Option<&Energy>,
    contacts: &[Contacts<'_>],
) -> Result<(), ExportError> {
    for history in histories {
        check(path, history, forces, outputs, None)?;
    }
    for (k, p) in positions.iter().enumerate() {
        finite(path, *p, || format!("position {k}"))?;
    }
    let times: Vec<f64> = (0..forces.samples()).map(|k| forces.time(k)).collect();
    let by_input: Vec<f64> = (0..forces.inputs.len()).flat_map(|j| forces.input(j)).collect();
    let (samples, n_out) = (forces.samples(), outputs.len());
    let mut variables = vec![
        ("time_s", Value::column(&times)),
        ("position_m", Value::column(positions)),
        ("input", Value::names(&forces.inputs)),
        ("output", Value::names(outputs)),
        ("force", Value::Real { dims: vec![samples, forces.inputs.len()], data: Cow::Owned(by_input) }),
    ];
    let kinds = histories.first().map(|h| blocks(h).len()).unwrap_or_default();
    for kind in 0..kinds {
        let mut data = Vec::with_capacity(samples * n_out * histories.len());
        let mut name = "";
        for history in histories {
            let all = blocks(history);
            length(path, "the recorded quantities", all.len(), kinds)?;
            let (called, _, values) = all[kind];
            name = called;
            for i in 0..n_out {
                data.extend(values.iter().skip(i).step_by(n_out));
            }
        }
        let dims = vec![samples, n_out, histories.len()];
        variables.push((name, Value::Real { dims, data: Cow::Owned(data) }));
    }
    if let Some(e) = energy {
        let fields = vec!["kinetic", "potential", "force", "dissipated", "travel"];
        let values = [&e.kinetic, &e.potential, &e.force, &e.dissipated, &e.travel].map(|v| Value::column(v)).to_vec();
        variables.push(("energy", Value::Structs { fields, values: vec![values] }));
    }
    if let Some(first) = contacts.first() {
        length(path, "the contacts", contacts.len(), histories.len())?;
        let joints = first.joints.len();
        variables.push(("contact", Value::names(first.joints)));
        for kind in 0..first.columns().len() {
            let mut data = Vec::with_capacity(samples * joints * contacts.len());
            for one in contacts {
                one.check(path, forces)?;
                (0..joints).for_each(|j| data.extend(one.columns()[kind].2.iter().skip(j).step_by(joints)));
            }
            let dims = vec![samples, joints, contacts.len()];
            variables.push((first.columns()[kind].0, Value::Real { dims, data: Cow::Owned(data) }));
        }
    }
    mat5::write(path, &variables)
}

/// Name, unit in headings and values of what was recorded.
fn blocks(history: &History) -> Vec<(&'static str, &'static str, &[f64])> {
    let mut out = vec![("displacement", "m", history.displacement.as_slice())];
    out.extend(history.velocity.as_deref().map(|v| ("velocity", "m_per_s", v)));
    out.extend(history.acceleration.as_deref().map(|v| ("acceleration", "m_per_s2", v)));
    out
}

fn check(
    path: &Path,
    history: &History,
    forces: &Forces,
    outputs: &[String],
    positions: Option<&[f64]>,
) -> Result<(), ExportError> {
    length(path, "the outputs", history.n_outputs, outputs.len())?;
    length(path, "the samples", history.samples(), forces.samples())?;
    if let Some(positions) = positions {
        length(path, "the positions", positions.len(), forces.samples())?;
    }
    for (name, _, values) in blocks(history) {
        length(path, name, values.len(), history.samples() * outputs.len())?;
        if let Some(at) = values.iter().position(|v| !v.is_finite()) {
            let (k, i) = (at / outputs.len(), at % outputs.len());
            let what = format!("the {name} of {} at {} s", outputs[i], forces.time(k));
            return Err(ExportError::NotFinite { path: path.into(), what, value: values[at] });
        }
    }
    Ok(())
}
