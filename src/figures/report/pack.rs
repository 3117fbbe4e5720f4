//! The arrays of a modal database.

use super::arrays::Arrays;
use super::header::CoupledEntry;
use super::local::Local;
use crate::frf::{ExactDamping, ModalSystem};
use crate::modal::{ModeFamilies, TrackedMode};
use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;
use std::sync::Arc;

/// The systems that the map is summed from, to the last bit, with what couples their modes.
pub(super) fn push_systems(arrays: &mut Arrays, systems: &[&ModalSystem], symmetric: bool) -> Option<CoupledEntry> {
    push_sums(arrays, "nominal", systems, symmetric);
    let exact = systems.iter().map(|s| s.exact.as_deref()).collect::<Option<Vec<&ExactDamping>>>()?;
    let first = exact.first()?;
    let (p, springs) = (exact.len(), first.viscous.len());
    let sums: Vec<&ModalSystem> = exact.iter().map(|e| &e.system).collect();
    let symmetric = sums.iter().all(|s| s.outputs == s.inputs);
    push_sums(arrays, "coupled", &sums, symmetric);
    arrays.push_f64("coupled_viscous", &[p, springs], exact.iter().flat_map(|e| e.viscous.iter().copied()));
    arrays.push_f64("coupled_structural", &[p, springs], exact.iter().flat_map(|e| e.structural.iter().copied()));
    Some(CoupledEntry { springs, complex: first.is_complex, symmetric })
}

/// Sums over modes with their residual, as arrays whose names begin so.
fn push_sums(arrays: &mut Arrays, name: &str, systems: &[&ModalSystem], symmetric: bool) {
    let of = |what: &str| format!("{name}_{what}");
    let p = systems.len();
    let m = systems.iter().map(|s| s.frequencies.len()).max().unwrap_or(0);
    let padded = |v: &[f64]| v.iter().copied().chain(std::iter::repeat_n(0.0, m - v.len())).collect::<Vec<_>>();
    arrays.push_u32(&of("count"), &[p], systems.iter().map(|s| s.frequencies.len()));
    arrays.push_f64(&of("frequency"), &[p, m], systems.iter().flat_map(|s| padded(&s.frequencies)));
    arrays.push_f64(&of("ratio"), &[p, m], systems.iter().flat_map(|s| padded(&s.damping_ratios)));
    arrays.push_f64(&of("loss"), &[p, m], systems.iter().flat_map(|s| padded(&s.loss_factors)));
    let rows = |a: &DMatrix<f64>| {
        a.row_iter().flat_map(|r| padded(&r.iter().copied().collect::<Vec<_>>())).collect::<Vec<_>>()
    };
    let (o, i) = systems.first().map_or((0, 0), |s| (s.outputs.nrows(), s.inputs.nrows()));
    arrays.push_f64(&of("outputs"), &[p, o, m], systems.iter().flat_map(|s| rows(&s.outputs)));
    if !symmetric {
        arrays.push_f64(&of("inputs"), &[p, i, m], systems.iter().flat_map(|s| rows(&s.inputs)));
    }
    let degrees = systems.iter().map(|s| s.residual.len()).max().unwrap_or(0);
    let coefficients = systems.iter().flat_map(|s| (0..degrees).map(move |d| s.residual.get(d)));
    let zero = DMatrix::zeros(o, i);
    let values =
        coefficients.flat_map(|c| c.unwrap_or(&zero).transpose().iter().flat_map(|v| [v.re, v.im]).collect::<Vec<_>>());
    arrays.push_f64(&of("residual"), &[p, degrees, o, i, 2], values);
}

/// Reads what [`push_sums`] wrote for ports of so many outputs and inputs; nothing if an array is missing or too short.
pub(super) fn read_sums(arrays: &Arrays, name: &str, ports: [usize; 2], symmetric: bool) -> Option<Vec<ModalSystem>> {
    let [o, i] = ports;
    let of = |what: &str| arrays.f64(&format!("{name}_{what}"));
    let (_, counts) = arrays.u32(&format!("{name}_count"))?;
    let (shape, frequency) = of("frequency")?;
    let &[_, m] = shape else { return None };
    let (ratio, loss, outputs) = (of("ratio")?.1, of("loss")?.1, of("outputs")?.1);
    let inputs = if symmetric { outputs.clone() } else { of("inputs")?.1 };
    let (shape, residual) = of("residual")?;
    let degrees = *shape.get(1)?;
    let whole = |v: &Vec<f64>, each: usize| v.len() == counts.len() * each;
    let lengths = [(&frequency, m), (&ratio, m), (&loss, m), (&outputs, o * m), (&inputs, i * m)];
    if lengths.iter().any(|(v, each)| !whole(v, *each)) || !whole(&residual, degrees * o * i * 2) {
        return None;
    }
    let one = |(p, &n): (usize, &usize)| {
        let rows = |v: &[f64], k: usize| DMatrix::from_fn(k, n, |a, r| v[(p * k + a) * m + r]);
        let c = |d: usize, a: usize, b: usize| {
            let at = 2 * (((p * degrees + d) * o + a) * i + b);
            Complex::new(residual[at], residual[at + 1])
        };
        (n <= m).then(|| ModalSystem {
            frequencies: frequency[p * m..p * m + n].to_vec(),
            damping_ratios: ratio[p * m..p * m + n].to_vec(),
            loss_factors: loss[p * m..p * m + n].to_vec(),
            outputs: rows(&outputs, o),
            inputs: rows(&inputs, i),
            residual: (0..degrees).map(|d| DMatrix::from_fn(o, i, |a, b| c(d, a, b))).collect(),
            exact: None,
        })
    };
    counts.iter().enumerate().map(one).collect()
}

/// Reads what couples the modes of systems with so many outputs and inputs; nothing if an array is missing or too short.
pub(super) fn read_coupled(
    arrays: &Arrays,
    entry: &CoupledEntry,
    [o, i]: [usize; 2],
) -> Option<Vec<Arc<ExactDamping>>> {
    let (s, parts) = (entry.springs, if entry.complex { 2 } else { 1 });
    let sums = read_sums(arrays, "coupled", [(o + s) * parts, (i + s) * parts], entry.symmetric)?;
    let (viscous, structural) = (arrays.f64("coupled_viscous")?.1, arrays.f64("coupled_structural")?.1);
    if viscous.len() != sums.len() * s || structural.len() != viscous.len() {
        return None;
    }
    let of = |all: &[f64], p: usize| all[p * s..(p + 1) * s].to_vec();
    let one = |(p, system)| Arc::new(ExactDamping::new(system, entry.complex, of(&viscous, p), of(&structural, p)));
    Some(sums.into_iter().enumerate().map(one).collect())
}

/// The machine around its nominal joints at every position: eigenvalues in Hz^2, rows, residual flexibility, stiffness.
pub(super) fn push_local(arrays: &mut Arrays, all: &[Local]) {
    let p = all.len();
    let n = all.iter().map(|l| l.eigenvalues.len()).max().unwrap_or(0);
    let (rows, springs) = all.first().map_or((0, 0), |l| (l.rows.nrows(), l.stiffness.len()));
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
    arrays.push_f64("stiffness", &[p, springs], all.iter().flat_map(|l| l.stiffness.iter().copied()));
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
