//! Numbers with units: `"77 N/um"`, `"40 mm"`, `"1e8 N m/rad"`.
//!
//! A unit is a product of symbols with SI prefixes; a slash divides by the symbol that follows it, a
//! trailing integer is a power (`kg/m3`). A unit's factor is kept as a power of ten where it is one, so
//! `"40 mm"` is the same floating-point number as `0.04`.

use super::nearest::nearest;

/// What a number measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Length, m.
    Length,
    /// Translational stiffness, N/m.
    Stiffness,
    /// Rotational stiffness, N m/rad.
    RotationalStiffness,
    /// Compliance, m/N.
    Compliance,
    /// Viscous damping of a translation, N s/m.
    Damping,
    /// Viscous damping of a rotation, N m s/rad.
    RotationalDamping,
    /// Elastic modulus, Pa.
    Pressure,
    /// Density, kg/m^3.
    Density,
    /// Frequency, Hz.
    Frequency,
    /// Inverse time, 1/s.
    InverseTime,
    /// Time, s.
    Time,
    /// Force, N.
    Force,
    /// Speed, m/s.
    Speed,
    /// A plain number, or per cent.
    Ratio,
}

/// Exponents of m, kg, s, rad and cycle.
type Exponents = [i32; 5];

impl Dimension {
    /// Its name with an article, for messages.
    pub fn name(self) -> &'static str {
        self.facts().0
    }

    /// Units to write it in, the SI unit first.
    pub fn units(self) -> &'static [&'static str] {
        self.facts().1
    }

    /// Smallest positive and largest absolute value that can be computed with, SI; both far beyond any machine. What
    /// lies outside would overflow, or vanish beside the rest, somewhere in the computation.
    pub fn computable(self) -> [f64; 2] {
        match self {
            Self::Length => [1e-12, 1e5],
            Self::Stiffness | Self::RotationalStiffness => [1e-9, 1e22],
            Self::Compliance => [0.0, 1e16],
            Self::Damping | Self::RotationalDamping => [0.0, 1e12],
            Self::Pressure => [1.0, 1e16],
            Self::Density => [1e-6, 1e9],
            Self::Frequency => [0.0, 1e9],
            Self::InverseTime => [0.0, 1e6],
            Self::Time => [0.0, 10.0],
            Self::Force => [0.0, 1e12],
            Self::Speed => [1e-12, 1e6],
            Self::Ratio => [0.0, 1e9],
        }
    }

    /// The words for [`Dimension::computable`], such as `from 1e-12 to 1e5 m`.
    fn computable_words(self, positive: bool) -> String {
        let [smallest, largest] = self.computable();
        let unit = if self == Self::Ratio { "" } else { self.units()[0] };
        let range = if positive && smallest > 0.0 {
            let smallest = if smallest < 1.0 { format!("{smallest:e}") } else { smallest.to_string() };
            format!("from {smallest} to {largest:e} {unit}")
        } else {
            format!("of size at most {largest:e} {unit}")
        };
        range.trim_end().to_owned()
    }

    /// Why a value cannot be computed with, in words of what is allowed, if it cannot.
    pub(crate) fn refused_range(self, value: f64, positive: bool) -> Option<String> {
        let [smallest, largest] = self.computable();
        let fits = value.abs() <= largest && (!positive || value >= smallest);
        (!fits).then(|| format!("{} {}", self.name(), self.computable_words(positive)))
    }

    fn facts(self) -> (&'static str, &'static [&'static str], Exponents) {
        match self {
            Self::Length => ("a length", &["m", "mm", "um"], [1, 0, 0, 0, 0]),
            Self::Stiffness => ("a stiffness", &["N/m", "N/um", "N/mm", "kN/mm"], [0, 1, -2, 0, 0]),
            Self::RotationalStiffness => ("a rotational stiffness", &["N m/rad", "kN m/rad"], [2, 1, -2, -1, 0]),
            Self::Compliance => ("a compliance", &["m/N", "um/N"], [0, -1, 2, 0, 0]),
            Self::Damping => ("a damping", &["N s/m", "N s/mm", "kN s/m"], [0, 1, -1, 0, 0]),
            Self::RotationalDamping => ("a rotational damping", &["N m s/rad"], [2, 1, -1, -1, 0]),
            Self::Pressure => ("a modulus", &["Pa", "GPa", "MPa", "N/mm2"], [-1, 1, -2, 0, 0]),
            Self::Density => ("a density", &["kg/m3", "g/cm3", "t/m3"], [-3, 1, 0, 0, 0]),
            Self::Frequency => ("a frequency", &["Hz", "kHz"], [0, 0, -1, 0, 1]),
            Self::InverseTime => ("an inverse time", &["1/s", "1/ms"], [0, 0, -1, 0, 0]),
            Self::Time => ("a time", &["s", "ms", "us"], [0, 0, 1, 0, 0]),
            Self::Force => ("a force", &["N", "kN"], [1, 1, -2, 0, 0]),
            Self::Speed => ("a speed", &["m/s", "mm/s", "um/s"], [1, 0, -1, 0, 0]),
            Self::Ratio => ("a ratio", &["%"], [0, 0, 0, 0, 0]),
        }
    }
}

/// Why a text is not the quantity that was asked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum QuantityError {
    /// No number at its beginning.
    #[error("found {text:?}, which does not begin with a number; allowed: {}", allowed(*expected))]
    NotANumber {
        /// The text seen.
        text: String,
        /// What was asked for.
        expected: Dimension,
    },
    /// NaN, infinite, or too large for a double.
    #[error("found {text}, which is not finite; allowed: {}", allowed(*expected))]
    NotFinite {
        /// The text seen.
        text: String,
        /// What was asked for.
        expected: Dimension,
    },
    /// A number in quotes without its unit.
    #[error("found {text:?} without a unit; allowed: {}, or the SI number without quotes", allowed(*expected))]
    NoUnit {
        /// The text seen.
        text: String,
        /// What was asked for.
        expected: Dimension,
    },
    /// A unit with a symbol that is not known.
    #[error("found {text:?} with the unknown unit {unit:?}; allowed: {}{}", allowed(*expected), meant(nearest))]
    UnknownUnit {
        /// The text seen.
        text: String,
        /// The unit in it.
        unit: String,
        /// What was asked for.
        expected: Dimension,
        /// The unit that was probably meant.
        nearest: Option<&'static str>,
    },
    /// A unit of another dimension.
    #[error("found {text:?}, which is {found}; allowed: {}", allowed(*expected))]
    WrongDimension {
        /// The text seen.
        text: String,
        /// What its unit measures.
        found: &'static str,
        /// What was asked for.
        expected: Dimension,
    },
}

fn allowed(dimension: Dimension) -> String {
    format!("{} in {}", dimension.name(), dimension.units().join(", "))
}

fn meant(nearest: &Option<&'static str>) -> String {
    nearest.map_or_else(String::new, |unit| format!(" (did you mean {unit:?}?)"))
}

/// A quantity in SI units, from a text such as `"77 N/um"`; a text without a unit is an SI number.
///
/// # Errors
/// [`QuantityError`] if the text has no number, an unknown unit or a unit of another dimension, or if
/// the number is not finite.
///
/// # Accuracy
/// Correctly rounded (one multiplication or division by an exact power of ten) for every unit but the
/// degree.
pub fn parse_quantity(text: &str, dimension: Dimension) -> Result<f64, QuantityError> {
    let owned = || text.to_owned();
    let trimmed = text.trim();
    let (number, unit) = trimmed.split_at(number_length(trimmed));
    let Ok(value) = number.parse::<f64>() else {
        return Err(if trimmed.parse::<f64>().is_ok() {
            QuantityError::NotFinite { text: owned(), expected: dimension }
        } else {
            QuantityError::NotANumber { text: owned(), expected: dimension }
        });
    };
    let unit = unit.trim();
    let si = if unit.is_empty() {
        value
    } else {
        let Some(scale) = Scale::parse(unit) else {
            return Err(QuantityError::UnknownUnit {
                text: owned(),
                unit: unit.to_owned(),
                expected: dimension,
                nearest: nearest(unit, dimension.units().iter().copied()),
            });
        };
        if scale.exponents != dimension.facts().2 {
            let found = name_of(scale.exponents);
            return Err(QuantityError::WrongDimension { text: owned(), found, expected: dimension });
        }
        scale.apply(value)
    };
    if !si.is_finite() {
        return Err(QuantityError::NotFinite { text: owned(), expected: dimension });
    }
    Ok(si)
}

/// Whether a text is a bare number, without a unit.
pub(super) fn is_bare_number(text: &str) -> bool {
    text.trim().parse::<f64>().is_ok()
}

/// Bytes of the decimal number at the beginning of a text.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits_from = |mut at: usize| {
        while bytes.get(at).is_some_and(u8::is_ascii_digit) {
            at += 1;
        }
        at
    };
    let is_sign = |at: usize| matches!(bytes.get(at), Some(b'+' | b'-'));
    let mut end = digits_from(usize::from(is_sign(0)));
    if bytes.get(end) == Some(&b'.') {
        end = digits_from(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let start = end + 1 + usize::from(is_sign(end + 1));
        let exponent_end = digits_from(start);
        if exponent_end > start {
            end = exponent_end;
        }
    }
    end
}

fn name_of(exponents: Exponents) -> &'static str {
    use Dimension::*;
    [
        Length,
        Stiffness,
        RotationalStiffness,
        Compliance,
        Damping,
        RotationalDamping,
        Pressure,
        Density,
        Frequency,
        InverseTime,
        Time,
        Force,
        Speed,
        Ratio,
    ]
    .into_iter()
    .find(|d| d.facts().2 == exponents)
    .map_or("of another dimension", Dimension::name)
}

/// A unit: what it measures, and its factor 10^power * factor to SI.
struct Scale {
    exponents: Exponents,
    power: i32,
    factor: f64,
}

impl Scale {
    fn parse(unit: &str) -> Option<Self> {
        let mut product = Scale { exponents: [0; 5], power: 0, factor: 1.0 };
        for (i, group) in unit.split('/').enumerate() {
            let symbols = group.split([' ', '*', '\u{b7}']).filter(|symbol| !symbol.is_empty());
            let mut count = 0;
            for (j, symbol) in symbols.enumerate() {
                product.multiply(symbol, if i > 0 && j == 0 { -1 } else { 1 })?;
                count += 1;
            }
            if count == 0 {
                return None;
            }
        }
        Some(product)
    }

    /// Multiplies by one symbol with its power, such as `mm3` or `s^-1`.
    fn multiply(&mut self, symbol: &str, sign: i32) -> Option<()> {
        if symbol == "1" {
            return Some(());
        }
        let name = symbol.trim_end_matches(|c: char| c.is_ascii_digit() || matches!(c, '^' | '-'));
        let digits = symbol[name.len()..].trim_start_matches('^');
        let exponent: i32 = if name.len() == symbol.len() { 1 } else { digits.parse().ok()? };
        if !(-9..=9).contains(&exponent) {
            return None;
        }
        let (exponents, power, factor) = base_unit(name).or_else(|| {
            let first = name.chars().next()?;
            let (exponents, power, factor) = base_unit(&name[first.len_utf8()..])?;
            Some((exponents, power + prefix(first)?, factor))
        })?;
        let exponent = exponent * sign;
        for (sum, e) in self.exponents.iter_mut().zip(exponents) {
            *sum += e * exponent;
        }
        self.power += power * exponent;
        self.factor *= factor.powi(exponent);
        Some(())
    }

    fn apply(&self, value: f64) -> f64 {
        let ten = 10f64.powi(self.power.abs());
        (if self.power < 0 { value / ten } else { value * ten }) * self.factor
    }
}

fn prefix(letter: char) -> Option<i32> {
    Some(match letter {
        'n' => -9,
        'u' | '\u{b5}' | '\u{3bc}' => -6,
        'm' => -3,
        'c' => -2,
        'k' => 3,
        'M' => 6,
        'G' => 9,
        _ => return None,
    })
}

/// Exponents, power of ten and further factor of a symbol without prefix.
fn base_unit(symbol: &str) -> Option<(Exponents, i32, f64)> {
    Some(match symbol {
        "m" => ([1, 0, 0, 0, 0], 0, 1.0),
        "g" => ([0, 1, 0, 0, 0], -3, 1.0),
        "t" => ([0, 1, 0, 0, 0], 3, 1.0),
        "s" => ([0, 0, 1, 0, 0], 0, 1.0),
        "rad" => ([0, 0, 0, 1, 0], 0, 1.0),
        "deg" => ([0, 0, 0, 1, 0], 0, std::f64::consts::PI / 180.0),
        "Hz" => ([0, 0, -1, 0, 1], 0, 1.0),
        "N" => ([1, 1, -2, 0, 0], 0, 1.0),
        "Pa" => ([-1, 1, -2, 0, 0], 0, 1.0),
        "%" => ([0, 0, 0, 0, 0], -2, 1.0),
        _ => return None,
    })
}
