//! Names of physical groups.

use super::lines::Lines;
use super::raw::Raw;
use crate::mesh::MeshError;

const SECTION: &str = "PhysicalNames";

pub fn read_names(lines: &mut Lines<'_>, raw: &mut Raw) -> Result<(), MeshError> {
    let count = lines.numbers::<u64>(SECTION, 1, "the number of names")?[0];
    for _ in 0..count {
        let line = lines.need(SECTION)?;
        let mut words = line.splitn(3, char::is_whitespace);
        let dimension = words.next().and_then(|word| word.parse::<u8>().ok()).filter(|d| *d <= 3);
        let number = words.next().and_then(|word| word.parse::<u64>().ok());
        let name = words.next().map(|word| word.trim().trim_matches('"')).filter(|name| !name.is_empty());
        let (Some(dimension), Some(number), Some(name)) = (dimension, number, name) else {
            return Err(lines.refuse(SECTION, line, "a dimension from 0 to 3, a number and a name in quotes"));
        };
        raw.names.insert((dimension, number), name.to_owned());
    }
    lines.end(SECTION)
}
