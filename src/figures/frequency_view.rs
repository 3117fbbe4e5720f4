//! The frequency view: the logarithm of a response as a map over position and frequency.

use super::canvas::Canvas;
use super::colour::viridis;
use super::field::Field;
use super::frame::{Frame, HEIGHT, WIDTH, bar_room, colour_bar};
use super::scale::Scale;
use super::text::Typeface;
use super::{FREQUENCY_LABEL, position_label};

/// Draws the map: positions to the right as in the picture of the eigenfrequencies.
pub(super) fn draw(heading: &str, axis: &str, field: &Field) -> Canvas {
    let font = Typeface::bundled();
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
    let (scale, cut) = field.logarithmic();
    let ends = |v: &[f64]| Scale::linear(v[0], v[v.len() - 1]);
    let (x, y) = (ends(&field.positions), ends(&field.frequencies));
    let room = bar_room(&font, &scale);
    let frame = Frame::new(&font, HEIGHT, x, y, room + 36.0);

    let (left, right) = (frame.left as usize, frame.right as usize);
    let (top, bottom) = (frame.top as usize, frame.bottom as usize);
    let columns: Vec<Vec<f64>> = (0..field.positions.len())
        .map(|p| {
            let row: Vec<f64> = field.row(p).iter().map(|v| scale.at(*v)).collect();
            column(&field.frequencies, &row, bottom - top)
        })
        .collect();
    let across: Vec<(usize, f64)> = (left..right)
        .map(|x| {
            let t = (x as f64 + 0.5 - frame.left) / (frame.right - frame.left);
            between(&field.positions, frame.x.low + t * (frame.x.high - frame.x.low))
        })
        .collect();
    canvas.fill(left..right, top..bottom, |x, y| {
        let ((i, weight), row) = (across[x - left], bottom - 1 - y);
        let (a, b) = (columns[i][row], columns[i + 1][row]);
        viridis(a + (b - a) * weight)
    });
    let heading = format!("{heading}, frequency view");
    frame.axes(&mut canvas, &font, &heading, &position_label(axis), FREQUENCY_LABEL);
    let place = (frame.right + 36.0, frame.top, frame.bottom);
    colour_bar(&mut canvas, &font, &scale, &field.label(), place, cut);
    canvas
}

/// One position's values on `n` pixels from the lowest frequency up: the largest of the samples
/// in a pixel and of the line between samples at its ends.
fn column(frequencies: &[f64], values: &[f64], n: usize) -> Vec<f64> {
    let (low, high) = (frequencies[0], frequencies[frequencies.len() - 1]);
    let at = |k: usize| {
        let frequency = low + (high - low) * k as f64 / n as f64;
        let (i, t) = between(frequencies, frequency);
        (i, values[i] + (values[i + 1] - values[i]) * t)
    };
    (0..n)
        .map(|k| {
            let ((i, from), (j, to)) = (at(k), at(k + 1));
            values[i + 1..=j].iter().fold(from.max(to), |a, b| a.max(*b))
        })
        .collect()
}

/// The interval of ascending values that holds one, and the place within, 0 to 1.
fn between(values: &[f64], x: f64) -> (usize, f64) {
    let i = values.partition_point(|v| *v <= x).clamp(1, values.len() - 1) - 1;
    let width = values[i + 1] - values[i];
    (i, if width > 0.0 { ((x - values[i]) / width).clamp(0.0, 1.0) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::column;

    #[test]
    fn a_peak_between_pixels_survives() {
        let frequencies: Vec<f64> = (0..=1000).map(f64::from).collect();
        let mut values = vec![0.0; 1001];
        values[503] = 7.0;
        let pixels = column(&frequencies, &values, 100);
        assert_eq!(pixels.iter().copied().fold(0.0, f64::max), 7.0);
        assert_eq!(pixels.iter().position(|v| *v == 7.0), Some(50));
    }
}
