//! The matrices A, B, C, D of a position's modes.

use super::{StateSpace, own_ratios, state_matrix};
use crate::modal::Modes;
use nalgebra::DMatrix;

/// What the outputs of a state-space system are, and whether its truncation is made good.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateSpaceOptions {
    /// Elastic modes.
    pub modes: usize,
    /// Rows for velocity after those for displacement.
    pub velocity: bool,
    /// Rows for acceleration after those.
    pub acceleration: bool,
    /// Whether D carries the constant residual R0 = H(0) - sum phi phi^T / omega_r^2 of the modes left out.
    pub residual: bool,
}

/// Modal state space at a position.
///
/// ```text
/// A = [ 0  I ; Lambda_1  Lambda_2 ]     Lambda_1 = -diag(omega_r^2), Lambda_2 = -diag(2 zeta_r omega_r) - G^T G
/// B = [ 0 ; Lambda_3 ]                  Lambda_3 = Phi^T F_u
/// C = [ Lambda_4 0 ; 0 Lambda_4 ; Lambda_4 Lambda_1  Lambda_4 Lambda_2 ]
/// D = [ R0 ; 0 ; Lambda_4 Lambda_3 ]    Lambda_4 = U_u Phi
/// ```
///
/// The states are the modal displacements (kg^(1/2) m), then their rates. The second and third rows of
/// C and D are there if asked for. Free motions are left out unless a port feels them. The rows G are those of the
/// joints' dampers between the modes ([`Modes::viscous`]); none where these are projected on the modes. A structural
/// loss factor enters as the viscous ratio eta_r / 2, which is exact at each resonance only.
///
/// # Source
/// Ksica and Hadas, equations (4) to (11); R0 is not in the paper.
pub fn state_space(modes: &Modes, options: StateSpaceOptions) -> StateSpace {
    assemble(modes, &modes.viscous().dampers, options)
}

/// The same with given rows of dampers between the modes, n_damper x n.
pub(super) fn assemble(modes: &Modes, dampers: &DMatrix<f64>, options: StateSpaceOptions) -> StateSpace {
    let elastic = (modes.free + options.modes).min(modes.eigenvalues.len());
    let kept: Vec<usize> = (0..elastic).filter(|&r| r >= modes.free || modes.is_felt(r)).collect();
    let n = kept.len();
    let eigenvalues: Vec<f64> = kept.iter().map(|&r| modes.eigenvalues[r]).collect();
    let damping: Vec<f64> = kept.iter().map(|&r| modes.damping_ratios[r] + 0.5 * modes.loss_factors[r]).collect();
    let outputs = modes.outputs.select_columns(&kept);
    let inputs = modes.inputs.select_columns(&kept);
    let dampers = dampers.select_columns(&kept);
    let (o, i) = (outputs.nrows(), inputs.nrows());

    let a = state_matrix(&eigenvalues, &own_ratios(&eigenvalues, &damping, &dampers), &dampers);
    let mut b = DMatrix::zeros(2 * n, i);
    b.rows_mut(n, n).copy_from(&inputs.transpose());

    let blocks = 1 + usize::from(options.velocity) + usize::from(options.acceleration);
    let mut c = DMatrix::zeros(blocks * o, 2 * n);
    let mut d = DMatrix::zeros(blocks * o, i);
    c.view_mut((0, 0), (o, n)).copy_from(&outputs);
    if options.residual {
        let mut residual = modes.direct.clone();
        for r in elastic..modes.eigenvalues.len() {
            residual += modes.outputs.column(r) * modes.inputs.column(r).transpose() / modes.eigenvalues[r];
        }
        d.rows_mut(0, o).copy_from(&residual);
    }
    let mut at = o;
    if options.velocity {
        c.view_mut((at, n), (o, n)).copy_from(&outputs);
        at += o;
    }
    if options.acceleration {
        c.rows_mut(at, o).copy_from(&(&outputs * a.rows(n, n)));
        d.rows_mut(at, o).copy_from(&(&outputs * inputs.transpose()));
    }
    StateSpace {
        position: modes.position,
        a,
        b,
        c,
        d,
        eigenvalues,
        eigenvectors: outputs.transpose(),
        damping,
        dampers,
    }
}
