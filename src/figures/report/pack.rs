//! The arrays of a modal database.

use super::ReportError;
use super::arrays::Arrays;
use super::local::{LocalBasis, local_basis};
use crate::coupling::CoupledModel;
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

/// The local coordinates of every position: eigenvalues in Hz^2, rows, residual flexibility, stiffness.
pub(super) fn push_local(
    arrays: &mut Arrays,
    model: &CoupledModel,
    modes: &[Cow<'_, Modes>],
    springs: &[usize],
    highest: f64,
    symmetric: bool,
) -> Result<(), ReportError> {
    let one = |modes: &Cow<'_, Modes>| -> Result<(LocalBasis, Vec<f64>), ReportError> {
        let position = modes.position;
        let at = model.at(position)?;
        let stiffness = model.stiffness(position)?;
        let mut basis = local_basis(model, &at, &stiffness, modes, springs, highest)
            .map_err(|source| ReportError::Local { position, source })?;
        if symmetric {
            let kept = springs.len() + modes.outputs.nrows();
            basis.rows = basis.rows.rows(0, kept).into_owned();
            basis.residual = basis.residual.view((0, 0), (kept, kept)).into_owned();
        }
        Ok((basis, springs.iter().map(|&s| stiffness[s]).collect()))
    };
    let all = modes.par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
    let p = all.len();
    let n = all.iter().map(|(b, _)| b.eigenvalues.len()).max().unwrap_or(0);
    let rows = all.first().map_or(0, |(b, _)| b.rows.nrows());
    let padded = |v: Vec<f64>| {
        let rest = n - v.len();
        v.into_iter().chain(std::iter::repeat_n(0.0, rest)).collect::<Vec<_>>()
    };
    arrays.push_u32("local_count", &[p], all.iter().map(|(b, _)| b.eigenvalues.len()));
    let hertz = |b: &LocalBasis| padded(b.eigenvalues.iter().map(|l| l / (TAU * TAU)).collect());
    arrays.push_f64("local_eigenvalue", &[p, n], all.iter().flat_map(|(b, _)| hertz(b)));
    let of_rows =
        |b: &LocalBasis| b.rows.row_iter().flat_map(|r| padded(r.iter().copied().collect())).collect::<Vec<_>>();
    arrays.push_f32("local_rows", &[p, rows, n], all.iter().flat_map(|(b, _)| of_rows(b)));
    let flexibility = all.iter().flat_map(|(b, _)| b.residual.transpose().iter().copied().collect::<Vec<_>>());
    arrays.push_f32("local_residual", &[p, rows, rows], flexibility);
    arrays.push_f64("stiffness", &[p, springs.len()], all.iter().flat_map(|(_, k)| k.iter().copied()));
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
