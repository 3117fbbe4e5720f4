//! Lines and sections of a Gmsh file.

use crate::mesh::{MeshError, Spot};
use std::path::Path;

type Result<T> = std::result::Result<T, MeshError>;

/// The lines of a file without empty ones.
pub struct Lines<'a> {
    file: &'a Path,
    rest: std::iter::Enumerate<std::str::Lines<'a>>,
    /// Last line read, counted from 1.
    pub number: usize,
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8], file: &'a Path) -> Result<Self> {
        // The header tells a binary file before its bytes fail to be text.
        let head = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).into_owned();
        let mut words = head.split_whitespace();
        let spot = |line| Spot { file: file.to_path_buf(), line };
        if words.next() == Some("$MeshFormat") && words.next().is_some() && words.next() == Some("1") {
            return Err(MeshError::Gmsh {
                spot: spot(2),
                section: "MeshFormat",
                seen: "a binary file".into(),
                allowed: "text; write it with Mesh.Binary = 0".into(),
            });
        }
        let text = std::str::from_utf8(bytes).map_err(|error| {
            let line = 1 + bytes[..error.valid_up_to()].iter().filter(|&&b| b == b'\n').count();
            MeshError::NotText { spot: spot(line) }
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        Ok(Lines { file, rest: text.lines().enumerate(), number: 0 })
    }

    pub fn spot(&self) -> Spot {
        Spot { file: self.file.to_path_buf(), line: self.number }
    }

    /// The next line that is not empty.
    pub fn next(&mut self) -> Option<&'a str> {
        for (index, line) in self.rest.by_ref() {
            self.number = index + 1;
            let line = line.trim();
            if !line.is_empty() {
                return Some(line);
            }
        }
        None
    }

    /// The next line of a section that must have one more.
    pub fn need(&mut self, section: &'static str) -> Result<&'a str> {
        match self.next() {
            Some(line) if !line.starts_with('$') => Ok(line),
            Some(line) => Err(self.refuse(section, line, "another line; the file may be cut off, write it again")),
            None => Err(self.cut_off(section)),
        }
    }

    /// Whole numbers or others at the beginning of the next line, at least `least` of them.
    pub fn numbers<T: std::str::FromStr>(
        &mut self,
        section: &'static str,
        least: usize,
        allowed: &str,
    ) -> Result<Vec<T>> {
        let line = self.need(section)?;
        let values: Option<Vec<T>> = line.split_whitespace().map(|word| word.parse().ok()).collect();
        values.filter(|values| values.len() >= least).ok_or_else(|| self.refuse(section, line, allowed))
    }

    pub fn end(&mut self, section: &'static str) -> Result<()> {
        match self.next() {
            Some(line) if line.strip_prefix("$End") == Some(section) => Ok(()),
            Some(line) => {
                Err(self.refuse(section, line, &format!("$End{section} after the lines that were announced")))
            }
            None => Err(self.cut_off(section)),
        }
    }

    /// `$MeshFormat`; whether it is version 4.1 and not 2.2.
    pub fn format(&mut self) -> Result<bool> {
        const SECTION: &str = "MeshFormat";
        match self.next() {
            Some("$MeshFormat") => {}
            Some(line) if line.starts_with('*') => {
                let allowed = "a Gmsh mesh; this is an Abaqus or CalculiX input file: rename it to end in .inp";
                return Err(self.refuse(SECTION, line, allowed));
            }
            Some("$NOD") => {
                let allowed = "version 2.2 or 4.1, not 1.0; save it with Mesh.MshFileVersion = 4.1";
                return Err(self.refuse(SECTION, "$NOD", allowed));
            }
            other => {
                let allowed = "$MeshFormat as the first line of a Gmsh mesh; save it by Gmsh, or name another file";
                return Err(self.refuse(SECTION, other.unwrap_or_default(), allowed));
            }
        }
        let line = self.need(SECTION)?;
        let mut words = line.split_whitespace();
        let four = match (words.next(), words.next()) {
            (Some("2.2" | "2"), Some("0")) => false,
            (Some("4.1"), Some("0")) => true,
            _ => {
                let allowed = "version 2.2 or 4.1 as text (0); save it with Mesh.MshFileVersion = 4.1, Mesh.Binary = 0";
                return Err(self.refuse(SECTION, line, allowed));
            }
        };
        self.end(SECTION)?;
        Ok(four)
    }

    /// Name of the next section.
    pub fn next_section(&mut self) -> Result<Option<&'a str>> {
        match self.next() {
            None => Ok(None),
            Some(line) => match line.strip_prefix('$') {
                Some(name) if !name.starts_with("End") => Ok(Some(name)),
                _ => Err(self.refuse("MeshFormat", line, "a section, a line that begins with $")),
            },
        }
    }

    /// Passes over a section that does not matter.
    pub fn skip_section(&mut self, name: &str) -> Result<()> {
        while let Some(line) = self.next() {
            if line.strip_prefix("$End") == Some(name) {
                return Ok(());
            }
        }
        let detail = format!("no $End{name}");
        Err(MeshError::Truncated { spot: self.spot(), what: "the file", detail })
    }

    pub fn refuse(&self, section: &'static str, seen: &str, allowed: &str) -> MeshError {
        let short: String = seen.chars().take(60).collect();
        let seen = if short.len() < seen.len() { format!("{short}...") } else { short };
        MeshError::Gmsh { spot: self.spot(), section, seen, allowed: allowed.to_owned() }
    }

    fn cut_off(&self, section: &'static str) -> MeshError {
        MeshError::Truncated { spot: self.spot(), what: "the file", detail: format!("no $End{section}") }
    }
}
