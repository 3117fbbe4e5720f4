//! scratch
use super::modes;
use super::database::{PAPER, by_matched_modes, stations};
use nalgebra::DMatrix;
use rayon::prelude::*;
use stiffmap::linalg::*;
use stiffmap::modal::Modes;
use stiffmap::state_space::*;

fn interp(db: &Database, position: f64, points: usize) -> StateSpace {
    let mut near: Vec<usize> = (0..db.aligned.len()).collect();
    near.sort_by(|a, b| (db.aligned[*a].position - position).abs().total_cmp(&(db.aligned[*b].position - position).abs()));
    near.truncate(points);
    let at = |k: usize| db.aligned[k].position;
    let w: Vec<f64> = near.iter().map(|&k| near.iter().filter(|o| **o != k).map(|&o| (position - at(o)) / (at(k) - at(o))).product()).collect();
    let blend = |of: fn(&Aligned) -> &DMatrix<f64>| near.iter().zip(&w).map(|(&k, w)| of(&db.aligned[k]) * *w).reduce(|a, b| a + b).unwrap();
    let k = blend(|a| &a.stiffness);
    let e = symmetric_eigen(&(0.5 * (&k + k.transpose()))).unwrap();
    let n = e.values.len();
    let outputs = blend(|a| &a.outputs) * &e.vectors;
    let inputs = blend(|a| &a.inputs).transpose() * &e.vectors;
    let mut direct = blend(|a| &a.compliance);
    for r in 0..n { direct -= outputs.column(r) * inputs.column(r).transpose() / e.values[r]; }
    let m = Modes { position, free: 0, eigenvalues: e.values.iter().copied().collect(), damping_ratios: vec![0.02; n], loss_factors: vec![0.0; n], shapes: e.vectors, outputs, inputs, direct };
    state_space(&m, PAPER)
}

#[test]
fn scratch_scan() {
    let window = stations(0.0, -0.6);
    let db = Database::new(&window, PAPER).unwrap();
    println!("carried {} worst loo {:?}", db.aligned[0].stiffness.nrows(), db.worst_leave_one_out());
    let rows: Vec<String> = (0..120usize).into_par_iter().map(|k| {
        let p = -0.005 * k as f64 - 0.002;
        let exact = state_space(&modes(p), PAPER);
        let e = [4, 6, 8].map(|n| receptance_difference(&interp(&db, p, n), &exact));
        let from = (k.max(1) - 1).min(window.len() - 4);
        let from6 = (k.max(2) - 2).min(window.len() - 6);
        let m4 = receptance_difference(&by_matched_modes(&window[from..from + 4], p), &exact);
        let m6 = receptance_difference(&by_matched_modes(&window[from6..from6 + 6], p), &exact);
        let m2 = receptance_difference(&by_matched_modes(&window[k..k + 2], p), &exact);
        format!("{p:.4} sub4 {:.1e} sub6 {:.1e} sub8 {:.1e} mac2 {m2:.1e} mac4 {m4:.1e} mac6 {m6:.1e} loo {:?}", e[0], e[1], e[2], db.leave_one_out[k])
    }).collect();
    println!("{}", rows.join("\n"));
}
