//! The table of a sweep: one row a design, appended as designs are done.
//!
//! | column | content |
//! |---|---|
//! | `design` | index of the design in the sample, from 0 |
//! | one a variable | its value, SI unit in brackets |
//! | `cost`, one or more a metric | its value, SI unit in brackets; empty where there is none |
//! | `bounds_met` | `yes` or `no`; empty where a bounded value is missing |
//! | `error` | why values are missing |
//!
//! Numbers are written with the fewest digits that give back the same f64. Rows stand in the order of their designs.
//! A row that a killed process left half-written ends without a line break; [`Store::open`] cuts it off.

use super::study::Study;
use super::table_error::{TableError, io};
use super::{Evaluation, SweepError};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// One design's line of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Index of the design.
    pub index: u64,
    /// Value of each variable, SI.
    pub values: Vec<f64>,
    /// Cost and metrics, in the order of [`Study::result_columns`].
    pub results: Vec<Option<f64>>,
    /// Whether every bound is kept; `None` where a bounded value is missing.
    pub bounds_met: Option<bool>,
    /// Why values are missing.
    pub error: Option<String>,
}

/// A number with the fewest digits that give back the same f64.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if (1e-4..1e15).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

impl Row {
    /// The row of a design from its evaluation.
    pub fn new(study: &Study, index: u64, values: Vec<f64>, outcome: &Result<Evaluation, SweepError>) -> Row {
        let mut results = Vec::new();
        let mut errors = Vec::new();
        results.extend(study.cost.as_ref().map(|cost| Some(cost.of(&values))));
        match outcome {
            Ok(evaluation) => {
                for metric in &study.metrics {
                    let (cells, missing) = metric.values(&study.positions, evaluation);
                    results.extend(cells);
                    errors.extend(missing);
                }
            }
            Err(error) => {
                results.resize(study.result_columns().len(), None);
                errors.push(error.to_string());
            }
        }
        let kept = |bound: &super::goals::Bound| {
            results[study.result_place(bound.figure)].map(|value| bound.violation(value) == 0.0)
        };
        let met = study.bounds.iter().map(kept).collect::<Option<Vec<bool>>>().map(|all| all.iter().all(|k| *k));
        let bounds_met = if outcome.is_ok() { met } else { None };
        let error = (!errors.is_empty()).then(|| errors.join("; ").replace(['\r', '\n'], " "));
        Row { index, values, results, bounds_met, error }
    }

    fn cells(&self, study: &Study) -> Vec<String> {
        let mut cells = beginning(study, self.index, &self.values);
        cells.extend(self.results.iter().map(|value| value.map(number).unwrap_or_default()));
        cells.push(self.bounds_met.map(|met| if met { "yes" } else { "no" }).unwrap_or_default().to_owned());
        cells.push(self.error.clone().unwrap_or_default());
        cells
    }

    /// The row as a line of CSV, its line break included.
    pub fn line(&self, study: &Study) -> Vec<u8> {
        csv_line(&self.cells(study))
    }

    /// Reads a row from the cells of its line.
    ///
    /// # Errors
    /// What is wrong with the line, in words.
    pub fn parse(study: &Study, cells: &csv::ByteRecord) -> Result<Row, String> {
        let (n_values, n_results) = (study.variables.len(), study.result_columns().len());
        let columns = 1 + n_values + n_results + 2;
        if cells.len() != columns {
            return Err(format!("it has {} cells, expected {columns}", cells.len()));
        }
        let text = |at: usize| std::str::from_utf8(&cells[at]).map_err(|_| format!("cell {} is not UTF-8", at + 1));
        let index = text(0)?.parse().map_err(|_| format!("{:?} is not the number of a design", cells[0].to_vec()))?;
        let read = |(at, variable): (usize, &super::variables::Variable)| {
            let cell = text(1 + at)?;
            variable.read(cell).ok_or_else(|| format!("{cell:?} is no value of {}", variable.name))
        };
        let values = study.variables.iter().enumerate().map(read).collect::<Result<Vec<f64>, String>>()?;
        let expected = beginning(study, index, &values);
        if let Some((seen, expected)) = cells.iter().zip(&expected).find(|(seen, e)| *seen != e.as_bytes()) {
            return Err(format!("found {:?} in place of {expected:?}", String::from_utf8_lossy(seen)));
        }
        let mut results = Vec::with_capacity(n_results);
        for at in expected.len()..expected.len() + n_results {
            let cell = text(at)?;
            let value: Option<f64> = if cell.is_empty() {
                None
            } else {
                Some(cell.parse().map_err(|_| format!("{cell:?} is not a number"))?)
            };
            results.push(value);
        }
        let bounds_met = match text(columns - 2)? {
            "" => None,
            "yes" => Some(true),
            "no" => Some(false),
            other => return Err(format!("bounds_met is {other:?}")),
        };
        let error = Some(text(columns - 1)?.to_owned()).filter(|e| !e.is_empty());
        Ok(Row { index, values, results, bounds_met, error })
    }
}

/// Index and variables as a row begins.
fn beginning(study: &Study, index: u64, values: &[f64]) -> Vec<String> {
    let variables = study.variables.iter().zip(values).map(|(variable, value)| variable.text(*value));
    std::iter::once(index.to_string()).chain(variables).collect()
}

/// Cells as a line of CSV.
pub(super) fn csv_line(cells: &[String]) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(cells).expect("a vector takes every record");
    writer.into_inner().expect("a vector takes every record")
}

/// The table's first line.
pub fn header(study: &Study) -> Vec<u8> {
    let columns = study.variable_columns().into_iter().chain(study.result_columns());
    let names = std::iter::once("design".to_owned()).chain(columns.map(|column| column.header()));
    csv_line(&names.chain(["bounds_met".to_owned(), "error".to_owned()]).collect::<Vec<_>>())
}

/// The values that the design of an index must have, where they are known in advance.
pub type Expected<'a> = &'a dyn Fn(u64) -> Option<Vec<f64>>;

/// A table that grows, locked against other processes.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    file: File,
}

impl Store {
    /// Begins a table, in place of what stood there.
    ///
    /// # Errors
    /// [`TableError::Io`], [`TableError::InUse`].
    pub fn create(path: &Path, study: &Study) -> Result<Store, TableError> {
        let mut store = Store::locked(path)?;
        store.file.set_len(0).map_err(io(path, "empty"))?;
        store.append(&header(study))?;
        Ok(store)
    }

    /// Opens a table to continue it: whole rows are kept and given to `seen`, a torn last one is cut off. Returns how
    /// many designs of the range it holds; a missing or empty table is begun.
    ///
    /// # Errors
    /// [`TableError::Damaged`] if a row before the last is not this study's, [`TableError::Io`], [`TableError::InUse`].
    pub fn open(
        path: &Path,
        study: &Study,
        range: &Range<u64>,
        expected: Expected<'_>,
        seen: &mut dyn FnMut(Row),
    ) -> Result<(Store, u64), TableError> {
        let mut store = Store::locked(path)?;
        let header = header(study);
        let mut text = Vec::new();
        store.file.seek(SeekFrom::Start(0)).map_err(io(path, "read"))?;
        store.file.read_to_end(&mut text).map_err(io(path, "read"))?;
        if text.len() < header.len() && header.starts_with(&text) {
            drop(store);
            return Ok((Store::create(path, study)?, 0));
        }
        if !text.starts_with(&header) {
            let reason = "its columns are not this study's".to_owned();
            return Err(TableError::Damaged { path: path.to_path_buf(), line: 1, reason });
        }
        let (whole, rows) = read_rows(path, study, &text, range, expected, seen)?;
        store.file.set_len(whole).map_err(io(path, "cut the torn row off"))?;
        store.file.seek(SeekFrom::End(0)).map_err(io(path, "continue"))?;
        Ok((store, rows))
    }

    fn locked(path: &Path) -> Result<Store, TableError> {
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        let file = file.map_err(io(path, "open"))?;
        match file.try_lock() {
            Ok(()) => Ok(Store { path: path.to_path_buf(), file }),
            Err(TryLockError::WouldBlock) => Err(TableError::InUse { path: path.to_path_buf() }),
            Err(TryLockError::Error(source)) => Err(io(path, "lock")(source)),
        }
    }

    /// Appends whole lines and waits until they are on the disk.
    ///
    /// # Errors
    /// [`TableError::Io`].
    pub fn append(&mut self, lines: &[u8]) -> Result<(), TableError> {
        self.file.write_all(lines).map_err(io(&self.path, "write"))?;
        self.file.sync_data().map_err(io(&self.path, "write"))
    }
}

/// Reads the rows of a table in memory, from the first design of the range; returns the bytes of header and whole
/// rows, and their number.
///
/// # Errors
/// [`TableError::Damaged`] for a row that ends with a line break and is not the one expected.
pub fn read_rows(
    path: &Path,
    study: &Study,
    text: &[u8],
    range: &Range<u64>,
    expected: Expected<'_>,
    seen: &mut dyn FnMut(Row),
) -> Result<(u64, u64), TableError> {
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(text);
    let mut record = csv::ByteRecord::new();
    let damaged = |line: u64, reason: String| TableError::Damaged { path: path.to_path_buf(), line, reason };
    let mut whole = header(study).len() as u64;
    let mut rows = 0;
    loop {
        let line = rows + 2;
        match reader.read_byte_record(&mut record) {
            Ok(false) => return Ok((whole, rows)),
            Ok(true) => {}
            Err(error) => return Err(damaged(line, error.to_string())),
        }
        let end = reader.position().byte();
        if text.get(end as usize - 1) != Some(&b'\n') {
            return Ok((whole, rows));
        }
        let index = range.start + rows;
        if index >= range.end {
            return Err(damaged(line, format!("the sweep ends with design {}", range.end - 1)));
        }
        let row = Row::parse(study, &record).map_err(|reason| damaged(line, reason))?;
        if row.index != index {
            return Err(damaged(line, format!("found design {} in place of {index}", row.index)));
        }
        if let Some(values) = expected(index).filter(|values| *values != row.values) {
            return Err(damaged(line, format!("found the values {:?} in place of {values:?}", row.values)));
        }
        seen(row);
        whole = end;
        rows += 1;
    }
}
