//! Sparse Cholesky factor and inertia (faer's supernodal kernels on a METIS order).

use super::{LinalgError, Ordering, SparseSymmetric};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, IntranodeLbltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Sparse Cholesky factor of a symmetric positive definite matrix.
pub struct Cholesky {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl Cholesky {
    /// Factors a symmetric positive definite matrix.
    ///
    /// # Errors
    /// [`LinalgError::NotPositiveDefinite`] with the unknown whose pivot is not positive;
    /// [`LinalgError::Factorisation`] if the factor does not fit into memory.
    pub fn new(a: &SparseSymmetric, ordering: &Ordering) -> Result<Self, LinalgError> {
        let n = a.n();
        let symbolic = analyse(a, ordering)?;
        let mut values = vec![0.0; symbolic.len_val()];
        let par = Par::Seq;
        let mut memory = workspace(n, symbolic.factorize_numeric_llt_scratch::<f64>(par, Spec::default()))?;
        symbolic
            .factorize_numeric_llt(
                &mut values,
                view(a),
                Side::Lower,
                Default::default(),
                par,
                MemStack::new(&mut memory),
                Spec::default(),
            )
            .map_err(|error| {
                let faer::linalg::cholesky::llt::factor::LltError::NonPositivePivot { index } = error;
                LinalgError::NotPositiveDefinite { unknown: ordering.forward.get(index).copied().unwrap_or(index), n }
            })?;
        Ok(Self { symbolic, values })
    }

    /// Solves A X = B for an n x b block.
    pub fn solve(&self, b: &DMatrix<f64>) -> DMatrix<f64> {
        let n = b.nrows();
        assert_eq!(n, self.symbolic.nrows(), "rows of the block against the order of the factor");
        let mut x = b.clone();
        by_panels(&mut x, |rhs, columns| {
            let mut memory = MemBuffer::new(self.symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq));
            let rhs = MatMut::from_column_major_slice_mut(rhs, n, columns);
            let memory = MemStack::new(&mut memory);
            LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, memory);
        });
        x
    }

    /// Numbers in the factor.
    pub fn entries(&self) -> usize {
        self.values.len()
    }
}

/// Factor L B L^T of a symmetric indefinite matrix, with its inertia.
pub struct Indefinite {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
    subdiagonal: Vec<f64>,
    forward: Vec<usize>,
    inverse: Vec<usize>,
    negative: usize,
}

impl Indefinite {
    /// Factors a symmetric matrix that need not be definite.
    ///
    /// # Errors
    /// [`LinalgError::Factorisation`] if the factor does not fit into memory or a pivot is zero or not
    /// finite: the matrix is singular to working precision.
    pub fn new(a: &SparseSymmetric, ordering: &Ordering) -> Result<Self, LinalgError> {
        let n = a.n();
        let symbolic = analyse(a, ordering)?;
        let mut values = vec![0.0; symbolic.len_val()];
        let mut subdiagonal = vec![0.0; n];
        let (mut forward, mut inverse) = (vec![0_usize; n], vec![0_usize; n]);
        let par = Par::Seq;
        let mut memory = workspace(n, symbolic.factorize_numeric_intranode_lblt_scratch::<f64>(par, Spec::default()))?;
        symbolic.factorize_numeric_intranode_lblt(
            &mut values,
            &mut subdiagonal,
            &mut forward,
            &mut inverse,
            view(a),
            Side::Lower,
            par,
            MemStack::new(&mut memory),
            Spec::default(),
        );
        let negative = count_negative_pivots(&symbolic, &values, &subdiagonal)?;
        Ok(Self { symbolic, values, subdiagonal, forward, inverse, negative })
    }

    /// Negative eigenvalues of the matrix (Sylvester's law of inertia).
    pub fn negative_eigenvalues(&self) -> usize {
        self.negative
    }

    /// Solves A X = B for an n x b block.
    pub fn solve(&self, b: &DMatrix<f64>) -> DMatrix<f64> {
        let n = b.nrows();
        assert_eq!(n, self.symbolic.nrows(), "rows of the block against the order of the factor");
        let mut x = b.clone();
        let perm = PermRef::new_checked(&self.forward, &self.inverse, n);
        by_panels(&mut x, |rhs, columns| {
            let mut memory = MemBuffer::new(self.symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq));
            let rhs = MatMut::from_column_major_slice_mut(rhs, n, columns);
            let memory = MemStack::new(&mut memory);
            IntranodeLbltRef::new(&self.symbolic, &self.values, &self.subdiagonal, perm).solve_in_place_with_conj(
                Conj::No,
                rhs,
                Par::Seq,
                memory,
            );
        });
        x
    }
}

/// Columns that one thread solves for together. The number is fixed, so that the sums, and with them the last bits of
/// a result, are the same however many threads there are.
const PANEL: usize = 64;

/// Calls `solve` with panels of columns of a block and their number, side by side.
fn by_panels(block: &mut DMatrix<f64>, solve: impl Fn(&mut [f64], usize) + Sync) {
    let n = block.nrows();
    if n > 0 && block.ncols() <= PANEL {
        let columns = block.ncols();
        solve(block.as_mut_slice(), columns);
    } else if n > 0 {
        block.as_mut_slice().par_chunks_mut(PANEL * n).for_each(|panel| solve(panel, panel.len() / n));
    }
}

/// Negative eigenvalues of the block diagonal factor B.
fn count_negative_pivots(
    symbolic: &SymbolicCholesky<usize>,
    values: &[f64],
    subdiagonal: &[f64],
) -> Result<usize, LinalgError> {
    let n = symbolic.nrows();
    let SymbolicCholeskyRaw::Supernodal(structure) = symbolic.raw() else {
        unreachable!("the analysis asks for supernodes");
    };
    let singular = |v: f64| !v.is_finite() || v == 0.0;
    let mut negative = 0;
    for s in 0..structure.n_supernodes() {
        let (begin, end) = (structure.supernode_begin()[s], structure.supernode_end()[s]);
        let columns = end - begin;
        let at = structure.col_ptr_for_val()[s];
        let rows = (structure.col_ptr_for_val()[s + 1] - at) / columns.max(1);
        let diagonal = |j: usize| values[at + j * rows + j];
        let mut j = 0;
        while j < columns {
            let (d, below) = (diagonal(j), subdiagonal[begin + j]);
            if below == 0.0 {
                if singular(d) {
                    return Err(LinalgError::Factorisation { n, reason: format!("pivot {d} in the inertia count") });
                }
                negative += usize::from(d < 0.0);
                j += 1;
            } else {
                let determinant = d * diagonal(j + 1) - below * below;
                if singular(determinant) {
                    return Err(LinalgError::Factorisation {
                        n,
                        reason: format!("2 x 2 pivot of determinant {determinant}"),
                    });
                }
                negative += if determinant < 0.0 { 1 } else { 2 * usize::from(d < 0.0) };
                j += 2;
            }
        }
    }
    Ok(negative)
}

/// Numbers in the factor of a matrix, from its pattern alone.
///
/// # Errors
/// [`LinalgError::Factorisation`] if the pattern is none.
pub fn factor_entries(a: &SparseSymmetric, ordering: &Ordering) -> Result<usize, LinalgError> {
    Ok(analyse(a, ordering)?.len_val())
}

fn analyse(a: &SparseSymmetric, ordering: &Ordering) -> Result<SymbolicCholesky<usize>, LinalgError> {
    let n = a.n();
    assert_eq!(ordering.forward.len(), n, "unknowns of the ordering against the order of the matrix");
    let params = CholeskySymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..CholeskySymbolicParams::default()
    };
    let order = SymmetricOrdering::Custom(PermRef::new_checked(&ordering.forward, &ordering.inverse, n));
    factorize_symbolic_cholesky(view(a).symbolic(), Side::Lower, order, params)
        .map_err(|error| LinalgError::Factorisation { n, reason: format!("{error:?}") })
}

/// faer's view of the matrix, by columns (rows and columns are the same).
fn view(a: &SparseSymmetric) -> SparseColMatRef<'_, usize, f64> {
    SparseColMatRef::new(
        SymbolicSparseColMatRef::new_checked(a.n(), a.n(), a.row_starts(), None, a.columns()),
        a.values(),
    )
}

fn workspace(n: usize, request: faer::dyn_stack::StackReq) -> Result<MemBuffer, LinalgError> {
    MemBuffer::try_new(request).map_err(|_| LinalgError::Factorisation {
        n,
        reason: format!("no memory for {} bytes of workspace", request.size_bytes()),
    })
}
