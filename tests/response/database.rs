//! Selection and interpolation of a database.

use super::{all_stations, mill, modes, names, python};
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::sync::OnceLock;
use stiffmap::export::mat;
use stiffmap::linalg::symmetric_eigen;
use stiffmap::modal::Modes;
use stiffmap::state_space::{Database, StateSpace, StateSpaceOptions, receptance, receptance_difference, state_space};

const PAPER: StateSpaceOptions = StateSpaceOptions { modes: 30, velocity: false, acceleration: false, residual: true };

/// The database of the whole travel.
fn database() -> &'static Database {
    static DATABASE: OnceLock<Database> = OnceLock::new();
    all_stations();
    DATABASE.get_or_init(|| Database::new(all_stations(), PAPER).unwrap())
}

/// The stations from one position down to another.
fn stations(from: f64, to: f64) -> Vec<Modes> {
    all_stations().iter().filter(|m| m.position <= from + 1e-9 && m.position >= to - 1e-9).cloned().collect()
}

/// The usual way: modes matched by their MAC from station to station, frequency, damping and shape interpolated one by
/// one over the stations that are given.
fn by_matched_modes(near: &[Modes], position: f64) -> StateSpace {
    let n = 30;
    let first = &near[0];
    let mut chains: Vec<Vec<(usize, f64)>> = (0..n).map(|r| vec![(first.free + r, 1.0)]).collect();
    for pair in near.windows(2) {
        let mut taken = vec![false; pair[1].eigenvalues.len()];
        for chain in &mut chains {
            let (r, sign) = chain[chain.len() - 1];
            let dot = |s: usize| pair[0].shapes.column(r).dot(&pair[1].shapes.column(s));
            let free = (pair[1].free..pair[1].free + n + 10).filter(|s| !taken[*s]);
            let best = free.max_by(|a, b| dot(*a).abs().total_cmp(&dot(*b).abs())).unwrap();
            taken[best] = true;
            chain.push((best, sign * dot(best).signum()));
        }
    }
    let at = |k: usize| near[k].position;
    let points = near.len();
    let weight =
        |k: usize| (0..points).filter(|o| *o != k).map(|o| (position - at(o)) / (at(k) - at(o))).product::<f64>();
    let mut out = Modes { position, free: 0, ..near[0].clone() };
    let blend = |of: &dyn Fn(&Modes, usize, f64) -> f64, chain: &[(usize, f64)]| -> f64 {
        chain.iter().enumerate().map(|(k, (r, sign))| weight(k) * of(&near[k], *r, *sign)).sum()
    };
    out.eigenvalues = chains.iter().map(|c| blend(&|m, r, _| m.eigenvalues[r].sqrt(), c).powi(2)).collect();
    out.damping_ratios = chains.iter().map(|c| blend(&|m, r, _| m.damping_ratios[r], c)).collect();
    out.loss_factors = vec![0.0; n];
    out.outputs = DMatrix::from_fn(3, n, |i, c| blend(&|m, r, s| s * m.outputs[(i, r)], &chains[c]));
    out.inputs = DMatrix::from_fn(3, n, |i, c| blend(&|m, r, s| s * m.inputs[(i, r)], &chains[c]));
    out.shapes = DMatrix::identity(n, n);
    // The compliance at 0 Hz as the subspaces have it: of all modes, interpolated, less that of the thirty.
    let whole = |m: &Modes| {
        let elastic = m.free..m.eigenvalues.len();
        let one = |r: usize| m.outputs.column(r) * m.inputs.column(r).transpose() / m.eigenvalues[r];
        elastic.fold(m.direct.clone(), |sum, r| sum + one(r))
    };
    out.direct = (0..points).map(|k| whole(&near[k]) * weight(k)).sum();
    for r in 0..n {
        out.direct -= out.outputs.column(r) * out.inputs.column(r).transpose() / out.eigenvalues[r];
    }
    state_space(&out, PAPER)
}

#[test]
fn subspaces_are_five_times_better_than_matched_modes_and_the_fixed_basis_is_exact() {
    // Over the travel; among them veerings, the carriage that begins to leave its rail at -0.55 m, and the last interval.
    let places = [
        -0.0023, -0.0577, -0.1131, -0.1475, -0.1869, -0.2222, -0.2618, -0.3025, -0.3379, -0.3831, -0.4268, -0.4625,
        -0.5029, -0.5422, -0.547, -0.552, -0.5577, -0.5731, -0.5869, -0.5972,
    ];
    // Made before the parallel loop: a task that waits for it could hold the thread that makes it.
    database();
    let rows: Vec<[f64; 4]> = places
        .par_iter()
        .map(|&position| {
            let exact = state_space(&modes(position), PAPER);
            let interval = (-position / 0.005).floor() as usize;
            let matched = |points: usize| {
                let from = (interval + 1).saturating_sub(points / 2).min(121 - points);
                receptance_difference(&by_matched_modes(&all_stations()[from..from + points], position), &exact)
            };
            [
                receptance_difference(&exact, &side_by_side(position)),
                receptance_difference(&database().interpolate(position).unwrap(), &exact),
                matched(2),
                matched(8),
            ]
        })
        .collect();
    println!("position m   fixed basis   subspaces   matched modes, 2 stations   8 stations");
    for (p, r) in places.iter().zip(&rows) {
        println!("{p:10.4}   {:11.1e}   {:9.1e}   {:25.1e}   {:10.1e}", r[0], r[1], r[2], r[3]);
    }
    let largest: [f64; 4] = std::array::from_fn(|i| rows.iter().map(|r| r[i]).fold(0.0, f64::max));
    println!("largest      {:11.1e}   {:9.1e}   {:25.1e}   {:10.1e}", largest[0], largest[1], largest[2], largest[3]);
    assert!(largest[0] < 1e-6, "{:.1e}", largest[0]);
    assert!(largest[1] < 5e-4, "{:.1e}", largest[1]);
    assert!(largest[2].min(largest[3]) > 5.0 * largest[1], "{largest:?}");
}

/// The state space of the superelements side by side, without any fixed basis.
fn side_by_side(position: f64) -> StateSpace {
    let machine = &mill().model.side_by_side;
    let eigen = symmetric_eigen(&machine.coupled_stiffness(position).unwrap()).unwrap();
    let ports = DMatrix::from_rows(&machine.outputs.iter().map(|p| p.row.clone()).collect::<Vec<_>>());
    let outputs = ports * &eigen.vectors;
    let n = eigen.values.len();
    let modes = Modes {
        position,
        free: 1,
        eigenvalues: eigen.values.iter().enumerate().map(|(r, l)| if r == 0 { 0.0 } else { *l }).collect(),
        damping_ratios: (0..n).map(|r| if r == 0 { 0.0 } else { 0.02 }).collect(),
        loss_factors: vec![0.0; n],
        inputs: outputs.clone(),
        outputs,
        direct: DMatrix::zeros(3, 3),
        dissipation: None,
        direct_loss_factor: 0.0,
        shapes: eigen.vectors,
    };
    state_space(&modes, PAPER)
}

#[test]
fn the_ceiling_rule_takes_the_next_station_and_refuses_what_is_outside() {
    let database = Database::new(&stations(0.0, -0.02), PAPER).unwrap();
    let select = |p: f64| database.select(p).unwrap().position;
    assert_eq!([select(0.0), select(-0.0001), select(-0.005), select(-0.0051)], [0.0, -0.005, -0.005, -0.01]);
    assert_eq!(select(-0.02), -0.02);
    let error = database.select(-0.021).unwrap_err().to_string();
    assert!(error.contains("-0.021 m lies outside the database, which covers 0 to -0.02 m"), "{error}");
    assert!(database.interpolate(f64::NAN).is_err());
    let twice = [modes(0.0), modes(-0.01), modes(-0.005)];
    assert!(Database::new(&twice, PAPER).unwrap_err().to_string().contains("all ascend or all descend"));
    assert!(Database::new(&[], PAPER).is_err());
}

#[test]
fn one_position_is_a_database_too() {
    let one = Database::new(&[modes(-0.3)], PAPER).unwrap();
    assert_eq!(one.leave_one_out, [None]);
    let found = one.interpolate(-0.3).unwrap();
    assert!(receptance_difference(&found, &one.states[0]) < 1e-9);
    assert_eq!(one.select(-0.3).unwrap().position, -0.3);
}

#[test]
fn the_leave_one_out_figure_bounds_the_error_between_the_stations() {
    let database = database();
    assert_eq!(database.leave_one_out.iter().flatten().count(), 119);
    assert!(database.leave_one_out[0].is_none() && database.leave_one_out[120].is_none());
    let stored = database.leave_one_out[60..70].iter().flatten().copied().fold(0.0, f64::max);
    let between = [-0.3125, -0.3225, -0.3275]
        .map(|p| receptance_difference(&database.interpolate(p).unwrap(), &state_space(&modes(p), PAPER)));
    let worst = between.into_iter().fold(0.0, f64::max);
    println!("leave one out {stored:.1e}, between the stations {worst:.1e}");
    assert!(worst < stored && stored < 1e-2, "{worst:.1e} {stored:.1e}");
}

#[test]
fn through_a_veering_the_interpolated_response_is_smooth() {
    // The thirtieth and thirty-first modes meet at 708 Hz between -0.25 and -0.3 m: second differences there.
    let rough = |system: &dyn Fn(f64) -> StateSpace| {
        let response = |k: i32| receptance(&system(-0.2851 - 0.0002 * f64::from(k)), 707.5)[(0, 0)];
        let values: Vec<_> = (0..100).map(response).collect();
        let size = values.iter().map(|v| v.norm()).fold(0.0, f64::max);
        values.windows(3).map(|w| (w[2] - w[1] * 2.0 + w[0]).norm()).fold(0.0, f64::max) / size
    };
    let subspaces = rough(&|p| database().interpolate(p).unwrap());
    let matched = rough(&|p| {
        let from = (-p / 0.005).floor() as usize - 1;
        by_matched_modes(&all_stations()[from..from + 4], p)
    });
    let stepped = rough(&|p| database().select(p).unwrap().clone());
    println!("second differences: subspaces {subspaces:.1e}, matched modes {matched:.1e}, ceiling rule {stepped:.1e}");
    assert!(subspaces < 1e-4, "{subspaces:.1e}");
    assert!(matched > 3.0 * subspaces && stepped > 3.0 * subspaces, "control: {matched:.1e}, {stepped:.1e}");
}

#[test]
fn the_file_alone_interpolates_in_python() {
    let folder = tempfile::tempdir().unwrap();
    let database = Database::new(&stations(-0.28, -0.36), PAPER).unwrap();
    let file = folder.path().join("state_space.mat");
    mat::write_database(&file, &database, &names(), &names(), None).unwrap();
    // What the aligned matrices carry: the modes asked for and some more.
    let carried = StateSpaceOptions { modes: database.aligned[0].stiffness.nrows(), ..PAPER };
    let exact = |p: f64| {
        let path = folder.path().join("exact.mat");
        mat::write_state_space(
            &path,
            &[StateSpace { position: -0.3175, ..state_space(&modes(p), carried) }],
            &names(),
            &names(),
        )
        .unwrap();
        path
    };
    let Some(figure) = python("aligned", &[&file, &exact(-0.3175)]) else { return };
    println!("python, file alone: {figure:.1e}");
    assert!(figure < 5e-4, "{figure:.1e}");
    assert!(python("aligned", &[&file, &exact(-0.32)]).unwrap() > 5e-4, "control: half a station away");
}

#[test]
fn stations_too_far_apart_leave_a_database_that_says_so() {
    // One mode, five metres of it: the polynomial through the others is negative at the second station.
    let one = |k: usize| Modes {
        position: k as f64,
        eigenvalues: vec![if k == 3 { 1e6 } else { 1e4 }],
        free: 0,
        damping_ratios: vec![0.02],
        loss_factors: vec![0.0],
        dissipation: None,
        shapes: DMatrix::identity(1, 1),
        outputs: DMatrix::identity(1, 1),
        inputs: DMatrix::identity(1, 1),
        direct: DMatrix::zeros(1, 1),
        direct_loss_factor: 0.0,
    };
    let modes: Vec<Modes> = (0..5).map(one).collect();
    let options = StateSpaceOptions { modes: 1, velocity: false, acceleration: false, residual: true };
    let database = Database::new(&modes, options).unwrap();
    assert_eq!(database.leave_one_out[1], Some(f64::INFINITY));
    assert_eq!((database.leave_one_out[0], database.leave_one_out[4]), (None, None));
    assert_eq!(database.worst_leave_one_out(), Some(f64::INFINITY));
    let folder = tempfile::tempdir().unwrap();
    let ports = ["x".to_owned()];
    mat::write_database(&folder.path().join("state_space.mat"), &database, &ports, &ports, None).unwrap();
    let smooth: Vec<Modes> = modes.iter().map(|m| Modes { eigenvalues: vec![1e4], ..m.clone() }).collect();
    let finite = Database::new(&smooth, options).unwrap().worst_leave_one_out().unwrap();
    assert!(finite < 1e-9, "control: a machine that does not change, {finite:e}");
}
