//! What moves freely: the motions of the free parts that no joint resists.
//!
//! Whether a motion is free is a question of geometry, not of size: a mount of 1 N/m holds, however stiff the
//! bolts beside it are. The rigid motions of the free parts (K R = 0) are the coordinates with eigenvalue
//! zero; a combination of them is free where no spring with a stiffness reads it.

use nalgebra::{DMatrix, DVector};

/// A spring's row that moves less than this share of itself with the rigid coordinates does not read them.
const UNREAD: f64 = 1e-9;
/// A singular value below this share of the largest is zero: rows are known to some 1e-12.
const RANK: f64 = 1e-8;

/// The free motions over all coordinates, n x n_free, orthonormal.
///
/// `rows` are the springs' rows (n_springs x n), of which those with `stiffness` above zero resist;
/// `eigenvalues` are exactly zero for the rigid coordinates.
pub(super) fn free_motions(rows: &DMatrix<f64>, eigenvalues: &DVector<f64>, stiffness: &[f64]) -> DMatrix<f64> {
    let rigid: Vec<usize> = (0..eigenvalues.len()).filter(|&i| eigenvalues[i] == 0.0).collect();
    let r = rigid.len();
    if r == 0 {
        return DMatrix::zeros(eigenvalues.len(), 0);
    }
    let mut read: Vec<Vec<f64>> = Vec::new();
    for (s, _) in stiffness.iter().enumerate().filter(|(_, k)| **k > 0.0) {
        let row: Vec<f64> = rigid.iter().map(|&i| rows[(s, i)]).collect();
        let size = row.iter().map(|v| v * v).sum::<f64>().sqrt();
        if size > UNREAD * rows.row(s).norm() {
            read.push(row.iter().map(|v| v / size).collect());
        }
    }
    let null = orthonormal(separated(&null_space(&read, r)));
    let mut out = DMatrix::zeros(eigenvalues.len(), null.ncols());
    for (k, &i) in rigid.iter().enumerate() {
        out.row_mut(i).copy_from(&null.row(k));
    }
    out
}

/// Orthonormal vectors of `columns` entries that every row (of unit length) leaves at zero.
pub fn null_space(rows: &[Vec<f64>], columns: usize) -> DMatrix<f64> {
    // At least as many rows as columns, so that all right singular vectors are there.
    let padded = DMatrix::from_fn(rows.len().max(columns), columns, |i, j| rows.get(i).map_or(0.0, |row| row[j]));
    let svd = padded.svd(false, true);
    let vectors = svd.v_t.unwrap_or_else(|| DMatrix::identity(columns, columns));
    let largest = svd.singular_values.max();
    let free: Vec<usize> = (0..columns).filter(|&k| svd.singular_values[k] <= RANK * largest).collect();
    DMatrix::from_fn(columns, free.len(), |i, k| vectors[(free[k], i)])
}

/// The same motions, each as far by itself as it goes: a spindle's turn is not mixed with a slide's travel.
///
/// By elimination with pivots: every vector has an entry 1 where all others have 0.
pub fn separated(null: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = null.clone();
    let (rows, columns) = out.shape();
    let mut taken = vec![false; rows];
    for k in 0..columns {
        let places = (0..rows).filter(|&i| !taken[i]).flat_map(|i| (k..columns).map(move |j| (i, j)));
        let size = |&(i, j): &(usize, usize)| out[(i, j)].abs();
        let Some((i, j)) = places.max_by(|a, b| size(a).total_cmp(&size(b))) else { break };
        taken[i] = true;
        out.swap_columns(k, j);
        let pivot = out[(i, k)];
        out.column_mut(k).scale_mut(pivot.recip());
        for other in (0..columns).filter(|&other| other != k) {
            let share = out[(i, other)];
            let part = out.column(k) * share;
            let mut column = out.column_mut(other);
            column -= part;
        }
    }
    let size = out.amax();
    out.apply(|v| {
        if v.abs() < RANK * size {
            *v = 0.0;
        }
    });
    out
}

/// Orthonormal vectors of the same span, those with the fewest entries first, which stay as they are.
fn orthonormal(mut vectors: DMatrix<f64>) -> DMatrix<f64> {
    let entries = |k: usize| vectors.column(k).iter().filter(|v| **v != 0.0).count();
    let mut order: Vec<usize> = (0..vectors.ncols()).collect();
    order.sort_by_key(|&k| entries(k));
    vectors = vectors.select_columns(&order);
    for k in 0..vectors.ncols() {
        for _ in 0..2 {
            for before in 0..k {
                let share = vectors.column(before).dot(&vectors.column(k));
                let part = vectors.column(before) * share;
                let mut column = vectors.column_mut(k);
                column -= part;
            }
        }
        vectors.column_mut(k).normalize_mut();
    }
    vectors
}
