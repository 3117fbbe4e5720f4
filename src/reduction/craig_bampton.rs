//! Craig-Bampton: constraint modes, fixed-interface modes and, if asked, the response to the inertia
//! of the constraint modes with the interfaces held.

use super::component_modes::ComponentModes;
use super::constraint::Constrained;
use super::{ReductionError, flexibility::Flexibility};
use crate::linalg::{
    Indefinite, LanczosOptions, LinalgError, Ordering, count_negative, lowest_modes, multiply_transposed,
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
) -> Result<(Vec<f64>, Vec<DMatrix<f64>>), ReductionError> {
    let failed = |source: LinalgError| ReductionError::Linalg { part: part.to_string(), source };
    let attachments = flexibility.apply(motions);
    let constrained = Constrained::new(part, flexibility, motions, &attachments)?;
    let available = system.n_dof() - constrained.motions.ncols();
    let inverse = |load: &DMatrix<f64>| constrained.apply(load);
    let options = LanczosOptions {
        modes: request.with_guard().min(available),
        block: 8,
        tolerance: 1e-7,
        interrupt: request.interrupt,
    };
    let spectrum = lowest_modes(&system.mass, &inverse, options).map_err(failed)?;

    // Inertia of K - mu M on the constrained subspace: negative eigenvalues of the unconstrained matrix
    // plus positive ones of W^T (K - mu M)^-1 W, minus the number of constraints.
    request
        .check_count(&spectrum, |shift| {
            let shifted = Indefinite::new(&system.stiffness.plus_scaled(-shift, &system.mass), ordering)?;
            let schur = multiply_transposed(&constrained.motions, &shifted.solve(&constrained.motions));
            let negative = count_negative(&(0.5 * (&schur + schur.transpose())))?;
            let count = shifted.negative_eigenvalues() as isize - negative as isize;
            Ok(count.max(0) as usize)
        })
        .map_err(failed)?;

    let (frequencies, modes) = request.keep(&spectrum);
    let constraint_modes = constrained.constraint_modes();
    let mut blocks = vec![modes];
    if request.second_moment {
        let inertia = system.mass.multiply(&constraint_modes);
        blocks.push(constraint_modes);
        blocks.push(constrained.apply(&inertia));
    } else {
        blocks.push(constraint_modes);
    }
    Ok((frequencies, blocks))
}
