//! Assembly of a part's stiffness and mass; clamped nodes and rigid surfaces are eliminated on the way.

use super::held::held;
use super::numbering::{NodeMap, Numbering, interface_motions, number, rigid_motions};
use super::{InterfaceMotion, NodeRows, SolidError, Surface};
use crate::element::{ElementMatrices, matrices, own_functions};
use crate::linalg::{LinalgError, Ordering, SparseBuilder, SparseSymmetric};
use crate::machine::Part;
use crate::mesh::{Cell, Mesh};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rayon::prelude::*;

/// A part as K u = f, M u'' with the motion of every node as a combination of the unknowns.
pub struct SecondOrder {
    /// Stiffness, N/m.
    pub stiffness: SparseSymmetric,
    /// Mass, kg.
    pub mass: SparseSymmetric,
    /// Rigid motions over the unknowns: three translations, three rotations about the centre of mass; of a
    /// part that is held somewhere the combinations that are left, none if it is clamped.
    pub rigid: DMatrix<f64>,
    /// Centre of mass, m.
    pub centre_of_mass: [f64; 3],
    /// Total mass, kg.
    pub total_mass: f64,
    /// Inertia tensor about the centre of mass, kg m^2.
    pub inertia: Matrix3<f64>,
    /// The interfaces' motions, in the order of the part.
    pub interfaces: Vec<InterfaceMotion>,
    /// The interfaces' whole surfaces before clipping (rails take their footprints from these).
    pub surfaces: Vec<Surface>,
    /// Node coordinates, m.
    pub nodes: Vec<[f64; 3]>,
    /// Unknowns of each node: for each of its three displacements, (unknown, factor) pairs.
    pub(super) node_unknowns: Vec<NodeMap>,
    /// Unknowns grouped for the fill-reducing order.
    pub(super) groups: Vec<Vec<usize>>,
    /// The groups that each group touches.
    pub(super) neighbours: Vec<Vec<usize>>,
}

impl SecondOrder {
    /// Unknowns.
    pub fn n_dof(&self) -> usize {
        self.stiffness.n()
    }

    /// The unknowns, with factors, that a node's displacement along axis 0, 1 or 2 follows from.
    pub fn unknowns_of(&self, node: usize, axis: usize) -> Vec<(usize, f64)> {
        let mut out = Vec::new();
        self.node_unknowns[node].each(|unknown, component, factor| {
            if component == axis && factor != 0.0 {
                out.push((unknown, factor));
            }
        });
        out
    }

    /// What each unknown is: a node and its direction (0 to 2 translations, 3 to 5 rotations); `None` for
    /// a modal coordinate, a rigid surface's motion or an incompatible mode of a C3D8I.
    pub fn node_of_unknown(&self) -> Vec<Option<(usize, usize)>> {
        let mut out = vec![None; self.n_dof()];
        for (i, map) in self.node_unknowns.iter().enumerate() {
            if let NodeMap::Free(_) | NodeMap::Held(..) | NodeMap::Single(_) = map {
                let (node, turn) = (i % self.nodes.len(), 3 * (i / self.nodes.len()));
                map.each(|unknown, component, _| out[unknown] = Some((node, component + turn)));
            }
        }
        out
    }

    /// A fill-reducing order of the unknowns.
    ///
    /// # Errors
    /// [`LinalgError::Ordering`] if METIS refuses the graph.
    pub fn ordering(&self) -> Result<Ordering, LinalgError> {
        Ordering::nested_dissection(&self.neighbours, &self.groups)
    }

    /// Six node rows as six columns over the unknowns, n x 6: q = W^T u.
    pub fn columns(&self, rows: &NodeRows) -> DMatrix<f64> {
        let mut w = DMatrix::zeros(self.n_dof(), 6);
        for (k, &node) in rows.nodes.iter().enumerate() {
            self.node_unknowns[node].each(|unknown, component, factor| {
                for q in 0..6 {
                    w[(unknown, q)] += factor * rows.rows[(q, 3 * k + component)];
                }
            });
        }
        w
    }

    /// Displacements of some nodes for vectors over the unknowns: 3 n_nodes x b.
    pub fn displacements(&self, nodes: &[usize], vectors: &DMatrix<f64>) -> DMatrix<f64> {
        let mut u = DMatrix::zeros(3 * nodes.len(), vectors.ncols());
        for (k, &node) in nodes.iter().enumerate() {
            self.node_unknowns[node].each(|unknown, component, factor| {
                for b in 0..vectors.ncols() {
                    u[(3 * k + component, b)] += factor * vectors[(unknown, b)];
                }
            });
        }
        u
    }
}

/// Assembles a part.
///
/// Clamped nodes and held displacements are removed; the nodes of rigid interfaces follow six unknowns
/// each. A part given by matrices takes those.
///
/// # Errors
/// [`SolidError`] for inverted elements, missing materials, unknown sets, surfaces without a face,
/// meshes in pieces, reduced elements that can move without stiffness, clamps on a line, overlapping rigid surfaces; given matrices that are indefinite, in
/// pieces, held in part, or without the rows that an interface reads.
pub fn assemble(part: &Part, mesh: &Mesh) -> Result<SecondOrder, SolidError> {
    if let Some(given) = &mesh.matrices {
        return super::given::assemble(part, mesh, given);
    }
    let name = &part.name;
    one_piece(name, mesh)?;
    let held = held(part, mesh)?;
    let (surfaces, interfaces): (Vec<_>, Vec<_>) = interface_motions(part, mesh)?.into_iter().unzip();
    let mut numbering = number(part, mesh, &held, &interfaces)?;
    let own = number_own_functions(mesh, &mut numbering);

    let elements: Vec<ElementMatrices> = mesh
        .cells
        .par_iter()
        .map(|cell| {
            let material = part.material.as_ref().or_else(|| cell.material.map(|m| &mesh.materials[m]));
            let material =
                material.ok_or_else(|| SolidError::NoMaterial { part: name.clone(), element: cell.label })?;
            let x: Vec<[f64; 3]> = cell.nodes.iter().map(|&node| mesh.nodes[node]).collect();
            matrices(cell.kind, &x, material.young, material.poisson, material.density).map_err(|determinant| {
                SolidError::InvertedElement { part: name.clone(), element: cell.label, determinant }
            })
        })
        .collect::<Result<_, _>>()?;
    super::hourglass::check(part, mesh, &numbering.nodes, &elements)?;

    let pattern = pattern(mesh, &numbering, &own);
    let (mut stiffness, mut mass) = (SparseBuilder::new(&pattern), SparseBuilder::new(&pattern));
    for ((cell, matrices), &first) in mesh.cells.iter().zip(&elements).zip(&own) {
        let maps: Vec<NodeMap> = function_maps(cell, first, &numbering.nodes).collect();
        for (a, map) in maps.iter().enumerate() {
            for (b, other) in maps.iter().enumerate() {
                let (k, m) = (matrices.stiffness(a, b), matrices.mass(a, b));
                map.each(|i, ci, fi| {
                    other.each(|j, cj, fj| {
                        stiffness.add(i, j, fi * fj * k[ci][cj]);
                        if ci == cj {
                            mass.add(i, j, fi * fj * m);
                        }
                    });
                });
            }
        }
    }
    let body = Body::of(mesh, &elements);
    let all = rigid_motions(mesh, part, &interfaces, &numbering, body.centre);
    let rigid = if held.is_empty() { all } else { all * held.free_motions(mesh, body.centre) };
    let neighbours = group_neighbours(&numbering.groups, &pattern);
    Ok(SecondOrder {
        stiffness: stiffness.finish(),
        mass: mass.finish(),
        rigid,
        centre_of_mass: body.centre,
        total_mass: body.mass,
        inertia: body.inertia,
        interfaces,
        surfaces,
        nodes: mesh.nodes.clone(),
        node_unknowns: numbering.nodes,
        groups: numbering.groups,
        neighbours,
    })
}

/// Gives the functions of elements' own (the mean incompatible mode of each C3D8I) three unknowns each, behind all
/// unknowns of nodes, and returns the first of each cell.
///
/// No other element shares them, so one group an element is enough for the fill-reducing order, which eliminates
/// them first.
fn number_own_functions(mesh: &Mesh, numbering: &mut Numbering) -> Vec<usize> {
    let mut first = Vec::with_capacity(mesh.cells.len());
    for cell in &mesh.cells {
        first.push(numbering.n_dof);
        let end = numbering.n_dof + 3 * own_functions(cell.kind);
        if end > numbering.n_dof {
            numbering.groups.push((numbering.n_dof..end).collect());
        }
        numbering.n_dof = end;
    }
    first
}

/// The unknowns of each displacement function of an element: its nodes, then its own functions, whose unknowns begin
/// at `first`.
fn function_maps<'a>(cell: &'a Cell, first: usize, nodes: &'a [NodeMap]) -> impl Iterator<Item = NodeMap> + 'a {
    let own = (0..own_functions(cell.kind)).map(move |k| NodeMap::Free(first + 3 * k));
    cell.nodes.iter().map(|&node| nodes[node].clone()).chain(own)
}

/// Columns of each row of the assembled matrices, ascending. `own` holds the first unknown of each cell's own functions.
fn pattern(mesh: &Mesh, numbering: &Numbering, own: &[usize]) -> Vec<Vec<usize>> {
    let mut cells_of_node = vec![Vec::new(); mesh.nodes.len()];
    for (c, cell) in mesh.cells.iter().enumerate() {
        for &node in &cell.nodes {
            cells_of_node[node].push(c);
        }
    }
    let columns_of = |cells: &[usize]| {
        let maps = cells.iter().flat_map(|&c| function_maps(&mesh.cells[c], own[c], &numbering.nodes));
        let mut columns: Vec<usize> = maps.flat_map(|map| map.unknowns()).collect();
        columns.sort_unstable();
        columns.dedup();
        columns
    };
    let rows_of_node: Vec<Vec<usize>> = cells_of_node.par_iter().map(|cells| columns_of(cells)).collect();
    let mut pattern = vec![Vec::new(); numbering.n_dof];
    for (map, columns) in numbering.nodes.iter().zip(&rows_of_node) {
        for unknown in map.unknowns() {
            let row: &mut Vec<usize> = &mut pattern[unknown];
            let shared = !row.is_empty();
            row.extend_from_slice(columns);
            if shared {
                row.sort_unstable();
                row.dedup();
            }
        }
    }
    for (c, cell) in mesh.cells.iter().enumerate() {
        let unknowns = own[c]..own[c] + 3 * own_functions(cell.kind);
        pattern[unknowns].fill(columns_of(&[c]));
    }
    pattern
}

/// The groups that each group of unknowns touches, without itself.
pub(super) fn group_neighbours(groups: &[Vec<usize>], pattern: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let mut group_of = vec![0; pattern.len()];
    for (g, unknowns) in groups.iter().enumerate() {
        for &u in unknowns {
            group_of[u] = g;
        }
    }
    let touched = |(g, unknowns): (usize, &Vec<usize>)| {
        let columns = unknowns.iter().flat_map(|&u| &pattern[u]);
        let mut touched: Vec<usize> = columns.map(|&u| group_of[u]).filter(|&h| h != g).collect();
        touched.sort_unstable();
        touched.dedup();
        touched
    };
    groups.iter().enumerate().map(touched).collect()
}

/// Refuses a mesh whose elements do not hang together.
fn one_piece(part: &str, mesh: &Mesh) -> Result<(), SolidError> {
    fn root(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    let mut parent: Vec<usize> = (0..mesh.nodes.len()).collect();
    for cell in &mesh.cells {
        let first = root(&mut parent, cell.nodes[0]);
        for &node in &cell.nodes[1..] {
            let other = root(&mut parent, node);
            parent[other] = first;
        }
    }
    let mut roots: Vec<(usize, u64)> = Vec::new();
    for cell in &mesh.cells {
        let r = root(&mut parent, cell.nodes[0]);
        if !roots.iter().any(|(seen, _)| *seen == r) {
            roots.push((r, cell.label));
        }
    }
    match roots.get(1) {
        None => Ok(()),
        Some(&(_, element)) => Err(SolidError::Pieces { part: part.to_string(), pieces: roots.len(), element }),
    }
}

/// Mass, centre and inertia by the consistent mass matrix.
struct Body {
    mass: f64,
    centre: [f64; 3],
    inertia: Matrix3<f64>,
}

impl Body {
    fn of(mesh: &Mesh, elements: &[ElementMatrices]) -> Self {
        let (mut mass, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for (cell, matrices) in mesh.cells.iter().zip(elements) {
            for (a, &na) in cell.nodes.iter().enumerate() {
                let x = Vector3::from(mesh.nodes[na]);
                for (b, &nb) in cell.nodes.iter().enumerate() {
                    let m = matrices.mass(a, b);
                    mass += m;
                    first += m * x;
                    second += m * x * Vector3::from(mesh.nodes[nb]).transpose();
                }
            }
        }
        let centre: Vector3<f64> = first / mass;
        let central = second - mass * centre * centre.transpose();
        Self { mass, centre: centre.into(), inertia: Matrix3::identity() * central.trace() - central }
    }
}
