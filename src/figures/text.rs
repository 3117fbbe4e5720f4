//! Text on a picture, in the bundled DejaVu Sans.

use ab_glyph::{Font, FontRef, GlyphId, OutlineCurve, PxScale, ScaleFont, point};

use super::canvas::{Canvas, Colour, INK, Point};
use super::vector::Outline;

/// Size of text in pixels an em: 9.6 pt where 1600 px are 16 cm wide.
pub(super) const TEXT: f64 = 34.0;

/// Size of small text: 9 pt.
pub(super) const SMALL: f64 = 32.0;

/// Height of capitals and digits, ems.
pub(super) const CAPITAL: f64 = 0.729;

/// Which point of a text stands at the given place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Align {
    Start,
    Middle,
    End,
}

/// The font, ready to measure and draw.
pub(super) struct Typeface(FontRef<'static>);

impl Typeface {
    /// The bundled font.
    pub fn bundled() -> Typeface {
        let bytes = include_bytes!("../../assets/fonts/DejaVuSans.ttf");
        Typeface(FontRef::try_from_slice(bytes).expect("the bundled font is a font"))
    }

    fn scale(&self, size: f64) -> PxScale {
        let units = self.0.units_per_em().unwrap_or(2048.0);
        PxScale::from(size as f32 * self.0.height_unscaled() / units)
    }

    /// Glyphs with their places along the line, and the line's length.
    fn layout(&self, text: &str, size: f64) -> (Vec<(GlyphId, f32)>, f64) {
        let font = self.0.as_scaled(self.scale(size));
        let (mut x, mut last, mut glyphs) = (0.0, None, Vec::new());
        for c in text.chars() {
            let glyph = font.glyph_id(c);
            x += last.map_or(0.0, |l| font.kern(l, glyph));
            glyphs.push((glyph, x));
            x += font.h_advance(glyph);
            last = Some(glyph);
        }
        (glyphs, f64::from(x))
    }

    /// The outline of laid-out glyphs in the text's own frame, capitals centred on 0.
    fn outline(&self, glyphs: &[(GlyphId, f32)], size: f64, start: f64) -> Outline {
        let unit = size / f64::from(self.0.units_per_em().unwrap_or(2048.0));
        let mut outline = Outline::default();
        for (glyph, x) in glyphs {
            let place = |p: ab_glyph::Point| {
                (f64::from(*x) + start + f64::from(p.x) * unit, CAPITAL * size / 2.0 - f64::from(p.y) * unit)
            };
            for curve in self.0.outline(*glyph).map(|o| o.curves).unwrap_or_default() {
                match curve {
                    OutlineCurve::Line(a, b) => {
                        outline.start(place(a));
                        outline.go(&[place(b)]);
                    }
                    OutlineCurve::Quad(a, b, c) => {
                        outline.start(place(a));
                        outline.go(&[place(b), place(c)]);
                    }
                    OutlineCurve::Cubic(a, b, c, d) => {
                        outline.start(place(a));
                        outline.go(&[place(b), place(c), place(d)]);
                    }
                }
            }
        }
        outline
    }

    /// Length of a text in pixels.
    pub fn width(&self, text: &str, size: f64) -> f64 {
        self.layout(text, size).1
    }

    /// Draws a text along the horizontal, capitals centred on the height of `at`.
    pub fn draw(&self, canvas: &mut Canvas, text: &str, at: Point, size: f64, align: Align) {
        self.paint(canvas, text, at, size, align, false, INK);
    }

    /// As [`Typeface::draw`] in a colour.
    pub fn draw_in(&self, canvas: &mut Canvas, text: &str, at: Point, size: f64, align: Align, colour: Colour) {
        self.paint(canvas, text, at, size, align, false, colour);
    }

    /// Draws a text that runs upwards, centred on `at`.
    pub fn draw_upwards(&self, canvas: &mut Canvas, text: &str, at: Point, size: f64) {
        self.paint(canvas, text, at, size, Align::Middle, true, INK);
    }

    #[expect(clippy::too_many_arguments, reason = "what a text is, behind the three short forms")]
    fn paint(
        &self,
        canvas: &mut Canvas,
        text: &str,
        at: Point,
        size: f64,
        align: Align,
        upwards: bool,
        colour: Colour,
    ) {
        let scale = self.scale(size);
        let (glyphs, length) = self.layout(text, size);
        let start = match align {
            Align::Start => 0.0,
            Align::Middle => -length / 2.0,
            Align::End => -length,
        };
        if let Some(vector) = canvas.vector() {
            let outline = self.outline(&glyphs, size, start);
            vector.text(text, outline.data(), at, upwards, colour);
        }
        // In the text's own frame: x along the line, y down from the middle of the capitals.
        let baseline = (CAPITAL * size / 2.0) as f32;
        let (fraction_x, fraction_y) = if upwards { (0.0, 0.0) } else { (at.0.fract(), at.1.fract()) };
        for (glyph, x) in glyphs {
            let place = point(x + (start + fraction_x) as f32, baseline + fraction_y as f32);
            let Some(outline) = self.0.outline_glyph(glyph.with_scale_and_position(scale, place)) else {
                continue;
            };
            let corner = outline.px_bounds().min;
            outline.draw(|i, j, coverage| {
                let x = corner.x as i64 + i64::from(i);
                let y = corner.y as i64 + i64::from(j);
                let (dx, dy) = if upwards { (y, -x) } else { (x, y) };
                let (x, y) = (at.0.floor() as i64 + dx, at.1.floor() as i64 + dy);
                canvas.blend(x, y, colour, coverage);
            });
        }
    }
}
