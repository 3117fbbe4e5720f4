//! A response over one axis, where the map has a single position or frequency.

use super::canvas::{Canvas, Point};
use super::colour;
use super::field::Field;
use super::frame::{Frame, HEIGHT, WIDTH};
use super::scale::{Scale, plain};
use super::text::Typeface;
use super::{FREQUENCY_LABEL, position_label};

/// Draws the response over the axis that has several values, with a logarithmic or linear height.
pub(super) fn draw(heading: &str, axis: &str, field: &Field, logarithmic: bool) -> Canvas {
    let font = Typeface::bundled();
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
    let over_frequency = field.positions.len() == 1;
    let (along, label, place) = if over_frequency {
        let at = number(field.positions[0]);
        (&field.frequencies, FREQUENCY_LABEL.to_owned(), format!("{axis} = {at} mm"))
    } else {
        let at = number(field.frequencies[0]);
        (&field.positions, position_label(axis), format!("{at} Hz"))
    };
    let x = Scale::linear(along[0], along[along.len() - 1]);
    let y = if logarithmic {
        let values = field.logarithmic().0;
        Scale::logarithmic(values.low / 1.2, values.high * 1.2)
    } else {
        Scale::from_zero(1.02 * field.max)
    };
    let frame = Frame::new(&font, HEIGHT, x, y, 60.0);
    frame.grid(&mut canvas);
    let points: Vec<Point> = along
        .iter()
        .zip(&field.values)
        .map(|(x, v)| frame.place(*x, v.max(if logarithmic { y.low } else { 0.0 })))
        .collect();
    match points[..] {
        [only] => canvas.line(only, only, 14.0, colour::family(1)),
        _ => canvas.curve(&points, 4.0, colour::family(1)),
    }
    let heading = format!("{heading}, {place}");
    frame.axes(&mut canvas, &font, &heading, &label, &field.label());
    canvas
}

/// A place on an axis, with a decimal where it has one.
fn number(value: f64) -> String {
    plain(value, if value.fract() == 0.0 { 1.0 } else { 0.1 })
}
