//! Free interface: free modes, attachment modes and, if asked, the response to their inertia.

use super::component_modes::{ComponentModes, Vectors};
use super::{ReductionError, flexibility::Flexibility};
use crate::linalg::{
    Indefinite, LanczosOptions, LinalgError, Ordering, independent_directions, lowest_modes, multiply,
    multiply_transposed,
};
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
) -> Result<Vectors, ReductionError> {
    let failed = |source: LinalgError| ReductionError::Linalg { part: part.to_string(), source };
    let rigid = flexibility.rigid.ncols();
    let count_below = |shift: f64| {
        let shifted = Indefinite::new(&system.stiffness.plus_scaled(-shift, &system.mass), ordering)?;
        Ok(shifted.negative_eigenvalues().saturating_sub(rigid))
    };
    let request = request.reaching(count_below).map_err(failed)?;
    let options = LanczosOptions {
        modes: request.with_guard().min(system.n_dof() - rigid),
        block: 8,
        tolerance: 1e-7,
        beyond: request.beyond(),
        interrupt: request.interrupt,
    };
    let spectrum = lowest_modes(&system.mass, &|load| flexibility.apply(load), options).map_err(failed)?;
    request.check_count(&spectrum, count_below).map_err(failed)?;
    let (frequencies, modes) = request.keep(&spectrum);
    let attachments = flexibility.apply(motions);
    // What lies beyond, with the interfaces brought back by the forces that it takes.
    let compliance = multiply_transposed(motions, &attachments);
    let combine = independent_directions(&(0.5 * (&compliance + compliance.transpose())), 1e-9).map_err(failed)?;
    let above = ComponentModes::above(&spectrum, frequencies.len());
    let moved = multiply_transposed(&multiply(motions, &combine), &above);
    let beyond = &above - multiply(&attachments, &multiply(&combine, &moved));
    let mut blocks = vec![modes];
    if request.second_moment {
        let second = flexibility.apply_mass(&attachments);
        blocks.push(attachments);
        blocks.push(second);
    } else {
        blocks.push(attachments);
    }
    Ok(Vectors { frequencies, blocks, beyond })
}
