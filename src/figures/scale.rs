//! Axes: limits, ticks and their labels.

/// A tick of an axis; minor ones have no label.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub value: f64,
    pub label: Option<String>,
}

/// A linear or logarithmic axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    pub low: f64,
    pub high: f64,
    pub logarithmic: bool,
}

impl Scale {
    /// A linear axis over the given limits; equal limits are moved apart.
    pub fn linear(low: f64, high: f64) -> Scale {
        let margin = if high > low { 0.0 } else { 0.5 * low.abs().max(1.0) };
        Scale { low: low - margin, high: high + margin, logarithmic: false }
    }

    /// A linear axis from zero to the next round number above `high`.
    pub fn from_zero(high: f64) -> Scale {
        if high <= 0.0 {
            return Scale::linear(0.0, 1.0);
        }
        let step = step(high, 5);
        Scale::linear(0.0, step * (high / step - 1e-9).ceil())
    }

    /// A logarithmic axis; limits at or below zero, or equal, are replaced by a decade.
    pub fn logarithmic(low: f64, high: f64) -> Scale {
        let high = if high > 0.0 { high } else { 1.0 };
        let low = if low > 0.0 && low < 0.999 * high { low } else { high / 10.0 };
        Scale { low, high, logarithmic: true }
    }

    /// Place of a value on the axis: 0 at the lower limit, 1 at the upper.
    pub fn at(&self, value: f64) -> f64 {
        if self.logarithmic {
            (value.max(f64::MIN_POSITIVE) / self.low).log10() / (self.high / self.low).log10()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Ticks within the limits, about `count` of them with labels.
    pub fn ticks(&self, count: usize) -> Vec<Tick> {
        if self.logarithmic { self.decades(count) } else { self.steps(count) }
    }

    fn steps(&self, count: usize) -> Vec<Tick> {
        let step = step(self.high - self.low, count);
        let slack = 1e-6;
        let first = (self.low / step - slack).ceil() as i64;
        let last = (self.high / step + slack).floor() as i64;
        (first..=last).map(|k| Tick { value: k as f64 * step, label: Some(plain(k as f64 * step, step)) }).collect()
    }

    /// Powers of ten with labels and their multiples without; below two powers, 1, 2 and 5 have labels.
    fn decades(&self, count: usize) -> Vec<Tick> {
        let inside = |v: f64| v >= self.low * (1.0 - 1e-9) && v <= self.high * (1.0 + 1e-9);
        let first = self.low.log10().floor() as i32;
        let last = self.high.log10().ceil() as i32;
        let powers = (first..=last).filter(|k| inside(10_f64.powi(*k))).count();
        let every = powers.div_ceil(count.max(2)).max(1) as i32;
        let mut ticks = Vec::new();
        for exponent in first..=last {
            for m in 1..10 {
                let value = f64::from(m) * 10_f64.powi(exponent);
                if !inside(value) {
                    continue;
                }
                let label = if powers < 2 {
                    [1, 2, 5].contains(&m).then(|| plain(value, value))
                } else {
                    (m == 1 && exponent.rem_euclid(every) == 0).then(|| power(exponent))
                };
                ticks.push(Tick { value, label });
            }
        }
        ticks
    }
}

/// A step of 1, 2 or 5 times a power of ten that gives about `count` steps in a range.
fn step(range: f64, count: usize) -> f64 {
    let rough = range / count.max(1) as f64;
    let decade = 10_f64.powf(rough.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * decade >= rough * 0.9999);
    factor.unwrap_or(10.0) * decade
}

/// A number with the decimals that its step needs, and a true minus sign.
pub(super) fn plain(value: f64, step: f64) -> String {
    let decimals = (-(step.abs().log10() + 1e-9).floor()).max(0.0) as usize;
    if decimals > 4 || value.abs() >= 1e6 {
        let exponent = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
        let mantissa = value / 10_f64.powi(exponent);
        let mantissa = format!("{:.1}", mantissa).replace('-', "\u{2212}");
        return if value == 0.0 { "0".into() } else { format!("{mantissa}·{}", power(exponent)) };
    }
    let value = if value == 0.0 { 0.0 } else { value }; // no minus zero
    format!("{value:.decimals$}").replace('-', "\u{2212}")
}

/// A power of ten with a raised exponent.
fn power(exponent: i32) -> String {
    let raised = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::{Scale, plain, power};

    fn labels(scale: Scale, count: usize) -> Vec<String> {
        scale.ticks(count).into_iter().filter_map(|t| t.label).collect()
    }

    #[test]
    fn linear_ticks_are_round_and_inside() {
        assert_eq!(labels(Scale::linear(-600.0, 0.0), 6), ["−600", "−500", "−400", "−300", "−200", "−100", "0"]);
        assert_eq!(labels(Scale::linear(0.0, 0.11), 5), ["0.00", "0.05", "0.10"]);
        assert_eq!(Scale::from_zero(0.93).high, 1.0);
    }

    #[test]
    fn logarithmic_ticks_label_powers_or_one_two_five() {
        assert_eq!(labels(Scale::logarithmic(2e-4, 3.0), 6), ["10⁻³", "10⁻²", "10⁻¹", "10⁰"]);
        assert_eq!(labels(Scale::logarithmic(0.3, 3.0), 6), ["0.5", "1", "2"]);
        assert_eq!(labels(Scale::logarithmic(1e-8, 1.0), 5), ["10⁻⁸", "10⁻⁶", "10⁻⁴", "10⁻²", "10⁰"]);
    }

    #[test]
    fn degenerate_limits_give_an_axis() {
        for scale in [Scale::linear(3.0, 3.0), Scale::logarithmic(0.0, 0.0), Scale::from_zero(0.0)] {
            assert!(scale.at(scale.low) == 0.0 && (scale.at(scale.high) - 1.0).abs() < 1e-12);
            assert!(!scale.ticks(5).is_empty());
        }
    }

    #[test]
    fn numbers_have_true_signs_and_powers() {
        assert_eq!(plain(-0.25, 0.05), "−0.25");
        assert_eq!(plain(2e-6, 1e-6), "2.0·10⁻⁶");
        assert_eq!(power(-14), "10⁻¹⁴");
    }
}
