//! Selection and interpolation of a database.

use super::{mill, modes, names, python};
use nalgebra::DMatrix;
use stiffmap::export::mat;
use stiffmap::linalg::symmetric_eigen;
use stiffmap::modal::Modes;
use stiffmap::state_space::{Database, StateSpace, StateSpaceOptions, receptance_difference, state_space};

pub(super) const PAPER: StateSpaceOptions = StateSpaceOptions { modes: 30, velocity: false, acceleration: false, residual: true };

/// Every 5 mm from one position down to another.
pub(super) fn stations(from: f64, to: f64) -> Vec<Modes> {
    let n = ((from - to) / 0.005_f64).round() as usize;
    (0..=n).map(|k| modes(from - 0.005 * k as f64)).collect()
}

/// The usual way: modes matched by their MAC from station to station, frequency, damping and shape interpolated one by
/// one over the same four stations.
pub(super) fn by_matched_modes(four: &[Modes], position: f64) -> StateSpace {
    let n = 30;
    let first = &four[0];
    let mut chains: Vec<Vec<(usize, f64)>> = (0..n).map(|r| vec![(first.free + r, 1.0)]).collect();
    for pair in four.windows(2) {
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
    let at = |k: usize| four[k].position;
    let points = four.len();
    let weight =
        |k: usize| (0..points).filter(|o| *o != k).map(|o| (position - at(o)) / (at(k) - at(o))).product::<f64>();
    let mut out = Modes { position, free: 0, ..four[0].clone() };
    let blend = |of: &dyn Fn(&Modes, usize, f64) -> f64, chain: &[(usize, f64)]| -> f64 {
        chain.iter().enumerate().map(|(k, (r, sign))| weight(k) * of(&four[k], *r, *sign)).sum()
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
    out.direct = (0..points).map(|k| whole(&four[k]) * weight(k)).sum();
    for r in 0..n {
        out.direct -= out.outputs.column(r) * out.inputs.column(r).transpose() / out.eigenvalues[r];
    }
    state_space(&out, PAPER)
}

#[test]
fn subspaces_are_five_times_better_than_matched_modes_and_the_fixed_basis_is_exact() {
    // A window at the top, and one around each place that the tracking reports as a veering.
    println!("position m   fixed basis   subspaces   matched modes");
    let (mut fixed, mut subspace, mut matched) = (0.0f64, 0.0f64, 0.0f64);
    for top in [0.0, -0.14, -0.3, -0.44, -0.57] {
        let window = stations(top, top - 0.03);
        let database = Database::new(&window, PAPER).unwrap();
        for position in [top - 0.0025, top - 0.0131, top - 0.0175, top - 0.0269] {
            let exact = state_space(&modes(position), PAPER);
            let from = ((((top - position) / 0.005).floor() as usize).max(1) - 1).min(window.len() - 4);
            let errors = [
                receptance_difference(&exact, &side_by_side(position)),
                receptance_difference(&database.interpolate(position).unwrap(), &exact),
                receptance_difference(&by_matched_modes(&window[from..from + 4], position), &exact),
            ];
            println!("{position:10.4}   {:11.1e}   {:9.1e}   {:13.1e}", errors[0], errors[1], errors[2]);
            fixed = fixed.max(errors[0]);
            subspace = subspace.max(errors[1]);
            matched = matched.max(errors[2]);
        }
    }
    println!("largest      {fixed:11.1e}   {subspace:9.1e}   {matched:13.1e}");
    assert!(fixed < 1e-6, "{fixed:.1e}");
    assert!(subspace < 5e-4, "{subspace:.1e}");
    assert!(matched > 5.0 * subspace, "{matched:.1e} against {subspace:.1e}");
}

/// The state space of the superelements side by side, without any fixed basis.
pub(super) fn side_by_side(position: f64) -> StateSpace {
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
    let database = Database::new(&stations(-0.3, -0.34), PAPER).unwrap();
    let figures: Vec<f64> = database.leave_one_out.iter().flatten().copied().collect();
    assert_eq!(figures.len(), 7);
    assert!(database.leave_one_out[0].is_none());
    let stored = database.worst_leave_one_out().unwrap();
    let between = [-0.3125, -0.3225, -0.3275].map(|p| {
        receptance_difference(&database.interpolate(p).unwrap(), &state_space(&modes(p), PAPER))
    });
    let worst = between.into_iter().fold(0.0, f64::max);
    println!("leave one out {stored:.1e}, between the stations {worst:.1e}");
    assert!(worst < stored && stored < 1e-2, "{worst:.1e} {stored:.1e}");
}

#[test]
fn through_a_veering_the_interpolated_response_is_smooth() {
    // Over one interval and its neighbours, second differences of the response at a fixed frequency.
    let database = Database::new(&stations(-0.13, -0.17), PAPER).unwrap();
    let response = |k: i32| {
        let system = database.interpolate(-0.145 - 0.0002 * f64::from(k)).unwrap();
        stiffmap::state_space::receptance(&system, 118.0)[(0, 0)]
    };
    let values: Vec<_> = (0..50).map(response).collect();
    let size = values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let jump = values.windows(3).map(|w| (w[2] - w[1] * 2.0 + w[0]).norm()).fold(0.0, f64::max);
    assert!(jump < 1e-3 * size, "{:.1e}", jump / size);
    let stepped = |k: i32| {
        let system = database.select(-0.145 - 0.0002 * f64::from(k)).unwrap();
        stiffmap::state_space::receptance(system, 118.0)[(0, 0)]
    };
    let values: Vec<_> = (0..50).map(stepped).collect();
    let control = values.windows(3).map(|w| (w[2] - w[1] * 2.0 + w[0]).norm()).fold(0.0, f64::max);
    assert!(control > 1e-3 * size, "control: the ceiling rule steps, {:.1e}", control / size);
}

#[test]
fn the_file_alone_interpolates_in_python() {
    let folder = tempfile::tempdir().unwrap();
    let database = Database::new(&stations(-0.3, -0.34), PAPER).unwrap();
    let file = folder.path().join("state_space.mat");
    mat::write_database(&file, &database, &names(), &names(), None).unwrap();
    // What the aligned matrices carry: the modes asked for and some more.
    let carried = StateSpaceOptions { modes: database.aligned[0].stiffness.nrows(), ..PAPER };
    let exact = |p: f64| {
        let path = folder.path().join("exact.mat");
        mat::write_state_space(&path, &[StateSpace { position: -0.3175, ..state_space(&modes(p), carried) }], &names(), &names())
            .unwrap();
        path
    };
    let Some(figure) = python("aligned", &[&file, &exact(-0.3175)]) else { return };
    println!("python, file alone: {figure:.1e}");
    assert!(figure < 5e-4, "{figure:.1e}");
    assert!(python("aligned", &[&file, &exact(-0.32)]).unwrap() > 5e-4, "control: half a station away");
}
