//! A metric over a grid of two variables.

use super::super::FigureError;
use super::super::canvas::Canvas;
use super::super::colour::viridis;
use super::super::frame::{Frame, HEIGHT, WIDTH, bar_room, colour_bar};
use super::super::scale::Scale;
use super::super::text::Typeface;
use super::{Values, in_shown, label, some, write};
use std::path::{Path, PathBuf};

/// Draws a full grid, in any order of designs; white where there is no value.
///
/// # Errors
/// [`FigureError::Shape`] without any value, [`FigureError::Encode`] and [`FigureError::Export`] if the file cannot be
/// written.
pub fn draw_grid(study: &str, [x, y]: [&Values; 2], metric: &Values, path: &Path) -> Result<PathBuf, FigureError> {
    let (xs, ys, values) = (in_shown(x), in_shown(y), in_shown(metric));
    some(path, "the values", values.iter().flatten().count())?;
    let font = Typeface::bundled();
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
    let (columns, rows) = (steps(&xs), steps(&ys));
    let ends = |steps: &[f64], logarithmic: bool| {
        let (low, high) = (steps[0], steps[steps.len() - 1]);
        if logarithmic { Scale::logarithmic(low, high) } else { Scale::linear(low, high) }
    };
    let range = values.iter().flatten().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    let colours = Scale::linear(range.0, range.1);
    let room = bar_room(&font, &colours);
    let frame = Frame::new(&font, HEIGHT, ends(&columns, x.logarithmic), ends(&rows, y.logarithmic), room + 36.0);
    let mut cells = vec![None; columns.len() * rows.len()];
    for ((x, y), value) in xs.iter().zip(&ys).zip(&values) {
        if let (Some(x), Some(y)) = (x, y) {
            cells[nearest(&rows, *y) * columns.len() + nearest(&columns, *x)] = *value;
        }
    }
    let share = |pixel: usize, from: f64, to: f64| (pixel as f64 + 0.5 - from) / (to - from);
    let place = |scale: &Scale, steps: &[f64], t: f64| {
        let places: Vec<f64> = steps.iter().map(|v| scale.at(*v)).collect();
        nearest(&places, t)
    };
    let across: Vec<usize> = (frame.left as usize..frame.right as usize)
        .map(|pixel| place(&frame.x, &columns, share(pixel, frame.left, frame.right)))
        .collect();
    for pixel_y in frame.top as usize..frame.bottom as usize {
        let row = place(&frame.y, &rows, 1.0 - share(pixel_y, frame.top, frame.bottom));
        for (pixel_x, column) in (frame.left as usize..).zip(&across) {
            if let Some(value) = cells[row * columns.len() + column] {
                canvas.set(pixel_x, pixel_y, viridis(colours.at(value)));
            }
        }
    }
    let name = label(&metric.name, &metric.unit);
    let heading = format!("{study}: {}", metric.name.replace('_', " "));
    frame.axes(&mut canvas, &font, &heading, &label(&x.name, &x.unit), &label(&y.name, &y.unit));
    colour_bar(&mut canvas, &font, &colours, &name, (frame.right + 36.0, frame.top, frame.bottom), false);
    write(&canvas, path)
}

/// The different values, ascending.
fn steps(values: &[Option<f64>]) -> Vec<f64> {
    let mut steps: Vec<f64> = values.iter().flatten().copied().collect();
    steps.sort_by(f64::total_cmp);
    steps.dedup();
    steps
}

/// Place of the value nearest to one, among ascending values.
fn nearest(steps: &[f64], value: f64) -> usize {
    let after = steps.partition_point(|s| *s < value).min(steps.len() - 1);
    let before = after.saturating_sub(1);
    if (steps[before] - value).abs() <= (steps[after] - value).abs() { before } else { after }
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn the_nearest_step_is_found() {
        let steps = [0.0, 1.0, 3.0];
        let found: Vec<usize> = [-1.0, 0.4, 0.6, 1.9, 2.1, 9.0].iter().map(|v| nearest(&steps, *v)).collect();
        assert_eq!(found, [0, 0, 1, 1, 2, 2]);
    }
}
