//! Forces and paths from CSV files.

use super::{Forces, Path, ResponseError};
use std::path::Path as File;

/// Numbers of a CSV file with a heading line; the first column is the time in s.
struct Table {
    headings: Vec<String>,
    /// Line in the file, numbers.
    rows: Vec<(usize, Vec<f64>)>,
}

fn failed(file: &File, line: Option<usize>, problem: impl Into<String>) -> ResponseError {
    ResponseError::File { file: file.display().to_string(), line, problem: problem.into() }
}

fn read(file: &File) -> Result<Table, ResponseError> {
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .flexible(true)
        .from_path(file)
        .map_err(|error| failed(file, None, error.to_string()))?;
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

/// Adds the forces of a CSV file: heading `time_s`, then names of inputs (a trailing `_N` is allowed); N.
/// Between its lines the force is straight, outside them zero; it is sampled at the history's rate.
///
/// # Errors
/// [`ResponseError::File`] with the line for what is not a number, not ascending or no input.
pub fn read_force_file(file: &File, forces: &mut Forces) -> Result<(), ResponseError> {
    let table = read(file)?;
    let n = forces.inputs.len();
    for (column, heading) in table.headings.iter().enumerate().skip(1) {
        let name = heading.strip_suffix("_N").unwrap_or(heading);
        let Some(input) = forces.inputs.iter().position(|i| i == name || i == heading) else {
            let problem = format!("the heading {heading:?} is no input; allowed: {}", forces.inputs.join(", "));
            return Err(failed(file, Some(1), problem));
        };
        let mut at = 0;
        for k in 0..forces.samples() {
            let time = forces.time(k);
            while at + 2 < table.rows.len() && table.rows[at + 1].1[0] < time {
                at += 1;
            }
            let Some((_, after)) = table.rows.get(at + 1) else { break };
            let before = &table.rows[at].1;
            let slack = 1e-9 * forces.step;
            if time < before[0] - slack || time > after[0] + slack {
                continue;
            }
            let share = ((time - before[0]) / (after[0] - before[0])).clamp(0.0, 1.0);
            forces.values[k * n + input] += before[column] + share * (after[column] - before[column]);
        }
    }
    if table.headings.len() < 2 {
        return Err(failed(file, Some(1), format!("no input; allowed beside time_s: {}", forces.inputs.join(", "))));
    }
    Ok(())
}

/// The path of a CSV file with the headings `time_s,position_m`.
///
/// # Errors
/// [`ResponseError::File`] with the line.
pub fn read_path_file(file: &File) -> Result<Path, ResponseError> {
    let table = read(file)?;
    if table.headings != ["time_s", "position_m"] {
        let problem = format!("the headings are {}; allowed: time_s,position_m", table.headings.join(","));
        return Err(failed(file, Some(1), problem));
    }
    Path::through(table.rows.into_iter().map(|(_, row)| (row[0], row[1])).collect())
}
