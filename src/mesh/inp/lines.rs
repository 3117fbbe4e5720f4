//! Lines, keywords and values of an input file.

use super::source::Source;
use crate::mesh::{MeshError, Spot};

type Result<T> = std::result::Result<T, MeshError>;

/// The lines of a text without comments and empty lines, with one line of look-ahead.
pub struct Lines<'a> {
    source: &'a Source,
    rest: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    number: usize,
    ahead: Option<(usize, &'a str)>,
}

/// A keyword line such as `*NSET, NSET=BASE`.
pub struct Keyword<'a> {
    /// In upper case without blanks, such as `SOLIDSECTION`.
    pub name: String,
    /// As the file writes it.
    pub spelling: &'a str,
    pub line: usize,
    /// Name in upper case without blanks, and value with its quotes (empty for a flag).
    pub parameters: Vec<(String, &'a str)>,
}

impl<'a> Lines<'a> {
    pub fn new(source: &'a Source) -> Self {
        let mut lines = Lines { source, rest: Box::new(source.lines()), number: 0, ahead: None };
        lines.advance();
        lines
    }

    fn advance(&mut self) {
        self.ahead = None;
        for (number, line) in self.rest.by_ref() {
            self.number = number;
            let line = line.trim();
            if !line.is_empty() && !line.starts_with("**") {
                self.ahead = Some((number, line));
                return;
            }
        }
    }

    /// Last line read.
    pub fn number(&self) -> usize {
        self.number
    }

    pub fn spot(&self, line: usize) -> Spot {
        self.source.spot(line)
    }

    /// The next data line, unless a keyword or the end of the file comes first.
    pub fn next_data(&mut self) -> Option<(usize, &'a str)> {
        let (number, line) = self.ahead.filter(|(_, line)| !line.starts_with('*'))?;
        self.advance();
        Some((number, line))
    }

    /// Passes over data lines up to the next keyword.
    pub fn skip_data(&mut self) {
        while self.next_data().is_some() {}
    }

    /// The next keyword, unless a data line or the end of the file comes first.
    pub fn next_keyword(&mut self) -> Option<Keyword<'a>> {
        let (number, line) = self.ahead.filter(|(_, line)| line.starts_with('*'))?;
        self.advance();
        let mut fields = split(&line[1..]).map(str::trim);
        let spelling = fields.next().unwrap_or_default();
        let mut keyword = Keyword { name: canonical(spelling), spelling, line: number, parameters: Vec::new() };
        keyword.add_parameters(fields);
        let mut last = line;
        // A keyword line that ends in a comma goes on in the next line.
        while last.ends_with(',') {
            let Some((_, line)) = self.next_data() else {
                break;
            };
            keyword.add_parameters(split(line).map(str::trim));
            last = line;
        }
        Some(keyword)
    }
}

impl<'a> Keyword<'a> {
    fn add_parameters(&mut self, fields: impl Iterator<Item = &'a str>) {
        self.parameters.extend(parameters(fields));
    }

    /// The value of a parameter without quotes; empty for a flag.
    pub fn get(&self, name: &str) -> Option<&'a str> {
        self.name(name).map(unquoted)
    }

    /// The name that a parameter gives, with its quotes.
    pub fn name(&self, name: &str) -> Option<&'a str> {
        self.parameters.iter().find(|(other, _)| other == name).map(|(_, value)| *value)
    }
}

/// Names in upper case without blanks, and values with their quotes (empty for flags).
pub fn parameters<'a>(fields: impl Iterator<Item = &'a str>) -> Vec<(String, &'a str)> {
    let split = |field: &'a str| field.split_once('=').unwrap_or((field, ""));
    let fields = fields.map(str::trim).filter(|field| !field.is_empty()).map(split);
    fields.map(|(name, value)| (canonical(name), value.trim())).collect()
}

/// The pieces of a line between commas; one in double quotes is no separator.
pub fn split(line: &str) -> impl Iterator<Item = &str> {
    let closed = line.bytes().filter(|&b| b == b'"').count().is_multiple_of(2);
    let mut quoted = false;
    line.split(move |c: char| {
        quoted ^= c == '"' && closed;
        c == ',' && !quoted
    })
}

/// A name or value without its quotes.
pub fn unquoted(name: &str) -> &str {
    name.trim_matches('"')
}

/// What names are compared by: without quotes and blanks, in upper case.
///
/// Abaqus and CalculiX read names without regard to case and blanks. In quotes Abaqus keeps both; a name that
/// differs from another one in them alone is refused ([`told_apart`]), so that a reference may be written either way.
pub fn key(name: &str) -> String {
    canonical(unquoted(name))
}

/// Whether Abaqus tells two names of one key apart.
pub fn told_apart(a: &str, b: &str) -> bool {
    (a.contains('"') || b.contains('"')) && a != b
}

/// Whether a field is a name: in quotes, or with a letter or an underscore in it, as in `1_base`.
pub fn is_name(field: &str) -> bool {
    field.contains(|c: char| c.is_alphabetic() || c == '_') || field.starts_with('"') && !unquoted(field).is_empty()
}

/// Upper case without blanks.
pub fn canonical(name: &str) -> String {
    name.chars().filter(|c| !c.is_whitespace()).collect::<String>().to_uppercase()
}

/// The values of a data line; the empty one after a trailing comma is left out.
pub fn fields(line: &str) -> impl Iterator<Item = &str> {
    split(line.strip_suffix(',').unwrap_or(line)).map(str::trim)
}

/// A finite number; Fortran's `1.0D+3` is read.
pub fn number(field: &str) -> Option<f64> {
    let value = field
        .parse::<f64>()
        .ok()
        .or_else(|| field.contains(['d', 'D']).then(|| field.replace(['d', 'D'], "e").parse::<f64>().ok())?)?;
    value.is_finite().then_some(value)
}

/// A label: a whole number from 1 on.
pub fn label(field: &str) -> Option<u64> {
    let field = field.strip_prefix('+').unwrap_or(field);
    let starts_with_digit = field.as_bytes().first().is_some_and(u8::is_ascii_digit);
    starts_with_digit.then(|| field.parse::<u64>().ok())?.filter(|&label| label > 0)
}

/// An error about a value on a data line.
pub fn bad_value<T>(spot: Spot, keyword: &'static str, seen: &str, allowed: impl Into<String>) -> Result<T> {
    Err(MeshError::Value { spot, keyword, seen: shortened(seen), allowed: allowed.into() })
}

/// A text for a message.
pub fn shortened(text: &str) -> String {
    const LONGEST: usize = 60;
    let shown: String = text.chars().take(LONGEST).collect();
    if shown.len() < text.len() { format!("{shown}...") } else { shown }
}
