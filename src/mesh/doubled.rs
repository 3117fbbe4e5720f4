//! Elements that stand more than once in a file.
//!
//! An element that is written twice would count its stiffness and mass twice, and its outer faces would seem to
//! lie between two elements. It counts once, and the reader says so.

use super::Cell;

/// The cells of a file, each once.
pub struct Merged {
    /// The cells that stay, in the order of the file.
    pub cells: Vec<Cell>,
    /// For each cell of the file its place among those that stay.
    pub place: Vec<usize>,
    /// For each cell of the file whether it is another one with its nodes in another order: its faces have
    /// other numbers.
    pub turned: Vec<bool>,
    /// What to say about those that are left out, with the place of the first in the file.
    pub warning: Option<(usize, String)>,
}

/// Two cells that share their corners and cannot count as one: their places in the file.
pub struct Clash {
    pub first: usize,
    pub second: usize,
    /// What they differ in.
    pub difference: &'static str,
}

/// Labels that a warning names.
const NAMED: usize = 5;

/// Takes out the cells whose nodes another one has; `expected(second, first)` are not warned of.
///
/// # Errors
/// Cells that share all corners, but neither midside nodes nor material.
pub fn merge(mut cells: Vec<Cell>, expected: impl Fn(usize, usize) -> bool) -> Result<Merged, Clash> {
    let corners = |cell: &Cell| {
        let mut key = [u32::MAX; 8];
        for (slot, &node) in key.iter_mut().zip(&cell.nodes[..cell.kind.corner_count()]) {
            *slot = node as u32;
        }
        key.sort_unstable();
        key
    };
    let mut order: Vec<([u32; 8], usize)> = cells.iter().enumerate().map(|(i, cell)| (corners(cell), i)).collect();
    order.sort_unstable();
    let mut first_of: Vec<usize> = (0..cells.len()).collect();
    for group in order.chunk_by(|a, b| a.0 == b.0) {
        group.iter().for_each(|&(_, i)| first_of[i] = group[0].1);
    }
    let sorted = |cell: &Cell| {
        let mut nodes = cell.nodes.clone();
        nodes.sort_unstable();
        nodes
    };
    let (mut doubled, mut turned) = (Vec::new(), vec![false; cells.len()]);
    for second in 0..cells.len() {
        let first = first_of[second];
        if first == second {
            continue;
        }
        let clash = |difference| Err(Clash { first, second, difference });
        if sorted(&cells[first]) != sorted(&cells[second]) {
            return clash("midside nodes");
        }
        match (cells[first].material, cells[second].material) {
            (Some(a), Some(b)) if a != b => return clash("materials"),
            (None, Some(b)) => cells[first].material = Some(b),
            _ => {}
        }
        turned[second] = cells[first].nodes != cells[second].nodes;
        if !expected(second, first) {
            doubled.push(second);
        }
    }
    let name = |&second: &usize| {
        let (first, second) = (&cells[first_of[second]], &cells[second]);
        let again = format!("{} is {} again", second.label, first.label);
        if first.kind == second.kind { again } else { format!("{again} (the {} stays)", first.kind.name()) }
    };
    let warning = doubled.first().map(|&place| {
        let named: Vec<String> = doubled.iter().take(NAMED).map(name).collect();
        let more = if doubled.len() > NAMED { ", .." } else { "" };
        let what = match doubled.len() {
            1 => "1 element stands twice (the same nodes) and counts once".to_owned(),
            count => format!("{count} elements stand twice (the same nodes) and count once"),
        };
        (place, format!("{what}: {}{more}", named.join(", ")))
    });
    let mut place = vec![0; cells.len()];
    let mut next = 0;
    for i in 0..cells.len() {
        place[i] = if first_of[i] == i { next } else { place[first_of[i]] };
        next += usize::from(first_of[i] == i);
    }
    let mut at = 0..;
    cells.retain(|_| at.next().is_some_and(|i| first_of[i] == i));
    Ok(Merged { cells, place, turned, warning })
}
