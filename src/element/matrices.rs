//! Stiffness and mass of one element.

use super::incompatible::relief;
use super::quadrature::{
    SolidPoint, brick, tet_degree_1, tet_degree_2, tet_degree_5, tri_degree_1, tri_degree_2, wedge,
};
use super::shape::{MAX_NODES, Shape, physical, shape};
use crate::mesh::CellKind;
use std::sync::OnceLock;

/// Stiffness (N/m) and mass (kg; the same for x, y, z) of one element.
#[derive(Clone, Debug)]
pub struct ElementMatrices {
    nodes: usize,
    stiffness: Vec<[[f64; 3]; 3]>,
    mass: Vec<f64>,
}

impl ElementMatrices {
    /// Nodes of the element.
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// The 3 x 3 block of node pair (a, b), N/m.
    pub fn stiffness(&self, a: usize, b: usize) -> &[[f64; 3]; 3] {
        &self.stiffness[a * self.nodes + b]
    }

    /// Mass of node pair (a, b), kg.
    pub fn mass(&self, a: usize, b: usize) -> f64 {
        self.mass[a * self.nodes + b]
    }
}

/// The shape functions at the points of a rule.
type Tabulated = Vec<(f64, Shape)>;

/// Points for stiffness and for mass. All but the masses of C3D4, C3D6 and C3D10 are those of CalculiX,
/// which takes the stiffness points there too and misses the inertia of the element about itself.
fn rules(kind: CellKind) -> (Vec<SolidPoint>, Vec<SolidPoint>) {
    match kind {
        CellKind::Tet4 => (tet_degree_1(), tet_degree_2()),
        CellKind::Tet10 => (tet_degree_2(), tet_degree_5()),
        CellKind::Hex8 | CellKind::Hex8Incompatible | CellKind::Hex20Reduced => (brick(2), brick(2)),
        CellKind::Hex20 => (brick(3), brick(3)),
        CellKind::Wedge6 => (wedge(&tri_degree_1(), 2), wedge(&tri_degree_2(), 2)),
        CellKind::Wedge15 => (wedge(&tri_degree_2(), 3), wedge(&tri_degree_2(), 3)),
    }
}

/// The rules of a kind with its shape functions, made once.
fn tables(kind: CellKind) -> &'static (Tabulated, Tabulated) {
    static TABLES: [OnceLock<(Tabulated, Tabulated)>; CellKind::ALL.len()] = [const { OnceLock::new() }; 8];
    TABLES[kind as usize].get_or_init(|| {
        let tabulate = |rule: Vec<SolidPoint>| rule.iter().map(|p| (p.weight, shape(kind, p.at))).collect();
        let (stiffness, mass) = rules(kind);
        (tabulate(stiffness), tabulate(mass))
    })
}

/// Stiffness and consistent mass of an isotropic element.
///
/// # Errors
/// The smallest Jacobian determinant (m^3), if it is not positive at a quadrature point: the element
/// is inverted or folded.
///
/// # Source
/// Zienkiewicz and Taylor, The Finite Element Method, vol. 1, ch. 6; rules in [`super::quadrature`].
pub fn matrices(
    kind: CellKind,
    nodes: &[[f64; 3]],
    young: f64,
    poisson: f64,
    density: f64,
) -> Result<ElementMatrices, f64> {
    let n = kind.node_count();
    assert_eq!(nodes.len(), n, "nodes of a {}", kind.name());
    let lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let shear = young / (2.0 * (1.0 + poisson));
    let (stiffness_rule, mass_rule) = tables(kind);
    let mut out = ElementMatrices { nodes: n, stiffness: vec![[[0.0; 3]; 3]; n * n], mass: vec![0.0; n * n] };
    let mut smallest = f64::INFINITY;
    for (weight, shape) in stiffness_rule {
        let (g, det) = physical(nodes, shape);
        smallest = smallest.min(det);
        add_stiffness(&mut out, &g, weight * det, lame, shear);
    }
    for (weight, shape) in mass_rule {
        let (_, det) = physical(nodes, shape);
        smallest = smallest.min(det);
        let w = weight * det * density;
        for (a, row) in out.mass.chunks_exact_mut(n).enumerate() {
            for (m, value) in row.iter_mut().zip(&shape.values) {
                *m += w * shape.values[a] * value;
            }
        }
    }
    if smallest.is_nan() || smallest <= 0.0 {
        return Err(smallest);
    }
    if kind == CellKind::Hex8Incompatible {
        let relief = relief(nodes, lame, shear).ok_or(smallest)?;
        for (k, block) in out.stiffness.iter_mut().enumerate() {
            let (a, b) = (k / n, k % n);
            for (i, row) in block.iter_mut().enumerate() {
                for (j, value) in row.iter_mut().enumerate() {
                    *value -= relief[(3 * a + i, 3 * b + j)];
                }
            }
        }
    }
    Ok(out)
}

/// Adds one point of the stiffness integral.
fn add_stiffness(out: &mut ElementMatrices, g: &[[f64; 3]; MAX_NODES], w: f64, lame: f64, shear: f64) {
    let n = out.nodes;
    for a in 0..n {
        for b in 0..n {
            let dot = g[a][0] * g[b][0] + g[a][1] * g[b][1] + g[a][2] * g[b][2];
            let block = &mut out.stiffness[a * n + b];
            for i in 0..3 {
                for j in 0..3 {
                    block[i][j] += w * (lame * g[a][i] * g[b][j] + shear * g[a][j] * g[b][i]);
                }
                block[i][i] += w * shear * dot;
            }
        }
    }
}
