//! Forces and paths from CSV files.

use super::sampling::Piece;
use super::{Forces, Path, ResponseError};
use crate::files::Inputs;
use std::path::{Path as File, PathBuf};

/// Numbers of a CSV file with a heading line; the first column is the time in s.
struct Table {
    headings: Vec<String>,
    /// Line in the file, numbers.
    rows: Vec<(usize, Vec<f64>)>,
}

fn failed(file: &File, line: Option<usize>, problem: impl Into<String>) -> ResponseError {
    ResponseError::File { file: file.display().to_string(), line, problem: problem.into() }
}

fn read(file: &File, inputs: &mut Inputs) -> Result<Table, ResponseError> {
    let bytes = inputs.read(file).map_err(|error| failed(file, None, error.to_string()))?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(&bytes[..]);
    let headings: Vec<String> =
        reader.headers().map_err(|error| failed(file, Some(1), error.to_string()))?.iter().map(str::to_owned).collect();
    let mut rows: Vec<(usize, Vec<f64>)> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| failed(file, None, error.to_string()))?;
        let line = record.position().map_or(0, |p| p.line() as usize);
        if record.len() != headings.len() {
            let problem = format!("{} values under {} headings", record.len(), headings.len());
            return Err(failed(file, Some(line), problem));
        }
        let mut row = Vec::with_capacity(record.len());
        for (text, heading) in record.iter().zip(&headings) {
            match text.parse::<f64>() {
                Ok(value) if value.is_finite() => row.push(value),
                _ => return Err(failed(file, Some(line), format!("{heading}: found {text:?}; allowed: a number"))),
            }
        }
        if let Some((_, before)) = rows.last().filter(|(_, before)| row[0] <= before[0]) {
            let problem = format!("the time {} s follows {} s; times must ascend", row[0], before[0]);
            return Err(failed(file, Some(line), problem));
        }
        rows.push((line, row));
    }
    if headings.first().is_none_or(|h| h != "time_s") {
        let seen = headings.first().map_or("", String::as_str);
        return Err(failed(file, Some(1), format!("the first heading is {seen:?}; allowed: time_s")));
    }
    if rows.len() < 2 {
        return Err(failed(file, None, format!("{} lines of numbers; at least two are needed", rows.len())));
    }
    Ok(Table { headings, rows })
}

/// Forces of a CSV file: heading `time_s`, then names of inputs (a trailing `_N` is allowed); N. Between its lines a
/// force is straight, outside them zero.
pub struct ForceFile {
    file: PathBuf,
    table: Table,
    /// The file as it was read.
    pub inputs: Inputs,
}

impl ForceFile {
    /// Reads a file.
    ///
    /// # Errors
    /// [`ResponseError::File`] with the line for what is not a number or not ascending.
    pub fn read(file: &File) -> Result<Self, ResponseError> {
        let mut inputs = Inputs::default();
        Ok(Self { file: file.to_path_buf(), table: read(file, &mut inputs)?, inputs })
    }

    /// Time of the last line, s.
    pub fn end(&self) -> f64 {
        self.table.rows.last().map_or(0.0, |(_, row)| row[0])
    }

    /// Adds the forces as samples that keep their momentum; returns what the samples cannot hold of them.
    ///
    /// # Errors
    /// [`ResponseError::File`] if a heading is no input, or if no force is left within the history.
    pub fn add_to(&self, forces: &mut Forces) -> Result<Vec<String>, ResponseError> {
        let (file, rows) = (&self.file, &self.table.rows);
        let last = forces.end();
        let mut lost = 0;
        for (column, heading) in self.table.headings.iter().enumerate().skip(1) {
            let name = heading.strip_suffix("_N").unwrap_or(heading);
            let Some(input) = forces.inputs.iter().position(|i| i == name || i == heading) else {
                let problem = format!("the heading {heading:?} is no input; allowed: {}", forces.inputs.join(", "));
                return Err(failed(file, Some(1), problem));
            };
            let peak = rows.iter().map(|(_, row)| row[column].abs()).fold(0.0, f64::max);
            let pieces = rows.windows(2).map(|pair| {
                let [a, b] = [&pair[0].1, &pair[1].1];
                Piece::line(a[0], b[0], [a[column], b[column]])
            });
            lost = lost.max(forces.add_pieces(input, pieces, peak));
        }
        if self.table.headings.len() < 2 {
            let problem = format!("no input; allowed beside time_s: {}", forces.inputs.join(", "));
            return Err(failed(file, Some(1), problem));
        }
        let acts = |row: &[f64]| row[1..].iter().any(|f| *f != 0.0);
        let first = rows.iter().position(|(_, row)| acts(row)).map(|k| k.saturating_sub(1));
        if let Some((line, row)) = first.map(|k| &rows[k]).filter(|(_, row)| row[0] >= last) {
            let problem = format!(
                "the force begins at {} s, after the history's last sample at {last} s; give a longer --duration",
                row[0]
            );
            return Err(failed(file, Some(*line), problem));
        }
        let mut told = Vec::new();
        let cut = rows.iter().rposition(|(_, row)| acts(row)).map(|k| rows[(k + 1).min(rows.len() - 1)].1[0]);
        if let Some(end) = cut.filter(|end| *end > last + forces.step * (1.0 + 1e-9)) {
            told.push(format!(
                "{}: the force goes on to {end} s, the history ends at {last} s: the rest is left out; give --duration \
                 {end} or more",
                file.display()
            ));
        }
        if lost > 0 {
            told.push(format!(
                "{}: in {lost} steps between samples the force turns more than once: its momentum is kept, its form is \
                 not; --rate is {}",
                file.display(),
                forces.step.recip()
            ));
        }
        Ok(told)
    }
}

/// Reads a CSV file of forces and adds them; returns what the samples cannot hold of them.
///
/// # Errors
/// As [`ForceFile::read`] and [`ForceFile::add_to`].
pub fn read_force_file(file: &File, forces: &mut Forces) -> Result<Vec<String>, ResponseError> {
    ForceFile::read(file)?.add_to(forces)
}

/// The path of a CSV file with the headings `time_s,position_m`; the file as it was read is added to `inputs`.
///
/// # Errors
/// [`ResponseError::File`] with the line.
pub fn read_path_file(file: &File, inputs: &mut Inputs) -> Result<Path, ResponseError> {
    let table = read(file, inputs)?;
    if table.headings != ["time_s", "position_m"] {
        let problem = format!("the headings are {}; allowed: time_s,position_m", table.headings.join(","));
        return Err(failed(file, Some(1), problem));
    }
    Path::through(table.rows.into_iter().map(|(_, row)| (row[0], row[1])).collect())
}
