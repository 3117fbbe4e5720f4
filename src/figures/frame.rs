//! The frame of a plane picture: heading, axes, grid, colour bar.

use super::canvas::{Canvas, GRID, INK, Point};
use super::colour::viridis;
use super::scale::Scale;
use super::text::{Align, SMALL, TEXT, Typeface};

/// Size of a picture, pixels.
pub(super) const WIDTH: usize = 1600;
/// Size of a picture, pixels.
pub(super) const HEIGHT: usize = 1100;

/// About the number of labelled ticks of an axis.
const TICKS: usize = 10;
/// Length of a labelled tick; minor ones have half.
const TICK: f64 = 10.0;
/// Width of axis lines.
pub(super) const AXIS: f64 = 2.5;
/// Width of grid lines.
pub(super) const THIN: f64 = 1.5;

/// The area that a picture's axes enclose.
pub(super) struct Frame {
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
    pub x: Scale,
    pub y: Scale,
}

impl Frame {
    /// A frame that leaves room for heading and labels, and `right` pixels beside it.
    pub fn new(font: &Typeface, height: usize, x: Scale, y: Scale, right: f64) -> Frame {
        let widest = labels(font, &y, TICKS);
        Frame {
            left: (34.0 + TEXT + 22.0 + widest + 16.0).round(),
            right: (WIDTH as f64 - right).round(),
            top: 92.0,
            bottom: height as f64 - 130.0,
            x,
            y,
        }
    }

    /// Place of a pair of values.
    pub fn place(&self, x: f64, y: f64) -> Point {
        (self.left + self.x.at(x) * (self.right - self.left), self.bottom - self.y.at(y) * (self.bottom - self.top))
    }

    /// Thin lines at the labelled ticks, to be drawn before the data.
    pub fn grid(&self, canvas: &mut Canvas) {
        for tick in self.x.ticks(TICKS).iter().filter(|t| t.label.is_some()) {
            let x = self.place(tick.value, self.y.low).0;
            canvas.line((x, self.top), (x, self.bottom), THIN, GRID);
        }
        for tick in self.y.ticks(TICKS).iter().filter(|t| t.label.is_some()) {
            let y = self.place(self.x.low, tick.value).1;
            canvas.line((self.left, y), (self.right, y), THIN, GRID);
        }
    }

    /// Heading, box, ticks and labels, to be drawn after the data.
    pub fn axes(&self, canvas: &mut Canvas, font: &Typeface, heading: &str, x: &str, y: &str) {
        draw_heading(canvas, font, heading, self.left);
        let (l, r, t, b) = (self.left, self.right, self.top, self.bottom);
        canvas.polyline(&[(l, t), (r, t), (r, b), (l, b), (l, t)], AXIS, INK);
        for tick in self.x.ticks(TICKS) {
            let at = self.place(tick.value, self.y.low).0;
            let length = if tick.label.is_some() { TICK } else { TICK / 2.0 };
            canvas.line((at, b), (at, b + length), AXIS, INK);
            if let Some(label) = tick.label {
                font.draw(canvas, &label, (at, b + 38.0), SMALL, Align::Middle);
            }
        }
        for tick in self.y.ticks(TICKS) {
            let at = self.place(self.x.low, tick.value).1;
            let length = if tick.label.is_some() { TICK } else { TICK / 2.0 };
            canvas.line((l - length, at), (l, at), AXIS, INK);
            if let Some(label) = tick.label {
                font.draw(canvas, &label, (l - 18.0, at), SMALL, Align::End);
            }
        }
        font.draw(canvas, x, ((l + r) / 2.0, b + 92.0), TEXT, Align::Middle);
        font.draw_upwards(canvas, y, (34.0 + TEXT / 2.0, (t + b) / 2.0), TEXT);
    }
}

/// The heading over a picture.
pub(super) fn draw_heading(canvas: &mut Canvas, font: &Typeface, heading: &str, left: f64) {
    let room = WIDTH as f64 - left - 20.0;
    let mut text = heading.to_owned();
    while font.width(&text, TEXT) > room && text.chars().count() > 1 {
        text = text.chars().take(text.chars().count() - 2).chain(['…']).collect();
    }
    font.draw(canvas, &text, (left, 50.0), TEXT, Align::Start);
}

/// Room that a colour bar takes from its left edge to the picture's.
pub(super) fn bar_room(font: &Typeface, scale: &Scale) -> f64 {
    34.0 + 16.0 + labels(font, scale, 6) + 22.0 + TEXT + 24.0
}

/// A colour bar with its left edge at `x`; a tip at the foot where low values are cut.
pub(super) fn colour_bar(
    canvas: &mut Canvas,
    font: &Typeface,
    scale: &Scale,
    label: &str,
    (x, top, bottom): (f64, f64, f64),
    cut: bool,
) {
    let (wide, tip) = (34.0, 30.0);
    let foot = if cut { bottom - tip } else { bottom };
    let colour = |_, row: usize| viridis((foot - row as f64 - 0.5) / (foot - top));
    canvas.fill(x as usize..(x + wide) as usize, top as usize..foot as usize, colour);
    let mut outline = vec![(x, foot), (x, top), (x + wide, top), (x + wide, foot)];
    if cut {
        let point = (x + wide / 2.0, bottom);
        canvas.triangle([(x, foot), (x + wide, foot), point], viridis(0.0));
        outline.push(point);
    }
    outline.push((x, foot));
    canvas.polyline(&outline, AXIS - 0.5, INK);
    for tick in scale.ticks(6) {
        let y = foot - scale.at(tick.value) * (foot - top);
        let length = if tick.label.is_some() { TICK } else { TICK / 2.0 };
        canvas.line((x + wide, y), (x + wide + length, y), AXIS - 0.5, INK);
        if let Some(label) = tick.label {
            font.draw(canvas, &label, (x + wide + 16.0, y), SMALL, Align::Start);
        }
    }
    let at = x + wide + 16.0 + labels(font, scale, 6) + 22.0 + TEXT / 2.0;
    font.draw_upwards(canvas, label, (at, (top + bottom) / 2.0), TEXT);
}

/// Width of the widest label of an axis.
pub(super) fn labels(font: &Typeface, scale: &Scale, count: usize) -> f64 {
    let labels = scale.ticks(count).into_iter().filter_map(|t| t.label);
    labels.map(|l| font.width(&l, SMALL)).fold(0.0, f64::max)
}
