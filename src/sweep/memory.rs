//! How much memory the prepared positions take, told before they are formed.

use super::{Design, PartScale, SweepError};
use crate::coupling::{Around, CoupledModel};
use crate::resources::{admit, room};

/// Bytes of a number.
const NUMBER: usize = size_of::<f64>();
/// What to do where they do not fit.
const ADVICE: &str = "take fewer positions or a lower band (\"positions\", \"band\" of the study), \
                      or a machine or limit with more memory";

/// Refuses positions that do not fit, from what one takes.
///
/// A design with other parts, or too far from nominal, has positions of its own beside the nominal ones. Where families
/// are followed, the shapes of all positions are there too for a while.
pub(super) fn admit_positions(
    one: &Around,
    positions: usize,
    (model, families): (&CoupledModel, bool),
    probes: &[Design],
) -> Result<(), SweepError> {
    let own = probes.iter().any(|probe| probe.parts.iter().any(|scale| *scale != PartScale::NOMINAL));
    // A third more, for the gaps that matrices formed on the way leave between those that stay.
    let prepared = if own { 2 } else { 1 } * bytes(one) * 4 / 3;
    let shapes = if families { NUMBER * model.n() * model.n() } else { 0 };
    let need = (positions as u64).saturating_mul((prepared + shapes) as u64);
    Ok(admit(&format!("preparing {positions} positions"), need, room().as_ref(), ADVICE)?)
}

/// Bytes of a prepared position.
fn bytes(one: &Around) -> usize {
    let energies: usize = one.strain_energy.iter().flatten().map(|form| form.len()).sum();
    let rows = one.springs.len() + one.outputs.len() + one.inputs.len();
    // The rows of the springs over the fixed basis, and its eigenvalues.
    let fixed = one.basis.nrows() * (one.springs.nrows() + 1);
    NUMBER * (one.basis.len() + rows + one.residual.len() + energies + fixed)
}
