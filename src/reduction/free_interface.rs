//! Free interface: free modes, attachment modes and, if asked, the response to their inertia.

use super::component_modes::ComponentModes;
use super::{ReductionError, flexibility::Flexibility};
use crate::linalg::{Indefinite, LanczosOptions, LinalgError, Ordering, lowest_modes};
use crate::solid::SecondOrder;
use nalgebra::DMatrix;

/// Blocks of basis vectors, the component modes first.
pub(super) fn vectors(
    part: &str,
    system: &SecondOrder,
    ordering: &Ordering,
    flexibility: &Flexibility<'_>,
    motions: &DMatrix<f64>,
    request: ComponentModes<'_>,
) -> Result<(Vec<f64>, Vec<DMatrix<f64>>), ReductionError> {
    let failed = |source: LinalgError| ReductionError::Linalg { part: part.to_string(), source };
    let rigid = flexibility.rigid.ncols();
    let options = LanczosOptions {
        modes: request.with_guard().min(system.n_dof() - rigid),
        block: 8,
        tolerance: 1e-7,
        interrupt: request.interrupt,
    };
    let spectrum = lowest_modes(&system.mass, &|load| flexibility.apply(load), options).map_err(failed)?;
    request
        .check_count(&spectrum, |shift| {
            let shifted = Indefinite::new(&system.stiffness.plus_scaled(-shift, &system.mass), ordering)?;
            Ok(shifted.negative_eigenvalues().saturating_sub(rigid))
        })
        .map_err(failed)?;
    let (frequencies, modes) = request.keep(&spectrum);
    let attachments = flexibility.apply(motions);
    let mut blocks = vec![modes];
    if request.second_moment {
        let second = flexibility.apply_mass(&attachments);
        blocks.push(attachments);
        blocks.push(second);
    } else {
        blocks.push(attachments);
    }
    Ok((frequencies, blocks))
}
