//! Mounts from 0.1 to 10 Hz beside bolts up to 1e20 N/m and N m/rad.

use crate::dense::symmetric_values;
use crate::{machine, reduced, solved};
use nalgebra::{Cholesky, DMatrix, DVector};
use stiffmap::coupling::{AroundOptions, CoupledModel};
use stiffmap::linalg::SparseSymmetric;
use stiffmap::modal::{modes_around, modes_at};

const MOUNT: [&str; 2] = ["400 N/m", "40 N m/rad"];

fn soft(mount: f64, bolt: &str) -> stiffmap::machine::Machine {
    machine(
        "soft_mounts.toml",
        &[
            (MOUNT[0], &format!("{mount} N/m")),
            (MOUNT[1], &format!("{} N m/rad", 0.1 * mount)),
            ("1e10 N/m", &format!("{bolt} N/m")),
            ("1e10 N m/rad", &format!("{bolt} N m/rad")),
        ],
    )
}

/// Lambda, rows of the springs and their stiffness, of the superelements side by side.
fn pieces(model: &CoupledModel) -> (DVector<f64>, DMatrix<f64>, Vec<f64>) {
    let side_by_side = &model.side_by_side;
    let rows = side_by_side.rows(0.0).expect("rows");
    (side_by_side.eigenvalues.clone(), rows, side_by_side.stiffness(0.0).expect("stiffness"))
}

/// The lowest frequencies with the bolts rigid: the motions that leave them without elongation, by an orthonormal
/// basis of those. No large number is left in it, so plain doubles do.
fn with_rigid_bolts(model: &CoupledModel, shift: f64) -> Vec<f64> {
    let (lambda, rows, stiffness) = pieces(model);
    let n = lambda.len();
    let bolts = rows.rows(6, 6).into_owned();
    // Rows of the coordinates' own flexibility make the basis accurate for the low ones.
    let scale = DVector::from_fn(n, |i, _| (lambda[i] + shift).sqrt().recip());
    let held = DMatrix::from_fn(n, 6, |i, j| bolts[(j, i)] * scale[i]);
    let q = held.qr().q();
    let free = DMatrix::identity(n, n) - &q * q.transpose();
    // K + s in the scaled coordinates is I + the mounts.
    let mounts = DMatrix::from_fn(6, n, |j, i| rows[(j, i)] * scale[i] * stiffness[j].sqrt());
    let whole = DMatrix::identity(n, n) + mounts.transpose() * &mounts;
    let mass = DMatrix::from_diagonal(&scale.map(|s| s * s));
    let inner = &free * &whole * &free + &q * q.transpose();
    let root = Cholesky::new(0.5 * (&inner + inner.transpose())).expect("definite").l();
    let inside = &free * mass * &free;
    let half = root.solve_lower_triangular(&inside).expect("regular");
    let theta = symmetric_values(&root.solve_lower_triangular(&half.transpose()).expect("regular"));
    theta.iter().rev().map(|t| (1.0 / t - shift).max(0.0).sqrt() / std::f64::consts::TAU).collect()
}

#[test]
fn soft_mounts_keep_their_frequencies_under_any_bolts() {
    for mount in [0.44, 400.0, 4400.0] {
        let machine = soft(mount, "1e20");
        let (_, parts) = reduced(&machine);
        let (model, found) = solved(&machine, &parts).expect("solves");
        let exact = with_rigid_bolts(&model, 0.01 * mount);
        let modes = &found.modes[0];
        assert_eq!(modes.free, 0, "a mount of {mount} N/m holds");
        for (r, f) in exact.iter().enumerate().take(9) {
            let error = (modes.frequency(r) / f - 1.0).abs();
            assert!(error < 1e-6, "mount {mount} N/m, mode {}: {} and {f} Hz", r + 1, modes.frequency(r));
        }
        // Control: bolts that are not rigid are told from those that are.
        let softer = soft(mount, "1e7");
        let other = &solved(&softer, &parts).expect("solves").1.modes[0];
        assert!((other.frequency(6) / exact[6] - 1.0).abs() > 1e-4);
    }
    // The mill's own order of bolts: CalculiX on the exported deck gives 3.0027, 3.0027, 3.1755 Hz.
    let machine = soft(400.0, "1e10");
    let (_, parts) = reduced(&machine);
    let modes = &solved(&machine, &parts).expect("solves").1.modes[0];
    for (r, f) in [3.0027, 3.0027, 3.1755].iter().enumerate() {
        assert!((modes.frequency(r) / f - 1.0).abs() < 2e-5, "{} Hz", modes.frequency(r));
    }
}

#[test]
fn free_motions_are_those_of_the_mechanism_whatever_the_bolts() {
    let all = "x = \"400 N/m\", y = \"400 N/m\", z = \"400 N/m\", rx = \"40 N m/rad\", ry = \"40 N m/rad\", rz = \"40 N m/rad\"";
    for (mounts, free) in [
        (all, 0),
        ("x = \"400 N/m\", y = \"400 N/m\", z = \"400 N/m\", rx = \"40 N m/rad\", ry = \"40 N m/rad\"", 1),
        ("x = \"400 N/m\", y = \"400 N/m\", z = \"400 N/m\"", 3),
        ("x = \"1e-6 N/m\"", 5),
    ] {
        for bolt in ["1e6", "1e10", "1e20"] {
            let edits = [
                ("type = \"bolted\"\nbetween = [\"floor.top\"", "type = \"spring-damper\"\nbetween = [\"floor.top\""),
                (all, mounts),
                ("1e10 N/m", &format!("{bolt} N/m")),
                ("1e10 N m/rad", &format!("{bolt} N m/rad")),
            ];
            let machine = machine("soft_mounts.toml", &edits);
            let (meshes, parts) = reduced(&machine);
            let modes = &solved(&machine, &parts).expect("solves").1.modes[0];
            assert_eq!(modes.free, free, "{mounts} with {bolt}");
            assert!(modes.frequency(free) > 0.0);
            // `check` says the same before anything is solved.
            let systems: Vec<_> = machine
                .parts
                .iter()
                .zip(&meshes)
                .map(|(p, m)| stiffmap::solid::assemble(p, &m.mesh).expect("assembles"))
                .collect();
            let named = stiffmap::pipeline::mechanisms(&machine, &meshes, &systems, 0.0).expect("springs");
            assert_eq!(named.len(), free, "{named:?}");
            assert!(named.iter().all(|n| n.contains("bed, block together")), "{named:?}");
        }
    }
}

#[test]
fn sweeps_and_the_page_see_the_same_soft_modes() {
    let machine = soft(4.4, "1e20");
    let (_, parts) = reduced(&machine);
    let (model, _) = solved(&machine, &parts).expect("solves");
    let damping = &machine.analysis.damping;
    let at = model.at(0.0).expect("inside");
    let springs = model.springs(0.0).expect("springs");
    let base = model.eigen(&at, &model.coupled(&at, &springs.stiffness).unwrap(), &springs.stiffness).unwrap();
    let varied: Vec<usize> = (0..springs.stiffness.len()).collect();
    for (factor, options) in [(0.3, AroundOptions::DESIGNS), (3.0, stiffmap::figures::report::PAGE)] {
        let around = model.around_modes(&at, &springs.stiffness, &base, &varied, 100.0, options).expect("around");
        assert_eq!(around.free, 0);
        // The mounts change, and the bolts with them.
        let mut changed = springs.clone();
        changed.stiffness.iter_mut().for_each(|k| *k *= factor);
        let losses = vec![None; machine.parts.len()];
        let few = modes_around(&around, damping, &changed, &losses).expect("solves");
        let bolt = format!("{:e}", 1e20 * factor);
        let other = soft(4.4 * factor, &bolt);
        let (there, _) = solved(&other, &parts).expect("solves");
        let whole = modes_at(&there, damping, 0.0).expect("solves");
        for r in 0..5 {
            let error = (few.frequency(r) / whole.frequency(r) - 1.0).abs();
            assert!(error < 1e-6, "times {factor}, mode {}: {} {}", r + 1, few.frequency(r), whole.frequency(r));
        }
        assert!((base.values[0].sqrt() / whole.eigenvalues[0].sqrt() - 1.0).abs() > 0.1, "control: it changes");
    }
}

#[test]
fn a_deck_of_a_slender_boom_bends_below_a_hertz_and_is_not_called_rigid() {
    use stiffmap::linalg::{Ordering, SparseBuilder, shift_invert_modes};
    // A free chain of masses with springs from 1 N/m to 1e12 N/m: one rigid motion, one soft mode.
    let k = [1e12, 1.0, 1e12];
    let pattern: Vec<Vec<usize>> = vec![vec![0, 1], vec![0, 1, 2], vec![1, 2, 3], vec![2, 3]];
    let build = |entries: &[(usize, usize, f64)]| -> SparseSymmetric {
        let mut builder = SparseBuilder::new(&pattern);
        entries.iter().for_each(|&(i, j, v)| builder.add(i, j, v));
        builder.finish()
    };
    let mut entries = Vec::new();
    for (i, k) in k.iter().enumerate() {
        entries.extend([(i, i, *k), (i + 1, i + 1, *k), (i, i + 1, -k), (i + 1, i, -k)]);
    }
    let stiffness = build(&entries);
    let mass = build(&(0..4).map(|i| (i, i, 10.0)).collect::<Vec<_>>());
    let neighbours = vec![vec![1], vec![0, 2], vec![1, 3], vec![2]];
    let groups: Vec<Vec<usize>> = (0..4).map(|i| vec![i]).collect();
    let ordering = Ordering::nested_dissection(&neighbours, &groups).expect("orders");
    let found = shift_invert_modes(&stiffness, &mass, &ordering, 1, 3, None).expect("converges");
    assert_eq!(found.rigid, 1);
    // Two masses of 20 kg on 1 N/m: omega^2 = 1 / 10.
    assert!((found.eigenvalues[1] / 0.1 - 1.0).abs() < 1e-2, "{:?}", found.eigenvalues);
}
