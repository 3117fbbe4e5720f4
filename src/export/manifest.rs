//! `manifest.json`: what a run took, did, found and left.

use std::path::Path;

use serde::Serialize;
use serde::ser::SerializeMap;
use serde_json::Value;

use super::{ExportError, atomic};

/// A list of named values that keeps its order; an object in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Ordered<T>(pub Vec<(String, T)>);

impl<T> Default for Ordered<T> {
    fn default() -> Self {
        Ordered(Vec::new())
    }
}

impl<T> Ordered<T> {
    /// Adds a value at the end.
    pub fn push(&mut self, name: impl Into<String>, value: T) {
        self.0.push((name.into(), value));
    }
}

impl<T: Serialize> Serialize for Ordered<T> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

/// A check that the run made, with what it saw and what it allows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// What was checked.
    pub name: String,
    /// The figure found.
    pub figure: f64,
    /// The largest figure allowed.
    pub bound: f64,
    /// Whether it passed.
    pub passed: bool,
}

/// The record of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Manifest {
    /// Name of the machine.
    pub name: String,
    /// Version of the program.
    pub version: String,
    /// The command that wrote the folder, such as `run`.
    pub command: String,
    /// The machine file as it was named by the user.
    pub machine_file: String,
    /// BLAKE3 of the bytes that were parsed of every file read, in hexadecimal, by path relative to the machine file (of
    /// sweeps to the study). Files named on the command line stand under option and path.
    pub input_hashes: Ordered<String>,
    /// Settings that the run took, from the machine file and the command line.
    pub settings: Ordered<Value>,
    /// Back end, adapter, precision.
    pub backend: Value,
    /// Nodes, elements, unknowns, reduced coordinates, positions, frequencies.
    pub counts: Ordered<u64>,
    /// Wall seconds a stage, in the order of the run.
    pub seconds: Ordered<f64>,
    /// Checks made.
    pub checks: Vec<Check>,
    /// Warnings given.
    pub warnings: Vec<String>,
    /// Files written, relative to the output folder.
    pub files: Vec<String>,
}

impl Default for Manifest {
    fn default() -> Self {
        Manifest {
            name: String::new(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: String::new(),
            machine_file: String::new(),
            input_hashes: Ordered::default(),
            settings: Ordered::default(),
            backend: Value::Object(serde_json::Map::new()),
            counts: Ordered::default(),
            seconds: Ordered::default(),
            checks: Vec::new(),
            warnings: Vec::new(),
            files: Vec::new(),
        }
    }
}

impl Manifest {
    /// Writes the manifest as indented JSON.
    ///
    /// # Errors
    /// [`ExportError::NotFinite`] for a second or a check's figure that JSON cannot hold,
    /// [`ExportError::Format`] for a name given twice or a null in the settings or the back end
    /// (serde_json makes one of every NaN; leave out what has no value), [`ExportError::Io`] if the file cannot be
    /// written.
    pub fn write(&self, path: &Path) -> Result<(), ExportError> {
        for (stage, seconds) in &self.seconds.0 {
            super::finite(path, *seconds, || format!("the time of stage `{stage}`"))?;
        }
        for check in &self.checks {
            super::finite(path, check.figure, || format!("the figure of check `{}`", check.name))?;
            super::finite(path, check.bound, || format!("the bound of check `{}`", check.name))?;
        }
        no_null(path, "backend", &self.backend)?;
        for (name, value) in &self.settings.0 {
            no_null(path, &format!("settings.{name}"), value)?;
        }
        unique(path, &self.input_hashes)?;
        unique(path, &self.settings)?;
        unique(path, &self.counts)?;
        unique(path, &self.seconds)?;
        let format = |e: serde_json::Error| ExportError::Format { path: path.into(), reason: e.to_string() };
        let mut text = serde_json::to_vec_pretty(self).map_err(format)?;
        text.push(b'\n');
        atomic::write_bytes(path, &text)
    }
}

fn no_null(path: &Path, name: &str, value: &Value) -> Result<(), ExportError> {
    match value {
        Value::Null => Err(ExportError::Format {
            path: path.into(),
            reason: format!("`{name}` is null: a number that is not finite, or no value"),
        }),
        Value::Array(list) => list.iter().enumerate().try_for_each(|(i, v)| no_null(path, &format!("{name}[{i}]"), v)),
        Value::Object(map) => map.iter().try_for_each(|(key, v)| no_null(path, &format!("{name}.{key}"), v)),
        _ => Ok(()),
    }
}

/// Refuses two values under one name, of which a reader would keep one.
fn unique<T>(path: &Path, list: &Ordered<T>) -> Result<(), ExportError> {
    for (i, (name, _)) in list.0.iter().enumerate() {
        if list.0[..i].iter().any(|(earlier, _)| earlier == name) {
            let reason = format!("`{name}` is given twice");
            return Err(ExportError::Format { path: path.into(), reason });
        }
    }
    Ok(())
}
