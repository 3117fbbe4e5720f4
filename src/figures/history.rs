//! Curves over time or frequency: the paper's figures 9 and 10.

use super::canvas::{Canvas, Point};
use super::frame::{Frame, HEIGHT, WIDTH};
use super::scale::Scale;
use super::text::{Align, SMALL, Typeface};
use super::{FREQUENCY_LABEL, FigureError, colour, write_both};
use crate::frf::ComplianceMap;
use crate::response::History;
use std::path::{Path, PathBuf};

/// Smallest share of the largest value that a logarithmic axis shows.
const SPAN: f64 = 1e-4;
/// Width of a curve.
const LINE: f64 = 3.0;

/// Draws the displacements of all outputs over time (figure 9) as PNG under the path and as SVG beside it; returns both.
///
/// # Errors
/// [`FigureError::NotFinite`], [`FigureError::Shape`], [`FigureError::Export`].
pub fn draw_history(
    path: &Path,
    heading: &str,
    history: &History,
    outputs: &[String],
) -> Result<[PathBuf; 2], FigureError> {
    let figure = name(path);
    let largest = history.displacement.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let (factor, unit) = match largest {
        l if l >= 1e-3 => (1e3, "mm"),
        l if l >= 1e-6 => (1e6, "µm"),
        _ => (1e9, "nm"),
    };
    let x: Vec<f64> = (0..history.samples()).map(|k| history.step * k as f64).collect();
    let series: Vec<Vec<f64>> =
        (0..outputs.len()).map(|i| history.output(i).into_iter().map(|v| factor * v).collect()).collect();
    let (low, high) = range(&figure, &x, &series)?;
    let margin = 0.05 * (high - low).max(f64::MIN_POSITIVE);
    let y = Scale::linear(low - margin, high + margin);
    let labels = ["Time [s]".to_owned(), format!("Displacement [{unit}]")];
    let across = Scale::linear(0.0, history.step * history.samples() as f64);
    save(path, heading, &labels, &x, &series, outputs, [across, y])
}

/// Draws the magnitudes of all outputs at one position of a map over frequency (figure 10), as [`draw_history`] does.
///
/// # Errors
/// As [`draw_history`].
pub fn draw_spectrum(
    path: &Path,
    heading: &str,
    map: &ComplianceMap,
    position: usize,
) -> Result<[PathBuf; 2], FigureError> {
    let magnitude = |i: usize| (0..map.frequencies.len()).map(|k| 1e6 * map.at(position, k, i, 0).norm()).collect();
    let series: Vec<Vec<f64>> = (0..map.outputs.len()).map(magnitude).collect();
    let (low, high) = range(&name(path), &map.frequencies, &series)?;
    let y = Scale::logarithmic(low.max(SPAN * high) / 1.2, 1.2 * high);
    let labels = [FREQUENCY_LABEL.to_owned(), "|H| [µm/N]".to_owned()];
    let across = Scale::linear(map.frequencies[0], map.frequencies[map.frequencies.len() - 1]);
    save(path, heading, &labels, &map.frequencies, &series, &map.outputs, [across, y])
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Smallest and largest value; refuses what cannot be drawn.
fn range(figure: &str, x: &[f64], series: &[Vec<f64>]) -> Result<(f64, f64), FigureError> {
    if x.is_empty() || series.is_empty() {
        let what = if x.is_empty() { "the horizontal axis" } else { "the curves" };
        let expected = "at least one".to_owned();
        return Err(FigureError::Shape { figure: figure.to_owned(), what: what.to_owned(), seen: 0, expected });
    }
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (i, values) in series.iter().enumerate() {
        for (x, v) in x.iter().zip(values) {
            if !v.is_finite() {
                let what = format!("curve {} at {x}", i + 1);
                return Err(FigureError::NotFinite { figure: figure.to_owned(), what, value: *v });
            }
            (low, high) = (low.min(*v), high.max(*v));
        }
    }
    Ok((low, high))
}

fn save(
    path: &Path,
    heading: &str,
    [x_label, y_label]: &[String; 2],
    x: &[f64],
    series: &[Vec<f64>],
    names: &[String],
    [across, y]: [Scale; 2],
) -> Result<[PathBuf; 2], FigureError> {
    let font = Typeface::bundled();
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
    let widest = names.iter().map(|n| font.width(n, SMALL)).fold(0.0, f64::max);
    let frame = Frame::new(&font, HEIGHT, across, y, 110.0 + widest);
    frame.grid(&mut canvas);
    for (i, values) in series.iter().enumerate() {
        let points = thinned(&frame, x, values);
        match points[..] {
            [only] => canvas.line(only, only, 14.0, colour::family(i + 1)),
            _ => canvas.curve(&points, LINE, colour::family(i + 1)),
        }
    }
    frame.axes(&mut canvas, &font, heading, x_label, y_label);
    for (i, name) in names.iter().enumerate() {
        let at = frame.top + 30.0 + 52.0 * i as f64;
        let left = frame.right + 24.0;
        canvas.line((left, at), (left + 40.0, at), 2.0 * LINE, colour::family(i + 1));
        font.draw(&mut canvas, name, (left + 54.0, at), SMALL, Align::Start);
    }
    write_both(path, &canvas)
}

/// Places of a curve; of samples on one pixel's width the first, smallest, largest and last, so that peaks stay.
fn thinned(frame: &Frame, x: &[f64], values: &[f64]) -> Vec<Point> {
    let place = |k: usize| frame.place(x[k], values[k].max(if frame.y.logarithmic { frame.y.low } else { f64::MIN }));
    let pixels = (frame.right - frame.left).max(1.0) as usize;
    let group = x.len().div_ceil(pixels).max(1);
    if group < 4 {
        return (0..x.len()).map(place).collect();
    }
    let mut points = Vec::new();
    for first in (0..x.len()).step_by(group) {
        let all = first..(first + group).min(x.len());
        let by = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let (Some(low), Some(high)) = (all.clone().min_by(by), all.clone().max_by(by)) else { continue };
        let mut kept = [first, low, high, all.end - 1];
        kept.sort_unstable();
        points.extend(kept.map(place));
    }
    points
}
