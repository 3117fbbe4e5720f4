//! A part whose stiffness and mass are given, as a second-order system.
//!
//! Rows of clamped nodes are taken out, nodes of rigid interfaces follow six unknowns, modal
//! coordinates are unknowns of no node. Whether the part is free is found from K R, R the rigid
//! motions of its nodes: it is where no entry is above 1e-9 of what its row adds up without signs.

use super::assembly::{SecondOrder, group_neighbours};
use super::held::{Held, held};
use super::numbering::{NodeMap, carry, interface_motions};
use super::{InterfaceMotion, SolidError, definite};
use crate::linalg::{SparseBuilder, SparseSymmetric, multiply, multiply_transposed};
use crate::machine::{Part, SurfaceCoupling};
use crate::matrix::{DofLabel, GivenMatrices, GivenNodes};
use crate::mesh::Mesh;
use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3};
use std::collections::BTreeSet;

/// An entry of K R, relative to what its row adds up without signs, below which a motion is free.
const FREE: f64 = 1e-9;
/// The same where the machine file says `free = true`; between the two nobody can tell.
const FREE_IF_SAID: f64 = 1e-5;

/// Where the unknowns of the given rows are.
struct Numbering {
    /// Translations of every node, then rotations of every node.
    maps: Vec<NodeMap>,
    /// First unknown and centre of each rigid surface.
    rigid: Vec<(usize, [f64; 3])>,
    groups: Vec<Vec<usize>>,
    /// For each given row its unknowns and factors.
    rows: Vec<Vec<(usize, f64)>>,
    n_dof: usize,
}

pub(super) fn assemble(part: &Part, mesh: &Mesh, given: &GivenMatrices) -> Result<SecondOrder, SolidError> {
    let held = held(part, mesh)?;
    let (surfaces, interfaces): (Vec<_>, Vec<_>) = interface_motions(part, mesh)?.into_iter().unzip();
    let numbering = number(part, mesh, given, &held, &interfaces)?;
    check_interfaces(part, mesh, given, &held, &interfaces, &numbering)?;
    let pattern = pattern(given, &numbering);
    let stiffness = project(&given.stiffness, &numbering.rows, &pattern);
    let mass = project(&given.mass, &numbering.rows, &pattern);
    let neighbours = group_neighbours(&numbering.groups, &pattern);
    let place = |unknown: usize| place(unknown, given, &numbering);
    one_piece(part, &neighbours, &numbering, &place)?;
    let ordering = crate::linalg::Ordering::nested_dissection(&neighbours, &numbering.groups)
        .map_err(|source| SolidError::Ordering { part: part.name.clone(), source })?;
    definite::check(&part.name, "stiffness", &stiffness, &ordering, &place)?;
    definite::check(&part.name, "mass", &mass, &ordering, &place)?;

    let motions = complete_modal(rigid_motions(mesh, given, &numbering), given, &numbering, &stiffness);
    let body = Body::of(&motions, &mass);
    let about_centre = multiply(&motions, &shift_to(body.centre));
    let free = free_motions(part, given, &stiffness, &about_centre)?;
    Ok(SecondOrder {
        rigid: if free { about_centre } else { DMatrix::zeros(numbering.n_dof, 0) },
        stiffness,
        mass,
        centre_of_mass: body.centre,
        total_mass: body.mass,
        inertia: body.inertia,
        interfaces,
        surfaces,
        nodes: mesh.nodes.clone(),
        node_unknowns: numbering.maps,
        groups: numbering.groups,
        neighbours,
    })
}

fn number(
    part: &Part,
    mesh: &Mesh,
    given: &GivenMatrices,
    held: &Held,
    interfaces: &[InterfaceMotion],
) -> Result<Numbering, SolidError> {
    let n_nodes = mesh.nodes.len();
    let mut maps = vec![NodeMap::Fixed; 2 * n_nodes];
    let mut owner: Vec<Option<&str>> = vec![None; n_nodes];
    let (mut groups, mut rigid, mut n_dof) = (Vec::new(), Vec::new(), 0);
    for ((interface, motion), nodes) in part.interfaces.iter().zip(interfaces).zip(&given.interfaces) {
        if interface.coupling != SurfaceCoupling::Rigid || matches!(nodes, GivenNodes::Point(_)) {
            continue;
        }
        carry(part, interface, motion, mesh, held, &mut owner, |node, arm| {
            maps[node] = NodeMap::Rigid(n_dof, arm);
            maps[n_nodes + node] = NodeMap::RigidTurn(n_dof);
        })?;
        rigid.push((n_dof, motion.centroid));
        groups.push((n_dof..n_dof + 6).collect());
        n_dof += 6;
    }
    let mut group_of: Vec<Option<usize>> = vec![None; n_nodes];
    let mut rows = Vec::with_capacity(given.labels.len());
    for (label, node) in given.labels.iter().zip(&given.node_of) {
        let (DofLabel::Node { direction, .. }, &Some(node)) = (label, node) else {
            rows.push(vec![(n_dof, 1.0)]);
            groups.push(vec![n_dof]);
            n_dof += 1;
            continue;
        };
        let map = &mut maps[if *direction < 3 { node } else { n_nodes + node }];
        if owner[node].is_none() && !is_held(held, node, *direction) {
            let mut own = if let NodeMap::Single(own) = map { *own } else { [None; 3] };
            own[direction % 3] = Some(n_dof);
            *map = NodeMap::Single(own);
            let group = *group_of[node].get_or_insert_with(|| {
                groups.push(Vec::new());
                groups.len() - 1
            });
            groups[group].push(n_dof);
            n_dof += 1;
        }
        let mut row = Vec::new();
        map.each(|unknown, component, factor| {
            if component == direction % 3 {
                row.push((unknown, factor));
            }
        });
        rows.push(row);
    }
    Ok(Numbering { maps, rigid, groups, rows, n_dof })
}

/// Whether a direction of a node is held to ground: a clamped node's rotations are held with it.
fn is_held(held: &Held, node: usize, direction: usize) -> bool {
    let own = held.of(node);
    if direction < 3 { own[direction] } else { own == [true; 3] }
}

/// Refuses an interface that reads a displacement which the matrices do not have.
fn check_interfaces(
    part: &Part,
    mesh: &Mesh,
    given: &GivenMatrices,
    held: &Held,
    interfaces: &[InterfaceMotion],
    numbering: &Numbering,
) -> Result<(), SolidError> {
    let fixed: BTreeSet<(usize, usize)> = given.fixed.iter().copied().collect();
    for (interface, motion) in part.interfaces.iter().zip(interfaces) {
        for (k, &node) in motion.rows.nodes.iter().enumerate() {
            let own = node % mesh.nodes.len();
            for c in 0..3 {
                let direction = c + if node < mesh.nodes.len() { 0 } else { 3 };
                let read = motion.rows.rows.column(3 * k + c).iter().any(|v| *v != 0.0);
                let mut has = false;
                numbering.maps[node].each(|_, component, _| has |= component == c);
                if read && !has && !is_held(held, own, direction) && !fixed.contains(&(own, direction)) {
                    let label = DofLabel::Node { node: mesh.node_labels[own], direction };
                    return Err(SolidError::NoSurface {
                        part: part.name.clone(),
                        interface: interface.name.clone(),
                        reason: format!(
                            "the matrices have no row for {label}; leave the node out, or name its set in `clamped` or `supported` if it is fixed to ground"
                        ),
                    });
                }
            }
        }
    }
    Ok(())
}

fn pattern(given: &GivenMatrices, numbering: &Numbering) -> Vec<Vec<usize>> {
    let mut pattern: Vec<Vec<usize>> = (0..numbering.n_dof).map(|i| vec![i]).collect();
    for matrix in [&given.stiffness, &given.mass] {
        for i in 0..matrix.n() {
            for (j, _) in matrix.row(i) {
                for (a, _) in &numbering.rows[i] {
                    pattern[*a].extend(numbering.rows[j].iter().map(|(b, _)| *b));
                }
            }
        }
    }
    for row in &mut pattern {
        row.sort_unstable();
        row.dedup();
    }
    pattern
}

/// T^T A T.
fn project(matrix: &SparseSymmetric, rows: &[Vec<(usize, f64)>], pattern: &[Vec<usize>]) -> SparseSymmetric {
    let mut out = SparseBuilder::new(pattern);
    for (i, own) in rows.iter().enumerate() {
        for (j, value) in matrix.row(i) {
            for (a, fa) in own {
                for (b, fb) in &rows[j] {
                    out.add(*a, *b, fa * fb * value);
                }
            }
        }
    }
    out.finish()
}

/// What an unknown is, for messages.
fn place(unknown: usize, given: &GivenMatrices, numbering: &Numbering) -> String {
    let row = numbering.rows.iter().position(|row| row.iter().any(|(u, _)| *u == unknown));
    row.map_or_else(|| "a rigid interface".into(), |row| format!("row {} ({})", row + 1, given.labels[row]))
}

fn one_piece(
    part: &Part,
    neighbours: &[Vec<usize>],
    numbering: &Numbering,
    place: &dyn Fn(usize) -> String,
) -> Result<(), SolidError> {
    let mut seen = vec![false; neighbours.len()];
    let mut pieces = 0;
    let mut outside = None;
    for start in 0..neighbours.len() {
        if seen[start] {
            continue;
        }
        pieces += 1;
        if pieces == 2 {
            outside = numbering.groups[start].first().copied();
        }
        let mut open = vec![start];
        while let Some(group) = open.pop() {
            if !std::mem::replace(&mut seen[group], true) {
                open.extend(neighbours[group].iter().copied().filter(|g| !seen[*g]));
            }
        }
    }
    match outside {
        None => Ok(()),
        Some(unknown) => Err(SolidError::MatrixPieces { part: part.name.clone(), pieces, place: place(unknown) }),
    }
}

/// Rigid motions of the nodes about the origin over the unknowns, n x 6; zero at modal coordinates.
fn rigid_motions(mesh: &Mesh, given: &GivenMatrices, numbering: &Numbering) -> DMatrix<f64> {
    let mut motions = DMatrix::zeros(numbering.n_dof, 6);
    let translation = |c: usize, [x, y, z]: [f64; 3]| {
        [[1.0, 0.0, 0.0, 0.0, z, -y], [0.0, 1.0, 0.0, -z, 0.0, x], [0.0, 0.0, 1.0, y, -x, 0.0]][c]
    };
    for (row, (label, node)) in given.labels.iter().zip(&given.node_of).enumerate() {
        let (DofLabel::Node { direction, .. }, Some(node)) = (label, node) else { continue };
        if let [(unknown, _)] = numbering.rows[row][..]
            && matches!(numbering.maps[*node], NodeMap::Single(_) | NodeMap::Fixed)
        {
            let values = if *direction < 3 {
                translation(*direction, mesh.nodes[*node])
            } else {
                std::array::from_fn(|q| f64::from(u8::from(q == *direction)))
            };
            (0..6).for_each(|q| motions[(unknown, q)] = values[q]);
        }
    }
    for &(first, centre) in &numbering.rigid {
        for c in 0..3 {
            (0..6).for_each(|q| motions[(first + c, q)] = translation(c, centre)[q]);
            motions[(first + 3 + c, 3 + c)] = 1.0;
        }
    }
    motions
}

/// Modal coordinates follow a rigid motion of the nodes so that they feel no force: K_qq q = -K_qm R_m.
fn complete_modal(
    mut motions: DMatrix<f64>,
    given: &GivenMatrices,
    numbering: &Numbering,
    stiffness: &SparseSymmetric,
) -> DMatrix<f64> {
    let modal: Vec<usize> =
        (0..given.labels.len()).filter(|&r| given.node_of[r].is_none()).map(|r| numbering.rows[r][0].0).collect();
    if modal.is_empty() {
        return motions;
    }
    let force = stiffness.multiply(&motions).select_rows(&modal);
    let mut own = DMatrix::zeros(modal.len(), modal.len());
    for (a, &i) in modal.iter().enumerate() {
        for (j, value) in stiffness.row(i) {
            if let Ok(b) = modal.binary_search(&j) {
                own[(a, b)] = value;
            }
        }
    }
    // A modal coordinate without stiffness feels no force from it either.
    for a in 0..modal.len() {
        if own[(a, a)] == 0.0 {
            own[(a, a)] = 1.0;
        }
    }
    if let Some(answer) = own.lu().solve(&-force) {
        for (a, &i) in modal.iter().enumerate() {
            motions.row_mut(i).copy_from(&answer.row(a));
        }
    }
    motions
}

/// Rigid motions about a point from those about the origin: R' = R T.
fn shift_to(centre: [f64; 3]) -> DMatrix<f64> {
    let mut t = DMatrix::identity(6, 6);
    // A turn about the point is one about the origin less the translation it gives the point.
    t.view_mut((0, 3), (3, 3)).copy_from(&Vector3::from(centre).cross_matrix());
    t
}

/// Whether K leaves all six rigid motions free.
fn free_motions(
    part: &Part,
    given: &GivenMatrices,
    stiffness: &SparseSymmetric,
    motions: &DMatrix<f64>,
) -> Result<bool, SolidError> {
    let gram = multiply_transposed(motions, motions);
    let scale: Vec<f64> = (0..6).map(|q| gram[(q, q)].sqrt()).collect();
    if scale.iter().any(|s| *s <= 0.0) {
        return Ok(false);
    }
    let residual = stiffness.multiply(motions);
    // Each row relative to what it adds up without signs, over all six motions.
    let reach = |j: usize| (0..6).map(|q| motions[(j, q)].abs() / scale[q]).sum::<f64>();
    let reach: Vec<f64> = (0..motions.nrows()).map(reach).collect();
    let mut relative = residual.clone();
    for i in 0..motions.nrows() {
        let whole: f64 = stiffness.row(i).map(|(j, v)| v.abs() * reach[j]).sum();
        for q in 0..6 {
            relative[(i, q)] = if whole > 0.0 { residual[(i, q)] / (scale[q] * whole) } else { 0.0 };
        }
    }
    let triangle = relative.clone().qr().r();
    let svd = triangle.svd(false, true);
    let Some(directions) = svd.v_t else { return Ok(false) };
    let largest = |q: usize| (&relative * directions.row(q).transpose()).amax();
    let residuals: Vec<f64> = (0..6).map(largest).collect();
    let allowed = if given.free == Some(true) { FREE_IF_SAID } else { FREE };
    let free = residuals.iter().filter(|r| **r <= allowed).count();
    let doubtful = residuals.iter().copied().filter(|r| *r > FREE && *r < FREE_IF_SAID).fold(0.0, f64::max);
    let file = given.file.display().to_string();
    match (given.free, free) {
        (Some(false), _) => Ok(false),
        (None, _) if doubtful > 0.0 => Err(SolidError::DoubtfullyFree {
            part: part.name.clone(),
            file,
            residual: doubtful,
            free: FREE,
            held: FREE_IF_SAID,
        }),
        (_, 6) => Ok(true),
        (None, 0) => Ok(false),
        (_, free) => Err(SolidError::PartlyFree { part: part.name.clone(), file, free }),
    }
}

/// Mass, centre and inertia by R^T M R.
struct Body {
    mass: f64,
    centre: [f64; 3],
    inertia: Matrix3<f64>,
}

impl Body {
    fn of(motions: &DMatrix<f64>, mass: &SparseSymmetric) -> Self {
        let all: DMatrix<f64> = multiply_transposed(motions, &mass.multiply(motions));
        let all = Matrix6::from_fn(|i, j| all[(i, j)]);
        let total = (all[(0, 0)] + all[(1, 1)] + all[(2, 2)]) / 3.0;
        if total <= 0.0 {
            return Self { mass: 0.0, centre: [0.0; 3], inertia: Matrix3::zeros() };
        }
        let first = all.fixed_view::<3, 3>(0, 3);
        // The coupling block is -m [c]x.
        let centre =
            Vector3::new(first[(1, 2)] - first[(2, 1)], first[(2, 0)] - first[(0, 2)], first[(0, 1)] - first[(1, 0)])
                / (2.0 * total);
        let about_origin: Matrix3<f64> = all.fixed_view::<3, 3>(3, 3).into_owned();
        let inertia =
            about_origin - total * (Matrix3::identity() * centre.norm_squared() - centre * centre.transpose());
        Self { mass: total, centre: centre.into(), inertia }
    }
}
