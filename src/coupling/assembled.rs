//! The unreduced machine at one position as one pair of sparse matrices: the parts' own, and the springs.

use super::Unreduced;
use crate::linalg::{SparseBuilder, SparseSymmetric};
use crate::solid::SecondOrder;
use std::collections::{BTreeMap, BTreeSet};

/// The machine's stiffness and mass at one position.
#[derive(Clone, Debug)]
pub struct Assembled {
    /// K + sum k b b^T, N/m.
    pub stiffness: SparseSymmetric,
    /// Mass, kg.
    pub mass: SparseSymmetric,
    /// What each row is.
    pub rows: Vec<AssembledRow>,
}

/// A row of [`Assembled`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AssembledRow {
    /// Part.
    pub part: usize,
    /// Node of the part and direction (0 to 2 translations, 3 to 5 rotations); `None` for a modal coordinate
    /// or a rigid surface's motion.
    pub node: Option<(usize, usize)>,
    /// Where the node is, m; zero without a node.
    pub at: [f64; 3],
}

/// Bytes that [`assembled`] takes beside the parts' own systems, at most: the pattern, two matrices and the text of
/// their rows on the way to a file, of all entries of the parts and all that springs add. A spring couples every
/// unknown of both surfaces with every other.
pub fn assembled_bytes(systems: &[SecondOrder], machine: &Unreduced) -> u64 {
    let own: u64 = systems.iter().map(|system| system.stiffness.entries() as u64).sum();
    let mut joined = BTreeSet::new();
    for spring in &machine.springs {
        joined.insert(spring.sides.iter().map(|(interface, _)| *interface).collect::<Vec<_>>());
    }
    let unknowns = |interface: &usize| 3 * machine.interfaces[*interface].motion.rows.nodes.len() as u64;
    let of_springs: u64 = joined.iter().map(|sides| sides.iter().map(unknowns).sum::<u64>().pow(2)).sum();
    ENTRY * (own + of_springs)
}

/// Bytes an entry: its place in the pattern, which grows by doubling, and in two matrices with column and value.
const ENTRY: u64 = 56;

/// Puts the parts' systems side by side and adds the springs.
pub fn assembled(systems: &[SecondOrder], machine: &Unreduced) -> Assembled {
    let mut first = Vec::new();
    let mut rows = Vec::new();
    for (part, (system, moved)) in systems.iter().zip(&machine.moved).enumerate() {
        first.push(rows.len());
        rows.extend(system.node_of_unknown().into_iter().map(|node| AssembledRow {
            part,
            node,
            at: node.map_or([0.0; 3], |(n, _)| [0, 1, 2].map(|c| system.nodes[n][c] + moved[c])),
        }));
    }
    let springs: Vec<(f64, BTreeMap<usize, f64>)> = machine
        .springs
        .iter()
        .map(|spring| {
            let mut row = BTreeMap::new();
            for (part, node, c, coefficient) in machine.elongation(spring) {
                for (unknown, factor) in systems[part].unknowns_of(node, c) {
                    *row.entry(first[part] + unknown).or_insert(0.0) += coefficient * factor;
                }
            }
            (spring.stiffness, row)
        })
        .collect();
    let mut pattern: Vec<Vec<usize>> = Vec::with_capacity(rows.len());
    for (system, first) in systems.iter().zip(&first) {
        pattern.extend((0..system.n_dof()).map(|i| system.stiffness.row(i).map(|(j, _)| first + j).collect()));
    }
    for (_, row) in &springs {
        for i in row.keys() {
            pattern[*i].extend(row.keys());
            // Springs of one joint have the same unknowns: kept until the end, each would count again.
            pattern[*i].sort_unstable();
            pattern[*i].dedup();
        }
    }
    let (mut stiffness, mut mass) = (SparseBuilder::new(&pattern), SparseBuilder::new(&pattern));
    for (system, first) in systems.iter().zip(&first) {
        for i in 0..system.n_dof() {
            system.stiffness.row(i).for_each(|(j, v)| stiffness.add(first + i, first + j, v));
            system.mass.row(i).for_each(|(j, v)| mass.add(first + i, first + j, v));
        }
    }
    for (k, row) in &springs {
        for (i, a) in row {
            row.iter().for_each(|(j, b)| stiffness.add(*i, *j, k * a * b));
        }
    }
    Assembled { stiffness: stiffness.finish(), mass: mass.finish(), rows }
}
