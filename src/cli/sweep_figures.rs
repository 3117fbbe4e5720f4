//! The pictures of a sweep or a search, from its rows.

use anyhow::Result;
use std::path::{Path, PathBuf};
use stiffmap::figures::sweep::{Curve, Dot, Series, Values, draw_curves, draw_front, draw_grid, draw_scatter};
use stiffmap::sweep::metrics::{Over, Quantity, directions};
use stiffmap::sweep::pareto::front;
use stiffmap::sweep::sampling::Method;
use stiffmap::sweep::table::Row;
use stiffmap::sweep::variables::Domain;
use stiffmap::sweep::{Design, Evaluation, Evaluator, Study};

/// Metrics drawn against the variables at most.
const MOST_METRICS: usize = 6;
/// Variables drawn at most.
const MOST_VARIABLES: usize = 7;

/// A design to be drawn beside the nominal one.
pub struct Best<'a> {
    pub study: &'a Study,
    pub evaluator: &'a dyn Evaluator,
    pub row: &'a Row,
}

/// Draws metrics over variables, a map for a grid of two, and the front of two or three objectives.
pub fn draw_rows(study: &Study, rows: &[Row], best: Option<&Row>, folder: &Path) -> Result<Vec<PathBuf>> {
    let mut drawn = Vec::new();
    let on_front: Vec<u64> =
        if study.objectives.len() > 1 { front(study, rows).iter().map(|row| row.index).collect() } else { Vec::new() };
    let dots: Vec<Dot> = rows
        .iter()
        .map(|row| Dot {
            kept: row.bounds_met == Some(true),
            front: on_front.contains(&row.index),
            best: best.is_some_and(|best| best.index == row.index),
        })
        .collect();
    let variables: Vec<Values> = (0..study.variables.len())
        .map(|v| Values {
            name: study.variables[v].name.clone(),
            unit: study.variables[v].unit().to_owned(),
            logarithmic: matches!(study.variables[v].domain, Domain::Range { logarithmic: true, .. }),
            values: rows.iter().map(|row| Some(row.values[v])).collect(),
        })
        .collect();
    let metrics = scalars(study, rows);
    let shown: Vec<&Values> = variables.iter().take(MOST_VARIABLES).collect();
    let rising: Vec<&Values> = metrics.iter().take(MOST_METRICS).collect();
    drawn.push(draw_scatter(&study.name, &shown, &rising, &dots, &folder.join("metrics_over_variables.png"))?);
    let ranges = study.variables.iter().all(|v| matches!(v.domain, Domain::Range { .. }));
    if study.sampling.method == Method::Grid && study.variables.len() == 2 && ranges && rows.len() > 3 {
        for metric in metrics.iter().take(MOST_METRICS) {
            let path = folder.join(format!("map_{}.png", file_name(&metric.name)));
            drawn.push(draw_grid(&study.name, [&variables[0], &variables[1]], metric, &path)?);
        }
    }
    if study.objectives.len() > 1 {
        let columns = study.result_columns();
        let objectives: Vec<Values> = study
            .objectives
            .iter()
            .take(3)
            .map(|objective| {
                let at = study.result_place(objective.figure);
                Values {
                    name: objective.name.clone(),
                    unit: columns[at].unit.clone(),
                    logarithmic: false,
                    values: rows.iter().map(|row| row.results[at]).collect(),
                }
            })
            .collect();
        drawn.push(draw_front(&study.name, &objectives, &dots, &folder.join("front.png"))?);
    }
    Ok(drawn)
}

/// The cost and the metrics that have one value a design.
fn scalars(study: &Study, rows: &[Row]) -> Vec<Values> {
    let columns = study.result_columns();
    let named = |name: &str, at: usize| Values {
        name: name.to_owned(),
        unit: columns[at].unit.clone(),
        logarithmic: false,
        values: rows.iter().map(|row| row.results[at]).collect(),
    };
    let metrics = study.metrics.iter().enumerate().filter(|(_, m)| m.over != Over::Each);
    let metrics =
        metrics.map(|(m, metric)| named(&metric.name, study.result_place(stiffmap::sweep::goals::Figure::Metric(m))));
    metrics.chain(study.cost.iter().map(|_| named("cost", 0))).collect()
}

/// Draws the dynamic stiffness over the position of a design beside the nominal machine's.
pub fn draw_best(best: &Best<'_>, folder: &Path) -> Result<Vec<PathBuf>> {
    let Best { study, evaluator, row } = best;
    if study.positions.len() < 2 {
        return Ok(Vec::new());
    }
    let designs = [Design::nominal(&study.machine), study.design(&row.values)];
    let evaluations = evaluator.evaluate(&designs).into_iter().collect::<std::result::Result<Vec<Evaluation>, _>>()?;
    let curve = |pair: usize, name: &str| {
        let series = evaluations.iter().zip(["nominal", "best"]).map(|(evaluation, name)| Series {
            name: name.to_owned(),
            values: evaluation
                .iter()
                .filter_map(|at| Quantity::DynamicStiffness(pair).of(at))
                .map(|(v, _)| v)
                .collect(),
        });
        Curve { name: format!("dynamic stiffness {name}"), unit: "N/m".to_owned(), series: series.collect() }
    };
    let curves: Vec<Curve> = directions(&study.machine).iter().enumerate().map(|(i, name)| curve(i, name)).collect();
    let heading = format!("{}: smallest dynamic stiffness of the band over position", study.name);
    let path = folder.join("best_over_position.png");
    Ok(vec![draw_curves(&heading, &study.machine.axis.name, &study.positions, &curves, &path)?])
}

fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || c == '_' { c } else { '_' }).collect()
}
