//! What moves freely, found from parts, joints and clamps before anything is solved.

use super::PipelineError;
use crate::coupling::{CouplingError, null_space, separated, unreduced};
use crate::linalg::{LinalgError, multiply, multiply_transposed, orthonormal_span};
use crate::machine::Machine;
use crate::mesh::MeshFile;
use crate::solid::{SecondOrder, axis_name};
use nalgebra::{DMatrix, DVector, Vector3};

/// The motions that no joint and no clamp holds at a position, in words: which parts move and how.
///
/// Each part moves rigidly as far as nothing holds it (K R = 0); each spring with a stiffness forbids the
/// combinations that stretch it. How stiff a spring is plays no part.
///
/// # Errors
/// [`PipelineError`] of the joints at the position.
pub fn mechanisms(
    machine: &Machine,
    meshes: &[MeshFile],
    systems: &[SecondOrder],
    position: f64,
) -> Result<Vec<String>, PipelineError> {
    let surfaces: Vec<Vec<_>> =
        systems.iter().map(|s| s.surfaces.iter().cloned().zip(s.interfaces.iter().cloned()).collect()).collect();
    let meshes: Vec<_> = meshes.iter().map(|f| &f.mesh).collect();
    let springs = unreduced(machine, &meshes, &surfaces, position)?;
    let mut first = vec![0];
    for system in systems {
        first.push(first[first.len() - 1] + system.rigid.ncols());
    }
    let all = first[systems.len()];
    if all == 0 {
        return Ok(Vec::new());
    }
    // Turns are weighted with the part's size, so that they are comparable with translations.
    let scale: Vec<DMatrix<f64>> = systems.iter().map(scaled_rigid).collect();
    let motions: Vec<DMatrix<f64>> = springs
        .interfaces
        .iter()
        .map(|i| multiply_transposed(&systems[i.part].columns(&i.motion.rows), &scale[i.part]))
        .collect();
    let mut rows = Vec::new();
    for spring in &springs.springs {
        let mut row = vec![0.0; all];
        for (interface, coefficients) in &spring.sides {
            let part = springs.interfaces[*interface].part;
            let own = nalgebra::RowDVector::from_row_slice(coefficients) * &motions[*interface];
            own.iter().enumerate().for_each(|(q, v)| row[first[part] + q] += v);
        }
        let size = row.iter().map(|v| v * v).sum::<f64>().sqrt();
        let coefficients = spring.sides.iter().flat_map(|(_, c)| c).map(|c| c * c).sum::<f64>().sqrt();
        if size > 1e-9 * coefficients {
            rows.push(row.iter().map(|v| v / size).collect());
        }
    }
    let free = by_part(&rows, &first).map_err(CouplingError::from)?;
    Ok((0..free.ncols()).map(|k| describe(machine, systems, &first, &free.column(k).into_owned())).collect())
}

/// The free motions, those of single parts first and those of several parts without them after.
fn by_part(rows: &[Vec<f64>], first: &[usize]) -> Result<DMatrix<f64>, LinalgError> {
    let all = first[first.len() - 1];
    let mut alone: Vec<DVector<f64>> = Vec::new();
    for part in first.windows(2).filter(|p| p[0] < p[1]) {
        let unit = |row: &Vec<f64>| {
            let own = &row[part[0]..part[1]];
            let size = own.iter().map(|v| v * v).sum::<f64>().sqrt();
            (size > 1e-9).then(|| own.iter().map(|v| v / size).collect::<Vec<f64>>())
        };
        let own = separated(&null_space(&rows.iter().filter_map(unit).collect::<Vec<_>>(), part[1] - part[0]));
        for k in 0..own.ncols() {
            let mut whole = DVector::zeros(all);
            whole.rows_mut(part[0], part[1] - part[0]).copy_from(&own.column(k));
            alone.push(whole);
        }
    }
    let null = null_space(rows, all);
    let mut rest = null.clone();
    if !alone.is_empty() {
        let span = orthonormal_span(&DMatrix::from_columns(&alone), 0.0)?;
        rest -= multiply(&span, &multiply_transposed(&span, &null));
    }
    let together = null.ncols() - alone.len().min(null.ncols());
    if together > 0 {
        let span = orthonormal_span(&rest, 1e-6)?;
        let span = span.columns(0, together.min(span.ncols())).into_owned();
        alone.extend(separated(&span).column_iter().map(|c| c.into_owned()));
    }
    Ok(if alone.is_empty() { DMatrix::zeros(all, 0) } else { DMatrix::from_columns(&alone) })
}

/// The rigid motions of a part, turns by one unit of length at the distance of the part's radius of gyration.
fn scaled_rigid(system: &SecondOrder) -> DMatrix<f64> {
    let mut rigid = system.rigid.clone();
    if rigid.ncols() == 6 {
        let radius = radius(system);
        rigid.columns_mut(3, 3).scale_mut(radius.recip());
    }
    rigid
}

fn radius(system: &SecondOrder) -> f64 {
    let radius = (0.5 * system.inertia.trace() / system.total_mass.max(f64::MIN_POSITIVE)).sqrt();
    if radius > 0.0 { radius } else { 1.0 }
}

/// Which parts move and how.
fn describe(machine: &Machine, systems: &[SecondOrder], first: &[usize], free: &DVector<f64>) -> String {
    let largest = free.amax();
    let moving: Vec<usize> =
        (0..systems.len()).filter(|&p| free.rows(first[p], first[p + 1] - first[p]).amax() > 1e-6 * largest).collect();
    let name = |p: usize| machine.parts[p].name.as_str();
    let how = |p: usize| {
        let own = free.rows(first[p], first[p + 1] - first[p]);
        if own.len() < 6 {
            return "as its supports leave it free".to_string();
        }
        let slide = Vector3::new(own[0], own[1], own[2]);
        let turn = Vector3::new(own[3], own[4], own[5]);
        if turn.norm() > 1e-6 * slide.norm() {
            format!("about {}", axis_name(turn))
        } else {
            format!("along {}", axis_name(slide))
        }
    };
    // The heaviest leads: what it carries may turn beside.
    let mass = |p: &&usize| systems[**p].total_mass;
    let first_how = how(*moving.iter().max_by(|a, b| mass(a).total_cmp(&mass(b))).unwrap_or(&0));
    let verb = if first_how.starts_with("along") {
        "slide"
    } else if first_how.starts_with("about") {
        "turn"
    } else {
        "move"
    };
    let names: Vec<&str> = moving.iter().map(|&p| name(p)).collect();
    let (subject, verb) = match names[..] {
        [one] => (one.to_string(), format!("{verb}s")),
        _ => (format!("{} together", names.join(", ")), verb.to_string()),
    };
    format!("{subject} {verb} {first_how}: no joint or clamp resists it")
}
