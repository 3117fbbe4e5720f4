//! Eigenfrequencies over the position, a line a family (the paper's figure 8).

use std::collections::BTreeMap;

use super::canvas::{Canvas, Colour, Point};
use super::frame::{Frame, THIN, WIDTH};
use super::scale::Scale;
use super::text::{Align, SMALL, Typeface};
use super::{FREQUENCY_LABEL, FigureError, colour, position_label};
use crate::modal::ModeFamilies;

/// Height of the picture: room for thirty labels.
const TALL: usize = 1240;
/// Height of the line on free families below the rest.
const NOTE: usize = 56;
/// Smallest distance of two labels in one column.
const PITCH: f64 = 31.0;
/// Width of a family's line.
const LINE: f64 = 4.0;

/// Draws the families.
pub(super) fn draw(figure: &str, machine: &str, axis: &str, families: &ModeFamilies) -> Result<Canvas, FigureError> {
    let lines = lines(figure, families)?;
    let (free, drawn): (Vec<_>, Vec<_>) = lines.into_iter().partition(|(_, line)| line.iter().all(|p| p.1 == 0.0));
    let font = Typeface::bundled();
    let note_room = if free.is_empty() { 0 } else { NOTE };
    let mut canvas = Canvas::new(WIDTH, TALL + note_room);

    let positions = families.positions.iter().map(|p| 1e3 * p);
    let low = positions.clone().fold(f64::INFINITY, f64::min);
    let high = positions.fold(f64::NEG_INFINITY, f64::max);
    let top = drawn.iter().flat_map(|(_, l)| l).map(|p| p.1).fold(0.0, f64::max);
    let bottom = drawn.iter().flat_map(|(_, l)| l).map(|p| p.1).fold(f64::INFINITY, f64::min);
    let y = if bottom < 0.5 * top { 0.0 } else { bottom - 0.1 * (top - bottom) };
    let y = if drawn.is_empty() { Scale::linear(0.0, 1.0) } else { Scale::linear(y, 1.03 * top) };

    let numbers: Vec<String> = drawn.iter().map(|(family, _)| family.to_string()).collect();
    let widest = numbers.iter().map(|n| font.width(n, SMALL)).fold(0.0, f64::max);
    let room = (TALL as f64 - 92.0 - 130.0) / PITCH;
    let columns = ((numbers.len() as f64 / room).ceil() as usize).max(1);
    let beside = 46.0 + columns as f64 * (widest + 14.0) + 30.0;
    let frame = Frame::new(&font, TALL, Scale::linear(low, high), y, beside);

    frame.grid(&mut canvas);
    for (family, line) in &drawn {
        draw_line(&mut canvas, &frame, families, line, colour::family(*family));
    }
    let heading = format!("{machine}: eigenfrequencies over position");
    frame.axes(&mut canvas, &font, &heading, &position_label(axis), FREQUENCY_LABEL);

    let mut ends: Vec<(f64, usize, &str)> = drawn
        .iter()
        .zip(&numbers)
        .filter_map(|((family, line), number)| {
            let end = line.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
            Some((frame.place(end.0, end.1).1, *family, number.as_str()))
        })
        .collect();
    ends.sort_by(|a, b| b.0.total_cmp(&a.0)); // from the lowest frequency up
    let wanted: Vec<f64> = ends.iter().map(|e| e.0).collect();
    let places = spread(&wanted, PITCH / columns as f64, frame.top, frame.bottom);
    for (i, ((from, family, number), to)) in ends.iter().zip(&places).enumerate() {
        let colour = colour::family(*family);
        let x = frame.right + 46.0 + (i % columns) as f64 * (widest + 14.0);
        let leader = [(frame.right + 2.0, *from), (frame.right + 12.0, *from), (x - 14.0, *to), (x - 6.0, *to)];
        canvas.polyline(&leader, THIN, colour);
        font.draw_in(&mut canvas, number, (x, *to), SMALL, Align::Start, colour);
    }
    let above = (WIDTH as f64 - 28.0, 50.0);
    font.draw(&mut canvas, "Family", above, SMALL, Align::End);
    if !free.is_empty() {
        let names: Vec<String> = free.iter().map(|(family, _)| family.to_string()).collect();
        let word = if free.len() == 1 { "Family" } else { "Families" };
        let note = format!("{word} {}: free at 0 Hz, not drawn", names.join(", "));
        let at = ((frame.left + frame.right) / 2.0, (TALL + NOTE / 2) as f64 - 18.0);
        font.draw(&mut canvas, &note, at, SMALL, Align::Middle);
    }
    Ok(canvas)
}

/// Positions (mm) and frequencies of each family, by position.
fn lines(figure: &str, families: &ModeFamilies) -> Result<BTreeMap<usize, Vec<Point>>, FigureError> {
    let n = families.positions.len();
    if n == 0 || families.modes.len() != n {
        return Err(FigureError::Shape {
            figure: figure.to_owned(),
            what: "the modes per position".to_owned(),
            seen: families.modes.len(),
            expected: if n == 0 { "at least one".to_owned() } else { n.to_string() },
        });
    }
    let mut lines: BTreeMap<usize, Vec<Point>> = BTreeMap::new();
    for (&position, modes) in families.positions.iter().zip(&families.modes) {
        for mode in modes {
            if !(position.is_finite() && mode.frequency.is_finite()) {
                return Err(FigureError::NotFinite {
                    figure: figure.to_owned(),
                    what: format!("the frequency of family {} at {position} m", mode.family),
                    value: if position.is_finite() { mode.frequency } else { position },
                });
            }
            lines.entry(mode.family).or_default().push((1e3 * position, mode.frequency));
        }
    }
    lines.values_mut().for_each(|line| line.sort_by(|a, b| a.0.total_cmp(&b.0)));
    Ok(lines)
}

/// A family's line, interrupted where it was not found at a position in between.
fn draw_line(canvas: &mut Canvas, frame: &Frame, families: &ModeFamilies, line: &[Point], colour: Colour) {
    let mut grid: Vec<f64> = families.positions.iter().map(|p| 1e3 * p).collect();
    grid.sort_by(f64::total_cmp);
    let rank = |x: f64| grid.partition_point(|g| *g < x);
    for piece in line.chunk_by(|a, b| rank(b.0) <= rank(a.0) + 1) {
        let points: Vec<Point> = piece.iter().map(|p| frame.place(p.0, p.1)).collect();
        match points[..] {
            [only] => canvas.line(only, only, 3.0 * LINE, colour),
            _ => canvas.curve(&points, LINE, colour),
        }
    }
}

/// Places for labels wanted at descending heights, at least `pitch` apart and within the limits,
/// as near to where they are wanted as that allows (pools of adjacent violators).
fn spread(wanted: &[f64], pitch: f64, top: f64, bottom: f64) -> Vec<f64> {
    // In a frame that falls with the labels, "apart by pitch" is "not ascending".
    let mut pools: Vec<(f64, usize)> = Vec::new(); // mean and members
    for (i, y) in wanted.iter().enumerate() {
        pools.push((y + i as f64 * pitch, 1));
        while let [.., a, b] = pools[..] {
            if a.0 >= b.0 {
                break;
            }
            let members = a.1 + b.1;
            let mean = (a.0 * a.1 as f64 + b.0 * b.1 as f64) / members as f64;
            pools.truncate(pools.len() - 2);
            pools.push((mean, members));
        }
    }
    let last = wanted.len().saturating_sub(1) as f64;
    let means = pools.iter().flat_map(|(mean, members)| std::iter::repeat_n(*mean, *members));
    means.enumerate().map(|(i, mean)| mean.min(bottom).max(top + last * pitch) - i as f64 * pitch).collect()
}

#[cfg(test)]
mod tests {
    use super::spread;

    #[test]
    fn labels_keep_their_distance_and_order() {
        let places = spread(&[900.0, 500.0, 495.0, 490.0, 100.0], 30.0, 90.0, 1000.0);
        assert_eq!(places, [900.0, 525.0, 495.0, 465.0, 100.0]);
        let crowded = spread(&[105.0, 104.0, 103.0], 30.0, 90.0, 1000.0);
        assert_eq!(crowded, [150.0, 120.0, 90.0]);
    }
}
