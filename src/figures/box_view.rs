//! A box in parallel projection: frequency along the front, position into the depth, magnitude
//! upwards, with walls, axes and labels.

use super::canvas::{Canvas, GRID, INK, Point};
use super::frame::{AXIS, THIN};
use super::scale::Scale;
use super::text::{Align, SMALL, TEXT, Typeface};
use super::{FREQUENCY_LABEL, position_label};

/// Edges of the box: frequency, position, height.
pub(super) const BOX: [f64; 3] = [1.62, 1.05, 0.80];
/// Turn about the vertical and height of the eye above the horizon, rad.
const TURN: f64 = 0.56;
const RISE: f64 = 0.52;
/// Geometry is drawn this much larger than the finished picture, text is not.
pub(super) const FINE: f64 = 2.0;

/// The projection of the box onto the picture.
pub(super) struct View {
    pub frequency: Scale,
    pub position: Scale,
    pub height: Scale,
    scale: f64,
    origin: Point,
}

impl View {
    /// A view of a box with the given axes, as large as the area from corner to corner allows.
    pub fn new(frequency: Scale, position: Scale, height: Scale, area: [Point; 2]) -> View {
        let mut view = View { frequency, position, height, scale: 1.0, origin: (0.0, 0.0) };
        view.fit(area);
        view
    }

    /// Place of a point of the unit box, in pixels of the finished picture.
    pub fn unit(&self, f: f64, p: f64, h: f64) -> Point {
        let (x, y) = flat(f, p, h);
        (self.origin.0 + self.scale * x, self.origin.1 + self.scale * y)
    }

    /// Place of a point of the doubled picture.
    pub fn fine(&self, f: f64, p: f64, h: f64) -> Point {
        let (x, y) = self.unit(f, p, h);
        (FINE * x, FINE * y)
    }

    /// Scales and moves the projection so that the box fills the area.
    fn fit(&mut self, [low, high]: [Point; 2]) {
        let corners: Vec<Point> =
            (0..8).map(|k| flat(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2 & 1))).collect();
        let range = |take: fn(&Point) -> f64| {
            let values = corners.iter().map(take);
            (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max))
        };
        let (x, y) = (range(|p| p.0), range(|p| p.1));
        self.scale = ((high.0 - low.0) / (x.1 - x.0)).min((high.1 - low.1) / (y.1 - y.0));
        self.origin =
            ((low.0 + high.0 - self.scale * (x.0 + x.1)) / 2.0, (low.1 + high.1 - self.scale * (y.0 + y.1)) / 2.0);
    }

    /// Floor and the two far walls with their grids.
    pub fn walls(&self, canvas: &mut Canvas) {
        let pane = [247, 247, 247];
        let at = |f, p, h| self.fine(f, p, h);
        canvas.quad([at(0., 0., 0.), at(1., 0., 0.), at(1., 1., 0.), at(0., 1., 0.)], pane);
        canvas.quad([at(0., 1., 0.), at(1., 1., 0.), at(1., 1., 1.), at(0., 1., 1.)], pane);
        canvas.quad([at(0., 0., 0.), at(0., 1., 0.), at(0., 1., 1.), at(0., 0., 1.)], pane);
        let mut line = |points: [(f64, f64, f64); 3]| {
            let points = points.map(|(f, p, h)| at(f, p, h));
            canvas.polyline(&points, FINE * THIN, GRID);
        };
        for t in labelled(&self.frequency, 6) {
            line([(t, 0., 0.), (t, 1., 0.), (t, 1., 1.)]);
        }
        for t in labelled(&self.position, 4) {
            line([(1., t, 0.), (0., t, 0.), (0., t, 1.)]);
        }
        for t in labelled(&self.height, 5) {
            line([(0., 0., t), (0., 1., t), (1., 1., t)]);
        }
        for [a, b] in [[(0., 1., 0.), (0., 1., 1.)], [(0., 1., 0.), (1., 1., 0.)], [(0., 0., 0.), (0., 1., 0.)]] {
            let [a, b] = [a, b].map(|(f, p, h): (f64, f64, f64)| at(f, p, h));
            canvas.line(a, b, FINE * THIN, [170, 170, 170]);
        }
    }

    /// The near edges that carry the ticks.
    pub fn edges(&self, canvas: &mut Canvas) {
        let at = |f, p, h| self.fine(f, p, h);
        canvas.polyline(&[at(0., 0., 1.), at(0., 0., 0.), at(1., 0., 0.), at(1., 1., 0.)], FINE * AXIS, INK);
        let mut tick = |t: [f64; 3], step: Point| {
            let a = at(t[0], t[1], t[2]);
            canvas.line(a, (a.0 + FINE * step.0, a.1 + FINE * step.1), FINE * AXIS, INK);
        };
        labelled(&self.frequency, 6).iter().for_each(|t| tick([*t, 0., 0.], (-6.0, 9.0)));
        labelled(&self.position, 4).iter().for_each(|t| tick([1., *t, 0.], (10.0, 5.0)));
        labelled(&self.height, 5).iter().for_each(|t| tick([0., 0., *t], (-11.0, 0.0)));
    }

    /// Tick and axis labels.
    pub fn labels(&self, canvas: &mut Canvas, font: &Typeface, axis: &str, height: &str) {
        let mut along = |scale: &Scale, count, corner: fn(f64) -> [f64; 3], shift: Point, align| {
            for tick in scale.ticks(count) {
                let Some(label) = tick.label else { continue };
                let [f, p, h] = corner(scale.at(tick.value));
                let at = self.unit(f, p, h);
                font.draw(canvas, &label, (at.0 + shift.0, at.1 + shift.1), SMALL, align);
            }
        };
        along(&self.frequency, 6, |t| [t, 0., 0.], (-12.0, 32.0), Align::Middle);
        along(&self.position, 4, |t| [1., t, 0.], (18.0, 14.0), Align::Start);
        along(&self.height, 5, |t| [0., 0., t], (-20.0, 0.0), Align::End);
        let middle = self.unit(0.5, 0.0, 0.0);
        font.draw(canvas, FREQUENCY_LABEL, (middle.0 - 40.0, middle.1 + 90.0), TEXT, Align::End);
        let corner = self.unit(1.0, 0.0, 0.0);
        let label = position_label(axis);
        font.draw(canvas, &label, (corner.0 + 30.0, corner.1 + 66.0), TEXT, Align::Start);
        let top = self.unit(0.0, 0.0, 1.0);
        font.draw(canvas, height, (top.0 - 20.0, top.1 - 46.0), TEXT, Align::Middle);
    }
}

/// Parallel projection of a point of the unit box, y down.
fn flat(f: f64, p: f64, h: f64) -> Point {
    let (x, y, z) = (BOX[0] * f, BOX[1] * p, BOX[2] * h);
    let depth = y * TURN.cos() - x * TURN.sin();
    (x * TURN.cos() + y * TURN.sin(), -z * RISE.cos() - depth * RISE.sin())
}

/// Places of the labelled ticks on an axis.
fn labelled(scale: &Scale, count: usize) -> Vec<f64> {
    scale.ticks(count).iter().filter(|t| t.label.is_some()).map(|t| scale.at(t.value)).collect()
}
