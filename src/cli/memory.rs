//! How much memory a map may take.

use super::UsageError;
use anyhow::{Context, Result};
use std::path::Path;
use stiffmap::export::mat5;
use stiffmap::resources::{Size, room};

/// Bytes where nothing is known of the machine's memory.
const UNKNOWN: u64 = 1 << 30;
/// Share of the available memory: beside the map lies its transposed copy, and room is left for the rest.
const SHARE: u64 = 4;

/// Largest map that is held in memory, bytes: what `--map-memory` says, else a quarter of the memory that is available;
/// never more than a variable of a MAT-file holds.
pub fn map_limit(asked: Option<u64>) -> u64 {
    let limit = asked.unwrap_or_else(|| room().map_or(UNKNOWN, |room| room.bytes / SHARE));
    limit.min(mat5::LIMIT - (1 << 16))
}

/// Bytes of a line of a surface's CSV file.
const SURFACE_LINE: u64 = 90;
/// Bytes of the other files of a run, but for the state space.
const REST: u64 = 16 << 20;

/// Refuses a map whose files the disk of their folder cannot hold.
///
/// `pairs` are its (position, frequency) pairs, `direct` the responses of a force to its own place, which have a table
/// each.
pub fn check_disk(bytes: u64, pairs: u64, direct: u64, out: &Path) -> Result<()> {
    let free = fs4::available_space(out).with_context(|| format!("free room of {}", out.display()))?;
    let need = bytes.saturating_add(pairs.saturating_mul(direct * SURFACE_LINE)).saturating_add(REST);
    anyhow::ensure!(
        need <= free,
        "{pairs} pairs of position and frequency make files of {}, and {} has {} free; make room there, take another \
         --out, or ask for fewer --positions or --frequencies",
        Size(need),
        out.display(),
        Size(free)
    );
    Ok(())
}

/// A size such as `512MB`, `2GiB` or a number of bytes.
pub fn parse_size(text: &str) -> Result<u64, UsageError> {
    const UNITS: [(&str, f64); 8] = [
        ("", 1.0),
        ("B", 1.0),
        ("kB", 1e3),
        ("MB", 1e6),
        ("GB", 1e9),
        ("KiB", 1024.0),
        ("MiB", 1048576.0),
        ("GiB", 1073741824.0),
    ];
    let text = text.trim();
    let end = text.find(|c: char| c.is_alphabetic()).unwrap_or(text.len());
    let (number, unit) = (text[..end].trim(), &text[end..]);
    let factor = UNITS.iter().find(|(name, _)| name.eq_ignore_ascii_case(unit)).map(|(_, factor)| factor);
    match (number.parse::<f64>(), factor) {
        (Ok(number), Some(factor)) if number.is_finite() && number >= 0.0 => Ok((number * factor) as u64),
        _ => Err(UsageError(format!(
            "\"{text}\" is no size; write a number of bytes, or `512MB`, `2GiB`; 0 always streams"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_with_their_units() {
        for (text, bytes) in [("0", 0), ("512", 512), ("512MB", 512_000_000), ("1.5 GiB", 1_610_612_736), ("2kb", 2000)]
        {
            assert_eq!(parse_size(text).unwrap(), bytes, "{text}");
        }
        for text in ["", "MB", "-1", "3 apples", "nan", "1e400"] {
            assert!(parse_size(text).unwrap_err().to_string().contains("512MB"), "{text}");
        }
    }

    #[test]
    fn a_map_beyond_the_disk_is_refused_with_both_figures() {
        let here = Path::new(".");
        check_disk(1, 1, 1, here).unwrap();
        let said = check_disk(1 << 60, 1 << 56, 3, here).unwrap_err().to_string();
        assert!(said.contains("GB, and . has") && said.contains("--frequencies"), "{said}");
    }

    #[test]
    fn the_limit_fits_a_variable_of_a_mat_file() {
        assert_eq!(map_limit(Some(1000)), 1000);
        assert!(map_limit(Some(u64::MAX)) < mat5::LIMIT && map_limit(None) > 0);
    }
}
