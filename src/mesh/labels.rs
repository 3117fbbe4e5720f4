//! From labels to indices.

use std::collections::HashMap;

/// Index of each label.
pub struct Labels {
    table: Table,
    count: usize,
}

/// A plain table where the labels are dense, a hash map where they are not.
enum Table {
    Dense(Vec<u32>),
    Sparse(HashMap<u64, u32>),
}

const ABSENT: u32 = u32::MAX;

impl Labels {
    /// Indexes labels in their order.
    ///
    /// # Errors
    /// The index of the first label that was there before.
    pub fn new(labels: impl ExactSizeIterator<Item = u64> + Clone) -> Result<Self, usize> {
        Self::with_twins(labels, |_, _| false)
    }

    /// Indexes labels in their order; one that is there already stands for the first where `twins(first, second)`.
    ///
    /// # Errors
    /// The index of the first label that was there before and is no twin.
    pub fn with_twins(
        labels: impl ExactSizeIterator<Item = u64> + Clone,
        twins: impl Fn(usize, usize) -> bool,
    ) -> Result<Self, usize> {
        let count = labels.len();
        assert!(count < ABSENT as usize, "{count} labels, at most {ABSENT}");
        let largest = labels.clone().max().unwrap_or(0);
        if largest <= 8 * count as u64 + 1024 {
            let mut table = vec![ABSENT; largest as usize + 1];
            for (index, label) in labels.enumerate() {
                let slot = &mut table[label as usize];
                if *slot == ABSENT {
                    *slot = index as u32;
                } else if !twins(*slot as usize, index) {
                    return Err(index);
                }
            }
            return Ok(Self { table: Table::Dense(table), count });
        }
        let mut map = HashMap::with_capacity(count);
        for (index, label) in labels.enumerate() {
            let first = *map.entry(label).or_insert(index as u32) as usize;
            if first != index && !twins(first, index) {
                return Err(index);
            }
        }
        Ok(Self { table: Table::Sparse(map), count })
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Index of a label.
    pub fn find(&self, label: u64) -> Option<usize> {
        let index = match &self.table {
            Table::Dense(table) => *table.get(usize::try_from(label).ok()?)?,
            Table::Sparse(map) => *map.get(&label)?,
        };
        (index != ABSENT).then_some(index as usize)
    }

    /// Every label with its index, in no order.
    pub fn iter(&self) -> Box<dyn Iterator<Item = (u64, usize)> + '_> {
        match &self.table {
            Table::Dense(table) => {
                Box::new((0u64..).zip(table).filter(|(_, index)| **index != ABSENT).map(|(l, i)| (l, *i as usize)))
            }
            Table::Sparse(map) => Box::new(map.iter().map(|(label, index)| (*label, *index as usize))),
        }
    }
}
