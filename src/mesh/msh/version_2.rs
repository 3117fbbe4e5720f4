//! Sections of version 2.2.

use super::elements::find;
use super::lines::Lines;
use super::raw::{Raw, RawElement};
use crate::mesh::MeshError;

type Result<T> = std::result::Result<T, MeshError>;

/// Reads `$Nodes`, or `$ParametricNodes`, whose lines name the entity of the node and its place there as well.
pub fn read_nodes(section: &'static str, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    let parametric = section != "Nodes";
    let count = lines.numbers::<u64>(section, 1, "the number of nodes")?[0];
    for _ in 0..count {
        let line = lines.need(section)?;
        let mut words = line.split_whitespace();
        let label = words.next().and_then(|word| word.parse::<u64>().ok()).filter(|label| *label > 0);
        let at: Vec<f64> = words.map_while(|word| word.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
        let (Some(label), [x, y, z, rest @ ..]) = (label, at.as_slice()) else {
            return Err(lines.refuse(section, line, "a label from 1 on and three finite coordinates"));
        };
        // Behind the coordinates dimension and number of the entity, and up to three parameters.
        let fits = if parametric { (2..=5).contains(&rest.len()) } else { rest.is_empty() };
        if !fits {
            let allowed = if parametric { "dimension, entity and parameters" } else { "nothing" };
            return Err(lines.refuse(section, line, &format!("{allowed} behind the three coordinates")));
        }
        raw.nodes.push((label, [*x, *y, *z], lines.number));
    }
    lines.end(section)
}

pub fn read_elements(lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const SECTION: &str = "Elements";
    const FORM: &str = "label, type, number of tags, tags, nodes";
    let count = lines.numbers::<u64>(SECTION, 1, "the number of elements")?[0];
    for _ in 0..count {
        let line = lines.need(SECTION)?;
        let values: Option<Vec<i64>> = line.split_whitespace().map(|word| word.parse().ok()).collect();
        let values = values.unwrap_or_default();
        let [label, kind, tags, rest @ ..] = values.as_slice() else {
            return Err(lines.refuse(SECTION, line, FORM));
        };
        let tags = usize::try_from(*tags).unwrap_or(usize::MAX);
        let Some((tags, nodes)) = rest.split_at_checked(tags) else {
            return Err(lines.refuse(SECTION, line, FORM));
        };
        let kind = find(u64::try_from(*kind).unwrap_or(0)).map_err(|allowed| lines.refuse(SECTION, line, allowed))?;
        let (expected, dimension) = (kind.node_count(), kind.dimension());
        let positive: Option<Vec<u64>> = nodes.iter().map(|n| u64::try_from(*n).ok().filter(|n| *n > 0)).collect();
        let (Some(nodes), Ok(label)) = (positive.filter(|n| n.len() == expected), u64::try_from(*label)) else {
            return Err(lines.refuse(SECTION, line, &format!("{FORM}, here {expected} node labels from 1 on")));
        };
        let physical = tags.first().and_then(|tag| u64::try_from(*tag).ok()).filter(|tag| *tag > 0);
        let groups = physical.map(|tag| vec![(dimension, tag)]).unwrap_or_default();
        raw.element_nodes.extend(nodes);
        let entity = tags.get(1).copied();
        raw.elements.push(RawElement { kind, label, line: lines.number, groups, entity });
    }
    lines.end(SECTION)
}
