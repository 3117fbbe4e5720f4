//! How much of an acceleration comes from modes that the model does not answer for.

use super::{Forces, History, Plant, Recording, simulate};

/// The largest acceleration that the modes above a frequency (Hz) add at any output and sample, as a share of the
/// largest acceleration of all modes at the same output; `None` where `history` has no accelerations or rests.
///
/// Displacements take little from fast modes, accelerations much: mode r adds L_r R_r f whatever its frequency, so that
/// the answer to a sudden force ends where the mesh and the reduced basis end. Two models of one machine that agree on
/// every frequency up to this one may differ by this share.
pub fn acceleration_share_above(frequency: f64, plant: &Plant, history: &History, forces: &Forces) -> Option<f64> {
    let whole = history.acceleration.as_ref()?;
    let kept: Vec<usize> =
        (0..plant.omega.len()).filter(|&r| plant.omega[r] <= std::f64::consts::TAU * frequency).collect();
    let below = Plant {
        omega: kept.iter().map(|&r| plant.omega[r]).collect(),
        zeta: kept.iter().map(|&r| plant.zeta[r]).collect(),
        dampers: plant.dampers.select_columns(&kept),
        outputs: plant.outputs.select_columns(&kept),
        inputs: plant.inputs.select_columns(&kept),
        ..plant.clone()
    };
    let part = simulate(&below, forces, Recording { velocity: false, acceleration: true }).acceleration?;
    let n = history.n_outputs;
    let mut share: Option<f64> = None;
    for i in 0..n {
        let of = |list: &[f64]| list.iter().skip(i).step_by(n).fold(0.0f64, |m, a| m.max(a.abs()));
        let difference: Vec<f64> = whole.iter().zip(&part).map(|(a, b)| a - b).collect();
        let (above, all) = (of(&difference), of(whole));
        if all > 0.0 {
            share = Some(share.unwrap_or(0.0).max(above / all));
        }
    }
    share
}
