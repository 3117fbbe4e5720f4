//! Which unknowns a node's displacement follows from: its own, a rigid surface's, or none.

use super::held::Held;
use super::places::{check_name, surface_of};
use super::{InterfaceMotion, NodeRows, SolidError, Surface};
use crate::machine::{Interface, Part, SurfaceCoupling};
use crate::matrix::{DofLabel, GivenNodes};
use crate::mesh::Mesh;
use nalgebra::{DMatrix, Vector3};

/// How a node's displacement follows from the unknowns.
#[derive(Clone, Debug)]
pub(super) enum NodeMap {
    /// Fixed to ground (or not part of any element).
    Fixed,
    /// Its own three unknowns, the first of which is this.
    Free(usize),
    /// An unknown of its own for some components.
    Single([Option<usize>; 3]),
    /// The rotation of a rigid surface whose six unknowns start here.
    RigidTurn(usize),
    /// Unknowns from this one on for those of its displacements that are not held.
    Held(usize, [bool; 3]),
    /// u = t + theta x arm of the six unknowns from this one on.
    Rigid(usize, [f64; 3]),
}

impl NodeMap {
    /// Calls back (unknown, displacement component, factor).
    pub fn each(&self, mut f: impl FnMut(usize, usize, f64)) {
        match self {
            NodeMap::Fixed => {}
            NodeMap::Free(first) => (0..3).for_each(|c| f(first + c, c, 1.0)),
            NodeMap::Single(own) => {
                own.iter().enumerate().filter_map(|(c, u)| Some((c, (*u)?))).for_each(|(c, u)| f(u, c, 1.0));
            }
            NodeMap::RigidTurn(first) => (0..3).for_each(|c| f(first + 3 + c, c, 1.0)),
            NodeMap::Held(first, held) => {
                (0..3).filter(|&c| !held[c]).enumerate().for_each(|(k, c)| f(first + k, c, 1.0));
            }
            NodeMap::Rigid(first, [x, y, z]) => {
                (0..3).for_each(|c| f(first + c, c, 1.0));
                f(first + 4, 0, *z);
                f(first + 5, 0, -*y);
                f(first + 3, 1, -*z);
                f(first + 5, 1, *x);
                f(first + 3, 2, *y);
                f(first + 4, 2, -*x);
            }
        }
    }

    /// The unknowns of a mesh's node, without their factors.
    pub fn unknowns(&self) -> std::ops::Range<usize> {
        match self {
            NodeMap::Single(_) | NodeMap::RigidTurn(_) => unreachable!("only rows of given matrices are numbered so"),
            NodeMap::Fixed => 0..0,
            NodeMap::Free(first) => *first..first + 3,
            NodeMap::Held(first, held) => *first..first + held.iter().filter(|h| !**h).count(),
            NodeMap::Rigid(first, _) => *first..first + 6,
        }
    }
}

/// Numbering of a part's unknowns.
pub(super) struct Numbering {
    /// One a node.
    pub nodes: Vec<NodeMap>,
    /// Unknowns that are eliminated together: one group a free node, one a rigid surface.
    pub groups: Vec<Vec<usize>>,
    /// Unknowns.
    pub n_dof: usize,
}

/// Numbers the unknowns of a part.
pub(super) fn number(
    part: &Part,
    mesh: &Mesh,
    held: &Held,
    interfaces: &[InterfaceMotion],
) -> Result<Numbering, SolidError> {
    let mut used = vec![false; mesh.nodes.len()];
    for &node in mesh.cells.iter().flat_map(|c| &c.nodes) {
        used[node] = true;
    }
    let mut nodes = vec![NodeMap::Fixed; mesh.nodes.len()];
    let (mut groups, mut n_dof) = (Vec::new(), 0);
    let mut owner: Vec<Option<&str>> = vec![None; mesh.nodes.len()];
    for (interface, motion) in part.interfaces.iter().zip(interfaces) {
        if interface.coupling != SurfaceCoupling::Rigid {
            continue;
        }
        carry(part, interface, motion, mesh, held, &mut owner, |node, arm| nodes[node] = NodeMap::Rigid(n_dof, arm))?;
        groups.push((n_dof..n_dof + 6).collect());
        n_dof += 6;
    }
    for node in 0..mesh.nodes.len() {
        if !used[node] || owner[node].is_some() || held.of(node) == [true; 3] {
            continue;
        }
        nodes[node] = match held.of(node) {
            [false, false, false] => NodeMap::Free(n_dof),
            some => NodeMap::Held(n_dof, some),
        };
        let unknowns = nodes[node].unknowns();
        n_dof = unknowns.end;
        groups.push(unknowns.collect());
    }
    Ok(Numbering { nodes, groups, n_dof })
}

/// Hands every node that a rigid interface carries to `place`, with its arm from the centroid (m).
///
/// # Errors
/// [`SolidError::RigidOverlap`] where something else holds or carries a node already.
pub(super) fn carry<'a>(
    part: &Part,
    interface: &'a Interface,
    motion: &InterfaceMotion,
    mesh: &Mesh,
    held: &Held,
    owner: &mut [Option<&'a str>],
    mut place: impl FnMut(usize, [f64; 3]),
) -> Result<(), SolidError> {
    for node in rigid_nodes(interface, motion, mesh) {
        let other = if held.of(node) != [false; 3] { Some("a clamp or support") } else { owner[node] };
        if let Some(other) = other {
            return Err(SolidError::RigidOverlap {
                part: part.name.clone(),
                interface: interface.name.clone(),
                node: mesh.node_labels[node],
                other: other.to_string(),
            });
        }
        owner[node] = Some(&interface.name);
        place(node, (Vector3::from(mesh.nodes[node]) - Vector3::from(motion.centroid)).into());
    }
    Ok(())
}

/// The nodes of an interface's surface that lie inside its region: those that a rigid one carries.
pub fn rigid_nodes(interface: &Interface, motion: &InterfaceMotion, mesh: &Mesh) -> Vec<usize> {
    motion.rows.nodes.iter().copied().filter(|node| is_inside(interface, mesh, *node)).collect()
}

/// Whether a node lies inside an interface's region.
fn is_inside(interface: &Interface, mesh: &Mesh, node: usize) -> bool {
    interface.within.is_none_or(|region| {
        (0..3).all(|c| {
            let slack = 1e-9 * (1.0 + mesh.nodes[node][c].abs());
            (region.min[c] - slack..=region.max[c] + slack).contains(&mesh.nodes[node][c])
        })
    })
}

/// The whole surface of each interface of a part, and its rigid motion inside its region.
///
/// # Errors
/// [`SolidError::UnknownSet`] or [`SolidError::NoSurface`], with what the mesh has instead;
/// [`SolidError::TwoPlaces`], [`SolidError::NoFace`].
pub fn interface_motions(part: &Part, mesh: &Mesh) -> Result<Vec<(Surface, InterfaceMotion)>, SolidError> {
    let one = |(i, interface): (usize, &Interface)| {
        let given = mesh.matrices.as_ref().and_then(|m| m.interfaces.get(i));
        if let Some(GivenNodes::Weighted(_) | GivenNodes::Point(_)) = given {
            check_name(part, mesh, &interface.nodes, &format!("interface \"{}\"", interface.name))?;
        }
        match given {
            None | Some(GivenNodes::Faces) => interface_motion(part, mesh, interface),
            Some(GivenNodes::Weighted(weights)) => weighted_motion(part, mesh, interface, weights),
            Some(GivenNodes::Point(node)) => Ok((Surface::default(), point_motion(mesh, *node))),
        }
    };
    part.interfaces.iter().enumerate().map(one).collect()
}

fn interface_motion(part: &Part, mesh: &Mesh, interface: &Interface) -> Result<(Surface, InterfaceMotion), SolidError> {
    let no_surface =
        |reason: String| SolidError::NoSurface { part: part.name.clone(), interface: interface.name.clone(), reason };
    let user = format!("interface \"{}\"", interface.name);
    let (surface, made_from) = surface_of(part, mesh, &interface.nodes, &user)?;
    if surface.faces.is_empty() {
        return Err(no_surface(format!(
            "{made_from} cover no outer element face; a face counts when all its nodes, midsides too, are in the set"
        )));
    }
    let everywhere = crate::machine::Region { min: [f64::NEG_INFINITY; 3], max: [f64::INFINITY; 3] };
    let weights = surface.weights_within(interface.within.as_ref().unwrap_or(&everywhere));
    let motion = InterfaceMotion::from_weights(&weights, |n| mesh.nodes[n]).ok_or_else(|| {
        let (lo, hi): (Vec<f64>, Vec<f64>) =
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].iter().map(|d| surface.extent(*d)).unzip();
        no_surface(format!(
            "`within` leaves no area of set \"{}\", which spans x {:.4} to {:.4}, y {:.4} to {:.4}, z {:.4} to {:.4} m",
            interface.nodes, lo[0], hi[0], lo[1], hi[1], lo[2], hi[2]
        ))
    })?;
    Ok((surface, motion))
}

/// The motion of weighted nodes inside an interface's region.
fn weighted_motion(
    part: &Part,
    mesh: &Mesh,
    interface: &Interface,
    weights: &[(usize, f64)],
) -> Result<(Surface, InterfaceMotion), SolidError> {
    let inside = |(node, _): &&(usize, f64)| is_inside(interface, mesh, *node);
    let kept: Vec<(usize, f64)> = weights.iter().filter(inside).copied().collect();
    let motion = InterfaceMotion::from_weights(&kept, |n| mesh.nodes[n]).ok_or_else(|| SolidError::NoSurface {
        part: part.name.clone(),
        interface: interface.name.clone(),
        reason: format!(
            "{} of its {} nodes are inside `within`, and they do not fix a rigid motion; it takes three that are not on one line, with weights of a positive sum",
            kept.len(),
            weights.len()
        ),
    })?;
    Ok((Surface::default(), motion))
}

/// The motion of one node: its translations, and its rotations where the matrices have rows for them.
fn point_motion(mesh: &Mesh, node: usize) -> InterfaceMotion {
    let turns = mesh.matrices.as_ref().is_some_and(|given| {
        let own = given.labels.iter().zip(&given.node_of).filter(|(_, n)| **n == Some(node));
        own.filter(|(label, _)| matches!(label, DofLabel::Node { direction: 3.., .. })).count() == 3
    });
    let nodes = if turns { vec![node, mesh.nodes.len() + node] } else { vec![node] };
    let rows = DMatrix::identity(6, 3 * nodes.len());
    InterfaceMotion { centroid: mesh.nodes[node], area: 0.0, rows: NodeRows { nodes, rows } }
}

/// Rigid motions over the unknowns about a point, n x 6.
pub(super) fn rigid_motions(
    mesh: &Mesh,
    part: &Part,
    interfaces: &[InterfaceMotion],
    numbering: &Numbering,
    centre: [f64; 3],
) -> DMatrix<f64> {
    let mut rigid = DMatrix::zeros(numbering.n_dof, 6);
    let mut set = |unknown: usize, at: [f64; 3], component: usize| {
        for (q, value) in rigid_rows(at, centre)[component].into_iter().enumerate() {
            rigid[(unknown, q)] = value;
        }
    };
    for (map, &x) in numbering.nodes.iter().zip(&mesh.nodes) {
        if !matches!(map, NodeMap::Rigid(..)) {
            map.each(|unknown, component, _| set(unknown, x, component));
        }
    }
    let rigid_interfaces = part.interfaces.iter().zip(interfaces).filter(|(i, _)| i.coupling == SurfaceCoupling::Rigid);
    let firsts: Vec<(usize, [f64; 3])> =
        rigid_interfaces.enumerate().map(|(k, (_, motion))| (6 * k, motion.centroid)).collect();
    for &(first, centroid) in &firsts {
        (0..3).for_each(|c| set(first + c, centroid, c));
    }
    for (first, _) in firsts {
        for c in 3..6 {
            rigid[(first + c, c)] = 1.0;
        }
    }
    rigid
}

/// Displacements x, y, z of a point under unit translations and rotations about `centre`.
pub(super) fn rigid_rows(at: [f64; 3], centre: [f64; 3]) -> [[f64; 6]; 3] {
    let [x, y, z] = [at[0] - centre[0], at[1] - centre[1], at[2] - centre[2]];
    [[1.0, 0.0, 0.0, 0.0, z, -y], [0.0, 1.0, 0.0, -z, 0.0, x], [0.0, 0.0, 1.0, y, -x, 0.0]]
}
