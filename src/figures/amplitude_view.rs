//! The amplitude view: a response as a surface over position and frequency.
//!
//! A surface over a grid seen from above needs no depth buffer: its cells drawn from the farthest to
//! the nearest hide each other rightly. Geometry is drawn at twice the size and averaged, text after
//! that.

use super::HeightScale;
use super::box_view::{BOX, FINE, View};
use super::canvas::{Canvas, INK, Point};
use super::colour::{shade, viridis};
use super::field::Field;
use super::frame::{HEIGHT, WIDTH, bar_room, colour_bar, draw_heading};
use super::scale::Scale;
use super::text::Typeface;

/// Most samples drawn: two a pixel of the doubled picture would show nothing more.
const MOST: (usize, usize) = (200, 1200);
/// Lines of constant position drawn on the surface.
const LINES: usize = 13;
/// Strips of a cell that spans the whole colour scale.
const STRIPS: f64 = 64.0;

/// Draws the surface with axes and colour bar.
pub(super) fn draw(heading: &str, axis: &str, field: &Field, height: HeightScale) -> Canvas {
    let font = Typeface::bundled();
    let field = &field.reduced(MOST.0, MOST.1);
    let (colours, cut) = field.logarithmic();
    let room = bar_room(&font, &colours);
    let ends = |v: &[f64]| Scale::linear(v[0], v[v.len() - 1]);
    let view = View::new(
        ends(&field.frequencies),
        ends(&field.positions),
        match height {
            HeightScale::Linear => Scale::from_zero(field.max),
            HeightScale::Logarithmic => colours,
        },
        [(120.0, 100.0), (WIDTH as f64 - room - 90.0, HEIGHT as f64 - 110.0)],
    );

    let mut large = Canvas::of_pixels(2 * WIDTH, 2 * HEIGHT);
    view.walls(&mut large);
    surface(&mut large, &view, field, &colours);
    view.edges(&mut large);
    let mut canvas = large.halved();
    view.labels(&mut canvas, &font, axis, &field.label());
    draw_heading(&mut canvas, &font, &format!("{heading}, amplitude view"), 60.0);
    let bar = (WIDTH as f64 - room, 150.0, HEIGHT as f64 - 150.0);
    colour_bar(&mut canvas, &font, &colours, &field.label(), bar, cut);
    canvas
}

/// The surface from the farthest cell to the nearest, closed to the floor at the front.
fn surface(canvas: &mut Canvas, view: &View, field: &Field, colours: &Scale) {
    let n = field.positions.len();
    let f: Vec<f64> = field.frequencies.iter().map(|v| view.frequency.at(*v)).collect();
    let p: Vec<f64> = field.positions.iter().map(|v| view.position.at(*v)).collect();
    let heights = |i: usize| -> Vec<f64> { field.row(i).iter().map(|v| view.height.at(*v).clamp(0.0, 1.0)).collect() };
    let project =
        |i: usize, h: &[f64]| -> Vec<Point> { f.iter().zip(h).map(|(f, h)| view.fine(*f, p[i], *h)).collect() };
    let mut far_heights = heights(n - 1);
    let mut far = project(n - 1, &far_heights);
    let every = (n as f64 / LINES as f64).max(1.0);
    let marked = |i: usize| i == 0 || (i as f64 / every).floor() != ((i - 1) as f64 / every).floor();
    let line = |canvas: &mut Canvas, points: &[Point]| {
        canvas.polyline(points, FINE * 1.2, [50, 50, 60]);
    };
    line(canvas, &far);
    for i in (0..n - 1).rev() {
        let near_heights = heights(i);
        let near = project(i, &near_heights);
        let (far_row, near_row) = (field.row(i + 1), field.row(i));
        for k in 0..f.len() - 1 {
            let slope = (far_heights[k] + far_heights[k + 1] - near_heights[k] - near_heights[k + 1])
                / 2.0
                / (p[i + 1] - p[i]).max(1e-12);
            let along = (far_heights[k + 1] + near_heights[k + 1] - far_heights[k] - near_heights[k])
                / 2.0
                / (f[k + 1] - f[k]).max(1e-12);
            let corners = [near[k], near[k + 1], far[k + 1], far[k]];
            let left = (far_row[k] + near_row[k]) / 2.0;
            let right = (far_row[k + 1] + near_row[k + 1]) / 2.0;
            cell(canvas, corners, (left, right), colours, light(along, slope));
        }
        if marked(i) && i > 0 {
            line(canvas, &near);
        }
        (far, far_heights) = (near, near_heights);
    }
    // The near faces: frequencies at the first position, positions at the last frequency.
    let curtain = |canvas: &mut Canvas, upper: &[Point], lower: &[Point], colour| {
        for k in 0..upper.len() - 1 {
            canvas.quad([upper[k], upper[k + 1], lower[k + 1], lower[k]], colour);
        }
        canvas.polyline(upper, FINE * 1.6, INK);
    };
    let floor: Vec<Point> = f.iter().map(|f| view.fine(*f, p[0], 0.0)).collect();
    curtain(canvas, &far, &floor, [225, 228, 232]);
    let last = f.len() - 1;
    let side = |h: fn(f64) -> f64| -> Vec<Point> {
        let top = |i: usize| view.height.at(field.row(i)[last]).clamp(0.0, 1.0);
        (0..n).map(|i| view.fine(f[last], p[i], h(top(i)))).collect()
    };
    curtain(canvas, &side(|h| h), &side(|_| 0.0), [208, 212, 218]);
}

/// Fills a cell whose value goes from `left` to `right` over the frequency, in strips where the
/// colour changes much.
fn cell(canvas: &mut Canvas, corners: [Point; 4], (left, right): (f64, f64), colours: &Scale, light: f64) {
    let change = (colours.at(right).clamp(0.0, 1.0) - colours.at(left).clamp(0.0, 1.0)).abs();
    if change * STRIPS <= 1.0 {
        let value = (left + right) / 2.0;
        return canvas.quad(corners, shade(viridis(colours.at(value)), light));
    }
    let strips = (change * STRIPS).ceil();
    let between = |a: Point, b: Point, t: f64| (a.0 + (b.0 - a.0) * t, a.1 + (b.1 - a.1) * t);
    let [near_left, near_right, far_right, far_left] = corners;
    for strip in 0..strips as usize {
        let (s, t) = (strip as f64 / strips, (strip as f64 + 1.0) / strips);
        let value = left + (right - left) * (s + t) / 2.0;
        let quad = [
            between(near_left, near_right, s),
            between(near_left, near_right, t),
            between(far_left, far_right, t),
            between(far_left, far_right, s),
        ];
        canvas.quad(quad, shade(viridis(colours.at(value)), light));
    }
}

/// Brightness of a cell from its slopes: light from the upper right, in front.
fn light(along: f64, into: f64) -> f64 {
    let normal = [-along * BOX[2] / BOX[0], -into * BOX[2] / BOX[1], 1.0];
    let source = [0.35, -0.45, 0.82];
    let dot: f64 = normal.iter().zip(source).map(|(n, s)| n * s).sum();
    let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
    0.80 + 0.24 * (dot / length).max(0.0)
}
