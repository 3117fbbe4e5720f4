//! Stiffness and mass of one element.

use super::incompatible::{self, Centre};
use super::quadrature::{
    SolidPoint, brick, tet_degree_1, tet_degree_2, tet_degree_5, tri_degree_1, tri_degree_2, wedge,
};
use super::shape::{Shape, physical, shape};
use crate::mesh::CellKind;
use std::sync::OnceLock;

/// Stiffness (N/m) and mass (kg; the same for x, y, z) of one element.
///
/// Rows go over its displacement functions: one a node, and behind them one of the element's own where it has any, the
/// mean incompatible mode of C3D8I. Each has three components, x, y and z.
#[derive(Clone, Debug)]
pub struct ElementMatrices {
    nodes: usize,
    functions: usize,
    stiffness: Vec<[[f64; 3]; 3]>,
    mass: Vec<f64>,
}

impl ElementMatrices {
    /// Nodes of the element.
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// Displacement functions: the nodes, and the mean incompatible mode of C3D8I behind them.
    pub fn functions(&self) -> usize {
        self.functions
    }

    /// The 3 x 3 block of the pair of functions (a, b), N/m.
    pub fn stiffness(&self, a: usize, b: usize) -> &[[f64; 3]; 3] {
        &self.stiffness[a * self.functions + b]
    }

    /// Mass of the pair of functions (a, b), kg.
    pub fn mass(&self, a: usize, b: usize) -> f64 {
        self.mass[a * self.functions + b]
    }
}

/// The points of a rule with the shape functions there; behind the nodes' the value of the element's own function.
type Tabulated = Vec<(SolidPoint, Shape)>;

/// Functions beside those of the nodes.
pub(super) fn own_functions(kind: CellKind) -> usize {
    usize::from(kind == CellKind::Hex8Incompatible)
}

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
        let at_point = |point: SolidPoint| {
            let mut shape = shape(kind, point.at);
            if own_functions(kind) > 0 {
                shape.values[kind.node_count()] = incompatible::mean_value(point.at);
            }
            (point, shape)
        };
        let tabulate = |rule: Vec<SolidPoint>| rule.into_iter().map(at_point).collect();
        let (stiffness, mass) = rules(kind);
        (tabulate(stiffness), tabulate(mass))
    })
}

/// Stiffness and consistent mass of an isotropic element, the mean incompatible mode of C3D8I as a row of its own.
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
    let nodal = kind.node_count();
    assert_eq!(nodes.len(), nodal, "nodes of a {}", kind.name());
    let n = nodal + own_functions(kind);
    let lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let shear = young / (2.0 * (1.0 + poisson));
    let (stiffness_rule, mass_rule) = tables(kind);
    let centre = (n > nodal).then(|| Centre::of(nodes));
    let stiff = if n > nodal { incompatible::FUNCTIONS } else { n };
    let mut stiffness = vec![[[0.0; 3]; 3]; stiff * stiff];
    let mut mass = vec![0.0; n * n];
    let mut smallest = centre.as_ref().map_or(f64::INFINITY, Centre::det);
    for (point, shape) in stiffness_rule {
        let (mut g, det) = physical(nodes, shape);
        smallest = smallest.min(det);
        if let Some(centre) = &centre {
            g[nodal..stiff].copy_from_slice(&centre.gradients(point.at, det));
        }
        add_stiffness(&mut stiffness, &g[..stiff], point.weight * det, lame, shear);
    }
    for (point, shape) in mass_rule {
        let (_, det) = physical(nodes, shape);
        smallest = smallest.min(det);
        let w = point.weight * det * density;
        for (a, row) in mass.chunks_exact_mut(n).enumerate() {
            for (m, value) in row.iter_mut().zip(&shape.values) {
                *m += w * shape.values[a] * value;
            }
        }
    }
    if smallest.is_nan() || smallest <= 0.0 {
        return Err(smallest);
    }
    if centre.is_some() {
        stiffness = incompatible::without_massless(&stiffness).ok_or(smallest)?;
    }
    Ok(ElementMatrices { nodes: nodal, functions: n, stiffness, mass })
}

/// Adds one point of the stiffness integral.
fn add_stiffness(stiffness: &mut [[[f64; 3]; 3]], g: &[[f64; 3]], w: f64, lame: f64, shear: f64) {
    let n = g.len();
    for a in 0..n {
        for b in 0..n {
            let dot = g[a][0] * g[b][0] + g[a][1] * g[b][1] + g[a][2] * g[b][2];
            let block = &mut stiffness[a * n + b];
            for i in 0..3 {
                for j in 0..3 {
                    block[i][j] += w * (lame * g[a][i] * g[b][j] + shear * g[a][j] * g[b][i]);
                }
                block[i][i] += w * shear * dot;
            }
        }
    }
}
