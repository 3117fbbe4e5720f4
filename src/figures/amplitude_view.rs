//! The amplitude view: a response as a surface over position and frequency.
//!
//! A parallel projection of a box: frequency runs along the front, position into the depth,
//! magnitude upwards. A surface over a grid seen from above needs no depth buffer: its cells drawn
//! from the farthest to the nearest hide each other rightly. Geometry is drawn at twice the size and
//! averaged, text after that.

use super::canvas::{Canvas, GRID, INK, Point};
use super::colour::{shade, viridis};
use super::field::Field;
use super::frame::{AXIS, HEIGHT, THIN, WIDTH, bar_room, colour_bar, draw_heading};
use super::scale::Scale;
use super::text::{Align, SMALL, TEXT, Typeface};
use super::{FREQUENCY_LABEL, HeightScale, position_label};

/// Edges of the box: frequency, position, height.
const BOX: [f64; 3] = [1.62, 1.05, 0.80];
/// Turn about the vertical and height of the eye above the horizon, rad.
const TURN: f64 = 0.56;
const RISE: f64 = 0.52;
/// Most samples drawn: two a pixel of the doubled picture would show nothing more.
const MOST: (usize, usize) = (200, 1200);
/// Lines of constant position drawn on the surface.
const LINES: usize = 13;
/// Strips of a cell that spans the whole colour scale.
const STRIPS: f64 = 64.0;
/// Geometry is drawn this much larger.
const FINE: f64 = 2.0;

/// The projection of the box onto the picture.
struct View {
    frequency: Scale,
    position: Scale,
    height: Scale,
    scale: f64,
    origin: Point,
}

impl View {
    /// Place of a point of the unit box, in pixels of the finished picture.
    fn unit(&self, f: f64, p: f64, h: f64) -> Point {
        let (x, y) = flat(f, p, h);
        (
            self.origin.0 + self.scale * x,
            self.origin.1 + self.scale * y,
        )
    }

    /// Place of a point of the doubled picture.
    fn fine(&self, f: f64, p: f64, h: f64) -> Point {
        let (x, y) = self.unit(f, p, h);
        (FINE * x, FINE * y)
    }
}

/// Parallel projection of a point of the unit box, y down.
fn flat(f: f64, p: f64, h: f64) -> Point {
    let (x, y, z) = (BOX[0] * f, BOX[1] * p, BOX[2] * h);
    let depth = y * TURN.cos() - x * TURN.sin();
    (
        x * TURN.cos() + y * TURN.sin(),
        -z * RISE.cos() - depth * RISE.sin(),
    )
}

/// Draws the surface with axes and colour bar.
pub(super) fn draw(heading: &str, axis: &str, field: &Field, height: HeightScale) -> Canvas {
    let font = Typeface::bundled();
    let field = &field.reduced(MOST.0, MOST.1);
    let (colours, cut) = field.logarithmic();
    let room = bar_room(&font, &colours);
    let ends = |v: &[f64]| Scale::linear(v[0], v[v.len() - 1]);
    let mut view = View {
        frequency: ends(&field.frequencies),
        position: ends(&field.positions),
        height: match height {
            HeightScale::Linear => Scale::from_zero(field.max),
            HeightScale::Logarithmic => colours,
        },
        scale: 1.0,
        origin: (0.0, 0.0),
    };
    fit(
        &mut view,
        (120.0, 100.0),
        (WIDTH as f64 - room - 90.0, HEIGHT as f64 - 110.0),
    );

    let mut large = Canvas::new(2 * WIDTH, 2 * HEIGHT);
    walls(&mut large, &view);
    surface(&mut large, &view, field, &colours);
    edges(&mut large, &view);
    let mut canvas = large.halved();
    labels(&mut canvas, &font, &view, axis, &field.label());
    draw_heading(
        &mut canvas,
        &font,
        &format!("{heading}, amplitude view"),
        60.0,
    );
    let bar = (WIDTH as f64 - room, 150.0, HEIGHT as f64 - 150.0);
    colour_bar(&mut canvas, &font, &colours, &field.label(), bar, cut);
    canvas
}

/// Scales and moves the projection so that the box fills the area.
fn fit(view: &mut View, low: Point, high: Point) {
    let corners: Vec<Point> = (0..8)
        .map(|k| {
            flat(
                f64::from(k & 1),
                f64::from(k >> 1 & 1),
                f64::from(k >> 2 & 1),
            )
        })
        .collect();
    let range = |take: fn(&Point) -> f64| {
        let values = corners.iter().map(take);
        (
            values.clone().fold(f64::INFINITY, f64::min),
            values.fold(f64::NEG_INFINITY, f64::max),
        )
    };
    let (x, y) = (range(|p| p.0), range(|p| p.1));
    view.scale = ((high.0 - low.0) / (x.1 - x.0)).min((high.1 - low.1) / (y.1 - y.0));
    view.origin = (
        (low.0 + high.0 - view.scale * (x.0 + x.1)) / 2.0,
        (low.1 + high.1 - view.scale * (y.0 + y.1)) / 2.0,
    );
}

/// Floor and the two far walls with their grids.
fn walls(canvas: &mut Canvas, view: &View) {
    let pane = [247, 247, 247];
    let at = |f, p, h| view.fine(f, p, h);
    canvas.quad(
        [
            at(0., 0., 0.),
            at(1., 0., 0.),
            at(1., 1., 0.),
            at(0., 1., 0.),
        ],
        pane,
    );
    canvas.quad(
        [
            at(0., 1., 0.),
            at(1., 1., 0.),
            at(1., 1., 1.),
            at(0., 1., 1.),
        ],
        pane,
    );
    canvas.quad(
        [
            at(0., 0., 0.),
            at(0., 1., 0.),
            at(0., 1., 1.),
            at(0., 0., 1.),
        ],
        pane,
    );
    let mut line = |points: [(f64, f64, f64); 3]| {
        let points = points.map(|(f, p, h)| at(f, p, h));
        canvas.polyline(&points, FINE * THIN, GRID);
    };
    for t in labelled(&view.frequency, 6) {
        line([(t, 0., 0.), (t, 1., 0.), (t, 1., 1.)]);
    }
    for t in labelled(&view.position, 4) {
        line([(1., t, 0.), (0., t, 0.), (0., t, 1.)]);
    }
    for t in labelled(&view.height, 5) {
        line([(0., 0., t), (0., 1., t), (1., 1., t)]);
    }
    for [a, b] in [
        [(0., 1., 0.), (0., 1., 1.)],
        [(0., 1., 0.), (1., 1., 0.)],
        [(0., 0., 0.), (0., 1., 0.)],
    ] {
        let [a, b] = [a, b].map(|(f, p, h): (f64, f64, f64)| at(f, p, h));
        canvas.line(a, b, FINE * THIN, [170, 170, 170]);
    }
}

/// Places of the labelled ticks on an axis.
fn labelled(scale: &Scale, count: usize) -> Vec<f64> {
    scale
        .ticks(count)
        .iter()
        .filter(|t| t.label.is_some())
        .map(|t| scale.at(t.value))
        .collect()
}

/// The surface from the farthest cell to the nearest, closed to the floor at the front.
fn surface(canvas: &mut Canvas, view: &View, field: &Field, colours: &Scale) {
    let n = field.positions.len();
    let f: Vec<f64> = field
        .frequencies
        .iter()
        .map(|v| view.frequency.at(*v))
        .collect();
    let p: Vec<f64> = field
        .positions
        .iter()
        .map(|v| view.position.at(*v))
        .collect();
    let heights = |i: usize| -> Vec<f64> {
        field
            .row(i)
            .iter()
            .map(|v| view.height.at(*v).clamp(0.0, 1.0))
            .collect()
    };
    let project = |i: usize, h: &[f64]| -> Vec<Point> {
        f.iter()
            .zip(h)
            .map(|(f, h)| view.fine(*f, p[i], *h))
            .collect()
    };
    let mut far_heights = heights(n - 1);
    let mut far = project(n - 1, &far_heights);
    let every = (n as f64 / LINES as f64).max(1.0);
    let marked =
        |i: usize| i == 0 || (i as f64 / every).floor() != ((i - 1) as f64 / every).floor();
    let line = |canvas: &mut Canvas, points: &[Point]| {
        canvas.polyline(points, FINE * 1.2, [50, 50, 60]);
    };
    line(canvas, &far);
    for i in (0..n - 1).rev() {
        let near_heights = heights(i);
        let near = project(i, &near_heights);
        let (far_row, near_row) = (field.row(i + 1), field.row(i));
        for k in 0..f.len() - 1 {
            let slope =
                (far_heights[k] + far_heights[k + 1] - near_heights[k] - near_heights[k + 1])
                    / 2.0
                    / (p[i + 1] - p[i]).max(1e-12);
            let along =
                (far_heights[k + 1] + near_heights[k + 1] - far_heights[k] - near_heights[k])
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
        (0..n)
            .map(|i| view.fine(f[last], p[i], h(top(i))))
            .collect()
    };
    curtain(canvas, &side(|h| h), &side(|_| 0.0), [208, 212, 218]);
}

/// Fills a cell whose value goes from `left` to `right` over the frequency, in strips where the
/// colour changes much.
fn cell(
    canvas: &mut Canvas,
    corners: [Point; 4],
    (left, right): (f64, f64),
    colours: &Scale,
    light: f64,
) {
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

/// The near edges that carry the ticks.
fn edges(canvas: &mut Canvas, view: &View) {
    let at = |f, p, h| view.fine(f, p, h);
    canvas.polyline(
        &[
            at(0., 0., 1.),
            at(0., 0., 0.),
            at(1., 0., 0.),
            at(1., 1., 0.),
        ],
        FINE * AXIS,
        INK,
    );
    let mut tick = |t: [f64; 3], step: Point| {
        let a = at(t[0], t[1], t[2]);
        canvas.line(
            a,
            (a.0 + FINE * step.0, a.1 + FINE * step.1),
            FINE * AXIS,
            INK,
        );
    };
    labelled(&view.frequency, 6)
        .iter()
        .for_each(|t| tick([*t, 0., 0.], (-6.0, 9.0)));
    labelled(&view.position, 4)
        .iter()
        .for_each(|t| tick([1., *t, 0.], (10.0, 5.0)));
    labelled(&view.height, 5)
        .iter()
        .for_each(|t| tick([0., 0., *t], (-11.0, 0.0)));
}

/// Tick and axis labels.
fn labels(canvas: &mut Canvas, font: &Typeface, view: &View, axis: &str, height: &str) {
    let mut along = |scale: &Scale, count, corner: fn(f64) -> [f64; 3], shift: Point, align| {
        for tick in scale.ticks(count) {
            let Some(label) = tick.label else { continue };
            let [f, p, h] = corner(scale.at(tick.value));
            let at = view.unit(f, p, h);
            font.draw(
                canvas,
                &label,
                (at.0 + shift.0, at.1 + shift.1),
                SMALL,
                align,
            );
        }
    };
    along(
        &view.frequency,
        6,
        |t| [t, 0., 0.],
        (-12.0, 32.0),
        Align::Middle,
    );
    along(
        &view.position,
        4,
        |t| [1., t, 0.],
        (18.0, 14.0),
        Align::Start,
    );
    along(&view.height, 5, |t| [0., 0., t], (-20.0, 0.0), Align::End);
    let middle = view.unit(0.5, 0.0, 0.0);
    font.draw(
        canvas,
        FREQUENCY_LABEL,
        (middle.0 - 40.0, middle.1 + 90.0),
        TEXT,
        Align::End,
    );
    let corner = view.unit(1.0, 0.0, 0.0);
    let label = position_label(axis);
    font.draw(
        canvas,
        &label,
        (corner.0 + 30.0, corner.1 + 66.0),
        TEXT,
        Align::Start,
    );
    let top = view.unit(0.0, 0.0, 1.0);
    font.draw(
        canvas,
        height,
        (top.0 - 20.0, top.1 - 46.0),
        TEXT,
        Align::Middle,
    );
}
