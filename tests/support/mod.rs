//! Meshes, parts and dense references made in code, for the tests of the physics.
#![allow(dead_code, reason = "each test binary uses its own part")]

pub mod dense;
pub mod direct;
pub mod grids;
pub mod slide;
pub mod tets;

use std::fmt::Write as _;
use std::path::PathBuf;
use stiffmap::machine::{
    ComponentAnalysis, Interface, Material, MeshUnits, Part, Placement, ReductionMethod, Region, SurfaceCoupling,
};
use stiffmap::mesh::{Cell, CellKind, Mesh};
use stiffmap::reduction::{ReductionRequest, Superelement, reduce};

/// Steel: 210 GPa, 0.3, 7850 kg/m^3.
pub fn steel() -> Material {
    Material { name: "steel".into(), young: 210e9, poisson: 0.3, density: 7850.0 }
}

/// A mesh of ten-node tetrahedra as the text of an Abaqus input file, its set ALL of the elements; `material` is what
/// follows.
pub fn inp(mesh: &Mesh, material: &str) -> String {
    let mut text = String::from("*NODE\n");
    for (label, [x, y, z]) in mesh.node_labels.iter().zip(&mesh.nodes) {
        writeln!(text, "{label}, {x}, {y}, {z}").expect("text");
    }
    text += "*ELEMENT, TYPE=C3D10, ELSET=ALL\n";
    for cell in &mesh.cells {
        let nodes: Vec<String> = cell.nodes.iter().map(|n| mesh.node_labels[*n].to_string()).collect();
        writeln!(text, "{}, {}", cell.label, nodes.join(", ")).expect("text");
    }
    for (name, nodes) in &mesh.node_sets {
        let nodes: Vec<String> = nodes.iter().map(|n| mesh.node_labels[*n].to_string()).collect();
        writeln!(text, "*NSET, NSET={name}\n{}", nodes.join(",\n")).expect("text");
    }
    text + material
}

/// The corner pair of each midside node, written here from the Abaqus manual, not from the crate.
pub const SIDES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// A box from `from` over `size` (m), each of its cells split into six ten-node tetrahedra (Kuhn).
///
/// Its faces are the node sets XMIN, XMAX, YMIN, YMAX, ZMIN, ZMAX. Node (i, j, k) of the lattice of
/// half cells has the index i + (2 nx + 1) (j + (2 ny + 1) k).
pub fn box_mesh(from: [f64; 3], size: [f64; 3], cells: [usize; 3]) -> Mesh {
    let lattice = cells.map(|n| 2 * n + 1);
    let index = |p: [usize; 3]| p[0] + lattice[0] * (p[1] + lattice[1] * p[2]);
    let mut mesh = Mesh { materials: vec![steel()], ..Mesh::default() };
    for node in 0..lattice.iter().product() {
        let at = lattice_point(node, lattice);
        mesh.nodes.push(std::array::from_fn(|c| from[c] + size[c] * at[c] as f64 / (lattice[c] - 1) as f64));
        mesh.node_labels.push(node as u64 + 1);
        for c in 0..3 {
            let ends = [("MIN", 0), ("MAX", lattice[c] - 1)];
            for (end, _) in ends.iter().filter(|(_, place)| at[c] == *place) {
                let name = format!("{}{end}", ["X", "Y", "Z"][c]);
                mesh.node_sets.entry(name).or_default().push(node);
            }
        }
    }
    for cell in 0..cells.iter().product() {
        let corner = lattice_point(cell, cells);
        for (a, b) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
            let mut corners = [corner.map(|i| 2 * i); 4];
            for (k, v) in corners.iter_mut().enumerate().skip(1) {
                v[a] += 2;
                v[b] += if k > 1 { 2 } else { 0 };
                v[3 - a - b] += if k > 2 { 2 } else { 0 };
            }
            if (b + 3 - a) % 3 != 1 {
                corners.swap(1, 2);
            }
            let middle = |[a, b]: [usize; 2]| std::array::from_fn(|c| (corners[a][c] + corners[b][c]) / 2);
            let nodes = corners.into_iter().chain(SIDES.map(middle));
            mesh.cells.push(Cell {
                kind: CellKind::Tet10,
                label: mesh.cells.len() as u64 + 1,
                nodes: nodes.map(index).collect(),
                material: Some(0),
            });
        }
    }
    mesh
}

fn lattice_point(index: usize, lattice: [usize; 3]) -> [usize; 3] {
    let [nx, ny, _] = lattice;
    [index % nx, index / nx % ny, index / (nx * ny)]
}

/// Moves the corner nodes inside the mesh by up to `amplitude` (m) and keeps its sides straight.
pub fn distort_inside(mesh: &mut Mesh, amplitude: f64) {
    let outside: std::collections::BTreeSet<usize> = mesh.node_sets.values().flatten().copied().collect();
    let corners: std::collections::BTreeSet<usize> = mesh.cells.iter().flat_map(|c| c.nodes[..4].to_vec()).collect();
    for &node in corners.difference(&outside) {
        for c in 0..3 {
            mesh.nodes[node][c] += amplitude * (12.9898 * (3 * node + c) as f64 + 1.0).sin();
        }
    }
    for cell in &mesh.cells {
        for (k, [a, b]) in SIDES.into_iter().enumerate() {
            let (xa, xb) = (mesh.nodes[cell.nodes[a]], mesh.nodes[cell.nodes[b]]);
            mesh.nodes[cell.nodes[4 + k]] = std::array::from_fn(|c| 0.5 * (xa[c] + xb[c]));
        }
    }
}

/// A part with the mesh's own material.
pub fn part(name: &str, clamped: &[&str], interfaces: Vec<Interface>) -> Part {
    Part {
        name: name.into(),
        mesh: PathBuf::from(format!("{name}.inp")),
        material: None,
        clamped: clamped.iter().map(|s| s.to_string()).collect(),
        interfaces,
        loss_factor: None,
        mesh_units: MeshUnits::METRE_KILOGRAM_SECOND,
        matrices: None,
        supported: Vec::new(),
        plain_bricks: false,
        placement: Placement::IDENTITY,
    }
}

/// A distributing interface on the whole of a node set; it has the set's name.
pub fn on(set: &str) -> Interface {
    Interface { name: set.into(), nodes: set.into(), within: None, coupling: SurfaceCoupling::Distributing }
}

/// A slab of space across an axis.
pub fn slab(axis: usize, from: f64, to: f64) -> Region {
    let mut region = Region { min: [f64::NEG_INFINITY; 3], max: [f64::INFINITY; 3] };
    region.min[axis] = from;
    region.max[axis] = to;
    region
}

/// Craig-Bampton with second moments.
pub fn craig_bampton(modes: usize) -> ComponentAnalysis {
    ComponentAnalysis {
        modes,
        follows: false,
        band: f64::INFINITY,
        method: ReductionMethod::CraigBampton,
        second_moment: true,
    }
}

/// Free interface with second moments.
pub fn free_interface(modes: usize) -> ComponentAnalysis {
    ComponentAnalysis { method: ReductionMethod::FreeInterface, ..craig_bampton(modes) }
}

/// The superelement of a part without rails.
pub fn superelement(part: &Part, mesh: &Mesh, component: ComponentAnalysis) -> Superelement {
    let request = ReductionRequest { part: part.clone(), component, reach: 0.0, rails: Vec::new() };
    reduce(&request, mesh, None).expect("the part can be reduced")
}

/// Largest |a / b - 1| over pairs.
pub fn worst_ratio(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
}

/// A clamped post of 600 unknowns with a free arm of 243 beside its head.
pub fn post_and_arm() -> (Vec<Part>, Vec<Mesh>) {
    let post = box_mesh([0.0; 3], [0.08, 0.1, 0.4], [2, 2, 4]);
    let arm = box_mesh([0.1, 0.0, 0.3], [0.3, 0.1, 0.1], [4, 1, 1]);
    let parts =
        vec![part("post", &["ZMIN"], vec![on("XMAX"), on("ZMAX")]), part("arm", &[], vec![on("XMIN"), on("XMAX")])];
    (parts, vec![post, arm])
}
