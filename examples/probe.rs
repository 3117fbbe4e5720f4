use stiffmap::{machine::*, mesh::*, reduction::*, coupling::*, modal::*, solid};
use std::time::Instant;
fn quick(path: &std::path::Path) -> Mesh {
    let text = std::fs::read_to_string(path).unwrap();
    let mut m = Mesh::default(); let mut mode = 0; let mut set = String::new();
    let mut idx = std::collections::HashMap::new();
    let mut mat = vec![];
    for l in text.lines() {
        if l.starts_with("**") { continue }
        if l.starts_with('*') {
            mode = if l.starts_with("*NODE") {1} else if l.starts_with("*ELEMENT") {2} else if l.starts_with("*NSET") { set = l.split('=').last().unwrap().to_string(); 3 } else if l.starts_with("*ELASTIC") {4} else if l.starts_with("*DENSITY") {5} else {0};
            continue;
        }
        let v: Vec<&str> = l.split(',').map(|s| s.trim()).filter(|s| !s.is_empty()).collect();
        match mode {
            1 => { idx.insert(v[0].parse::<u64>().unwrap(), m.nodes.len()); m.node_labels.push(v[0].parse().unwrap()); m.nodes.push([v[1].parse().unwrap(), v[2].parse().unwrap(), v[3].parse().unwrap()]); }
            2 => m.cells.push(Cell { kind: CellKind::Tet10, label: v[0].parse().unwrap(), nodes: v[1..].iter().map(|s| idx[&s.parse::<u64>().unwrap()]).collect(), material: Some(0) }),
            3 => m.node_sets.entry(set.clone()).or_default().extend(v.iter().map(|s| idx[&s.parse::<u64>().unwrap()])),
            4 | 5 => mat.extend(v.iter().map(|s| s.parse::<f64>().unwrap())),
            _ => {}
        }
    }
    m.materials.push(Material { name: "M".into(), young: mat[0], poisson: mat[1], density: mat[2] });
    m
}
fn main() {
    let dir = std::env::args().nth(1).unwrap_or("machines/vertical_mill".into());
    let method = std::env::args().nth(2).unwrap_or_default();
    let mut machine = read_machine(std::path::Path::new(&dir)).unwrap();
    if method == "free" { machine.analysis.component.method = ReductionMethod::FreeInterface; }
    let t = Instant::now();
    let meshes: Vec<Mesh> = machine.parts.iter().map(|p| quick(&p.mesh)).collect();
    let centroids: Vec<Vec<[f64;3]>> = machine.parts.iter().zip(&meshes).map(|(p, m)| solid::interface_motions(p, m).unwrap().iter().map(|x| x.1.centroid).collect()).collect();
    println!("meshes {:?}", t.elapsed());
    let requests = reduction_requests(&machine, &centroids);
    let cache = Cache::in_folder(format!("/tmp/probe_cache{method}"));
    let mut parts = vec![];
    for (r, m) in requests.iter().zip(&meshes).skip(if method == "spindle" {2} else {0}).take(if method == "column" || method == "spindle" {1} else {9}) {
        let t = Instant::now();
        let c = cache.reduce(r, m, None).unwrap();
        let s = &c.superelement;
        println!("{} n_dof {} -> {} mass {:.2} hit {} modes {:?}..{:?} highest {:.0} Hz, below 2700: {}, {:?}", s.part, s.n_dof, s.n(), s.mass, c.hit, s.component_frequencies.first(), s.component_frequencies.last(), s.eigenvalues.last().unwrap().sqrt()/6.283, s.eigenvalues.iter().filter(|l| **l < (2700.0*6.2832f64).powi(2)).count(), t.elapsed());
        parts.push(c.superelement);
    }
    let reference = [40.581245,42.873021,66.602246,73.724601,89.32758,118.526567,154.51563,169.709197,216.794082,241.256131,333.987138,364.643404,395.484449,424.858848,456.475174,517.204276,544.333631,573.295611,576.440707,576.860152,616.395126,629.617948,652.675558,655.551198,657.452583,669.331125,696.402398,704.980206,707.429755,708.067752];
    // full
    let sbs = SideBySide::new(&machine, &parts).unwrap();
    println!("side by side {}", sbs.n());
    let mut exact = vec![];
    for p in [0.0, -0.1525, -0.3, -0.4475, -0.6] {
        let t = Instant::now();
        let e = stiffmap::linalg::symmetric_eigen(&sbs.coupled_stiffness(p).unwrap()).unwrap();
        let f: Vec<f64> = e.values.iter().map(|l| l.max(0.0).sqrt()/std::f64::consts::TAU).collect();
        if p == 0.0 {
            let worst = reference.iter().zip(&f[1..]).map(|(a,b)| ((b-a)/a).abs()).fold(0.0, f64::max);
            println!("{:?}", reference.iter().zip(&f[1..]).map(|(a,b)| format!("{:.1e}", (b-a)/a)).collect::<Vec<_>>());
            println!("vs full order: {worst:.2e}  f0 {} f1.. {:?} {:?}", f[0], &f[1..4], t.elapsed());
        }
        exact.push((p, f));
    }
    for (band, tol) in [(2700.0,1e-3),(2700.0,3e-3),(2700.0,1e-2),(2200.0,1e-3),(1800.0,3e-4),(1800.0,1e-3),(1800.0,3e-3),(1350.0,1e-3)] {
        let t = Instant::now();
        let model = couple(&machine, &parts, BasisOptions { band, tolerance: tol }).unwrap();
        let tc = t.elapsed();
        let t = Instant::now();
        let mut w30 = 0.0f64; let mut w1800 = 0.0f64;
        for (p, f) in &exact {
            let m = modes_at(&model, &machine.analysis.damping, *p, 150).unwrap();
            for r in 1..31 { w30 = w30.max((m.frequency(r)/f[r]-1.0).abs()); }
            for r in 1..f.iter().filter(|x| **x < 1800.0).count() { w1800 = w1800.max((m.frequency(r)/f[r]-1.0).abs()); }
            let _ = check_count(&model, &m, 31).map_err(|e| println!("{e}"));
        }
        println!("band {band} tol {tol}: n {} couple {tc:?} five solves {:?}: err30 {w30:.2e} err to 1800 Hz {w1800:.2e} highest {:.0}", model.n(), t.elapsed(), model.eigenvalues.max().sqrt()/6.283);
    }
    let _ = Instant::now();
}
