//! The arrays of a modal database.

use super::ReportError;
use super::arrays::Arrays;
use crate::coupling::{Around, AroundOptions, CoupledEigen, CoupledModel};
use crate::frf::ModalSystem;
use crate::modal::{ModeFamilies, Modes, TrackedMode};
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::borrow::Cow;
use std::f64::consts::TAU;

/// The systems that the map is summed from, to the last bit.
pub(super) fn push_systems(arrays: &mut Arrays, systems: &[&ModalSystem], symmetric: bool) {
    let p = systems.len();
    let m = systems.iter().map(|s| s.frequencies.len()).max().unwrap_or(0);
    let padded = |v: &[f64]| v.iter().copied().chain(std::iter::repeat_n(0.0, m - v.len())).collect::<Vec<_>>();
    arrays.push_u32("nominal_count", &[p], systems.iter().map(|s| s.frequencies.len()));
    arrays.push_f64("nominal_frequency", &[p, m], systems.iter().flat_map(|s| padded(&s.frequencies)));
    arrays.push_f64("nominal_ratio", &[p, m], systems.iter().flat_map(|s| padded(&s.damping_ratios)));
    arrays.push_f64("nominal_loss", &[p, m], systems.iter().flat_map(|s| padded(&s.loss_factors)));
    let rows = |a: &DMatrix<f64>| {
        a.row_iter().flat_map(|r| padded(&r.iter().copied().collect::<Vec<_>>())).collect::<Vec<_>>()
    };
    let (o, i) = systems.first().map_or((0, 0), |s| (s.outputs.nrows(), s.inputs.nrows()));
    arrays.push_f64("nominal_outputs", &[p, o, m], systems.iter().flat_map(|s| rows(&s.outputs)));
    if !symmetric {
        arrays.push_f64("nominal_inputs", &[p, i, m], systems.iter().flat_map(|s| rows(&s.inputs)));
    }
    let degrees = systems.iter().map(|s| s.residual.len()).max().unwrap_or(0);
    let coefficients = systems.iter().flat_map(|s| (0..degrees).map(move |d| s.residual.get(d)));
    let zero = DMatrix::zeros(o, i);
    let values =
        coefficients.flat_map(|c| c.unwrap_or(&zero).transpose().iter().flat_map(|v| [v.re, v.im]).collect::<Vec<_>>());
    arrays.push_f64("nominal_residual", &[p, degrees, o, i, 2], values);
}

/// What the page keeps of the machine as it was run: fewer coordinates than a sweep, because the page finds their modes at
/// every position while a slider moves.
pub const PAGE: AroundOptions = AroundOptions { band: 1.05, tolerance: 2e-2 };

/// The machine around its nominal joints at one position, as the page holds it.
struct Local {
    /// Eigenvalues, (rad/s)^2.
    eigenvalues: Vec<f64>,
    /// How many of them, the first, are free motions.
    free: usize,
    /// Elongations of the springs, then outputs, then inputs, over the coordinates.
    rows: DMatrix<f64>,
    /// Static flexibility between the rows that the coordinates leave out.
    residual: DMatrix<f64>,
    /// Of the springs.
    stiffness: Vec<f64>,
}

/// Motion of springs and ports below which a free motion is left out, relative to the largest of any coordinate.
const UNFELT: f64 = 1e-9;

impl Local {
    fn new(around: &Around, symmetric: bool) -> Self {
        let (n_springs, n_outputs) = (around.springs.nrows(), around.outputs.nrows());
        let ports = if symmetric { n_outputs } else { n_outputs + around.inputs.nrows() };
        let places: Vec<usize> = around.varied.iter().copied().chain((0..ports).map(|p| n_springs + p)).collect();
        let row = |place: usize, r: usize| match place {
            s if s < n_springs => around.springs[(s, r)],
            o if o < n_springs + n_outputs => around.outputs[(o - n_springs, r)],
            i => around.inputs[(i - n_springs - n_outputs, r)],
        };
        let rows = DMatrix::from_fn(places.len(), around.n(), |i, r| row(places[i], r));
        let largest = rows.column_iter().map(|c| c.norm()).fold(0.0, f64::max);
        let is_free = |r: usize| r < around.free;
        let kept: Vec<usize> =
            (0..around.n()).filter(|&r| !is_free(r) || rows.column(r).norm() > UNFELT * largest).collect();
        Self {
            free: kept.iter().filter(|r| is_free(**r)).count(),
            eigenvalues: kept.iter().map(|&r| around.eigenvalues[r]).collect(),
            rows: rows.select_columns(&kept),
            residual: DMatrix::from_fn(places.len(), places.len(), |i, j| around.residual[(places[i], places[j])]),
            stiffness: around.varied.iter().map(|&s| around.base[s]).collect(),
        }
    }
}

/// The machine around its nominal joints at every position: eigenvalues in Hz^2, rows, residual flexibility, stiffness.
pub(super) fn push_local(
    arrays: &mut Arrays,
    model: &CoupledModel,
    modes: &[Cow<'_, Modes>],
    springs: &[usize],
    highest: f64,
    symmetric: bool,
) -> Result<(), ReportError> {
    let one = |modes: &Cow<'_, Modes>| -> Result<Local, ReportError> {
        let stiffness = model.stiffness(modes.position)?;
        let base =
            CoupledEigen { values: modes.eigenvalues.clone().into(), vectors: modes.shapes.clone(), free: modes.free };
        let at = model.at(modes.position)?;
        Ok(Local::new(&model.around_modes(&at, &stiffness, &base, springs, highest, PAGE)?, symmetric))
    };
    let all = modes.par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
    let p = all.len();
    let n = all.iter().map(|l| l.eigenvalues.len()).max().unwrap_or(0);
    let rows = all.first().map_or(0, |l| l.rows.nrows());
    let padded = |v: Vec<f64>| {
        let rest = n - v.len();
        v.into_iter().chain(std::iter::repeat_n(0.0, rest)).collect::<Vec<_>>()
    };
    arrays.push_u32("local_count", &[p], all.iter().map(|l| l.eigenvalues.len()));
    arrays.push_u32("local_free", &[p], all.iter().map(|l| l.free));
    let hertz = |l: &Local| padded(l.eigenvalues.iter().map(|l| l / (TAU * TAU)).collect());
    arrays.push_f64("local_eigenvalue", &[p, n], all.iter().flat_map(hertz));
    let of_rows = |l: &Local| l.rows.row_iter().flat_map(|r| padded(r.iter().copied().collect())).collect::<Vec<_>>();
    arrays.push_f32("local_rows", &[p, rows, n], all.iter().flat_map(of_rows));
    let flexibility = all.iter().flat_map(|l| l.residual.transpose().iter().copied().collect::<Vec<_>>());
    arrays.push_f32("local_residual", &[p, rows, rows], flexibility);
    arrays.push_f64("stiffness", &[p, springs.len()], all.iter().flat_map(|l| l.stiffness.iter().copied()));
    Ok(())
}

/// Families by rank, 0 where a position has fewer; returns the modes listed a position.
pub(super) fn push_families(arrays: &mut Arrays, families: &ModeFamilies) -> usize {
    let listed = families.modes.iter().map(Vec::len).max().unwrap_or(0);
    let shape = [families.modes.len(), listed];
    let at = |k: usize| move |modes: &Vec<TrackedMode>| modes.get(k).copied();
    let all = || families.modes.iter().flat_map(move |modes| (0..listed).map(move |k| at(k)(modes)));
    arrays.push_u32("family", &shape, all().map(|m| m.map_or(0, |m| m.family)));
    arrays.push_f64("family_frequency", &shape, all().map(|m| m.map_or(0.0, |m| m.frequency)));
    arrays.push_f64("family_ratio", &shape, all().map(|m| m.map_or(0.0, |m| m.damping_ratio)));
    listed
}
