//! The best design under bounds, by CMA-ES (N. Hansen, The CMA evolution strategy, 2006; crate `cmaes`).
//!
//! The search runs in the unit box of the variables' places ([`Variable::place`](super::variables::Variable::place)),
//! so that a logarithmic scale is straight. A point outside the box stands for the nearest one inside, and pays for
//! its distance. Since only the order of designs counts, a design that misses bounds comes after every one that keeps
//! them, by how far it misses them, and one without a value last.
//!
//! The sequence of designs is a function of the study and of the values found: a search is continued by giving the
//! same values again.

use super::goals::{Names, Objective};
use super::runner::RunError;
use super::study::Study;
use super::study_error::StudyError;
use super::table::Row;
use super::{Evaluator, SweepError};
use crate::interrupt::Interrupt;
use crate::machine::table::Table;
use cmaes::{CMAESOptions, DVector};

/// How the best design is looked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// What is improved; `None` in a study that has no objective and names none here.
    pub objective: Option<Objective>,
    /// Evaluations at most.
    pub evaluations: usize,
    /// Designs a generation; `None` takes 4 + floor(3 ln n).
    pub population: Option<usize>,
    /// First step, as a share of each variable's range.
    pub step: f64,
    /// Seed.
    pub seed: u64,
}

/// Reads `[optimise]`, which may be left out.
///
/// Its objective is one of the study's, the first without a name, or any other metric or the cost, which is then
/// improved in its own sense.
pub(super) fn read_search(root: &Table<'_>, objectives: &[Objective], names: Names<'_>) -> Result<Search, StudyError> {
    let objective = objectives.first().cloned();
    let mut search = Search { objective, evaluations: 400, population: None, step: 0.3, seed: 1 };
    let Some(item) = root.get("optimise") else { return Ok(search) };
    let table = item.table()?;
    if let Some(item) = table.get("objective") {
        let (figure, name) = names.find(&item, item.text()?)?;
        let listed = objectives.iter().find(|objective| objective.figure == figure).cloned();
        search.objective = Some(listed.unwrap_or_else(|| Objective::natural(figure, name, names.metrics)));
    }
    if let Some(item) = table.get("evaluations") {
        search.evaluations = item.count()?;
    }
    if let Some(item) = table.get("population") {
        search.population = match item.count()? {
            n if n < 4 => return Err(item.refuse("at least 4", "raise it").into()),
            n => Some(n),
        };
    }
    if let Some(item) = table.get("step") {
        search.step = item.plain_number()?;
        if !(search.step > 0.0 && search.step <= 1.0) {
            return Err(item.refuse("more than 0 and at most 1, a share of each range", "write step = 0.3").into());
        }
    }
    if let Some(item) = table.get("seed") {
        search.seed = item.count()? as u64;
    }
    table.finish()?;
    Ok(search)
}

/// Added to the score of a design that misses a bound, and of one without a value.
const MISSES_BOUNDS: f64 = 1e6;
const WITHOUT_VALUE: f64 = 1e12;
/// Cost of a squared distance from the box, in units of the first value's size.
const OUTSIDE: f64 = 10.0;
/// A spread of scores below this share of the first value's size ends the search.
const SPREAD: f64 = 1e-7;

/// What the search found.
#[derive(Clone, Debug)]
pub struct Found {
    /// Every evaluation, in order.
    pub rows: Vec<Row>,
    /// Place of the best design among the rows: the best that keeps every bound, if one does. `None` where no design has
    /// a value.
    pub best: Option<usize>,
    /// Designs a generation.
    pub population: usize,
    /// Why the search ended.
    pub ended: String,
}

impl Study {
    /// The value to be made small: of the search's objective, or far larger where a bound is missed or a value missing.
    ///
    /// # Panics
    /// If the search has no objective.
    pub fn score(&self, row: &Row, size: f64) -> f64 {
        let objective = self.search.objective.as_ref().expect("an objective");
        let missed = |b: &super::goals::Bound| row.results[self.result_place(b.figure)].map(|v| b.violation(v));
        let violation: Option<f64> = self.bounds.iter().map(missed).sum();
        let value = row.results[self.result_place(objective.figure)];
        match (violation, value.filter(|_| row.error.is_none() || row.bounds_met.is_some())) {
            (Some(0.0), Some(value)) => objective.to_minimise(value) / size,
            (Some(violation), Some(_)) => MISSES_BOUNDS * (1.0 + violation),
            _ => WITHOUT_VALUE,
        }
    }
}

/// Looks for the best design. `known` are evaluations of an earlier run in their order, which are not computed again;
/// `seen` is given every new one.
///
/// # Errors
/// [`RunError::Interrupted`], and what `seen` returns.
///
/// # Panics
/// If the search has no objective.
pub fn optimise(
    study: &Study,
    evaluator: &dyn Evaluator,
    known: &[Row],
    interrupt: &Interrupt,
    seen: &mut dyn FnMut(&Row) -> Result<(), RunError>,
) -> Result<Found, RunError> {
    let search = &study.search;
    let objective = search.objective.as_ref().expect("a study whose search has an objective");
    let start: Vec<f64> = study.variables.iter().map(|v| v.nominal.map_or(0.5, |value| v.place(value))).collect();
    let mut rows: Vec<Row> = Vec::new();
    let (mut failed, mut size) = (None, None::<f64>);
    let score = |x: &DVector<f64>| -> f64 {
        // Generations are whole to the crate; what of the last one exceeds the evaluations allowed is not computed.
        if rows.len() >= search.evaluations {
            return WITHOUT_VALUE;
        }
        let inside: Vec<f64> = x.iter().map(|x| x.clamp(0.0, 1.0)).collect();
        let distance: f64 = x.iter().zip(&inside).map(|(x, i)| (x - i) * (x - i)).sum();
        let values: Vec<f64> = study.variables.iter().zip(&inside).map(|(v, place)| v.at(*place)).collect();
        let index = rows.len();
        let row = match known.get(index).filter(|row| row.values == values) {
            Some(row) => row.clone(),
            None => {
                let mut outcome = evaluator.evaluate(&[study.design(&values)]);
                let outcome = outcome.pop().unwrap_or(Err(SweepError::Interrupted));
                if matches!(outcome, Err(SweepError::Interrupted)) || interrupt.requested() {
                    failed = Some(RunError::Interrupted);
                    return f64::NAN;
                }
                let row = Row::new(study, index as u64, values, &outcome);
                if let Err(error) = seen(&row) {
                    failed = Some(error);
                    return f64::NAN;
                }
                row
            }
        };
        let own = row.results[study.result_place(objective.figure)];
        let size = *size.get_or_insert(own.map_or(1.0, |v| v.abs().max(f64::MIN_POSITIVE)));
        let score = study.score(&row, size) + OUTSIDE * distance;
        rows.push(row);
        score
    };
    let mut options = CMAESOptions::new(start, search.step)
        .max_function_evals(search.evaluations)
        .tol_fun(SPREAD)
        .tol_fun_hist(SPREAD)
        .seed(search.seed);
    if let Some(population) = search.population {
        options = options.population_size(population);
    }
    let population = options.population_size;
    let mut cmaes = options.build(score).expect("options that the study's checks allow");
    let ended = cmaes.run();
    drop(cmaes);
    if let Some(error) = failed {
        return Err(error);
    }
    let reasons: Vec<String> = ended.reasons.iter().map(ToString::to_string).collect();
    let size = size.unwrap_or(1.0);
    let valued = (0..rows.len()).filter(|&at| study.score(&rows[at], size) < WITHOUT_VALUE);
    let best = valued.min_by(|&a, &b| study.score(&rows[a], size).total_cmp(&study.score(&rows[b], size)));
    Ok(Found { rows, best, population, ended: reasons.join(", ") })
}
