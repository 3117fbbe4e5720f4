//! Quantities over the position for several designs.

use super::super::canvas::GRID;
use super::super::canvas::{Canvas, Point};
use super::super::frame::{Frame, THIN, WIDTH};
use super::super::scale::Scale;
use super::super::text::{Align, SMALL, TEXT, Typeface};
use super::super::{FigureError, colour, position_label};
use super::{Curve, heading as draw_heading, label, panel_axes, shown, some, write};
use std::path::{Path, PathBuf};

/// Height of a panel with its name.
const PANEL: f64 = 420.0;

/// Draws a panel a quantity, a line a design.
///
/// # Errors
/// [`FigureError::Shape`] without quantities or with a line that has not one value a position, [`FigureError::Encode`]
/// and [`FigureError::Export`] if the file cannot be written.
pub fn draw_curves(
    heading: &str,
    axis: &str,
    positions: &[f64],
    curves: &[Curve],
    path: &Path,
) -> Result<PathBuf, FigureError> {
    some(path, "the quantities", curves.len())?;
    let figure = || path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    for series in curves.iter().flat_map(|curve| &curve.series) {
        if series.values.len() != positions.len() {
            let (what, expected) = (format!("the line {:?}", series.name), positions.len().to_string());
            return Err(FigureError::Shape { figure: figure(), what, seen: series.values.len(), expected });
        }
        if let Some(value) = series.values.iter().find(|v| !v.is_finite()) {
            return Err(FigureError::NotFinite { figure: figure(), what: series.name.clone(), value: *value });
        }
    }
    let font = Typeface::bundled();
    let mut canvas = Canvas::new(WIDTH, (90.0 + PANEL * curves.len() as f64 + 130.0) as usize);
    draw_heading(&mut canvas, &font, heading);
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_by(|a, b| positions[*a].total_cmp(&positions[*b]));
    let ends = [order[0], order[order.len() - 1]].map(|i| 1e3 * positions[i]);
    for (row, curve) in curves.iter().enumerate() {
        let factor = shown(&curve.unit).0;
        let top = curve.series.iter().flat_map(|s| &s.values).fold(0.0_f64, |a, b| a.max(factor * b));
        let from = 90.0 + PANEL * row as f64;
        let (x, y) = (Scale::linear(ends[0], ends[1]), Scale::from_zero(1.05 * top));
        let frame =
            Frame { left: 150.0, right: WIDTH as f64 - 50.0, top: from + 56.0, bottom: from + PANEL - 18.0, x, y };
        font.draw(&mut canvas, &label(&curve.name, &curve.unit), (frame.left, from + 26.0), SMALL, Align::Start);
        for tick in y.ticks(5) {
            let at = frame.place(x.low, tick.value).1;
            canvas.line((frame.left, at), (frame.right, at), THIN, GRID);
        }
        let mut end = frame.right;
        for (k, series) in curve.series.iter().enumerate().rev() {
            let colour = colour::family(k + 1);
            let points: Vec<Point> =
                order.iter().map(|&i| frame.place(1e3 * positions[i], factor * series.values[i])).collect();
            canvas.curve(&points, 4.5, colour);
            font.draw_in(&mut canvas, &series.name, (end, from + 26.0), SMALL, Align::End, colour);
            end -= font.width(&series.name, SMALL) + 16.0;
            canvas.line((end - 50.0, from + 26.0), (end, from + 26.0), 5.0, colour);
            end -= 90.0;
        }
        let last = row + 1 == curves.len();
        panel_axes(&mut canvas, &font, &frame, [last, true], [8, 5]);
        if last {
            let middle = 0.5 * (frame.left + frame.right);
            font.draw(&mut canvas, &position_label(axis), (middle, frame.bottom + 84.0), TEXT, Align::Middle);
        }
    }
    write(&canvas, path)
}
