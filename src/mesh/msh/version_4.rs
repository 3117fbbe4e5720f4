//! Sections of version 4.1.

use super::elements::find;
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
            let entity = entity(dimension, &words, 1).ok_or_else(|| lines.refuse(SECTION, line, FORM))?;
            raw.entities.extend(entity);
        }
    }
    lines.end(SECTION)
}

/// The same of a mesh that Gmsh has partitioned: its elements belong to pieces of the entities, and a piece has
/// the groups of the entity that it is cut from.
pub fn read_partitioned_entities(lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const SECTION: &str = "PartitionedEntities";
    const FORM: &str =
        "an entity: number, dimension and number of its parent, partitions, coordinates or box, physical groups";
    lines.numbers::<u64>(SECTION, 1, "the number of partitions")?;
    let ghosts = lines.numbers::<u64>(SECTION, 1, "the number of ghost entities")?[0];
    for _ in 0..ghosts {
        lines.need(SECTION)?;
    }
    let counts = lines.numbers::<u64>(SECTION, 4, "the numbers of points, curves, surfaces and volumes")?;
    for (dimension, count) in (0u8..4).zip(counts) {
        for _ in 0..count {
            let line = lines.need(SECTION)?;
            let words: Vec<&str> = line.split_whitespace().collect();
            // Number, dimension and number of the parent, number of partitions, partitions.
            let partitions = words.get(3).and_then(|word| word.parse::<usize>().ok());
            let entity = partitions.and_then(|n| entity(dimension, &words, n.checked_add(4)?));
            raw.entities.extend(entity.ok_or_else(|| lines.refuse(SECTION, line, FORM))?);
        }
    }
    lines.end(SECTION)
}

/// An entity's dimension, number and physical groups, unless it has none; its place begins at the word `place`.
fn entity(dimension: u8, words: &[&str], place: usize) -> Option<Option<Entity>> {
    // A point has three coordinates, everything else a box.
    let at = place.checked_add(if dimension == 0 { 3 } else { 6 })?;
    let count = words.get(at)?.parse::<usize>().ok()?;
    let groups = words.get(at + 1..(at + 1).checked_add(count)?)?;
    // A negative group means the entity the other way round.
    let groups: Option<Vec<u64>> = groups.iter().map(|w| w.parse::<i64>().ok().map(i64::unsigned_abs)).collect();
    let (number, groups) = (words.first()?.parse::<u64>().ok()?, groups?);
    Some((!groups.is_empty()).then_some(((dimension, number), groups)))
}

/// Dimension and number of an entity, and its physical groups.
type Entity = ((u8, u64), Vec<u64>);

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
            let expected = kind.node_count();
            let values = lines.numbers::<u64>(SECTION, 1, "a label and node labels")?;
            let (label, nodes) = (values[0], &values[1..]);
            if nodes.len() != expected || nodes.contains(&0) {
                let seen = format!("element {label} with {} nodes", nodes.len());
                return Err(lines.refuse(SECTION, &seen, &format!("{expected} node labels from 1 on")));
            }
            raw.element_nodes.extend(nodes);
            let entity = i64::try_from(entity).ok();
            raw.elements.push(RawElement { kind, label, line: lines.number, groups: groups.clone(), entity });
        }
    }
    lines.end(SECTION)
}
