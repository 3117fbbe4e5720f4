//! A picture in memory: anti-aliased lines, triangles, PNG; and the same strokes as SVG.

use super::FigureError;
use super::vector::Vector;
use std::ops::Range;
use std::path::Path;

/// Red, green, blue.
pub(super) type Colour = [u8; 3];

/// A place on the picture in pixels, from the upper left corner; pixel centres at halves.
pub(super) type Point = (f64, f64);

pub(super) const INK: Colour = [30, 30, 30];
/// What a picture is drawn on.
pub(super) const PAPER: Colour = [255, 255, 255];
pub(super) const GRID: Colour = [222, 222, 222];

/// Pixels a metre in print: 1600 px stand for 16 cm.
const PIXELS_PER_METRE: u32 = 10_000;

/// An RGB picture.
pub(super) struct Canvas {
    pub width: usize,
    pub height: usize,
    pixels: Vec<u8>,
    /// The strokes, unless the canvas is for pixels alone.
    vector: Option<Vector>,
}

impl Canvas {
    /// A white picture.
    pub fn new(width: usize, height: usize) -> Canvas {
        Canvas { vector: Some(Vector::default()), ..Canvas::of_pixels(width, height) }
    }

    /// A white picture for strokes too many to be kept; in an SVG file it is an image.
    pub fn of_pixels(width: usize, height: usize) -> Canvas {
        Canvas { width, height, pixels: vec![255; 3 * width * height], vector: None }
    }

    /// Gives every pixel of a rectangle inside the picture a colour.
    pub fn fill(&mut self, x: Range<usize>, y: Range<usize>, colour: impl Fn(usize, usize) -> Colour) {
        let (x, y) = (x.start..x.end.min(self.width), y.start..y.end.min(self.height));
        let mut image = Canvas::of_pixels(x.len(), y.len());
        for (target, row) in image.pixels.chunks_exact_mut((3 * x.len()).max(1)).zip(y.clone()) {
            for (pixel, column) in target.chunks_exact_mut(3).zip(x.clone()) {
                pixel.copy_from_slice(&colour(column, row));
            }
            let at = 3 * (row * self.width + x.start);
            self.pixels[at..at + target.len()].copy_from_slice(target);
        }
        let place = (x.start as f64, y.start as f64);
        self.keep_image(&image, place, (x.len() as f64, y.len() as f64));
    }

    fn keep_image(&mut self, image: &Canvas, place: Point, size: (f64, f64)) {
        if let Some(vector) = &mut self.vector
            && image.width * image.height > 0
        {
            let png = image.encode().expect("a picture with pixels can be encoded in memory");
            vector.image(&png, place, size);
        }
    }

    /// The strokes, if they are kept.
    pub fn vector(&mut self) -> Option<&mut Vector> {
        self.vector.as_mut()
    }

    /// Lays a colour over a pixel with a coverage of 0 to 1; places outside are passed over.
    pub fn blend(&mut self, x: i64, y: i64, colour: Colour, coverage: f32) {
        if x < 0 || y < 0 || x >= self.width as i64 || y >= self.height as i64 {
            return;
        }
        let at = 3 * (y as usize * self.width + x as usize);
        let weight = coverage.clamp(0.0, 1.0);
        for (old, new) in self.pixels[at..at + 3].iter_mut().zip(colour) {
            *old = (f32::from(*old) + (f32::from(new) - f32::from(*old)) * weight + 0.5) as u8;
        }
    }

    /// A line with round ends.
    pub fn line(&mut self, a: Point, b: Point, width: f64, colour: Colour) {
        self.vector.iter_mut().for_each(|v| v.polyline(&[a, b], width, colour));
        self.stroke(a, b, width, colour);
    }

    fn stroke(&mut self, a: Point, b: Point, width: f64, colour: Colour) {
        let size = (self.width, self.height);
        cover(size, a, b, width, |x, y, coverage| self.blend(x, y, colour, coverage));
    }

    /// Lines from point to point.
    pub fn polyline(&mut self, points: &[Point], width: f64, colour: Colour) {
        self.vector.iter_mut().for_each(|v| v.polyline(points, width, colour));
        points.windows(2).for_each(|p| self.stroke(p[0], p[1], width, colour));
    }

    /// A curve through points, its edges even where many short lines meet.
    pub fn curve(&mut self, points: &[Point], width: f64, colour: Colour) {
        self.vector.iter_mut().for_each(|v| v.polyline(points, width, colour));
        let range = |take: fn(&Point) -> f64, limit: usize| -> (i64, usize) {
            let low = points.iter().map(take).fold(f64::INFINITY, f64::min) - width - 2.0;
            let high = points.iter().map(take).fold(f64::NEG_INFINITY, f64::max) + width + 2.0;
            let (low, high) = (low.max(0.0) as i64, high.min(limit as f64) as i64);
            (low, (high - low).max(0) as usize)
        };
        let ((left, wide), (top, tall)) = (range(|p| p.0, self.width), range(|p| p.1, self.height));
        let mut covered = vec![0.0_f32; wide * tall];
        for pair in points.windows(2) {
            cover((self.width, self.height), pair[0], pair[1], width, |x, y, coverage| {
                let (i, j) = (x - left, y - top);
                if (0..wide as i64).contains(&i) && (0..tall as i64).contains(&j) {
                    let at = &mut covered[j as usize * wide + i as usize];
                    *at = at.max(coverage);
                }
            });
        }
        for (k, coverage) in covered.into_iter().enumerate().filter(|(_, c)| *c > 0.0) {
            self.blend(left + (k % wide) as i64, top + (k / wide) as i64, colour, coverage);
        }
    }

    /// Fills the pixels whose centres lie in a triangle; of a shared edge, those of one side.
    pub fn triangle(&mut self, p: [Point; 3], colour: Colour) {
        self.vector.iter_mut().for_each(|v| v.polygon(&p, colour));
        self.area(p, colour);
    }

    fn area(&mut self, mut p: [Point; 3], colour: Colour) {
        p.sort_by(|a, b| a.1.total_cmp(&b.1));
        // Pixels from round(low) up to round(high), exclusive, have their centres between.
        let pixel = |v: f64, limit: usize| ((v + 0.5).max(0.0) as usize).min(limit);
        let (first, last) = (pixel(p[0].1, self.height), pixel(p[2].1, self.height));
        let slope = |a: Point, b: Point| {
            let rise = b.1 - a.1;
            if rise > 0.0 { (b.0 - a.0) / rise } else { 0.0 }
        };
        let (long, upper, lower) = (slope(p[0], p[2]), slope(p[0], p[1]), slope(p[1], p[2]));
        for row in first..last {
            let y = row as f64 + 0.5;
            let x = p[0].0 + long * (y - p[0].1);
            let other = if y < p[1].1 { p[0].0 + upper * (y - p[0].1) } else { p[1].0 + lower * (y - p[1].1) };
            let from = pixel(x.min(other), self.width);
            let to = pixel(x.max(other), self.width);
            let start = 3 * row * self.width;
            for pixel in self.pixels[start + 3 * from..start + 3 * to].chunks_exact_mut(3) {
                pixel.copy_from_slice(&colour);
            }
        }
    }

    /// Fills a quadrilateral, corners in order round it.
    pub fn quad(&mut self, p: [Point; 4], colour: Colour) {
        self.vector.iter_mut().for_each(|v| v.polygon(&p, colour));
        self.area([p[0], p[1], p[2]], colour);
        self.area([p[0], p[2], p[3]], colour);
    }

    /// The picture at half the size, each pixel the mean of four; in an SVG file at its full size.
    pub fn halved(&self) -> Canvas {
        let mut half = Canvas::new(self.width / 2, self.height / 2);
        let stride = 3 * self.width;
        for (y, row) in half.pixels.chunks_exact_mut(3 * half.width).enumerate() {
            let upper = &self.pixels[2 * y * stride..][..stride];
            let lower = &self.pixels[(2 * y + 1) * stride..][..stride];
            let pairs = upper.chunks_exact(6).zip(lower.chunks_exact(6));
            for (pixel, (u, l)) in row.chunks_exact_mut(3).zip(pairs) {
                for c in 0..3 {
                    let sum = u16::from(u[c]) + u16::from(u[c + 3]);
                    let sum = sum + u16::from(l[c]) + u16::from(l[c + 3]);
                    pixel[c] = ((sum + 2) / 4) as u8;
                }
            }
        }
        half.keep_image(self, (0.0, 0.0), (half.width as f64, half.height as f64));
        half
    }

    /// The picture as an SVG file; empty where its strokes were not kept.
    pub fn svg(&self) -> String {
        self.vector.as_ref().map_or_else(String::new, |v| v.file(self.width, self.height))
    }

    /// The picture as a PNG file in memory.
    pub fn png(&self, path: &Path) -> Result<Vec<u8>, FigureError> {
        self.encode().map_err(|e| FigureError::Encode { path: path.into(), reason: e.to_string() })
    }

    fn encode(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::with_capacity(self.pixels.len() / 8);
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::FilterType::Up);
        encoder.set_pixel_dims(Some(png::PixelDimensions {
            xppu: PIXELS_PER_METRE,
            yppu: PIXELS_PER_METRE,
            unit: png::Unit::Meter,
        }));
        encoder.write_header()?.write_image_data(&self.pixels)?;
        Ok(bytes)
    }
}

/// Visits the pixels that a line with round ends covers, with the coverage.
fn cover((wide, tall): (usize, usize), a: Point, b: Point, width: f64, mut visit: impl FnMut(i64, i64, f32)) {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length2 = (dx * dx + dy * dy).max(1e-12);
    let steep = dy.abs() > dx.abs();
    // Runs along the longer direction; at each step covers the line's width across.
    let (start, end, slope, origin) = if steep {
        (a.1.min(b.1), a.1.max(b.1), dx / if dy == 0.0 { 1.0 } else { dy }, (a.1, a.0))
    } else {
        (a.0.min(b.0), a.0.max(b.0), dy / if dx == 0.0 { 1.0 } else { dx }, (a.0, a.1))
    };
    let reach = width / 2.0 + 1.0;
    let across = reach * (1.0 + slope * slope).sqrt();
    let limit = if steep { tall } else { wide } as f64;
    let first = (start - reach).max(0.0).floor() as i64;
    let last = (end + reach).min(limit).ceil() as i64;
    for i in first..last {
        let along = i as f64 + 0.5;
        let centre = origin.1 + slope * (along.clamp(start, end) - origin.0);
        for j in (centre - across).floor() as i64..(centre + across).ceil() as i64 {
            let (x, y) = if steep { (j, i) } else { (i, j) };
            let p = (x as f64 + 0.5 - a.0, y as f64 + 0.5 - a.1);
            let t = ((p.0 * dx + p.1 * dy) / length2).clamp(0.0, 1.0);
            let (ex, ey) = (p.0 - t * dx, p.1 - t * dy);
            let coverage = width / 2.0 + 0.5 - (ex * ex + ey * ey).sqrt();
            if coverage > 0.0 {
                visit(x, y, coverage.min(width) as f32);
            }
        }
    }
}
