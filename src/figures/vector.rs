//! What was drawn on a canvas as SVG: lines, areas and outlines of letters as paths, pixels as images.

use super::canvas::{Colour, Point};
use crate::export::base64;
use std::fmt::Write as _;

/// The elements of a picture, in the order in which they were drawn.
#[derive(Default)]
pub(super) struct Vector {
    body: String,
}

/// A colour as `#rrggbb`.
fn hex([r, g, b]: Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A number with two decimals, without trailing zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// A text without what XML reserves.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn pairs(points: &[Point]) -> String {
    points.iter().map(|(x, y)| format!("{},{}", short(*x), short(*y))).collect::<Vec<_>>().join(" ")
}

impl Vector {
    /// Lines from point to point with round ends and corners.
    pub fn polyline(&mut self, points: &[Point], width: f64, colour: Colour) {
        let (points, width, colour) = (pairs(points), short(width), hex(colour));
        self.push(&format!(r#"<polyline points="{points}" stroke="{colour}" stroke-width="{width}"/>"#));
    }

    /// A filled polygon.
    pub fn polygon(&mut self, points: &[Point], colour: Colour) {
        let (points, colour) = (pairs(points), hex(colour));
        self.push(&format!(r#"<polygon points="{points}" fill="{colour}" stroke="none"/>"#));
    }

    /// The outline of a text, in its own frame with its start at `at`, turned to run upwards or not.
    pub fn text(&mut self, text: &str, outline: &str, at: Point, upwards: bool, colour: Colour) {
        let turn = if upwards { " rotate(-90)" } else { "" };
        let (x, y, text, colour) = (short(at.0), short(at.1), escape(text), hex(colour));
        self.push(&format!(
            r#"<path role="img" aria-label="{text}" transform="translate({x} {y}){turn}" d="{outline}" fill="{colour}" stroke="none"/>"#
        ));
    }

    /// A PNG picture over a rectangle.
    pub fn image(&mut self, png: &[u8], (x, y): Point, (width, height): (f64, f64)) {
        let (x, y, width, height) = (short(x), short(y), short(width), short(height));
        let data = base64::encode(png);
        self.push(&format!(
            r#"<image x="{x}" y="{y}" width="{width}" height="{height}" preserveAspectRatio="none" href="data:image/png;base64,{data}"/>"#
        ));
    }

    fn push(&mut self, element: &str) {
        self.body.push_str(element);
        self.body.push('\n');
    }

    /// The file, for a canvas of a size in pixels of which ten make a millimetre.
    pub fn file(&self, width: usize, height: usize) -> String {
        let mut text = String::with_capacity(self.body.len() + 400);
        let (mm_wide, mm_tall) = (short(width as f64 / 10.0), short(height as f64 / 10.0));
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{mm_wide}mm" height="{mm_tall}mm" viewBox="0 0 {width} {height}">"#
        );
        text.push_str("<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n");
        text.push_str("<g fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n");
        text.push_str(&self.body);
        text.push_str("</g>\n</svg>\n");
        text
    }
}

/// The outline of letters as the data of an SVG path.
#[derive(Default)]
pub(super) struct Outline {
    data: String,
    last: Option<Point>,
}

impl Outline {
    /// Goes to where a curve starts, if it is not there.
    pub fn start(&mut self, at: Point) {
        let away = |last: Point| (last.0 - at.0).abs() + (last.1 - at.1).abs() > 1e-4;
        if self.last.is_none_or(away) {
            self.step('M', &[at]);
        }
    }

    /// A line (one point), a quadratic curve (two) or a cubic one (three) from where it is.
    pub fn go(&mut self, points: &[Point]) {
        self.step(['L', 'Q', 'C'][points.len() - 1], points);
    }

    fn step(&mut self, letter: char, points: &[Point]) {
        self.data.push(letter);
        self.data.push_str(&pairs(points));
        self.last = points.last().copied();
    }

    /// The data.
    pub fn data(&self) -> &str {
        &self.data
    }
}
