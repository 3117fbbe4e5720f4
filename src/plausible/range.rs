//! A range of usual values, and the slips that would carry a value out of it.

use super::Finding;

/// A range of a quantity, in its SI unit.
#[derive(Clone, Copy)]
pub(super) struct Usual {
    /// Smallest and largest value that no warning is given for.
    pub from: f64,
    pub to: f64,
    /// Units that messages write, ascending, each with how many SI units it is.
    pub units: &'static [(&'static str, f64)],
    /// What the range is of, such as `a guide`.
    pub of: &'static str,
    /// Slips: what the value would have to be multiplied by to undo each, and its name.
    pub slips: &'static [(f64, &'static str)],
}

impl Usual {
    /// A warning if a value lies outside.
    pub fn check(&self, key: impl FnOnce() -> String, value: f64) -> Option<Finding> {
        if (self.from..=self.to).contains(&value) {
            return None;
        }
        let slip = self.slips.iter().find(|(factor, _)| (self.from..=self.to).contains(&(value * factor)));
        let slip = match slip {
            Some((factor, name)) => format!("likely {name} ({} was meant?)", self.text(value * factor)),
            None => "check the value and its unit".to_owned(),
        };
        Some(Finding { key: key(), seen: self.text(value), usual: self.words(), slip })
    }

    /// The range in words.
    pub fn words(&self) -> String {
        format!("{} to {} for {}", self.text(self.from), self.text(self.to), self.of)
    }

    /// A value in the largest unit that leaves a digit before or right behind the point.
    fn text(&self, value: f64) -> String {
        let fits = |(_, size): &&(&str, f64)| value.abs() >= 0.1 * size;
        let (name, size) = self.units.iter().rev().find(fits).unwrap_or(&self.units[0]);
        format!("{} {name}", number(value / size))
    }
}

/// Units of lengths.
pub(super) const LENGTHS: [(&str, f64); 3] = [("um", 1e-6), ("mm", 1e-3), ("m", 1.0)];

/// A number with four digits, as one would write it by hand.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return scientific(value);
    }
    let decimals = if size == 0.0 { 0 } else { (3 - size.log10().floor() as i32).clamp(0, 6) as usize };
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Four digits and a power of ten, without zeros at the end.
fn scientific(value: f64) -> String {
    let text = format!("{value:.3e}");
    match text.split_once('e') {
        Some((digits, power)) => format!("{}e{power}", digits.trim_end_matches('0').trim_end_matches('.')),
        None => text,
    }
}

/// A length in the unit that suits it.
pub(super) fn length(value: f64) -> String {
    let size = value.abs();
    if size < 1.0 { format!("{} mm", number(value * 1e3)) } else { format!("{} m", number(value)) }
}

/// A point, m; a hundredth of a millimetre is enough.
pub(super) fn point(x: [f64; 3]) -> String {
    let rounded = |c: f64| if c.abs() < 1e3 { (c * 1e5).round() * 1e-5 + 0.0 } else { c };
    format!("({}) m", x.map(|c| number(rounded(c))).join(", "))
}

#[cfg(test)]
mod tests {
    use super::{length, number};

    #[test]
    fn numbers_read_as_written_by_hand() {
        for (value, text) in [
            (0.0, "0"),
            (150.0, "150"),
            (0.00015, "1.5e-4"),
            (162_446_400_000.0, "1.624e11"),
            (46636.4, "46636"),
            (2.5, "2.5"),
            (-0.1175, "-0.1175"),
            (100.0, "100"),
        ] {
            assert_eq!(number(value), text);
        }
        assert_eq!(length(0.19), "190 mm");
        assert_eq!(length(25.0), "25 m");
    }
}
