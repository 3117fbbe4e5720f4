//! The best design under bounds, by CMA-ES.

use super::goals::Objective;
use super::study_error::StudyError;
use super::variables::Variable;
use crate::machine::table::{Table, find_name};

/// How the best design is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Objective by index, if the study has one.
    pub objective: usize,
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
pub(super) fn read_search(
    root: &Table<'_>,
    objectives: &[Objective],
    _variables: &[Variable],
) -> Result<Search, StudyError> {
    let mut search = Search { objective: 0, evaluations: 400, population: None, step: 0.3, seed: 1 };
    let Some(item) = root.get("optimise") else { return Ok(search) };
    let table = item.table()?;
    if let Some(item) = table.get("objective") {
        let names: Vec<&str> = objectives.iter().map(|o| o.name.as_str()).collect();
        search.objective = find_name(&item, "objective", item.text()?, &names)?;
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
