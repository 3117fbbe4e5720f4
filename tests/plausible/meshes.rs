//! Meshes of a small horizontal mill as .inp files in millimetres: a bed with two rails, a slide on four pads, a tube
//! with a bore on it, and a hollow spindle in the bore.

use std::fmt::Write as _;

/// A node set: its name, and whether a node (mm) is in it.
type Set<'a> = (&'a str, &'a dyn Fn([f64; 3]) -> bool);

/// Nodes and bricks.
struct Mesh {
    nodes: Vec<[f64; 3]>,
    bricks: Vec<[usize; 8]>,
}

impl Mesh {
    /// A box from `low`, with as many bricks of a size along each axis.
    fn block(low: [f64; 3], size: [f64; 3], cells: [usize; 3]) -> Self {
        let place = |i: usize, j: usize, k: usize| {
            let step = [i, j, k];
            std::array::from_fn(|c| low[c] + size[c] * step[c] as f64 / cells[c] as f64)
        };
        let [nx, ny, nz] = cells;
        let index = |i: usize, j: usize, k: usize| (k * (ny + 1) + j) * (nx + 1) + i;
        let mut mesh = Mesh { nodes: Vec::new(), bricks: Vec::new() };
        for (k, j) in (0..=nz).flat_map(|k| (0..=ny).map(move |j| (k, j))) {
            mesh.nodes.extend((0..=nx).map(|i| place(i, j, k)));
        }
        for (k, j) in (0..nz).flat_map(|k| (0..ny).map(move |j| (k, j))) {
            for i in 0..nx {
                let ring = |k| [index(i, j, k), index(i + 1, j, k), index(i + 1, j + 1, k), index(i, j + 1, k)];
                let ([a, b, c, d], [e, f, g, h]) = (ring(k), ring(k + 1));
                mesh.bricks.push([a, b, c, d, e, f, g, h]);
            }
        }
        mesh
    }

    /// A tube about the line through `centre` along y, from `from` to `to`, of 16 sides and `cells` bricks along it.
    fn tube(centre: [f64; 2], radii: [f64; 2], [from, to]: [f64; 2], cells: usize) -> Self {
        const SIDES: usize = 16;
        let mut mesh = Mesh { nodes: Vec::new(), bricks: Vec::new() };
        for k in 0..=cells {
            let y = from + (to - from) * k as f64 / cells as f64;
            for (s, r) in (0..SIDES).flat_map(|s| radii.map(|r| (s, r))) {
                let turn = std::f64::consts::TAU * s as f64 / SIDES as f64;
                mesh.nodes.push([centre[0] + r * turn.cos(), y, centre[1] + r * turn.sin()]);
            }
        }
        let index = |k: usize, s: usize, r: usize| (k * SIDES + s % SIDES) * 2 + r;
        for (k, s) in (0..cells).flat_map(|k| (0..SIDES).map(move |s| (k, s))) {
            // Seen along -y the face goes inner, outer, outer, inner, so that the element is not inverted.
            let ring = |k| [index(k, s, 0), index(k, s + 1, 0), index(k, s + 1, 1), index(k, s, 1)];
            let ([a, b, c, d], [e, f, g, h]) = (ring(k), ring(k + 1));
            mesh.bricks.push([a, b, c, d, e, f, g, h]);
        }
        mesh
    }

    /// The file, with the nodes for which each predicate holds as sets.
    fn text(&self, sets: &[Set<'_>]) -> String {
        let mut out = String::from("*NODE\n");
        for (i, [x, y, z]) in self.nodes.iter().enumerate() {
            writeln!(out, "{}, {x:.6}, {y:.6}, {z:.6}", i + 1).unwrap();
        }
        out += "*ELEMENT, TYPE=C3D8I, ELSET=ALL\n";
        for (i, brick) in self.bricks.iter().enumerate() {
            let nodes = brick.map(|n| (n + 1).to_string()).join(", ");
            writeln!(out, "{}, {nodes}", i + 1).unwrap();
        }
        for (name, holds) in sets {
            let inside = self.nodes.iter().enumerate().filter(|(_, x)| holds(**x)).map(|(i, _)| (i + 1).to_string());
            let lines: Vec<String> = inside.collect();
            assert!(!lines.is_empty(), "the set {name} is empty");
            writeln!(out, "*NSET, NSET={name}\n{}", lines.join(",\n")).unwrap();
        }
        out
    }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-3
}

/// Distance from the line through (x, z) along y.
fn radius(p: [f64; 3], [x, z]: [f64; 2]) -> f64 {
    (p[0] - x).hypot(p[2] - z)
}

/// File names and contents.
pub fn files() -> Vec<(&'static str, String)> {
    let bed = Mesh::block([0.0; 3], [1000.0, 400.0, 100.0], [20, 4, 1]).text(&[
        ("FEET", &|p| near(p[2], 0.0)),
        ("RAIL_L", &|p| near(p[2], 100.0) && p[1] < 101.0),
        ("RAIL_R", &|p| near(p[2], 100.0) && p[1] > 299.0),
        ("MOUNT", &|p| near(p[0], 0.0)),
    ]);
    let pad = |p: [f64; 3], low: f64, left: bool| {
        near(p[2], 120.0)
            && (low - 1.0..low + 101.0).contains(&p[0])
            && (if left { p[1] < 101.0 } else { p[1] > 299.0 })
    };
    let slide = Mesh::block([200.0, 0.0, 120.0], [300.0, 400.0, 50.0], [3, 4, 1]).text(&[
        ("PAD_A", &|p| pad(p, 200.0, true)),
        ("PAD_B", &|p| pad(p, 200.0, false)),
        ("PAD_C", &|p| pad(p, 400.0, true)),
        ("PAD_D", &|p| pad(p, 400.0, false)),
        ("NUT", &|p| near(p[0], 200.0)),
        ("TOP", &|p| near(p[2], 170.0)),
    ]);
    let centre = [350.0, 250.0];
    let head = Mesh::tube(centre, [40.0, 80.0], [50.0, 250.0], 8).text(&[
        ("BORE", &|p| near(radius(p, centre), 40.0)),
        ("FOOT", &|p| near(radius(p, centre), 80.0) && p[2] < 220.0),
    ]);
    let spindle = Mesh::tube(centre, [10.0, 35.0], [0.0, 300.0], 12)
        .text(&[("JOURNAL", &|p| near(radius(p, centre), 35.0)), ("NOSE", &|p| near(p[1], 0.0))]);
    vec![("bed.inp", bed), ("slide.inp", slide), ("head.inp", head), ("spindle.inp", spindle)]
}
