//! Craig-Bampton: constraint modes, fixed-interface modes and, if asked, the response to the inertia
//! of the constraint modes with the interfaces held.

use super::component_modes::{ComponentModes, Vectors};
use super::constraint::Constrained;
use super::{ReductionError, flexibility::Flexibility};
use crate::linalg::{
    Indefinite, LanczosOptions, LinalgError, Ordering, count_negative, lowest_modes, multiply, multiply_transposed,
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
    let attachments = flexibility.apply(motions);
    let constrained = Constrained::new(part, flexibility, motions, &attachments)?;
    let available = system.n_dof() - constrained.motions.ncols();
    if available == 0 {
        // Every motion of the part is one of its interfaces.
        let (blocks, beyond) = (vec![constrained.constraint_modes()], DMatrix::zeros(system.n_dof(), 0));
        return Ok(Vectors { frequencies: Vec::new(), blocks, beyond });
    }
    let inverse = |load: &DMatrix<f64>| constrained.apply(load);
    // Inertia of K - mu M on the constrained subspace: negative eigenvalues of the unconstrained matrix
    // plus positive ones of W^T (K - mu M)^-1 W, minus the number of constraints.
    let count_below = |shift: f64| {
        let shifted = Indefinite::new(&system.stiffness.plus_scaled(-shift, &system.mass), ordering)?;
        let schur = multiply_transposed(&constrained.motions, &shifted.solve(&constrained.motions));
        let negative = count_negative(&(0.5 * (&schur + schur.transpose())))?;
        let count = shifted.negative_eigenvalues() as isize - negative as isize;
        Ok(count.max(0) as usize)
    };
    let request = request.reaching(count_below).map_err(failed)?;
    let options = LanczosOptions {
        modes: request.with_guard().min(available),
        block: 8,
        tolerance: 1e-7,
        beyond: request.beyond(),
        interrupt: request.interrupt,
    };
    let spectrum = lowest_modes(&system.mass, &inverse, options).map_err(failed)?;

    request.check_count(&spectrum, count_below).map_err(failed)?;
    let (frequencies, modes) = request.keep(&spectrum);
    let constraint_modes = constrained.constraint_modes();
    // The last vectors of an iteration that has used up its space are rounding, and no longer hold the interfaces.
    let above = ComponentModes::above(&spectrum, frequencies.len());
    let moved = multiply_transposed(&constrained.motions, &above);
    let beyond = above - multiply(&constraint_modes, &moved);
    let mut blocks = vec![modes];
    if request.second_moment {
        let inertia = system.mass.multiply(&constraint_modes);
        blocks.push(constraint_modes);
        blocks.push(constrained.apply(&inertia));
    } else {
        blocks.push(constraint_modes);
    }
    Ok(Vectors { frequencies, blocks, beyond })
}
