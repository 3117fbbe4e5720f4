//! Sensitivities of a design's metrics as a table.

use anyhow::Result;
use stiffmap::interrupt::Interrupt;
use stiffmap::reduction::Superelement;
use stiffmap::sweep::metrics::Over;
use stiffmap::sweep::table::{Row, number};
use stiffmap::sweep::{Evaluator, ModesRoute, Request, Study};

/// One line a variable: its value, and the derivative of each metric by it; empty where a value is missing, and for
/// names, which have no derivative.
pub fn rates(study: &Study, superelements: &[Superelement], row: &Row, interrupt: &Interrupt) -> Result<Vec<u8>> {
    let route = ModesRoute::new(&study.machine, superelements, Request::of(study), &study.probes(), interrupt)?;
    let evaluation = route.evaluate(&[study.design(&row.values)]).swap_remove(0)?;
    // Names stay as they are; the others vary.
    let varied: Vec<usize> = (0..row.values.len()).filter(|&v| !study.variables[v].is_name()).collect();
    let values: Vec<f64> = varied.iter().map(|&v| row.values[v]).collect();
    let design = |values: &[f64]| {
        let mut all = row.values.clone();
        for (&v, value) in varied.iter().zip(values) {
            all[v] = *value;
        }
        Ok(study.design(&all))
    };
    let found = route.sensitivities(&values, &design)?;
    let metrics: Vec<_> = study.metrics.iter().filter(|m| m.over != Over::Each).collect();
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut header = vec!["variable".to_owned(), "value".to_owned(), "unit".to_owned()];
    header.extend(metrics.iter().map(|m| format!("{} [{} per unit]", m.name, m.quantity.unit())));
    writer.write_record(&header)?;
    for (v, variable) in study.variables.iter().enumerate() {
        let mut cells = vec![variable.name.clone(), variable.text(row.values[v]), variable.unit().to_owned()];
        let by = varied.iter().position(|&other| other == v).map(|at| &found[at]);
        cells.extend(
            metrics.iter().map(|metric| by.and_then(|by| metric.rate(&evaluation, by)).map(number).unwrap_or_default()),
        );
        writer.write_record(&cells)?;
    }
    Ok(writer.into_inner()?)
}
