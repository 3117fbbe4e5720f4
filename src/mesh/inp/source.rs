//! The text of an input file with the files that it includes in their places.
//!
//! A file that is included many times is held once, and its text stands in the whole as often as it is asked for.
//! Lines are numbered through the whole; [`Source::spot`] finds file and line of a number again.

use super::lines::{canonical, parameters, split, unquoted};
use crate::files::Inputs;
use crate::mesh::{MeshError, Spot};
use crate::resources::{admit, room};
use std::path::{Path, PathBuf};

type Result<T> = std::result::Result<T, MeshError>;

/// Includes in includes.
const DEEPEST: usize = 16;
/// `*INCLUDE` lines that are followed in one input file with everything that it includes, and bytes of its files.
const MOST_INCLUDES: usize = 1000;
const MOST_BYTES: u64 = 4 << 30;
/// Includes up to so many bytes are read without a look at the memory that is left.
const SMALL: u64 = 1 << 20;
/// Bytes of text that stand in the whole because a file is included again.
const MOST_AGAIN: u64 = 64 << 20;

/// Files, each held once however often it is included, and the order of their pieces.
pub struct Source {
    files: Vec<SourceFile>,
    pieces: Vec<Piece>,
    /// Bytes of the files, of the text that includes repeat, and the includes followed.
    bytes: u64,
    again: u64,
    followed: usize,
    lines: usize,
    /// The files as they were read.
    pub inputs: Inputs,
}

/// A file with what it includes.
struct SourceFile {
    path: PathBuf,
    /// The path without links, by which an include of it is known; none for the main file's bytes from elsewhere.
    real: Option<PathBuf>,
    text: String,
    includes: Vec<Include>,
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
    /// Reads a file and what it includes, relative to the file's folder.
    pub fn read(file: &Path) -> Result<Self> {
        let mut inputs = Inputs::default();
        let bytes = super::read(file, &mut inputs)?;
        Self::of(bytes, file, inputs)
    }

    /// Takes in a file's bytes and what they include.
    pub fn new(bytes: &[u8], file: &Path) -> Result<Self> {
        let mut inputs = Inputs::default();
        inputs.add(file, bytes)?;
        Self::of(bytes.to_vec(), file, inputs)
    }

    fn of(bytes: Vec<u8>, file: &Path, inputs: Inputs) -> Result<Self> {
        let bytes_of_main = bytes.len() as u64;
        let (files, pieces) = (Vec::new(), Vec::new());
        let mut source = Source { files, pieces, bytes: bytes_of_main, again: 0, followed: 0, lines: 0, inputs };
        let main = source.keep(bytes, file, file.canonicalize().ok())?;
        source.take_in(main, &mut vec![main])?;
        Ok(source)
    }

    /// Keeps a file's text; its place in the list.
    fn keep(&mut self, bytes: Vec<u8>, path: &Path, real: Option<PathBuf>) -> Result<usize> {
        let text = text(bytes, path)?;
        let includes = includes(&text);
        self.files.push(SourceFile { path: path.to_path_buf(), real, text, includes });
        Ok(self.files.len() - 1)
    }

    /// The whole text's lines, with their numbers.
    pub fn lines(&self) -> impl Iterator<Item = (usize, &str)> {
        self.pieces.iter().flat_map(|piece| {
            let text = &self.files[piece.file].text[piece.from..piece.to];
            (piece.first..).zip(text.lines())
        })
    }

    /// File and line of a line's number.
    pub fn spot(&self, line: usize) -> Spot {
        let after = self.pieces.partition_point(|piece| piece.first <= line);
        match self.pieces.get(after.saturating_sub(1)) {
            Some(piece) => {
                let line = (line + piece.first_in_file).saturating_sub(piece.first);
                Spot { file: self.files[piece.file].path.clone(), line }
            }
            None => Spot { file: self.files.first().map(|file| file.path.clone()).unwrap_or_default(), line },
        }
    }

    /// Whether the main file lacks its last line end.
    pub fn ends_without_line_end(&self) -> bool {
        self.files.first().is_some_and(|file| !file.text.is_empty() && !file.text.ends_with('\n'))
    }

    /// Puts the pieces of a file and of what it includes into their order; `open` are the files that include it.
    fn take_in(&mut self, file: usize, open: &mut Vec<usize>) -> Result<()> {
        let includes = std::mem::take(&mut self.files[file].includes);
        let taken: Result<(usize, usize)> = includes.iter().try_fold((0, 1), |(from, line), include| {
            self.push(file, from..include.begins, line, include.line - line);
            let included = self.included(file, include, open)?;
            open.push(included);
            self.take_in(included, open)?;
            open.pop();
            Ok((include.ends, include.line + include.lines))
        });
        self.files[file].includes = includes;
        let (from, line) = taken?;
        let text = &self.files[file].text;
        let (length, count) = (text.len(), text[from..].lines().count());
        self.push(file, from..length, line, count);
        Ok(())
    }

    fn push(&mut self, file: usize, range: std::ops::Range<usize>, first_in_file: usize, lines: usize) {
        let first = self.lines + 1;
        self.lines += lines;
        self.pieces.push(Piece { file, from: range.start, to: range.end, first, first_in_file });
    }

    /// The file that an include names, read unless it is held already.
    fn included(&mut self, by: usize, include: &Include, open: &[usize]) -> Result<usize> {
        let file = self.files[by].path.clone();
        let spot = Spot { file: file.clone(), line: include.line };
        let named = include.path.as_ref().ok_or_else(|| MeshError::Parameter {
            spot: spot.clone(),
            keyword: "INCLUDE",
            seen: "the parameter INPUT is missing".into(),
            allowed: "INPUT",
            advice: "name the file",
        })?;
        let path = file.parent().unwrap_or(Path::new("")).join(named);
        let refuse = |reason: String| MeshError::Include { spot: spot.clone(), include: path.clone(), reason };
        self.followed += 1;
        if open.len() > DEEPEST || self.followed > MOST_INCLUDES {
            return Err(refuse(format!(
                "more than {DEEPEST} includes in each other or {MOST_INCLUDES} in all; join the files"
            )));
        }
        let failed = |e: std::io::Error| refuse(format!("{e}; correct the name or the permissions"));
        let real = path.canonicalize().map_err(failed)?;
        if let Some(known) = self.files.iter().position(|f| f.real.as_ref() == Some(&real)) {
            if open.contains(&known) {
                return Err(refuse("the file includes itself; remove one of the two lines".into()));
            }
            self.again += self.files[known].text.len() as u64;
            if self.again > MOST_AGAIN {
                return Err(refuse(format!(
                    "files are included again, {} MB in all, and {} MB are allowed; include each file once",
                    self.again >> 20,
                    MOST_AGAIN >> 20
                )));
            }
            return Ok(known);
        }
        let metadata = std::fs::metadata(&path).map_err(failed)?;
        self.bytes = self.bytes.saturating_add(metadata.len());
        if !metadata.is_file() || self.bytes > MOST_BYTES {
            return Err(refuse(format!("it is not a plain file, or the whole exceeds {MOST_BYTES} bytes")));
        }
        if metadata.len() > SMALL {
            let before = (self.bytes - metadata.len()) >> 20;
            let what = format!("{spot}: beside {before} MB of text the included file {}", path.display());
            let advice = "take out what the mesh does not need, or a machine or limit with more memory";
            admit(&what, metadata.len(), room().as_ref(), advice)?;
        }
        let bytes = self.inputs.read(&path).map_err(failed)?;
        self.keep(bytes, &path, Some(real))
    }
}

/// A file's bytes as text, without a copy of them.
fn text(bytes: Vec<u8>, file: &Path) -> Result<String> {
    let refused = |bytes: &[u8], valid: usize| {
        let line = 1 + bytes[..valid].iter().filter(|&&b| b == b'\n').count();
        MeshError::NotText { spot: Spot { file: file.to_path_buf(), line } }
    };
    let mut text = String::from_utf8(bytes).map_err(|e| refused(e.as_bytes(), e.utf8_error().valid_up_to()))?;
    if let Some(zero) = text.find('\0') {
        return Err(refused(text.as_bytes(), zero));
    }
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
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
