//! Which modes take part in a run with contacts, and what becomes of the others.

use super::Element;
use crate::response::Plant;
use nalgebra::DMatrix;

/// The largest omega h of a mode that takes part; stiffer ones follow statically.
const HIGHEST_PHASE: f64 = 2.0;

/// The modes that take part in steps of h seconds; the static compliance of the others goes to the direct one, to the
/// contacts' own flexibility and to what stands between contacts and ports.
pub(super) fn reduced(plant: &Plant, elements: &[Element], h: f64) -> (Plant, Vec<Element>) {
    let kept: Vec<usize> = (0..plant.omega.len()).filter(|r| plant.omega[*r] * h <= HIGHEST_PHASE).collect();
    let ratios = plant.projected_ratios();
    let mut direct = plant.direct.clone();
    for r in (0..plant.omega.len()).filter(|r| plant.omega[*r] * h > HIGHEST_PHASE) {
        direct += plant.outputs.column(r) * plant.inputs.column(r).transpose() / plant.omega[r].powi(2);
    }
    let fast: Vec<usize> = (0..plant.omega.len()).filter(|r| plant.omega[*r] * h > HIGHEST_PHASE).collect();
    // What the fast modes add between an element and a row of shapes.
    let still = |e: &Element, shape: &dyn Fn(usize) -> f64| -> f64 {
        fast.iter().map(|&r| e.row[r] * shape(r) / plant.omega[r].powi(2)).sum()
    };
    let given = |list: &[f64], k: usize| list.get(k).copied().unwrap_or(0.0);
    let own = |e: &Element| Element {
        row: kept.iter().map(|&r| e.row[r]).collect(),
        flexibility: e.flexibility + still(e, &|r| e.row[r]),
        towards: elements.iter().enumerate().map(|(k, o)| given(&e.towards, k) + still(e, &|r| o.row[r])).collect(),
        outputs: (0..plant.outputs.nrows())
            .map(|k| given(&e.outputs, k) + still(e, &|r| plant.outputs[(k, r)]))
            .collect(),
        inputs: (0..plant.inputs.nrows()).map(|k| given(&e.inputs, k) + still(e, &|r| plant.inputs[(k, r)])).collect(),
        ..e.clone()
    };
    let reduced = Plant {
        position: plant.position,
        omega: kept.iter().map(|&r| plant.omega[r]).collect(),
        // Contacts are stepped mode by mode, with the dampers projected on the modes.
        zeta: kept.iter().map(|&r| ratios[r]).collect(),
        dampers: DMatrix::zeros(0, kept.len()),
        outputs: plant.outputs.select_columns(&kept),
        inputs: plant.inputs.select_columns(&kept),
        direct,
    };
    (reduced, elements.iter().map(own).collect())
}
