//! Sections of version 4.1.

use super::elements::{Kind, find};
use super::lines::Lines;
use super::raw::{Raw, RawElement};
use crate::mesh::MeshError;

type Result<T> = std::result::Result<T, MeshError>;

/// Physical groups of each point, curve, surface and volume.
pub fn read_entities(lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const SECTION: &str = "Entities";
    const FORM: &str = "an entity: number, coordinates or box, number of physical groups, groups";
    let counts = lines.numbers::<u64>(SECTION, 4, "the numbers of points, curves, surfaces and volumes")?;
    for (dimension, count) in (0u8..4).zip(counts) {
        for _ in 0..count {
            let line = lines.need(SECTION)?;
            let words: Vec<&str> = line.split_whitespace().collect();
            // A point has three coordinates, everything else a box.
            let at = if dimension == 0 { 4 } else { 7 };
            let groups = words.get(at).and_then(|word| word.parse::<usize>().ok());
            let groups = groups.and_then(|n| words.get(at + 1..(at + 1).checked_add(n)?));
            // A negative group means the entity the other way round.
            let groups: Option<Vec<u64>> =
                groups.and_then(|g| g.iter().map(|w| w.parse::<i64>().ok().map(i64::unsigned_abs)).collect());
            let number = words.first().and_then(|word| word.parse::<u64>().ok());
            let (Some(number), Some(groups)) = (number, groups) else {
                return Err(lines.refuse(SECTION, line, FORM));
            };
            if !groups.is_empty() {
                raw.entities.insert((dimension, number), groups);
            }
        }
    }
    lines.end(SECTION)
}

pub fn read_nodes(lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const SECTION: &str = "Nodes";
    let blocks = lines.numbers::<u64>(SECTION, 4, "numbers of blocks and nodes, smallest and largest label")?[0];
    for _ in 0..blocks {
        let header = lines.numbers::<u64>(SECTION, 4, "dimension, entity, parametric, number of nodes")?;
        let count = header[3];
        let first = raw.nodes.len();
        for _ in 0..count {
            let label = lines.numbers::<u64>(SECTION, 1, "a label from 1 on")?[0];
            if label == 0 {
                return Err(lines.refuse(SECTION, "0", "a label from 1 on"));
            }
            raw.nodes.push((label, [0.0; 3], lines.number));
        }
        for k in first..raw.nodes.len() {
            const FORM: &str = "three finite coordinates";
            let at = lines.numbers::<f64>(SECTION, 3, FORM)?;
            if !at.iter().all(|x| x.is_finite()) {
                return Err(lines.refuse(SECTION, "an infinite number or NaN", FORM));
            }
            raw.nodes[k].1 = [at[0], at[1], at[2]];
        }
    }
    lines.end(SECTION)
}

pub fn read_elements(lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const SECTION: &str = "Elements";
    let blocks = lines.numbers::<u64>(SECTION, 4, "numbers of blocks and elements, smallest and largest label")?[0];
    for _ in 0..blocks {
        const FORM: &str = "dimension, entity, element type, number of elements";
        let header = lines.numbers::<u64>(SECTION, 4, FORM)?;
        let &[dimension, entity, kind, count] = header.as_slice() else {
            return Err(lines.refuse(SECTION, &format!("{} numbers", header.len()), FORM));
        };
        let dimension = u8::try_from(dimension).ok().filter(|d| *d <= 3);
        let dimension = dimension.ok_or_else(|| lines.refuse(SECTION, &format!("dimension {}", header[0]), FORM))?;
        let groups: Vec<(u8, u64)> =
            raw.entities.get(&(dimension, entity)).into_iter().flatten().map(|tag| (dimension, *tag)).collect();
        if groups.len() > 64 {
            return Err(lines.refuse(SECTION, &format!("{} physical groups", groups.len()), "at most 64 an entity"));
        }
        for _ in 0..count {
            let found = find(kind);
            let kind = found.map_err(|allowed| lines.refuse(SECTION, &format!("element type {kind}"), allowed))?;
            let expected = match kind {
                Kind::Solid(kind, _) => kind.node_count(),
                Kind::Carrier(count) => count,
            };
            let values = lines.numbers::<u64>(SECTION, 1, "a label and node labels")?;
            let (label, nodes) = (values[0], &values[1..]);
            if nodes.len() != expected || nodes.contains(&0) {
                let seen = format!("element {label} with {} nodes", nodes.len());
                return Err(lines.refuse(SECTION, &seen, &format!("{expected} node labels from 1 on")));
            }
            raw.element_nodes.extend(nodes);
            raw.elements.push(RawElement { kind, label, line: lines.number, groups: groups.clone() });
        }
    }
    lines.end(SECTION)
}
