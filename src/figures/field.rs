//! One response of a map as the pictures need it: magnitudes on sorted axes, in units to read.

use super::FigureError;
use super::scale::Scale;
use crate::export::response::{Response, index};
use crate::frf::{ComplianceMap, Quantity};

/// Largest ratio that a logarithmic scale spans: four decades.
const SPAN: f64 = 1e4;

/// Magnitudes of one response.
pub(super) struct Field {
    /// Positions, mm, ascending.
    pub positions: Vec<f64>,
    /// Frequencies, Hz, ascending.
    pub frequencies: Vec<f64>,
    /// `[position, frequency]`, in `unit`.
    pub values: Vec<f64>,
    /// What the response is, for headings.
    pub title: String,
    /// Unit of the values.
    pub unit: &'static str,
    /// Largest value.
    pub max: f64,
    /// Smallest value above zero, or zero.
    pub min: f64,
}

impl Field {
    /// Takes a response out of a map and checks it.
    pub fn new(figure: &str, map: &ComplianceMap, r: &Response) -> Result<Field, FigureError> {
        let shape = |what: &str, seen, expected: String| FigureError::Shape {
            figure: figure.to_owned(),
            what: what.to_owned(),
            seen,
            expected,
        };
        let (n_position, n_frequency) = (map.positions.len(), map.frequencies.len());
        if n_position == 0 || n_frequency == 0 {
            let what = if n_position == 0 { "the positions" } else { "the frequencies" };
            return Err(shape(what, 0, "at least one".into()));
        }
        let count = n_position * n_frequency * map.outputs.len() * map.inputs.len();
        if map.values.len() != count {
            return Err(shape("the map", map.values.len(), count.to_string()));
        }
        let not_finite = |what: String, value| FigureError::NotFinite { figure: figure.to_owned(), what, value };
        for (what, axis) in [("position", &map.positions), ("frequency", &map.frequencies)] {
            if let Some(i) = axis.iter().position(|v| !v.is_finite()) {
                return Err(not_finite(format!("{what} {i}"), axis[i]));
            }
        }
        let (name, factor, unit) = match map.quantity {
            Quantity::Receptance => ("compliance", 1e6, "µm/N"),
            Quantity::Mobility => ("mobility", 1e6, "µm/(s·N)"),
            Quantity::Accelerance => ("accelerance", 1.0, "m/(s²·N)"),
        };
        let (by_position, by_frequency) = (order(&map.positions), order(&map.frequencies));
        let mut values = Vec::with_capacity(n_position * n_frequency);
        let (mut min, mut max) = (f64::INFINITY, 0.0_f64);
        for &p in &by_position {
            for &f in &by_frequency {
                let value = factor * map.values[index(map, p, f, r)].norm();
                if !value.is_finite() {
                    let (position, frequency) = (map.positions[p], map.frequencies[f]);
                    let what = format!("the response at {position} m and {frequency} Hz");
                    return Err(not_finite(what, value));
                }
                max = max.max(value);
                if value > 0.0 {
                    min = min.min(value);
                }
                values.push(value);
            }
        }
        Ok(Field {
            positions: by_position.iter().map(|&p| 1e3 * map.positions[p]).collect(),
            frequencies: by_frequency.iter().map(|&f| map.frequencies[f]).collect(),
            values,
            title: if map.outputs[r.output] == map.inputs[r.input] {
                format!("direct {name} at {}", map.outputs[r.output])
            } else {
                format!("{name} from {} to {}", map.inputs[r.input], map.outputs[r.output])
            },
            unit,
            max,
            min: if min.is_finite() { min } else { 0.0 },
        })
    }

    /// The values of one position.
    pub fn row(&self, position: usize) -> &[f64] {
        &self.values[position * self.frequencies.len()..][..self.frequencies.len()]
    }

    /// Label of the magnitude.
    pub fn label(&self) -> String {
        format!("|H| [{}]", self.unit)
    }

    /// Logarithmic scale for the values, over at most [`SPAN`], and whether it cuts low values.
    pub fn logarithmic(&self) -> (Scale, bool) {
        let low = self.min.max(self.max / SPAN);
        (Scale::logarithmic(low, self.max), self.min < low)
    }

    /// The field on at most the given numbers of positions and frequencies. Groups of samples
    /// become their largest at their middle, so that peaks stay; the ends keep their places.
    pub fn reduced(&self, positions: usize, frequencies: usize) -> Field {
        let group = |n: usize, limit: usize| n.div_ceil(limit);
        let (gp, gf) = (group(self.positions.len(), positions), group(self.frequencies.len(), frequencies));
        let middles = |axis: &[f64], group: usize| -> Vec<f64> {
            let mut middles: Vec<f64> = axis.chunks(group).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect();
            let last = middles.len() - 1;
            if last > 0 {
                (middles[0], middles[last]) = (axis[0], axis[axis.len() - 1]);
            }
            middles
        };
        let mut values = Vec::new();
        for rows in self.values.chunks(gp * self.frequencies.len()) {
            for first in (0..self.frequencies.len()).step_by(gf) {
                let largest = rows
                    .chunks_exact(self.frequencies.len())
                    .flat_map(|row| row[first..].iter().take(gf))
                    .fold(0.0_f64, |a, b| a.max(*b));
                values.push(largest);
            }
        }
        Field {
            positions: middles(&self.positions, gp),
            frequencies: middles(&self.frequencies, gf),
            values,
            title: self.title.clone(),
            ..*self
        }
    }
}

/// Indices that sort the values.
fn order(values: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    order
}
