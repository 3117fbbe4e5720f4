//! Every metric against every variable.

use super::super::FigureError;
use super::super::canvas::Canvas;
use super::super::frame::{Frame, WIDTH};
use super::super::text::{Align, SMALL, Typeface};
use super::{Dot, Values, axis_of, draw_dot, fitted, heading, in_shown, label, legend, panel_axes, some, write};
use std::path::{Path, PathBuf};

/// Height of a row: its name, then the panels.
const ROW: f64 = 290.0;
const NAME: f64 = 52.0;

/// Draws a row of panels a metric, a column a variable.
///
/// # Errors
/// [`FigureError::Shape`] without variables or metrics, [`FigureError::Encode`] and [`FigureError::Export`] if the file
/// cannot be written.
pub fn draw_scatter(
    study: &str,
    variables: &[&Values],
    metrics: &[&Values],
    dots: &[Dot],
    path: &Path,
) -> Result<PathBuf, FigureError> {
    some(path, "the variables", variables.len())?;
    some(path, "the metrics", metrics.len())?;
    let font = Typeface::bundled();
    let top = 140.0;
    let mut canvas = Canvas::new(WIDTH, (top + ROW * metrics.len() as f64 + 110.0) as usize);
    heading(&mut canvas, &font, &format!("{study}: metrics over variables"));
    legend(&mut canvas, &font, dots, WIDTH as f64 - 30.0, 98.0);
    let (left, gap) = (130.0, 26.0);
    let wide = (WIDTH as f64 - left - 30.0 + gap) / variables.len() as f64;
    let size = if dots.len() > 1500 { 5.0 } else { 9.0 };
    let mut order: Vec<usize> = (0..dots.len()).collect();
    order.sort_by_key(|&i| dots[i].rank());
    for (row, metric) in metrics.iter().enumerate() {
        let y_values = in_shown(metric);
        let y = axis_of(y_values.iter().flatten().copied(), false);
        let from = top + ROW * row as f64;
        font.draw(&mut canvas, &label(&metric.name, &metric.unit), (left, from + 26.0), SMALL, Align::Start);
        for (column, variable) in variables.iter().enumerate() {
            let x_values = in_shown(variable);
            let x = axis_of(x_values.iter().flatten().copied(), variable.logarithmic);
            let at = left + wide * column as f64;
            let frame = Frame { left: at, right: at + wide - gap, top: from + NAME, bottom: from + ROW - 14.0, x, y };
            for &i in &order {
                if let (Some(x), Some(y)) = (x_values[i], y_values[i]) {
                    draw_dot(&mut canvas, frame.place(x, y), dots[i], size);
                }
            }
            let last = row + 1 == metrics.len();
            panel_axes(&mut canvas, &font, &frame, [last, column == 0], [3, 3]);
            if last {
                let text = label(&variable.name, &variable.unit);
                let middle = 0.5 * (frame.left + frame.right);
                let size = fitted(&font, &text, SMALL, wide - 30.0);
                font.draw(&mut canvas, &text, (middle, frame.bottom + 80.0), size, Align::Middle);
            }
        }
    }
    write(&canvas, path)
}
