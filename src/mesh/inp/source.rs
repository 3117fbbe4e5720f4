//! The text of an input file with the files that it includes in their places.
//!
//! Lines are numbered through the whole; [`Source::spot`] finds file and line of a number again.

use super::lines::{canonical, parameters, split, unquoted};
use crate::mesh::{MeshError, Spot};
use std::path::{Path, PathBuf};

type Result<T> = std::result::Result<T, MeshError>;

/// Includes in includes.
const DEEPEST: usize = 16;
/// Files, and bytes of text, of one input file with everything that it includes.
const MOST_FILES: usize = 1000;
const MOST_BYTES: u64 = 4 << 30;

/// Files and the order of their pieces.
pub struct Source {
    files: Vec<(PathBuf, String)>,
    pieces: Vec<Piece>,
    bytes: u64,
    lines: usize,
}

/// Consecutive lines of one file.
struct Piece {
    file: usize,
    from: usize,
    to: usize,
    /// Number of the first line in the whole, and in its file, both counted from 1.
    first: usize,
    first_in_file: usize,
}

impl Source {
    /// Takes in a file's bytes and what they include, relative to the file's folder.
    pub fn new(bytes: &[u8], file: &Path) -> Result<Self> {
        let mut source = Source { files: Vec::new(), pieces: Vec::new(), bytes: bytes.len() as u64, lines: 0 };
        source.take_in(text(bytes, file)?, file, &mut vec![file.to_path_buf()])?;
        Ok(source)
    }

    /// The whole text's lines, with their numbers.
    pub fn lines(&self) -> impl Iterator<Item = (usize, &str)> {
        self.pieces.iter().flat_map(|piece| {
            let text = &self.files[piece.file].1[piece.from..piece.to];
            (piece.first..).zip(text.lines())
        })
    }

    /// File and line of a line's number.
    pub fn spot(&self, line: usize) -> Spot {
        let after = self.pieces.partition_point(|piece| piece.first <= line);
        match self.pieces.get(after.saturating_sub(1)) {
            Some(piece) => {
                let line = (line + piece.first_in_file).saturating_sub(piece.first);
                Spot { file: self.files[piece.file].0.clone(), line }
            }
            None => Spot { file: self.files.first().map(|(file, _)| file.clone()).unwrap_or_default(), line },
        }
    }

    /// Whether the main file lacks its last line end.
    pub fn ends_without_line_end(&self) -> bool {
        self.files.first().is_some_and(|(_, text)| !text.is_empty() && !text.ends_with('\n'))
    }

    fn take_in(&mut self, text: String, file: &Path, open: &mut Vec<PathBuf>) -> Result<()> {
        let index = self.files.len();
        let includes = includes(&text);
        let length = text.len();
        let line_count = text.lines().count();
        self.files.push((file.to_path_buf(), text));
        let (mut from, mut line) = (0, 1);
        for Include { line: at, begins, ends, lines, path } in includes {
            self.push(index, from..begins, line, at - line);
            let spot = Spot { file: file.to_path_buf(), line: at };
            let path = file.parent().unwrap_or(Path::new("")).join(path.ok_or_else(|| MeshError::Parameter {
                spot: spot.clone(),
                keyword: "INCLUDE",
                seen: "the parameter INPUT is missing".into(),
                allowed: "INPUT",
                advice: "name the file",
            })?);
            let text = self.read(&path, open, spot)?;
            open.push(path.clone());
            self.take_in(text, &path, open)?;
            open.pop();
            (from, line) = (ends, at + lines);
        }
        self.push(index, from..length, line, (line_count + 1).saturating_sub(line));
        Ok(())
    }

    fn push(&mut self, file: usize, range: std::ops::Range<usize>, first_in_file: usize, lines: usize) {
        let first = self.lines + 1;
        self.lines += lines;
        self.pieces.push(Piece { file, from: range.start, to: range.end, first, first_in_file });
    }

    fn read(&mut self, path: &Path, open: &[PathBuf], spot: Spot) -> Result<String> {
        let refuse = |reason: String| MeshError::Include { spot: spot.clone(), include: path.to_path_buf(), reason };
        let same = |other: &PathBuf| other.canonicalize().ok().is_some_and(|a| path.canonicalize().ok() == Some(a));
        if open.iter().any(same) {
            return Err(refuse("the file includes itself; remove one of the two lines".into()));
        }
        if open.len() > DEEPEST || self.files.len() >= MOST_FILES {
            return Err(refuse(format!(
                "more than {DEEPEST} includes in each other or {MOST_FILES} in all; join the files"
            )));
        }
        let metadata =
            std::fs::metadata(path).map_err(|e| refuse(format!("{e}; correct the name or the permissions")))?;
        self.bytes = self.bytes.saturating_add(metadata.len());
        if !metadata.is_file() || self.bytes > MOST_BYTES {
            return Err(refuse(format!("it is not a plain file, or the whole exceeds {MOST_BYTES} bytes")));
        }
        let bytes = std::fs::read(path).map_err(|e| refuse(format!("{e}; correct the name or the permissions")))?;
        text(&bytes, path)
    }
}

/// A file's bytes as text.
fn text(bytes: &[u8], file: &Path) -> Result<String> {
    let found = std::str::from_utf8(bytes).ok().filter(|text| !text.contains('\0'));
    let text = found.ok_or_else(|| {
        let valid = match std::str::from_utf8(bytes) {
            Ok(text) => text.find('\0').unwrap_or(0),
            Err(error) => error.valid_up_to(),
        };
        let line = 1 + bytes[..valid].iter().filter(|&&b| b == b'\n').count();
        MeshError::NotText { spot: Spot { file: file.to_path_buf(), line } }
    })?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text).to_owned())
}

/// An `*INCLUDE` line.
struct Include {
    /// Its line, counted from 1, and how many lines it takes.
    line: usize,
    lines: usize,
    /// Bytes before it and behind it.
    begins: usize,
    ends: usize,
    path: Option<String>,
}

fn includes(text: &str) -> Vec<Include> {
    let mut found = Vec::new();
    let mut lines = text.split_inclusive('\n').enumerate();
    let mut at = 0;
    while let Some((number, line)) = lines.next() {
        let begins = at;
        at += line.len();
        let trimmed = line.trim();
        let Some(rest) = trimmed.strip_prefix('*') else { continue };
        let mut fields = split(rest);
        if canonical(fields.next().unwrap_or_default()) != "INCLUDE" {
            continue;
        }
        let mut all = parameters(fields);
        let mut taken = 1;
        if trimmed.ends_with(',')
            && let Some((_, next)) = lines.next()
        {
            at += next.len();
            taken += 1;
            all.extend(parameters(split(next.trim())));
        }
        let path = all
            .into_iter()
            .find(|(name, _)| name == "INPUT")
            .map(|(_, value)| unquoted(value).to_owned())
            .filter(|v| !v.is_empty());
        found.push(Include { line: number + 1, lines: taken, begins, ends: at, path });
    }
    found
}

/// The files that an input file's bytes include, and those that they include, as far as they can be read.
pub fn included_files(bytes: &[u8], file: &Path) -> Vec<PathBuf> {
    Source::new(bytes, file).map(|s| s.files.into_iter().skip(1).map(|(file, _)| file).collect()).unwrap_or_default()
}
