//! The designs that no other design beats in every objective.

use super::study::Study;
use super::table::Row;

/// The objectives' values of a row as something to make small; `None` where one is missing.
fn goals(study: &Study, row: &Row) -> Option<Vec<f64>> {
    let value = |o: &super::goals::Objective| Some(o.to_minimise(row.results[study.result_place(o.figure)]?));
    study.objectives.iter().map(value).collect()
}

/// Whether `a` is at least as good as `b` in everything and better in something.
pub fn dominates(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
}

/// Places of the points that no other dominates, in their order; equal points are all kept.
pub fn non_dominated(points: &[Vec<f64>]) -> Vec<usize> {
    // In lexicographic order a point is dominated only by one before it.
    let mut order: Vec<usize> = (0..points.len()).collect();
    let lexicographic = |a: &usize, b: &usize| {
        let pairs = points[*a].iter().zip(&points[*b]);
        pairs.map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    };
    order.sort_by(lexicographic);
    let mut front: Vec<usize> = Vec::new();
    for i in order {
        if !front.iter().any(|&kept| dominates(&points[kept], &points[i])) {
            front.push(i);
        }
    }
    front.sort_unstable();
    front
}

/// The rows of the front: those that keep every bound and have all objectives, of which no other is better.
pub fn front<'a>(study: &Study, rows: &'a [Row]) -> Vec<&'a Row> {
    let allowed: Vec<(&Row, Vec<f64>)> = rows
        .iter()
        .filter(|row| row.bounds_met == Some(true))
        .filter_map(|row| Some((row, goals(study, row)?)))
        .collect();
    let points: Vec<Vec<f64>> = allowed.iter().map(|(_, goals)| goals.clone()).collect();
    non_dominated(&points).into_iter().map(|i| allowed[i].0).collect()
}

/// The best row: by the first objective among those that keep every bound, or by the first metric without objectives.
pub fn best<'a>(study: &Study, rows: &'a [Row]) -> Option<&'a Row> {
    let goal = |row: &Row| match study.objectives.first() {
        Some(objective) => Some(objective.to_minimise(row.results[study.result_place(objective.figure)]?)),
        None => {
            let metric = study.metrics.iter().position(|m| m.over != super::metrics::Over::Each)?;
            let value = row.results[study.result_place(super::goals::Figure::Metric(metric))]?;
            Some(if study.metrics[metric].quantity.larger_is_better() { -value } else { value })
        }
    };
    let allowed = rows.iter().filter(|row| row.bounds_met == Some(true));
    let valued = allowed.filter_map(|row| Some((row, goal(row)?)));
    valued.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(row, _)| row)
}
