//! Lines and numbers of text files.

use super::MatrixError;
use std::path::Path;

/// Characters of a file's text that a message repeats at most.
const LONGEST: usize = 40;

/// The lines of a file with their numbers from 1; blank ones are passed over.
pub(super) struct Lines<'a> {
    pub file: &'a Path,
    rest: &'a [u8],
    /// Number of the line given last.
    pub line: usize,
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8], file: &'a Path) -> Self {
        Self { file, rest: bytes, line: 0 }
    }

    /// The next line that is not blank, without the space around it.
    pub fn next(&mut self) -> Result<Option<&'a str>, MatrixError> {
        while let Some(raw) = self.next_raw()? {
            let line = raw.trim();
            if !line.is_empty() {
                return Ok(Some(line));
            }
        }
        Ok(None)
    }

    /// The next line as it stands, for fixed columns.
    pub fn next_raw(&mut self) -> Result<Option<&'a str>, MatrixError> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        self.line += 1;
        let end = self.rest.iter().position(|&b| b == b'\n').unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest.get(1..).unwrap_or_default();
        let line = std::str::from_utf8(line).map_err(|_| self.refuse("bytes that are not text", "text in UTF-8"))?;
        Ok(Some(line.trim_end_matches('\r')))
    }

    /// The next line as [`Self::next_raw`] will give it, without its end; `None` at the end of the file.
    pub fn peek_raw(&self) -> Option<&'a [u8]> {
        (!self.rest.is_empty()).then(|| self.rest.split(|&b| b == b'\n').next().unwrap_or_default())
    }

    /// Refuses what stands on the line given last.
    pub fn refuse(&self, seen: impl Into<String>, allowed: impl Into<String>) -> MatrixError {
        MatrixError::Content {
            file: self.file.to_path_buf(),
            place: format!("line {}", self.line.max(1)),
            seen: shortened(&seen.into()),
            allowed: allowed.into(),
            advice: "correct the line, or write the file again",
        }
    }
}

/// A text cut to a length that a message can hold.
pub(super) fn shortened(text: &str) -> String {
    if text.chars().count() <= LONGEST {
        return text.to_owned();
    }
    text.chars().take(LONGEST).chain("...".chars()).collect()
}

/// A finite number as C and Fortran write it: `1.5e3`, `1.5D+03`, `1.5+103`.
pub(super) fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    let value = text.parse::<f64>().ok().or_else(|| {
        let exponent = text.replace(['d', 'D'], "e");
        exponent.parse().ok().or_else(|| {
            let at = text.get(1..)?.rfind(['+', '-'])? + 1;
            format!("{}e{}", text.get(..at)?, text.get(at..)?).parse().ok()
        })
    })?;
    value.is_finite().then_some(value)
}

/// The fields of a line that commas or spaces part.
pub(super) fn fields(line: &str) -> impl Iterator<Item = &str> {
    line.split(|c: char| c == ',' || c.is_whitespace()).filter(|field| !field.is_empty())
}
