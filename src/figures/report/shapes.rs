//! Mode shapes of all positions in few vectors, and the parts' surfaces in them.
//!
//! The shapes of all positions, columns of W in the fixed basis, lie close to a space of some 70
//! dimensions: the strongest eigenvectors U of W W^T, as many as leave 1 % of no shape's norm out.
//! A shape is then U^T w, its surface S U (U^T w) with S the skins' rows, and the MAC of two shapes
//! (U^T a . U^T b)^2, since the mass matrix is the identity.

use super::arrays::Arrays;
use crate::coupling::CoupledModel;
use crate::linalg::{LinalgError, multiply, multiply_transposed, symmetric_eigen};
use crate::modal::Modes;
use crate::reduction::Superelement;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Largest share of a shape's norm that may be left out.
const TOLERANCE: f64 = 0.01;

/// A part's place in the skins of all parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartSkin {
    /// Name.
    pub name: String,
    /// Whether it moves with the axis.
    pub moves: bool,
    /// First node.
    pub first_node: usize,
    /// Number of nodes.
    pub nodes: usize,
}

/// Appends the shapes of the lowest `listed` modes a position; returns the parts' places.
///
/// # Errors
/// [`LinalgError`] of the eigenproblem of W W^T.
pub(super) fn push_shapes(
    arrays: &mut Arrays,
    model: &CoupledModel,
    superelements: &[Superelement],
    moves: &[bool],
    modes: &[Cow<'_, Modes>],
    listed: usize,
) -> Result<Vec<PartSkin>, LinalgError> {
    let all: Vec<DMatrix<f64>> =
        modes.iter().map(|m| m.shapes.columns(0, listed.min(m.shapes.ncols())).into_owned()).collect();
    let n = model.n();
    let mut gram = DMatrix::zeros(n, n);
    for shapes in &all {
        gram += multiply(shapes, &shapes.transpose());
    }
    let eigen = symmetric_eigen(&(0.5 * (&gram + gram.transpose())))?;
    let strongest = DMatrix::from_fn(n, n, |i, k| eigen.vectors[(i, n - 1 - k)]);
    let coefficients: Vec<DMatrix<f64>> = all.iter().map(|shapes| multiply_transposed(&strongest, shapes)).collect();
    let needed = |c: nalgebra::DVectorView<'_, f64>| {
        let mut left: f64 = 0.0;
        (0..n).rev().find(|&k| {
            left += c[k] * c[k];
            left > TOLERANCE * TOLERANCE
        })
    };
    let rank = coefficients.iter().flat_map(|c| c.column_iter()).filter_map(needed).max().map_or(0, |k| k + 1);
    let space = strongest.columns(0, rank).into_owned();

    let (mut parts, mut surfaces) = (Vec::new(), Vec::new());
    let mut first_node = 0;
    for ((share, superelement), &moves) in model.parts.iter().zip(superelements).zip(moves) {
        let skin = &superelement.skin;
        surfaces.push(multiply(&skin.basis, &multiply(&share.basis, &space)));
        parts.push(PartSkin { name: share.name.clone(), moves, first_node, nodes: skin.nodes.len() });
        first_node += skin.nodes.len();
    }
    let column = |k: usize| surfaces.iter().flat_map(move |s| s.column(k).into_owned().data.as_vec().clone());
    let scales: Vec<f64> = (0..rank).map(|k| column(k).map(f64::abs).fold(f64::MIN_POSITIVE, f64::max)).collect();
    let steps = f64::from(i16::MAX);
    arrays.push_f32("shape_scale", &[rank], scales.iter().map(|s| s / steps));
    let quantised = (0..rank).flat_map(|k| column(k).map(move |v| (v, k)));
    arrays.push_i16(
        "shape_surface",
        &[rank, 3 * first_node],
        quantised.map(|(v, k)| (v / scales[k] * steps).round() as i16),
    );
    let of_mode = |p: usize, r: usize, k: usize| coefficients[p].get((k, r)).copied().unwrap_or(0.0);
    let indices = (0..modes.len()).flat_map(|p| (0..listed).flat_map(move |r| (0..rank).map(move |k| (p, r, k))));
    let values = indices.map(|(p, r, k)| (of_mode(p, r, k).clamp(-1.0, 1.0) * steps).round() as i16);
    arrays.push_i16("shape_coefficient", &[modes.len(), listed, rank], values);

    let nodes = superelements.iter().flat_map(|s| s.skin.nodes.iter().flatten().copied());
    arrays.push_f32("skin_node", &[first_node, 3], nodes);
    let triangles: Vec<usize> = superelements
        .iter()
        .zip(&parts)
        .flat_map(|(s, part)| s.skin.triangles.iter().flatten().map(|n| n + part.first_node))
        .collect();
    arrays.push_u32("skin_triangle", &[triangles.len() / 3, 3], triangles.iter().copied());
    Ok(parts)
}
