//! Shares of a sample, and the record that says what a table belongs to.

use super::study::Study;
use super::table::{header, read_rows};
use super::table_error::{TableError, io};
use crate::files::{Inputs, MANIFEST, SWEEP_RECORD};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// One of several equal shares of a sample, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 1.
    pub number: u64,
    /// Of how many.
    pub of: u64,
}

impl Shard {
    /// The whole sample.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// Its designs: consecutive indices, sizes differing by one at most.
    pub fn range(self, designs: u64) -> Range<u64> {
        let end = |k: u64| (u128::from(designs) * u128::from(k) / u128::from(self.of)) as u64;
        end(self.number - 1)..end(self.number)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refused = || format!("{text:?} is no shard; write I/N with I from 1 to N, such as 3/8");
        let (number, of) = text.split_once('/').ok_or_else(refused)?;
        let read = |part: &str| part.trim().parse::<u64>().map_err(|_| refused());
        let shard = Self { number: read(number)?, of: read(of)? };
        if shard.number == 0 || shard.number > shard.of { Err(refused()) } else { Ok(shard) }
    }
}

/// What a table belongs to, kept beside it as `sweep.json`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Record {
    /// Version of the program.
    pub version: String,
    /// Name of the study.
    pub study: String,
    /// BLAKE3 of every file that was read, by its path relative to the study: study, machine, meshes with all that they
    /// include, matrices with their tables.
    pub inputs: Vec<(String, String)>,
    /// Designs of the whole sample.
    pub designs: u64,
    /// Positions.
    pub positions: u64,
    /// The route that answers the designs.
    pub route: String,
    /// Number of the shard.
    pub shard: u64,
    /// Number of shards.
    pub shards: u64,
}

/// Name of the record beside a table.
pub const RECORD: &str = SWEEP_RECORD;
/// Name of the table.
pub const TABLE: &str = "designs.csv";

impl Record {
    /// The record of a sweep by a route; `inputs` are all files that it was made from.
    pub fn new(study: &Study, inputs: &Inputs, route: &str, shard: Shard) -> Self {
        let folder = study.file.parent().unwrap_or(Path::new(""));
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            study: study.name.clone(),
            inputs: inputs.named(folder),
            designs: study.sampling.designs,
            positions: study.positions.len() as u64,
            route: route.to_owned(),
            shard: shard.number,
            shards: shard.of,
        }
    }

    /// Reads the record of a folder; `None` if there is none.
    ///
    /// # Errors
    /// [`TableError::Io`], [`TableError::Record`].
    pub fn read(folder: &Path) -> Result<Option<Self>, TableError> {
        let path = folder.join(RECORD);
        let text = match std::fs::read(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(io(&path, "read")(error)),
        };
        let record = serde_json::from_slice(&text);
        record.map(Some).map_err(|error| TableError::Record { path, reason: error.to_string() })
    }

    /// Refuses a record of other inputs, another route or, where asked, another shard.
    ///
    /// # Errors
    /// [`TableError::Differs`].
    pub fn check_same(&self, seen: &Record, folder: &Path, shard_too: bool) -> Result<(), TableError> {
        let differs = |what: String, seen: String, expected: String| {
            if seen == expected {
                Ok(())
            } else {
                Err(TableError::Differs { path: folder.join(RECORD), what, seen, expected })
            }
        };
        differs("the program's version".into(), seen.version.clone(), self.version.clone())?;
        for (name, hash) in &self.inputs {
            let other = seen.inputs.iter().find(|(n, _)| n == name).map_or("missing", |(_, hash)| hash);
            let other = if seen.inputs.contains(&(name.clone(), hash.clone())) { hash } else { other };
            differs(format!("the hash of {name}"), other.to_owned(), hash.clone())?;
        }
        for (name, hash) in &seen.inputs {
            let expected = if self.inputs.iter().any(|(n, _)| n == name) { hash.clone() } else { "missing".to_owned() };
            differs(format!("the hash of {name}"), hash.clone(), expected)?;
        }
        differs("the number of designs".into(), seen.designs.to_string(), self.designs.to_string())?;
        differs("the route".into(), seen.route.clone(), self.route.clone())?;
        if shard_too {
            let text = |r: &Record| format!("{}/{}", r.shard, r.shards);
            differs("the shard".into(), text(seen), text(self))?;
        }
        Ok(())
    }

    /// The designs of the record's shard.
    pub fn range(&self) -> Range<u64> {
        Shard { number: self.shard, of: self.shards }.range(self.designs)
    }
}

/// The table that the shards in some folders make up, as one run would have written it.
///
/// # Errors
/// [`TableError::NoEnd`] for a folder without manifest,
/// [`TableError::Differs`] for a shard of other inputs, [`TableError::Gap`] and [`TableError::Overlap`] with the
/// designs, [`TableError::Record`], [`TableError::Damaged`], [`TableError::Io`].
pub fn merge(study: &Study, inputs: &Inputs, folders: &[PathBuf]) -> Result<(Record, Vec<u8>), TableError> {
    let mut shards: Vec<(Record, &PathBuf)> = Vec::new();
    for folder in folders {
        let record = Record::read(folder)?
            .ok_or_else(|| TableError::Record { path: folder.join(RECORD), reason: "there is none".to_owned() })?;
        shards.push((record, folder));
    }
    shards.sort_by_key(|(record, _)| (record.range().start, record.range().end));
    let route = shards.first().map_or("", |(record, _)| record.route.as_str());
    let whole = Record::new(study, inputs, route, Shard::WHOLE);
    for (record, folder) in &shards {
        whole.check_same(record, folder, false)?;
    }
    let gap = |from: u64, to: u64, why: String| Err(TableError::Gap { from, to: to - 1, why });
    let (mut next, mut before) = (0, None::<&PathBuf>);
    let mut text = header(study);
    for (record, folder) in &shards {
        let range = record.range();
        if range.start > next {
            return gap(next, range.start, "no shard covers them; name the folder of each shard".to_owned());
        }
        if let Some(first) = before.filter(|_| range.start < next && !range.is_empty()) {
            let (first, second) = (first.clone(), (*folder).clone());
            return Err(TableError::Overlap { from: range.start, to: next.min(range.end) - 1, first, second });
        }
        let path = folder.join(TABLE);
        let table = std::fs::read(&path).map_err(io(&path, "read"))?;
        if !table.starts_with(&header(study)) {
            let reason = "its columns are not this study's".to_owned();
            return Err(TableError::Damaged { path, line: 1, reason });
        }
        let (end, rows) = read_rows(&path, study, &table, &range, &|i| Some(study.values(i)), &mut |_| {})?;
        if rows < range.end - range.start {
            let why = format!("{} is not finished; continue it with --resume", folder.display());
            return gap(range.start + rows, range.end, why);
        }
        // All rows are there, but the job that wrote them did not come to its end, or goes on.
        if !folder.join(MANIFEST).is_file() {
            return Err(TableError::NoEnd { path: (*folder).clone() });
        }
        text.extend_from_slice(&table[header(study).len()..end as usize]);
        (next, before) = (range.end, Some(*folder));
    }
    if next < study.sampling.designs {
        return gap(next, study.sampling.designs, "no shard covers them; name the folder of each shard".to_owned());
    }
    Ok((whole, text))
}
