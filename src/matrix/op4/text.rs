//! OUTPUT4 as text: fields of 8 characters in headers, of the width that the format names in data.

use super::super::MatrixError;
use super::super::text::{Lines, number};
use super::{Found, Header};
use std::path::Path;

pub(super) fn parse(bytes: &[u8], file: &Path, found: &mut Found) -> Result<(), MatrixError> {
    let mut lines = Lines::new(bytes, file);
    while let Some(line) = lines.next_raw()? {
        if line.trim().is_empty() {
            continue;
        }
        let (header, width) = header(line).ok_or_else(|| {
            lines.refuse(
                line,
                "columns, rows, form, type (1 to 4) in fields of 8 characters, a name and a format such as 1P,5E16.9",
            )
        })?;
        matrix(&mut lines, header, width, file, found)?;
    }
    Ok(())
}

fn header(line: &str) -> Option<(Header, usize)> {
    let field = |k: usize| integer(line, k);
    let format = line.get(40..).unwrap_or_default().to_ascii_uppercase();
    // 1P,5E16.9 or 5D23.16: the width stands between the letter and the point.
    let width = match format.find(['E', 'D']) {
        Some(at) => format.get(at + 1..)?.split('.').next()?.trim().parse().ok().filter(|w| (8..=64).contains(w))?,
        None if format.trim().is_empty() => 16,
        None => return None,
    };
    Some((Header::new(field(0)?, field(1)?, field(2)?, field(3)?, line.get(32..40.min(line.len()))?)?, width))
}

/// An integer field of 8 characters.
fn integer(line: &str, k: usize) -> Option<i64> {
    line.get(8 * k..line.len().min(8 * k + 8))?.trim().parse().ok()
}

fn matrix(
    lines: &mut Lines<'_>,
    header: Header,
    width: usize,
    file: &Path,
    found: &mut Found,
) -> Result<(), MatrixError> {
    let mut matrix = header.start(file);
    let mut words_each = None;
    loop {
        let line = lines.next_raw()?.ok_or_else(|| lines.refuse("the end of the file", "a column of the matrix"))?;
        let fields = integer(line, 0).zip(integer(line, 1)).zip(integer(line, 2));
        let fields = fields.and_then(|((c, r), w)| {
            Some((usize::try_from(c).ok()?, usize::try_from(r).ok()?, usize::try_from(w).ok()?))
        });
        let (column, row, words) = fields.ok_or_else(|| lines.refuse(line, "column, first row, number of words"))?;
        if column > header.columns {
            // The closing column carries one value.
            lines.next_raw()?;
            break;
        }
        let outside = |lines: &Lines<'_>| {
            lines.refuse(line, format!("columns to {}, rows to {}, whole values", header.columns, header.rows))
        };
        if column == 0 {
            return Err(outside(lines));
        }
        if row > 0 {
            // Nastran counts the numbers of a dense column; others count words, in the whole matrix. A line without
            // numbers ends the column.
            let values = values(lines, words, width, true)?;
            let each = *words_each.get_or_insert(if values.len() == words { 1 } else { header.words });
            if values.len() * each != words {
                let seen = format!("{} numbers where {} are announced", values.len(), words / each);
                return Err(lines.refuse(seen, "as many numbers as the column's header announces"));
            }
            header.put(&mut matrix, column, row, values.into_iter()).ok_or_else(|| outside(lines))?;
            continue;
        }
        let mut left = words;
        while left > 0 {
            let line =
                lines.next_raw()?.ok_or_else(|| lines.refuse("the end of the file", "a string of the column"))?;
            let string = if header.big {
                let (length, row) = (integer(line, 0), integer(line, 1));
                length.zip(row).and_then(|(l, r)| Some((usize::try_from(r).ok()?, usize::try_from(l - 1).ok()?, 2)))
            } else {
                line.trim().parse().ok().and_then(Header::string).map(|(row, words)| (row, words, 1))
            };
            let string =
                string.filter(|(_, words, own)| *words > 0 && words + own <= left && words % header.words == 0);
            let (row, words, own) =
                string.ok_or_else(|| lines.refuse(line, format!("a string of at most {left} words")))?;
            let values = values(lines, words / header.words, width, false)?;
            header.put(&mut matrix, column, row, values.into_iter()).ok_or_else(|| outside(lines))?;
            left -= words + own;
        }
    }
    header.finish(matrix, found);
    Ok(())
}

/// `count` numbers from the next lines, in fields of `width` characters; fewer where a line that holds none, as the
/// header of a column, comes first and `may_end`.
fn values(lines: &mut Lines<'_>, count: usize, width: usize, may_end: bool) -> Result<Vec<f64>, MatrixError> {
    let mut values = Vec::new();
    while values.len() < count {
        if may_end && lines.peek_raw().is_some_and(|next| !next.contains(&b'.')) {
            break;
        }
        let line = lines.next_raw()?.ok_or_else(|| lines.refuse("the end of the file", format!("{count} values")))?;
        let before = values.len();
        let mut rest = line;
        while !rest.trim().is_empty() {
            let at = width.min(rest.len());
            let (field, next) = rest.split_at_checked(at).ok_or_else(|| lines.refuse(line, "numbers"))?;
            let value =
                number(field).ok_or_else(|| lines.refuse(field, format!("a finite number of {width} characters")))?;
            values.push(value);
            rest = next;
        }
        if values.len() == before || values.len() > count {
            return Err(lines.refuse(line, format!("{count} values")));
        }
    }
    Ok(values)
}
