//! The objective over the evaluations of a search.

use super::super::FigureError;
use super::super::canvas::{Canvas, Point};
use super::super::frame::{Frame, HEIGHT, WIDTH};
use super::super::text::Typeface;
use super::{BEST, Convergence, Dot, axis_of, draw_dot, label, legend, shown, some, write};
use std::path::{Path, PathBuf};

/// Draws a dot an evaluation, and as a line the best so far that keeps every bound.
///
/// # Errors
/// [`FigureError::Shape`] without any value, [`FigureError::Encode`] and [`FigureError::Export`] if the file cannot be
/// written.
pub fn draw_convergence(input: &Convergence, path: &Path) -> Result<PathBuf, FigureError> {
    let points: Vec<(f64, f64, bool)> = input
        .points
        .iter()
        .enumerate()
        .filter_map(|(i, point)| point.map(|(value, kept)| (i as f64, value * shown(&input.unit).0, kept)))
        .collect();
    some(path, "the evaluations", points.len())?;
    let font = Typeface::bundled();
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
    let x = axis_of(points.iter().map(|p| p.0), false);
    let mut frame = Frame::new(&font, HEIGHT, x, axis_of(points.iter().map(|p| p.1), false), 60.0);
    frame.top += 50.0;
    frame.grid(&mut canvas);
    let dots: Vec<Dot> = points.iter().map(|p| Dot { kept: p.2, front: false, best: false }).collect();
    for (point, dot) in points.iter().zip(&dots) {
        draw_dot(&mut canvas, frame.place(point.0, point.1), *dot, 11.0);
    }
    let mut line: Vec<Point> = Vec::new();
    let mut best: Option<f64> = None;
    for (x, y, _) in points.iter().filter(|p| p.2) {
        if best.is_none_or(|b| if input.maximise { *y > b } else { *y < b }) {
            line.extend(best.map(|b| frame.place(*x, b)));
            line.push(frame.place(*x, *y));
            best = Some(*y);
        }
    }
    line.extend(best.map(|b| frame.place(points[points.len() - 1].0, b)));
    canvas.polyline(&line, 4.0, BEST);
    let heading = format!("{}: search for the best design, the line the best so far", input.study);
    frame.axes(&mut canvas, &font, &heading, "Evaluation", &label(&input.objective, &input.unit));
    legend(&mut canvas, &font, &dots, frame.right, 104.0);
    write(&canvas, path)
}
