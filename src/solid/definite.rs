//! Whether a given matrix is positive semidefinite.

use super::SolidError;
use crate::linalg::{Cholesky, Indefinite, Ordering, SparseSymmetric};

/// A negative eigenvalue below this share of the diagonal is rounding.
const ROUNDING: f64 = 1e-9;

/// Refuses a matrix with a negative diagonal, a row without diagonal, or negative eigenvalues: A +
/// 1e-9 diag(A) must have a Cholesky factor. A row of the mass that is zero throughout is allowed.
pub(super) fn check(
    part: &str,
    what: &'static str,
    matrix: &SparseSymmetric,
    ordering: &Ordering,
    place: &dyn Fn(usize) -> String,
) -> Result<(), SolidError> {
    let refused = |unknown: usize, reason: String| SolidError::NotSemidefinite {
        part: part.to_string(),
        what,
        place: place(unknown),
        reason,
        tolerance: ROUNDING,
    };
    let mut some = false;
    for (i, diagonal) in matrix.diagonal().into_iter().enumerate() {
        let empty = matrix.row(i).all(|(_, v)| v == 0.0);
        some |= diagonal > 0.0;
        if diagonal < 0.0 || diagonal == 0.0 && !(empty && what == "mass") {
            return Err(refused(i, format!("its diagonal is {diagonal:.6e}")));
        }
    }
    if !some {
        return Err(refused(0, "the whole matrix is zero".into()));
    }
    let raised = matrix.with_diagonal(|_, d| if d == 0.0 { 1.0 } else { d * (1.0 + ROUNDING) });
    let unknown = match Cholesky::new(&raised, ordering) {
        Ok(_) => return Ok(()),
        Err(crate::linalg::LinalgError::NotPositiveDefinite { unknown, .. }) => unknown,
        Err(source) => return Err(SolidError::Ordering { part: part.to_string(), source }),
    };
    let count = Indefinite::new(&raised, ordering).map_or_else(
        |_| "at least one eigenvalue is negative".to_string(),
        |factor| format!("{} of its {} eigenvalues are negative", factor.negative_eigenvalues().max(1), matrix.n()),
    );
    Err(refused(unknown, format!("{count}, the first pivot that is not positive stands here")))
}
