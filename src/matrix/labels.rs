//! What each row of a matrix is: a direction of a node, or a modal coordinate.

use super::MatrixError;
use super::text::{Lines, fields, number};
use std::collections::BTreeMap;
use std::path::Path;

/// Names of the six directions of a node.
pub const DIRECTIONS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// What a row of the matrices is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DofLabel {
    /// A translation (0 to 2) or rotation (3 to 5) of a node.
    Node {
        /// Label of the node.
        node: u64,
        /// Direction, as an index into [`DIRECTIONS`].
        direction: usize,
    },
    /// A coordinate that belongs to no node, such as a component mode of a superelement.
    Modal(u64),
}

impl std::fmt::Display for DofLabel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Node { node, direction } => write!(f, "node {node}, {}", DIRECTIONS[*direction]),
            Self::Modal(k) => write!(f, "modal coordinate {k}"),
        }
    }
}

/// A table of degrees of freedom.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DofTable {
    /// One a row of the matrices.
    pub labels: Vec<DofLabel>,
    /// Coordinates by node label, in the file's unit, where the table gives them.
    pub nodes: BTreeMap<u64, [f64; 3]>,
}

/// CalculiX's `.dof`: one `node.direction` a line.
///
/// # Errors
/// [`MatrixError::Content`] with the line.
pub fn parse_calculix_dofs(bytes: &[u8], file: &Path) -> Result<DofTable, MatrixError> {
    let mut lines = Lines::new(bytes, file);
    let mut table = DofTable::default();
    while let Some(line) = lines.next()? {
        let parts = line.split_once('.').and_then(|(node, direction)| {
            let direction = direction.parse::<usize>().ok().filter(|d| (1..=6).contains(d))?;
            Some((node.trim().parse().ok()?, direction - 1))
        });
        let (node, direction) =
            parts.ok_or_else(|| lines.refuse(line, "NODE.DIRECTION with a direction from 1 to 6"))?;
        table.labels.push(DofLabel::Node { node, direction });
    }
    Ok(table)
}

/// A table `node,direction[,x,y,z]` with that header, one line a row of the matrices.
///
/// A direction is 1 to 6 or one of x, y, z, rx, ry, rz; `modal` is a coordinate that belongs to no
/// node, and `node` then its number.
///
/// # Errors
/// [`MatrixError::Content`] with the line; a node with two places is one.
pub fn parse_dof_table(bytes: &[u8], file: &Path) -> Result<DofTable, MatrixError> {
    let mut lines = Lines::new(bytes, file);
    let header = lines.next()?.unwrap_or_default().to_ascii_lowercase();
    let columns: Vec<&str> = header.split(',').map(str::trim).collect();
    let placed = match columns[..] {
        ["node", "direction"] => false,
        ["node", "direction", "x", "y", "z"] => true,
        _ => return Err(lines.refuse(header.as_str(), "the header node,direction or node,direction,x,y,z")),
    };
    let mut table = DofTable::default();
    while let Some(line) = lines.next()? {
        let parts: Vec<&str> = line.split(',').map(str::trim).collect();
        let label = parts.first().and_then(|node| node.parse().ok()).zip(parts.get(1).and_then(|d| direction(d)));
        let Some((node, direction)) = label else {
            return Err(lines.refuse(line, "a node label, and a direction: 1 to 6, x, y, z, rx, ry, rz or modal"));
        };
        let Some(direction) = direction else {
            table.labels.push(DofLabel::Modal(node));
            continue;
        };
        table.labels.push(DofLabel::Node { node, direction });
        if placed {
            let numbers: Vec<f64> = parts[2..].iter().map_while(|p| number(p)).collect();
            let at = <[f64; 3]>::try_from(numbers).map_err(|_| lines.refuse(line, "three finite coordinates"))?;
            if table.nodes.insert(node, at).is_some_and(|before| before != at) {
                return Err(lines.refuse(line, format!("one place for node {node} in all of its lines")));
            }
        }
    }
    Ok(table)
}

/// `Some(None)` for a modal coordinate.
fn direction(text: &str) -> Option<Option<usize>> {
    if text.eq_ignore_ascii_case("modal") {
        return Some(None);
    }
    let named = DIRECTIONS.iter().position(|d| d.eq_ignore_ascii_case(text));
    named.or_else(|| text.parse::<usize>().ok().filter(|d| (1..=6).contains(d)).map(|d| d - 1)).map(Some)
}

/// Coordinates of a table `node,x,y,z` with or without that header, by node label.
///
/// # Errors
/// [`MatrixError::Content`] with the line.
pub fn parse_node_table(bytes: &[u8], file: &Path) -> Result<BTreeMap<u64, [f64; 3]>, MatrixError> {
    let mut lines = Lines::new(bytes, file);
    let mut nodes = BTreeMap::new();
    while let Some(line) = lines.next()? {
        if lines.line == 1 && line.to_ascii_lowercase().starts_with("node") {
            continue;
        }
        let mut parts = fields(line);
        let node = parts.next().and_then(|f| f.parse::<u64>().ok());
        let numbers: Vec<f64> = parts.map_while(number).collect();
        let at = <[f64; 3]>::try_from(numbers).ok();
        let Some((node, at)) = node.zip(at) else {
            return Err(lines.refuse(line, "a node label and three finite coordinates"));
        };
        if nodes.insert(node, at).is_some() {
            return Err(lines.refuse(line, format!("node {node} once")));
        }
    }
    Ok(nodes)
}

/// Node sets of a table `set,node[,weight]` with that header.
///
/// # Errors
/// [`MatrixError::Content`] with the line.
pub fn parse_set_table(bytes: &[u8], file: &Path) -> Result<BTreeMap<String, NodeSet>, MatrixError> {
    let mut lines = Lines::new(bytes, file);
    let header = lines.next()?.unwrap_or_default().to_ascii_lowercase();
    let columns: Vec<&str> = header.split(',').map(str::trim).collect();
    let weighted = match columns[..] {
        ["set", "node"] => false,
        ["set", "node", "weight"] => true,
        _ => return Err(lines.refuse(header.as_str(), "the header set,node or set,node,weight")),
    };
    let mut sets: BTreeMap<String, NodeSet> = BTreeMap::new();
    while let Some(line) = lines.next()? {
        let parts: Vec<&str> = line.split(',').map(str::trim).collect();
        let node = parts.get(1).and_then(|n| n.parse::<u64>().ok());
        let weight = if weighted { parts.get(2).and_then(|w| number(w)) } else { None };
        let (Some(node), true) = (node, !parts[0].is_empty() && weight.is_some() == weighted) else {
            return Err(lines.refuse(line, format!("{header}: a name, a node label, a finite weight")));
        };
        let set = sets.entry(parts[0].to_owned()).or_default();
        if set.nodes.insert(node, weight.unwrap_or(1.0)).is_some() {
            return Err(lines.refuse(line, format!("node {node} once in set {}", parts[0])));
        }
        set.weighted = weighted;
    }
    Ok(sets)
}

/// A node set of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeSet {
    /// Weight by node label; 1 where the table has none.
    pub nodes: BTreeMap<u64, f64>,
    /// Whether the table gives weights.
    pub weighted: bool,
}
