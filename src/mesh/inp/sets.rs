//! Named sets, from labels, ranges and other sets.

use super::assemble::Element;
use super::lines::{key, told_apart, unquoted};
use super::raw::{Members, RawSet};
use super::source::Source;
use crate::machine::nearest;
use crate::mesh::labels::Labels;
use crate::mesh::{MeshError, Spot, Warning};
use std::collections::HashMap;

type Result<T> = std::result::Result<T, MeshError>;

/// Most members of all sets together, before duplicates are removed: this many, or this many times the
/// labels if that is more. Bounds time and memory.
pub const MOST_MEMBERS: usize = 1_000_000;
pub const MOST_MEMBERS_PER_LABEL: usize = 200;

/// Sets by the key of their name.
pub struct Sets(HashMap<String, Set>);

struct Set {
    /// The name as it came first, with its quotes.
    name: String,
    /// Indices; ascending and without duplicates only up to `sorted`.
    members: Vec<u32>,
    sorted: usize,
}

impl Set {
    fn extend(&mut self, added: &[u32]) {
        self.members.extend_from_slice(added);
        if self.members.len() > 2 * self.sorted + 64 {
            self.sort();
        }
    }

    fn sort(&mut self) {
        self.members.sort_unstable();
        self.members.dedup();
        self.sorted = self.members.len();
    }
}

impl Sets {
    /// The members of a set.
    pub fn get(&self, name: &str) -> Option<&[u32]> {
        self.0.get(&key(name)).map(|set| set.members.as_slice())
    }

    /// Keys, names without quotes, and members.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str, &[u32])> {
        self.0.iter().map(|(key, set)| (key.as_str(), unquoted(&set.name), set.members.as_slice()))
    }

    /// The set that `name` is probably a misspelling of.
    pub fn nearest(&self, name: &str) -> Option<String> {
        nearest(unquoted(name), self.0.values().map(|set| unquoted(&set.name))).map(str::to_owned)
    }
}

/// Resolves the sets of one file.
pub struct Resolver<'a> {
    source: &'a Source,
    /// Members added so far, and labels looked through for them.
    members: usize,
    /// What was passed over so far.
    pub warnings: Vec<Warning>,
}

/// What a set is made of: nodes or elements.
pub struct Kind<'a> {
    pub name: &'static str,
    pub labels: &'a Labels,
    /// The elements and their sets, from which node sets may be made.
    pub elements: Option<(&'a Vec<Element>, &'a Sets)>,
}

impl<'a> Resolver<'a> {
    pub fn new(source: &'a Source, warnings: Vec<Warning>) -> Self {
        Resolver { source, members: 0, warnings }
    }

    fn spot(&self, line: usize) -> Spot {
        self.source.spot(line)
    }

    /// Members of each set as ascending indices without duplicates. Sets that the pieces name are those above
    /// them, or those of `named` where there are some.
    pub fn resolve(&mut self, pieces: &[RawSet], kind: &Kind<'_>, named: Option<&Sets>) -> Result<Sets> {
        let mut sets = Sets(HashMap::new());
        for RawSet { name, members } in pieces {
            let added = self.piece(members, kind, name, named.unwrap_or(&sets))?;
            let new = || Set { name: name.clone(), members: Vec::new(), sorted: 0 };
            let set = sets.0.entry(key(name)).or_insert_with(new);
            if told_apart(&set.name, name) {
                let (first, second) = (set.name.clone(), name.clone());
                return Err(MeshError::AlmostEqualNames { spot: self.spot(members.line()), first, second });
            }
            set.extend(&added);
        }
        sets.0.values_mut().for_each(Set::sort);
        Ok(sets)
    }

    /// Members that one piece adds to the set `name`.
    fn piece(&mut self, members: &Members, kind: &Kind<'_>, name: &str, sets: &Sets) -> Result<Vec<u32>> {
        let name = unquoted(name);
        let added = match members {
            Members::Section { first, end, .. } => (*first as u32..*end as u32).collect(),
            Members::Labels(list) => self.listed(list, kind, name)?,
            Members::Range { first, last, step, line } => self.range([*first, *last, *step], *line, kind, name)?,
            Members::Set { name: other, line } => {
                let added = sets.get(other).ok_or_else(|| MeshError::UnknownName {
                    spot: self.spot(*line),
                    kind: if kind.name == "node" { "node set above" } else { "element set above" },
                    name: unquoted(other).to_owned(),
                    nearest: sets.nearest(other),
                })?;
                added.to_vec()
            }
            Members::OfElements { name: other, line } => {
                let found = kind.elements.and_then(|(elements, sets)| Some((elements, sets.get(other)?)));
                let (elements, members) = found.ok_or_else(|| MeshError::UnknownName {
                    spot: self.spot(*line),
                    kind: "element set",
                    name: unquoted(other).to_owned(),
                    nearest: kind.elements.and_then(|(_, sets)| sets.nearest(other)),
                })?;
                members.iter().flat_map(|&i| &elements[i as usize].nodes).map(|&node| node as u32).collect()
            }
        };
        self.members += added.len();
        let limit = MOST_MEMBERS.max(MOST_MEMBERS_PER_LABEL * kind.labels.len());
        if self.members > limit {
            return Err(MeshError::TooManyMembers { spot: self.spot(members.line()), limit });
        }
        Ok(added)
    }

    fn listed(&self, list: &[(u64, u32)], kind: &Kind<'_>, name: &str) -> Result<Vec<u32>> {
        let mut added = Vec::with_capacity(list.len());
        for &(label, line) in list {
            let index = kind.labels.find(label).ok_or_else(|| MeshError::MissingLabel {
                spot: self.spot(line as usize),
                by: format!("the {} set {name:?}", kind.name),
                kind: kind.name,
                label,
            })?;
            added.push(index as u32);
        }
        Ok(added)
    }

    /// The existing labels of `first, first + step, ..., last`; those that do not exist are counted in a
    /// warning, as numbers with gaps are usual. Never more work than the mesh has labels.
    fn range(&mut self, [first, last, step]: [u64; 3], line: usize, kind: &Kind<'_>, name: &str) -> Result<Vec<u32>> {
        let count = (last - first) / step + 1;
        let added: Vec<u32> = if count <= kind.labels.len() as u64 {
            (0..count).filter_map(|i| kind.labels.find(first + i * step)).map(|index| index as u32).collect()
        } else {
            self.members += kind.labels.len();
            let inside = |label: u64| (first..=last).contains(&label) && (label - first).is_multiple_of(step);
            kind.labels.iter().filter(|(label, _)| inside(*label)).map(|(_, index)| index as u32).collect()
        };
        if added.is_empty() {
            let by = format!("the {} set {name:?}", kind.name);
            return Err(MeshError::MissingLabel { spot: self.spot(line), by, kind: kind.name, label: first });
        }
        let missing = count - added.len() as u64;
        if missing > 0 {
            let text = format!(
                "GENERATE of the {} set {name:?}: {missing} of {count} labels do not exist and are passed over",
                kind.name
            );
            self.warnings.push(Warning { line, text });
        }
        Ok(added)
    }
}
