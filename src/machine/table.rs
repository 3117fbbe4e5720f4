//! Typed reading of the machine file: a table that knows its key path, and which keys were asked for.

use super::error::{MachineError, Place};
use super::nearest::nearest;
use super::quantity::{Dimension, QuantityError, is_bare_number, parse_quantity};
use std::cell::RefCell;
use std::ops::Range;
use std::path::Path;
use toml::de::{DeTable, DeValue};

type Result<T> = std::result::Result<T, MachineError>;

/// The file's name and text.
pub(crate) struct Source<'a> {
    pub path: &'a Path,
    pub text: &'a str,
}

impl Source<'_> {
    /// Line and column of a byte of the text, counted from 1.
    pub fn line_column(&self, offset: usize) -> (usize, usize) {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        let line_start = before.iter().rposition(|&b| b == b'\n').map_or(0, |at| at + 1);
        let line = 1 + before.iter().filter(|&&b| b == b'\n').count();
        (line, 1 + String::from_utf8_lossy(&before[line_start..]).chars().count())
    }

    fn place(&self, offset: usize, key: &str) -> Box<Place> {
        let line = self.line_column(offset).0;
        Box::new(Place { file: self.path.to_path_buf(), line, key: key.to_owned() })
    }
}

/// A value of the file with its key path.
#[derive(Clone)]
pub(crate) struct Item<'a> {
    source: &'a Source<'a>,
    value: &'a DeValue<'a>,
    span: Range<usize>,
    /// Key path, such as `parts.column.mesh`.
    pub key: String,
}

/// Which numbers a quantity may be.
#[derive(Clone, Copy)]
pub(crate) enum Bound {
    Any,
    Positive,
    NotNegative,
}

impl<'a> Item<'a> {
    pub fn place(&self) -> Box<Place> {
        self.source.place(self.span.start, &self.key)
    }

    /// The value as the file writes it, on one line.
    pub fn seen(&self) -> String {
        const LONGEST: usize = 60;
        let text = self.source.text.get(self.span.clone()).unwrap_or_default();
        let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
        if line.chars().count() <= LONGEST {
            return line;
        }
        line.chars().take(LONGEST).chain("...".chars()).collect()
    }

    /// Refuses this value.
    pub fn refuse(&self, allowed: impl Into<String>, advice: impl Into<String>) -> MachineError {
        self.refuse_seen(self.seen(), allowed, advice)
    }

    /// Refuses this value, which reads better as `seen`.
    pub fn refuse_seen(
        &self,
        seen: impl Into<String>,
        allowed: impl Into<String>,
        advice: impl Into<String>,
    ) -> MachineError {
        MachineError::NotAllowed {
            place: self.place(),
            seen: seen.into(),
            allowed: allowed.into(),
            advice: advice.into(),
        }
    }

    pub fn text(&self) -> Result<&'a str> {
        match self.value {
            DeValue::String(text) => Ok(text),
            _ => Err(self.refuse("a text in quotes", "put it in quotes")),
        }
    }

    pub fn is_text(&self) -> bool {
        matches!(self.value, DeValue::String(_))
    }

    pub fn is_table(&self) -> bool {
        matches!(self.value, DeValue::Table(_))
    }

    pub fn is_list(&self) -> bool {
        matches!(self.value, DeValue::Array(_))
    }

    pub fn boolean(&self) -> Result<bool> {
        match self.value {
            DeValue::Boolean(value) => Ok(*value),
            _ => Err(self.refuse("true or false", "write one of them without quotes")),
        }
    }

    /// A whole number from one to a billion.
    pub fn count(&self) -> Result<usize> {
        match self.number().map(|n| n.parse::<f64>()) {
            Some(Ok(n)) if (1.0..=1e9).contains(&n) && n.fract() == 0.0 => Ok(n as usize),
            Some(Ok(n)) if n > 1e9 => Err(self.refuse("a whole number of at most 1000000000", "lower it")),
            _ => Err(self.refuse("a whole number of at least 1", "write it without quotes or unit")),
        }
    }

    /// A plain number, such as a vector's component.
    pub fn plain_number(&self) -> Result<f64> {
        match self.number().map(|n| n.parse::<f64>()) {
            Some(Ok(n)) if n.is_finite() => Ok(n),
            _ => Err(self.refuse("a finite number without unit", "write it without quotes")),
        }
    }

    /// A quantity in SI units.
    pub fn quantity(&self, dimension: Dimension, bound: Bound) -> Result<f64> {
        let refused = |source| MachineError::Quantity { place: self.place(), source };
        let value = match (self.value, self.number()) {
            (DeValue::String(text), _) if dimension != Dimension::Ratio && is_bare_number(text) => {
                let text = text.to_string();
                let finite = text.trim().parse::<f64>().is_ok_and(f64::is_finite);
                return Err(refused(if finite {
                    QuantityError::NoUnit { text, expected: dimension }
                } else {
                    QuantityError::NotFinite { text, expected: dimension }
                }));
            }
            (DeValue::String(text), _) => parse_quantity(text, dimension).map_err(refused)?,
            (_, Some(number)) => match number.parse::<f64>() {
                Ok(value) if value.is_finite() => value,
                _ => {
                    let text = self.seen();
                    return Err(refused(QuantityError::NotFinite { text, expected: dimension }));
                }
            },
            _ => {
                let unit = dimension.units()[0];
                return Err(self.refuse(
                    format!("{} in {}", dimension.name(), dimension.units().join(", ")),
                    format!("write a text such as \"1 {unit}\", or the number in SI units"),
                ));
            }
        };
        let allowed = match bound {
            Bound::Positive if value <= 0.0 => "a positive value",
            Bound::NotNegative if value < 0.0 => "zero or a positive value",
            _ => {
                let outside = dimension.refused_range(value, matches!(bound, Bound::Positive));
                return outside.map_or(Ok(value), |allowed| {
                    Err(self.refuse(allowed, "correct the value or its unit; nothing could be computed with it"))
                });
            }
        };
        Err(self.refuse(
            format!("{allowed} ({} in {})", dimension.name(), dimension.units().join(", ")),
            "correct the value",
        ))
    }

    /// The digits of a TOML integer or float.
    fn number(&self) -> Option<String> {
        match self.value {
            DeValue::Float(float) => Some(float.as_str().replace('_', "")),
            DeValue::Integer(integer) if integer.radix() == 10 => Some(integer.as_str().replace('_', "")),
            DeValue::Integer(integer) => {
                u64::from_str_radix(&integer.as_str().replace('_', ""), integer.radix()).ok().map(|n| n.to_string())
            }
            _ => None,
        }
    }

    pub fn list(&self) -> Result<Vec<Item<'a>>> {
        let DeValue::Array(array) = self.value else {
            return Err(self.refuse("a list in square brackets", "write [ ... ]"));
        };
        let items = array.iter().enumerate().map(|(i, value)| Item {
            source: self.source,
            value: value.get_ref(),
            span: value.span(),
            key: format!("{}[{}]", self.key, i + 1),
        });
        Ok(items.collect())
    }

    /// A list of exactly `N` values.
    pub fn array<const N: usize>(&self) -> Result<[Item<'a>; N]> {
        self.list()?.try_into().map_err(|list: Vec<_>| {
            let advice = format!("give {N} values, not {}", list.len());
            self.refuse(format!("a list of {N} values"), advice)
        })
    }

    pub fn table(&self) -> Result<Table<'a>> {
        match self.value {
            DeValue::Table(map) => Ok(Table { item: self.clone(), map, asked: RefCell::default() }),
            _ => Err(self.refuse("a table", "write { key = value, ... } or a [section]")),
        }
    }

    /// Refuses a name that would not serve in key paths, references and file names.
    pub fn check_name(&self, name: &str) -> Result<()> {
        let fits = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | ' ');
        if !name.trim().is_empty() && name.trim() == name && name.chars().all(fits) {
            return Ok(());
        }
        let allowed = "a name of letters, digits, spaces, _ and -";
        Err(self.refuse_seen(format!("the name {name:?}"), allowed, "rename it"))
    }
}

/// A table of the file that remembers which keys were asked for.
pub(crate) struct Table<'a> {
    pub item: Item<'a>,
    map: &'a DeTable<'a>,
    asked: RefCell<Vec<&'static str>>,
}

impl<'a> Table<'a> {
    pub fn root(source: &'a Source<'a>, value: &'a DeTable<'a>) -> Self {
        static NONE: DeValue<'static> = DeValue::Boolean(false);
        let item = Item { source, value: &NONE, span: 0..0, key: String::new() };
        Table { item, map: value, asked: RefCell::default() }
    }

    fn child(&self, key: &str) -> Option<Item<'a>> {
        let (name, value) = self.map.get_key_value(key)?;
        let path = &self.item.key;
        let key = if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
        // A table's own span may be its header's or empty; the key stands where the user looks.
        let span = match value.get_ref() {
            DeValue::Table(_) | DeValue::Array(_) if value.span().is_empty() => name.span(),
            _ => value.span(),
        };
        Some(Item { source: self.item.source, value: value.get_ref(), span, key })
    }

    /// The value of a key that may be left out.
    pub fn get(&self, key: &'static str) -> Option<Item<'a>> {
        self.asked.borrow_mut().push(key);
        self.child(key)
    }

    /// The value under a name of the file's own.
    pub fn get_named(&self, name: &str) -> Option<Item<'a>> {
        self.child(name)
    }

    /// The value of a key that must be there; `expected` says what to write.
    pub fn need(&self, key: &'static str, expected: &'static str) -> Result<Item<'a>> {
        self.get(key).ok_or_else(|| MachineError::MissingKey {
            place: self.item.place(),
            key,
            found: nearest(key, self.unasked()).map(str::to_owned),
            expected,
        })
    }

    /// All entries in the order of the file, for tables whose keys are names.
    pub fn entries(&self) -> Result<Vec<(&'a str, Item<'a>)>> {
        let entries = self.children();
        entries.iter().try_for_each(|(name, item)| item.check_name(name))?;
        Ok(entries)
    }

    /// The same where the keys repeat names from elsewhere, which may hold points.
    pub fn children(&self) -> Vec<(&'a str, Item<'a>)> {
        let mut keys: Vec<_> = self.map.keys().collect();
        keys.sort_by_key(|key| key.span().start);
        keys.into_iter().filter_map(|key| Some((key.get_ref().as_ref(), self.child(key.get_ref())?))).collect()
    }

    /// Refuses every key that nobody asked for.
    pub fn finish(self) -> Result<()> {
        let Some(key) = self.unasked().next() else {
            return Ok(());
        };
        let mut allowed = self.asked.take();
        let mut seen = std::collections::BTreeSet::new();
        allowed.retain(|key| seen.insert(*key));
        let at = self.map.get_key_value(key).map_or(0, |(name, _)| name.span().start);
        Err(MachineError::UnknownKey {
            place: self.item.source.place(at, &self.item.key),
            key: key.to_owned(),
            nearest: nearest(key, allowed.iter().copied()).map(str::to_owned),
            allowed,
        })
    }

    fn unasked(&self) -> impl Iterator<Item = &'a str> {
        let asked = self.asked.borrow().clone();
        let mut keys: Vec<_> = self.map.keys().collect();
        keys.sort_by_key(|key| key.span().start);
        keys.into_iter().map(|key| key.get_ref().as_ref()).filter(move |key| !asked.contains(key))
    }
}

/// Index of a name among the existing ones.
pub(crate) fn find_name(item: &Item<'_>, kind: &str, name: &str, existing: &[&str]) -> Result<usize> {
    existing.iter().position(|other| *other == name).ok_or_else(|| MachineError::UnknownName {
        place: item.place(),
        kind: kind.to_owned(),
        name: name.to_owned(),
        nearest: nearest(name, existing.iter().copied()).map(str::to_owned),
        existing: existing.iter().map(|&name| name.to_owned()).collect(),
    })
}
