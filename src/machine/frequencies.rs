//! The frequency grid of `[analysis]`: a list, or a table whose `grid` says how the frequencies are laid.

use super::analysis_model::Grid;
use super::error::MachineError;
use super::quantity::Dimension;
use super::table::{Bound, Item, Table};

type Result<T> = std::result::Result<T, MachineError>;

/// Most frequencies of the grid.
const MOST_FREQUENCIES: f64 = 1_000_000.0;
/// Frequencies a mode of a clustered grid where no number is given: one is the mode's own, and no point of its circle in
/// the Nyquist plane is farther than pi/28 from one.
pub const DEFAULT_POINTS: usize = 13;
/// Frequencies of a clustered grid's background where no number is given.
pub const DEFAULT_BACKGROUND: usize = 101;

/// `count` frequencies at equal ratios from `from` to `to` (Hz, above 0), both kept.
pub fn logarithmic_frequencies(from: f64, to: f64, count: usize) -> Vec<f64> {
    assert!(from > 0.0 && to > from && count >= 2, "{count} frequencies from {from} to {to} Hz");
    let (ratio, last) = ((to / from).ln(), count - 1);
    let at = |i| match i {
        0 => from,
        i if i == last => to,
        i => from * (ratio * i as f64 / last as f64).exp(),
    };
    (0..count).map(at).collect()
}

/// `count` frequencies at equal steps from `from` to `to` (Hz), both kept.
pub fn uniform_frequencies(from: f64, to: f64, count: usize) -> Vec<f64> {
    assert!(to > from && count >= 2, "{count} frequencies from {from} to {to} Hz");
    let step = (to - from) / (count - 1) as f64;
    (0..count).map(|i| if i + 1 == count { to } else { from + step * i as f64 }).collect()
}

/// The frequencies, Hz (of a clustered grid the background), and how they are laid.
pub(super) fn read_frequencies(item: &Item<'_>) -> Result<(Vec<f64>, Grid)> {
    if !item.is_table() {
        return Ok((read_list(item)?, Grid::Listed));
    }
    let table = item.table()?;
    match table.get("grid").map(|kind| kind.text().map(|name| (kind.clone(), name))).transpose()? {
        None | Some((_, "uniform")) => Ok((read_uniform(table)?, Grid::Uniform)),
        Some((_, "logarithmic")) => Ok((read_logarithmic(table)?, Grid::Logarithmic)),
        Some((_, "clustered")) => read_clustered(table),
        Some((kind, _)) => {
            Err(kind
                .refuse("\"uniform\", \"logarithmic\" or \"clustered\"", "write one of them, or a list of frequencies"))
        }
    }
}

/// `from` and `to`, Hz, in order; `lowest` is what `from` may be.
fn read_ends<'a>(table: &Table<'a>, lowest: Bound) -> Result<(f64, f64, Item<'a>)> {
    let from_item = table.need("from", "from = \"0 Hz\"")?;
    let from = from_item.quantity(Dimension::Frequency, lowest)?;
    let to_item = table.need("to", "to = \"900 Hz\"")?;
    let to = to_item.quantity(Dimension::Frequency, Bound::NotNegative)?;
    if to < from {
        return Err(to_item.refuse(format!("at least `from`, {from} Hz"), "exchange the two"));
    }
    Ok((from, to, to_item))
}

fn read_uniform(table: Table<'_>) -> Result<Vec<f64>> {
    let (from, to, _) = read_ends(&table, Bound::NotNegative)?;
    let step_item = table.need("step", "step = \"1 Hz\"")?;
    let step = step_item.quantity(Dimension::Frequency, Bound::Positive)?;
    table.finish()?;
    let intervals = (to - from) / step;
    if intervals > MOST_FREQUENCIES {
        let allowed = format!("a step that divides the range into at most {MOST_FREQUENCIES} intervals");
        return Err(step_item.refuse(allowed, "make the step larger"));
    }
    // A last step that misses `to` by rounding alone still reaches it.
    let count = (intervals * (1.0 + 1e-9)).floor() as usize;
    let mut grid: Vec<f64> = (0..=count).map(|i| (from + step * i as f64).min(to)).collect();
    if grid.last().is_some_and(|last| to - last > 1e-9 * step) {
        grid.push(to);
    }
    Ok(grid)
}

fn read_logarithmic(table: Table<'_>) -> Result<Vec<f64>> {
    let (from, to, to_item) = read_ends(&table, Bound::Positive)?;
    let count = read_number(&table.need("count", "count = 500")?)?;
    table.finish()?;
    require_above(from, to, &to_item)?;
    Ok(logarithmic_frequencies(from, to, count))
}

fn read_clustered(table: Table<'_>) -> Result<(Vec<f64>, Grid)> {
    let (from, to, to_item) = read_ends(&table, Bound::NotNegative)?;
    let background = table.get("background").map(|item| read_number(&item)).transpose()?;
    let points = match table.get("points") {
        None => DEFAULT_POINTS,
        Some(item) => match item.count()? {
            points @ 1..=1000 => points,
            _ => return Err(item.refuse("a whole number from 1 to 1000", "13 follow a peak to a thousandth of it")),
        },
    };
    table.finish()?;
    require_above(from, to, &to_item)?;
    Ok((uniform_frequencies(from, to, background.unwrap_or(DEFAULT_BACKGROUND)), Grid::Clustered { points }))
}

/// A number of frequencies, at least two.
fn read_number(item: &Item<'_>) -> Result<usize> {
    match item.count()? {
        count if (2..=MOST_FREQUENCIES as usize).contains(&count) => Ok(count),
        _ => {
            let allowed = format!("a whole number from 2 to {MOST_FREQUENCIES}");
            Err(item.refuse(allowed, "both ends of the grid count"))
        }
    }
}

fn require_above(from: f64, to: f64, item: &Item<'_>) -> Result<()> {
    if to > from { Ok(()) } else { Err(item.refuse(format!("more than `from`, {from} Hz"), "raise it")) }
}

fn read_list(item: &Item<'_>) -> Result<Vec<f64>> {
    const ALLOWED: &str =
        "an ascending list such as [5, \"25 Hz\"], or { from = \"0 Hz\", to = \"900 Hz\", step = \"1 Hz\" }";
    if !item.is_list() {
        return Err(item.refuse(ALLOWED, "write one of them"));
    }
    let mut list: Vec<f64> = Vec::new();
    for entry in item.list()? {
        let frequency = entry.quantity(Dimension::Frequency, Bound::NotNegative)?;
        if let Some(&last) = list.last().filter(|&&last| frequency <= last) {
            return Err(entry.refuse(format!("more than the one before, {last} Hz"), "put them in ascending order"));
        }
        list.push(frequency);
    }
    if list.is_empty() {
        return Err(item.refuse(ALLOWED, "give at least one frequency"));
    }
    Ok(list)
}
