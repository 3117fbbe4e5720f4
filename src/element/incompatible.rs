//! The incompatible modes of the eight-node brick (C3D8I).
//!
//! The displacements get the terms (1 - r^2) a_1 + (1 - s^2) a_2 + (1 - t^2) a_3 with nine parameters of
//! the element's own, which let it bend without shearing. Their gradients are taken with the Jacobian at
//! the centre, J_0, and scaled by det J_0 / det J,
//!
//! ```text
//! grad = (det J_0 / det J) J_0^-1 [-2 r, -2 s, -2 t],      integral grad dV = 0,
//! ```
//!
//! so that a constant stress does no work on them and distorted meshes pass the patch test. The
//! parameters are eliminated in the element; they carry no mass.
//!
//! # Source
//! E. L. Wilson, R. L. Taylor, W. P. Doherty, J. Ghaboussi, Incompatible displacement models (1973);
//! R. L. Taylor, P. J. Beresford, E. L. Wilson, A non-conforming element for stress analysis, Int. J.
//! Numer. Methods Eng. 10 (1976).
//!
//! # Differs
//! CalculiX leaves the factor det J_0 / det J out: the same on parallelepipeds, elsewhere its element fails
//! the patch test.

use super::quadrature::brick;
use super::shape::{inverse_jacobian, physical, shape};
use crate::mesh::CellKind;
use nalgebra::{SMatrix, SVector};

type Strain<const N: usize> = SMatrix<f64, 6, N>;

/// Minus what the eliminated modes take away from the stiffness: K_ua K_aa^-1 K_au, 24 x 24.
///
/// `None` where the element is so distorted that its modes cannot be eliminated.
pub(super) fn relief(nodes: &[[f64; 3]], lame: f64, shear: f64) -> Option<SMatrix<f64, 24, 24>> {
    let (centre, centre_det) = inverse_jacobian(nodes, &shape(CellKind::Hex8, [0.0; 3]).derivatives);
    let mut coupling = SMatrix::<f64, 24, 9>::zeros();
    let mut own = SMatrix::<f64, 9, 9>::zeros();
    for point in brick(2) {
        let (gradients, det) = physical(nodes, &shape(CellKind::Hex8, point.at));
        let mut modes = [[0.0; 3]; 3];
        for (a, mode) in modes.iter_mut().enumerate() {
            *mode = centre[a].map(|g| -2.0 * point.at[a] * g * centre_det / det);
        }
        let compatible: Strain<24> = strain(&gradients[..8]);
        let incompatible: Strain<9> = strain(&modes);
        let stress = stress(&incompatible, lame, shear) * (point.weight * det);
        coupling += compatible.transpose() * stress;
        own += incompatible.transpose() * stress;
    }
    let solved = own.cholesky()?.solve(&coupling.transpose());
    Some(coupling * solved)
}

/// Strains (xx, yy, zz, 2 xy, 2 yz, 2 zx) of unit displacements with the given gradients.
fn strain<const N: usize>(gradients: &[[f64; 3]]) -> Strain<N> {
    let mut b = Strain::<N>::zeros();
    for (i, [x, y, z]) in gradients.iter().enumerate() {
        let columns = [[*x, 0.0, 0.0, *y, 0.0, *z], [0.0, *y, 0.0, *x, *z, 0.0], [0.0, 0.0, *z, 0.0, *y, *x]];
        for (c, column) in columns.into_iter().enumerate() {
            b.set_column(3 * i + c, &SVector::<f64, 6>::from(column));
        }
    }
    b
}

fn stress<const N: usize>(strain: &Strain<N>, lame: f64, shear: f64) -> Strain<N> {
    let mut out = *strain * shear;
    for k in 0..N {
        let volume = strain[(0, k)] + strain[(1, k)] + strain[(2, k)];
        for i in 0..3 {
            out[(i, k)] += shear * strain[(i, k)] + lame * volume;
        }
    }
    out
}
