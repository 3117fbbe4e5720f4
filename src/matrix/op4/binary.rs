//! OUTPUT4 as Fortran's unformatted records of 4-byte words, in either byte order.

use super::super::MatrixError;
use super::{Found, Header};
use std::path::Path;

struct Records<'a> {
    bytes: &'a [u8],
    file: &'a Path,
    at: usize,
    big_endian: bool,
}

pub(super) fn parse(bytes: &[u8], file: &Path, found: &mut Found) -> Result<(), MatrixError> {
    let mut records = Records { bytes, file, at: 0, big_endian: false };
    // The first record is a header of 24 bytes (48 with words of 8 bytes), which tells the order of bytes.
    records.big_endian = !matches!(records.word(0), Some(24 | 48));
    while records.at < bytes.len() {
        let record = records.next()?;
        if record.len() == 48 {
            return Err(records.refuse(
                "words of 8 bytes".into(),
                "words of 4 bytes; write it by a 32-bit (LP64) Nastran, or as text",
            ));
        }
        let integers: Vec<i64> = (0..4).filter_map(|k| records.integer(record, k)).collect();
        let name = record.get(16..).map(String::from_utf8_lossy).unwrap_or_default();
        let name: String = name.chars().filter(|c| c.is_ascii_graphic()).collect();
        let header = match integers[..] {
            [columns, rows, form, kind] if record.len() == 24 => Header::new(columns, rows, form, kind, &name),
            _ => None,
        };
        let allowed = "a header of 24 bytes: columns, rows, form, type (1 to 4), name";
        let header = header.ok_or_else(|| records.refuse(format!("a record of {} bytes", record.len()), allowed))?;
        records.matrix(header, found)?;
    }
    Ok(())
}

impl<'a> Records<'a> {
    fn refuse(&self, seen: String, allowed: impl Into<String>) -> MatrixError {
        MatrixError::Content {
            file: self.file.to_path_buf(),
            place: format!("byte {}", self.at),
            seen,
            allowed: allowed.into(),
            advice: "the file may be cut off; write it again",
        }
    }

    fn word(&self, at: usize) -> Option<u32> {
        let bytes = self.bytes.get(at..at.checked_add(4)?)?.try_into().ok()?;
        Some(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    fn next(&mut self) -> Result<&'a [u8], MatrixError> {
        let length = self.word(self.at).unwrap_or(u32::MAX) as usize;
        let from = self.at + 4;
        let data = self.bytes.get(from..from.saturating_add(length));
        let closed = self.word(from.saturating_add(length)) == Some(length as u32);
        let (Some(data), true) = (data, closed) else {
            return Err(
                self.refuse(format!("a record of {length} bytes"), "one that ends within the file, with its length")
            );
        };
        self.at = from + length + 4;
        Ok(data)
    }

    /// Integer number k of a record.
    fn integer(&self, record: &[u8], k: usize) -> Option<i64> {
        let bytes = record.get(4 * k..4 * k + 4)?.try_into().ok()?;
        Some(i64::from(if self.big_endian { i32::from_be_bytes(bytes) } else { i32::from_le_bytes(bytes) }))
    }

    /// Values of 4 bytes, or of 8 where a value has two words.
    fn values(&self, data: &[u8], double: bool) -> Vec<f64> {
        let one = |b: &[u8]| match (<[u8; 8]>::try_from(b), <[u8; 4]>::try_from(b)) {
            (Ok(b), _) => {
                if self.big_endian {
                    f64::from_be_bytes(b)
                } else {
                    f64::from_le_bytes(b)
                }
            }
            (_, Ok(b)) => f64::from(if self.big_endian { f32::from_be_bytes(b) } else { f32::from_le_bytes(b) }),
            _ => f64::NAN,
        };
        data.chunks_exact(if double { 8 } else { 4 }).map(one).collect()
    }

    fn matrix(&mut self, header: Header, found: &mut Found) -> Result<(), MatrixError> {
        let mut matrix = header.start(self.file);
        loop {
            let record = self.next()?;
            let integers = [0, 1, 2].map(|k| self.integer(record, k).and_then(|i| usize::try_from(i).ok()));
            let allowed = || format!("columns to {}, rows to {}, whole values", header.columns, header.rows);
            let [Some(column), Some(row), Some(count)] = integers else {
                return Err(self.refuse(format!("a column of {} bytes", record.len()), allowed()));
            };
            if column > header.columns {
                break;
            }
            let data = record.get(12..).and_then(|d| d.get(..count.checked_mul(4)?));
            let Some(mut data) = data.filter(|_| column > 0) else {
                return Err(
                    self.refuse(format!("column {column} with {count} words in {} bytes", record.len()), allowed())
                );
            };
            if header.unusable.is_some() {
                continue;
            }
            let mut strings = Vec::new();
            if row > 0 {
                strings.push((row, data));
            }
            while row == 0 && !data.is_empty() {
                let first = self.integer(data, 0);
                let string = if header.big {
                    let row = self.integer(data, 1).and_then(|r| usize::try_from(r).ok());
                    row.zip(first.and_then(|l| usize::try_from(l - 1).ok())).map(|(row, l)| (row, l, 2))
                } else {
                    first.and_then(Header::string).map(|(row, l)| (row, l, 1))
                };
                let split = string.filter(|(_, l, _)| *l > 0 && *l % header.words == 0).and_then(|(row, l, own)| {
                    let rest = data.get(4 * own..)?;
                    let (values, rest) = rest.split_at_checked(l.checked_mul(4)?)?;
                    Some((row, values, rest))
                });
                let Some((row, values, rest)) = split else {
                    return Err(self.refuse(format!("a string header {first:?} in column {column}"), allowed()));
                };
                strings.push((row, values));
                data = rest;
            }
            for (row, values) in strings {
                if values.len() % (4 * header.words) != 0
                    || header
                        .put(&mut matrix, column, row, self.values(values, header.words == 2).into_iter())
                        .is_none()
                {
                    return Err(
                        self.refuse(format!("row {row} and {} bytes in column {column}", values.len()), allowed())
                    );
                }
            }
        }
        header.finish(matrix, found);
        Ok(())
    }
}
