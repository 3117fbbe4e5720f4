//! Fill-reducing order by METIS nested dissection on the node graph.

use super::LinalgError;
use std::sync::Mutex;

/// METIS draws from the C library's one random sequence: one call at a time keeps its answer repeatable.
static METIS: Mutex<()> = Mutex::new(());

/// An elimination order of the unknowns.
#[derive(Clone, Debug)]
pub struct Ordering {
    /// `forward[i]` is the unknown eliminated as number i.
    pub forward: Vec<usize>,
    /// `inverse[u]` is the place of unknown u.
    pub inverse: Vec<usize>,
}

impl Ordering {
    /// Nested dissection of a graph of groups (the nodes of a mesh), spread to each group's unknowns.
    ///
    /// `neighbours[g]` lists the other groups that group g touches; `unknowns[g]` its unknowns.
    ///
    /// # Errors
    /// [`LinalgError::Ordering`] if METIS refuses the graph or it has more than 2^31 edges.
    pub fn nested_dissection(neighbours: &[Vec<usize>], unknowns: &[Vec<usize>]) -> Result<Self, LinalgError> {
        let nodes = neighbours.len();
        assert_eq!(nodes, unknowns.len(), "one list of unknowns a group");
        let refused = |status| LinalgError::Ordering { nodes, status };
        let edges: usize = neighbours.iter().map(Vec::len).sum();
        let mut count = i32::try_from(nodes).map_err(|_| refused(0))?;
        i32::try_from(edges).map_err(|_| refused(0))?;
        let mut order: Vec<i32> = (0..count).collect();
        if edges > 0 {
            let mut start = Vec::with_capacity(nodes + 1);
            start.push(0_i32);
            for list in neighbours {
                start.push(start[start.len() - 1] + list.len() as i32);
            }
            let mut edge: Vec<i32> = neighbours.iter().flatten().map(|&g| g as i32).collect();
            let mut weight: Vec<i32> = unknowns.iter().map(|u| u.len() as i32).collect();
            let mut place = vec![0_i32; nodes];
            let guard = METIS.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            // SAFETY: the arrays have the lengths METIS asks for (nodes + 1, edges, nodes, nodes,
            // nodes) and outlive the call; a null options pointer means its defaults.
            let status = unsafe {
                metis_sys::METIS_NodeND(
                    &mut count,
                    start.as_mut_ptr(),
                    edge.as_mut_ptr(),
                    weight.as_mut_ptr(),
                    std::ptr::null_mut(),
                    order.as_mut_ptr(),
                    place.as_mut_ptr(),
                )
            };
            drop(guard);
            if status != 1 {
                return Err(refused(status));
            }
        }
        let forward: Vec<usize> = order.iter().flat_map(|&g| unknowns[g as usize].iter().copied()).collect();
        let mut inverse = vec![usize::MAX; forward.len()];
        for (place, &unknown) in forward.iter().enumerate() {
            inverse[unknown] = place;
        }
        assert!(!inverse.contains(&usize::MAX), "every unknown belongs to one group");
        Ok(Self { forward, inverse })
    }
}
