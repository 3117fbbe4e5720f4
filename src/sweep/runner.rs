//! The loop of a sweep: designs in batches from the evaluator into the table.

use super::study::Study;
use super::table::{Row, Store};
use super::table_error::TableError;
use super::{Design, Evaluator, SweepError};
use crate::interrupt::Interrupt;
use std::ops::Range;

/// Why a sweep ended before its last design.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The table could not be written.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The device that was asked for failed.
    #[error("{message}; the designs done so far are in the table, continue with --resume")]
    Device {
        /// Why.
        message: String,
    },
    /// The user asked to stop.
    #[error("interrupted; the designs done so far are in the table, continue with --resume")]
    Interrupted,
}

/// Evaluates a range of designs and appends their rows, each batch as it is done.
///
/// A design that cannot be answered has a row with its error. `seen` is given every row once it is on the disk.
///
/// # Errors
/// [`RunError`].
pub fn run(
    study: &Study,
    evaluator: &dyn Evaluator,
    range: Range<u64>,
    store: &mut Store,
    interrupt: &Interrupt,
    seen: &mut dyn FnMut(Row),
) -> Result<(), RunError> {
    let batch = evaluator.batch().max(1) as u64;
    let mut next = range.start;
    while next < range.end {
        let end = (next + batch).min(range.end);
        let values: Vec<Vec<f64>> = (next..end).map(|index| study.values(index)).collect();
        let designs: Vec<Design> = values.iter().map(|values| study.design(values)).collect();
        let outcomes = evaluator.evaluate(&designs);
        let stopped = outcomes.iter().any(|o| matches!(o, Err(SweepError::Interrupted)));
        if stopped || interrupt.requested() {
            return Err(RunError::Interrupted);
        }
        for outcome in &outcomes {
            if let Err(SweepError::Device { message }) = outcome {
                return Err(RunError::Device { message: message.clone() });
            }
        }
        let rows: Vec<Row> = (next..end)
            .zip(values)
            .zip(&outcomes)
            .map(|((index, values), outcome)| Row::new(study, index, values, outcome))
            .collect();
        store.append(&rows.iter().flat_map(|row| row.line(study)).collect::<Vec<u8>>())?;
        rows.into_iter().for_each(&mut *seen);
        next = end;
    }
    Ok(())
}
