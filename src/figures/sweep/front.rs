//! Two or three objectives against each other.

use super::super::FigureError;
use super::super::canvas::{Canvas, Point};
use super::super::colour::viridis;
use super::super::frame::{Frame, HEIGHT, WIDTH, bar_room, colour_bar};
use super::super::text::Typeface;
use super::{Dot, FRONT, Values, axis_of, draw_dot, in_shown, label, legend, some, write};
use std::path::{Path, PathBuf};

/// Draws the first objective against the second; a third is the colour of the front's designs.
///
/// # Errors
/// [`FigureError::Shape`] with fewer than two objectives or without designs, [`FigureError::Encode`] and
/// [`FigureError::Export`] if the file cannot be written.
pub fn draw_front(study: &str, objectives: &[Values], dots: &[Dot], path: &Path) -> Result<PathBuf, FigureError> {
    some(path, "the objectives", objectives.len().saturating_sub(1))?;
    some(path, "the designs", dots.len())?;
    let font = Typeface::bundled();
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
    let values: Vec<Vec<Option<f64>>> = objectives.iter().map(in_shown).collect();
    let colours = values.get(2).map(|third| axis_of(third.iter().flatten().copied(), false));
    let room = colours.map_or(60.0, |scale| bar_room(&font, &scale) + 36.0);
    let axis = |k: usize| axis_of(values[k].iter().flatten().copied(), false);
    let mut frame = Frame::new(&font, HEIGHT, axis(0), axis(1), room);
    frame.top += 50.0;
    frame.grid(&mut canvas);
    let mut order: Vec<usize> = (0..dots.len()).collect();
    order.sort_by_key(|&i| dots[i].rank());
    let mut joined: Vec<Point> = Vec::new();
    for &i in &order {
        let (Some(x), Some(y)) = (values[0][i], values[1][i]) else { continue };
        let at = frame.place(x, y);
        draw_dot(&mut canvas, at, dots[i], if dots[i].front { 16.0 } else { 10.0 });
        if let (true, Some(scale), Some(third)) = (dots[i].front, colours, values.get(2).and_then(|v| v[i])) {
            canvas.line(at, at, 11.0, viridis(scale.at(third)));
        }
        if dots[i].front {
            joined.push(at);
        }
    }
    if objectives.len() == 2 {
        joined.sort_by(|a, b| a.0.total_cmp(&b.0));
        canvas.polyline(&joined, 2.5, FRONT);
    }
    let names: Vec<String> = objectives.iter().map(|o| label(&o.name, &o.unit)).collect();
    frame.axes(&mut canvas, &font, &format!("{study}: designs that no other beats"), &names[0], &names[1]);
    legend(&mut canvas, &font, dots, frame.right, 104.0);
    if let (Some(scale), Some(name)) = (colours, names.get(2)) {
        colour_bar(&mut canvas, &font, &scale, name, (frame.right + 36.0, frame.top, frame.bottom), false);
    }
    write(&canvas, path)
}
