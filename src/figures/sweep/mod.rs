//! Pictures of sweeps and searches.
//!
//! | file | shows |
//! |---|---|
//! | `metrics_over_variables.png` | every metric against every variable, a dot a design |
//! | `map_<metric>.png` | a metric over a grid of two variables |
//! | `front.png` | two or three objectives, the designs that no other beats joined |
//! | `best_over_position.png` | dynamic stiffness over the position, the best design beside the nominal one |
//! | `convergence.png` | the objective over a search's evaluations |

mod convergence;
mod curves;
mod front;
mod grid;
mod scatter;

pub use convergence::draw_convergence;
pub use curves::draw_curves;
pub use front::draw_front;
pub use grid::draw_grid;
pub use scatter::draw_scatter;

use super::FigureError;
use super::canvas::{Canvas, Colour, INK, Point};
use super::frame::{AXIS, Frame};
use super::scale::Scale;
use super::text::{Align, SMALL, TEXT, Typeface};
use crate::export::atomic;
use std::path::{Path, PathBuf};

/// Designs that miss a bound, that keep all, on the front, and the best.
const MISSES: Colour = [190, 190, 190];
const KEEPS: Colour = [0, 90, 160];
const FRONT: Colour = [200, 85, 0];
const BEST: Colour = [190, 30, 90];

/// A column of numbers, SI; `None` where there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// Name, underscores for spaces.
    pub name: String,
    /// Unit, SI; empty for a plain number.
    pub unit: String,
    /// Whether its axis is logarithmic.
    pub logarithmic: bool,
    /// One a design.
    pub values: Vec<Option<f64>>,
}

/// How a design's dot looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dot {
    /// Whether the design keeps every bound.
    pub kept: bool,
    /// Whether no other design beats it.
    pub front: bool,
    /// Whether it is the best.
    pub best: bool,
}

impl Dot {
    fn colour(self) -> Colour {
        match self {
            Dot { best: true, .. } => BEST,
            Dot { front: true, .. } => FRONT,
            Dot { kept: true, .. } => KEEPS,
            _ => MISSES,
        }
    }

    /// Order of drawing: what matters most comes last.
    fn rank(self) -> u8 {
        2 * u8::from(self.front) + u8::from(self.kept) + 4 * u8::from(self.best)
    }
}

/// One line of a picture over the position.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// What it is, for the legend.
    pub name: String,
    /// One value a position, SI.
    pub values: Vec<f64>,
}

/// A quantity over the position, for several designs.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name.
    pub name: String,
    /// Unit, SI.
    pub unit: String,
    /// The designs.
    pub series: Vec<Series>,
}

/// The objective over a search's evaluations.
#[derive(Clone, Debug, PartialEq)]
pub struct Convergence {
    /// Name of the study.
    pub study: String,
    /// Name of the objective.
    pub objective: String,
    /// Its unit, SI.
    pub unit: String,
    /// Whether larger is better.
    pub maximise: bool,
    /// Value of each evaluation, and whether it keeps every bound; `None` where there is none.
    pub points: Vec<Option<(f64, bool)>>,
}

/// Factor from an SI unit to the one that pictures show, and its name.
fn shown(unit: &str) -> (f64, &str) {
    match unit {
        "N/m" => (1e-6, "N/µm"),
        "m" => (1e3, "mm"),
        "m/N" => (1e6, "µm/N"),
        "Pa" => (1e-9, "GPa"),
        other => (1.0, other),
    }
}

/// A name with its unit, as an axis says it.
fn label(name: &str, unit: &str) -> String {
    let (name, unit) = (name.replace('_', " "), shown(unit).1);
    if unit.is_empty() { name } else { format!("{name} [{unit}]") }
}

/// Values in the unit that pictures show.
fn in_shown(values: &Values) -> Vec<Option<f64>> {
    let factor = shown(&values.unit).0;
    values.values.iter().map(|v| v.map(|v| v * factor)).collect()
}

/// An axis that holds some values with a margin.
fn axis_of(values: impl Iterator<Item = f64>, logarithmic: bool) -> Scale {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if low > high {
        return Scale::linear(0.0, 1.0);
    }
    if logarithmic && low > 0.0 && high > low {
        let margin = (high / low).powf(0.04);
        return Scale::logarithmic(low / margin, high * margin);
    }
    let margin = 0.05 * (high - low);
    Scale::linear(low - margin, high + margin)
}

/// Text in the size that fits a room, at most `size`.
fn fitted(font: &Typeface, text: &str, size: f64, room: f64) -> f64 {
    let width = font.width(text, size);
    if width > room { size * room / width } else { size }
}

fn draw_dot(canvas: &mut Canvas, at: Point, dot: Dot, size: f64) {
    let size = if dot.best { 1.8 * size } else { size };
    if dot.best {
        canvas.line(at, at, size + 4.0, [255, 255, 255]);
    }
    canvas.line(at, at, size, dot.colour());
}

/// A legend of dots in one line, from the right end leftwards.
fn legend(canvas: &mut Canvas, font: &Typeface, dots: &[Dot], right: f64, y: f64) {
    let mut x = right;
    let kinds = [
        ("best", Dot { kept: true, front: true, best: true }),
        ("front", Dot { kept: true, front: true, best: false }),
        ("keeps the bounds", Dot { kept: true, front: false, best: false }),
        ("misses a bound", Dot { kept: false, front: false, best: false }),
    ];
    for (name, kind) in kinds.into_iter().filter(|(_, kind)| dots.iter().any(|dot| dot.colour() == kind.colour())) {
        font.draw(canvas, name, (x, y), SMALL, Align::End);
        x -= font.width(name, SMALL) + 22.0;
        draw_dot(canvas, (x, y), kind, 13.0);
        x -= 40.0;
    }
}

/// Box and ticks of a panel; labels where asked.
fn panel_axes(canvas: &mut Canvas, font: &Typeface, frame: &Frame, labels: [bool; 2], ticks: [usize; 2]) {
    let (l, r, t, b) = (frame.left, frame.right, frame.top, frame.bottom);
    canvas.polyline(&[(l, t), (r, t), (r, b), (l, b), (l, t)], AXIS, INK);
    let mut end = f64::NEG_INFINITY;
    for tick in frame.x.ticks(ticks[0]) {
        let Some(text) = tick.label else { continue };
        let x = frame.place(tick.value, frame.y.low).0;
        canvas.line((x, b), (x, b + 8.0), AXIS, INK);
        let half = 0.5 * font.width(&text, SMALL);
        // A label that would touch the one before stays away.
        if labels[0] && x - half > end + 12.0 {
            font.draw(canvas, &text, (x, b + 32.0), SMALL, Align::Middle);
            end = x + half;
        }
    }
    for tick in frame.y.ticks(ticks[1]) {
        let Some(text) = tick.label else { continue };
        let y = frame.place(frame.x.low, tick.value).1;
        canvas.line((l - 8.0, y), (l, y), AXIS, INK);
        if labels[1] {
            font.draw(canvas, &text, (l - 16.0, y), SMALL, Align::End);
        }
    }
}

fn heading(canvas: &mut Canvas, font: &Typeface, text: &str) {
    let size = fitted(font, text, TEXT, canvas.width as f64 - 60.0);
    font.draw(canvas, text, (30.0, 44.0), size, Align::Start);
}

fn write(canvas: &Canvas, path: &Path) -> Result<PathBuf, FigureError> {
    atomic::write_bytes(path, &canvas.png(path)?)?;
    Ok(path.to_path_buf())
}

/// Refuses a picture without anything in it.
fn some(path: &Path, what: &str, seen: usize) -> Result<(), FigureError> {
    if seen > 0 {
        return Ok(());
    }
    let figure = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    Err(FigureError::Shape { figure, what: what.to_owned(), seen, expected: "at least one".to_owned() })
}
