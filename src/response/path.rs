//! Positions over time.

use super::ResponseError;

/// A path: straight lines between points in time; before the first and after the last it rests.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// (time in s, position in m), times ascending.
    points: Vec<(f64, f64)>,
}

impl Path {
    /// From one position to another at a constant speed, m/s.
    ///
    /// # Errors
    /// [`ResponseError::NotAllowed`] if the speed is not positive or a position not finite.
    pub fn constant_speed(from: f64, to: f64, speed: f64) -> Result<Self, ResponseError> {
        if !(speed.is_finite() && speed > 0.0) {
            return Err(ResponseError::not_allowed("--feed-rate", speed * 60.0, "a positive speed in m/min"));
        }
        if !(from.is_finite() && to.is_finite() && from != to) {
            let seen = format!("{from}:{to}");
            return Err(ResponseError::not_allowed("--path", seen, "FROM:TO, two different positions in m"));
        }
        Ok(Self { points: vec![(0.0, from), ((to - from).abs() / speed, to)] })
    }

    /// Through points (time, position).
    ///
    /// # Errors
    /// [`ResponseError::NotAllowed`] if there is none, one is not finite, or the times do not ascend.
    pub fn through(points: Vec<(f64, f64)>) -> Result<Self, ResponseError> {
        let allowed = "at least one point, finite, times ascending";
        if points.is_empty() || points.iter().any(|(t, p)| !(t.is_finite() && p.is_finite())) {
            return Err(ResponseError::not_allowed("the path", format!("{} points", points.len()), allowed));
        }
        if let Some(w) = points.windows(2).find(|w| w[1].0 <= w[0].0) {
            return Err(ResponseError::not_allowed("the path", format!("{} s after {} s", w[1].0, w[0].0), allowed));
        }
        Ok(Self { points })
    }

    /// Position at a time, m.
    pub fn at(&self, time: f64) -> f64 {
        let after = self.points.partition_point(|(t, _)| *t <= time);
        match (after.checked_sub(1).map(|k| self.points[k]), self.points.get(after)) {
            (Some((t, p)), Some(&(u, q))) => p + (q - p) * (time - t) / (u - t),
            (Some((_, p)), None) => p,
            (None, Some(&(_, p))) => p,
            (None, None) => f64::NAN,
        }
    }

    /// The positions where it rests: before its first point, after its last, and between two points at one place; m.
    pub fn rests(&self) -> Vec<f64> {
        let inner = self.points.windows(2).filter(|w| w[0].1 == w[1].1).map(|w| w[0].1);
        let mut all: Vec<f64> =
            [self.points[0].1, self.points[self.points.len() - 1].1].into_iter().chain(inner).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }

    /// When it ends, s.
    pub fn duration(&self) -> f64 {
        self.points.last().map_or(0.0, |p| p.0)
    }

    /// Smallest and largest position, m.
    pub fn range(&self) -> [f64; 2] {
        let all = self.points.iter().map(|p| p.1);
        [all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max)]
    }
}
