//! Sparse factor, inertia, Lanczos and the dense eigenproblem, against dense references and constructed spectra.

mod support;

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use std::sync::OnceLock;
use stiffmap::linalg::*;
use stiffmap::solid::{SecondOrder, assemble};
use support::dense::{eigenvalues, full, symmetric_values};
use support::{box_mesh, part, worst_ratio};

struct Body {
    system: SecondOrder,
    ordering: Ordering,
    eigenvalues: Vec<f64>,
}

/// A clamped beam of 216 unknowns.
fn body() -> &'static Body {
    static BODY: OnceLock<Body> = OnceLock::new();
    BODY.get_or_init(|| {
        let mesh = box_mesh([0.0; 3], [0.06, 0.08, 0.4], [1, 1, 4]);
        let system = assemble(&part("beam", &["ZMIN"], vec![]), &mesh).expect("assembles");
        let ordering = system.ordering().expect("METIS orders it");
        let eigenvalues = eigenvalues(&full(&system.stiffness), &full(&system.mass), 0.0);
        Body { system, ordering, eigenvalues }
    })
}

/// Reproducible numbers in (-1, 1).
fn numbers(rows: usize, columns: usize, seed: f64) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |i, j| ((i * columns + j) as f64 * 78.233 + seed).sin() * 43_758.545 % 1.0)
}

#[test]
fn the_sparse_product_is_the_dense_one() {
    let k = &body().system.stiffness;
    for columns in [1, 7, 8, 9, 20] {
        let x = numbers(k.n(), columns, 1.0);
        let (mine, dense) = (k.multiply(&x), full(k) * &x);
        assert!((&mine - &dense).amax() < 1e-13 * dense.amax());
        let other = numbers(k.n(), columns, 2.0);
        assert!((k.multiply(&other) - &dense).amax() > 1e-3 * dense.amax());
    }
}

// Backward error of Cholesky: |b - K x| <= c n eps |K| |x|.
#[test]
fn cholesky_solves_to_a_small_residual() {
    let k = &body().system.stiffness;
    let factor = Cholesky::new(k, &body().ordering).expect("positive definite");
    let b = numbers(k.n(), 5, 0.3);
    let x = factor.solve(&b);
    let scale = full(k).amax() * x.amax();
    let residual = |x: &DMatrix<f64>| (&b - k.multiply(x)).amax() / scale;
    assert!(residual(&x) < 1e-14, "{:.1e}", residual(&x));
    assert!(residual(&(&x * (1.0 + 1e-6))) > 100.0 * residual(&x), "control: 1e-6 of the solution shows");
    let dense = full(k).cholesky().expect("positive definite").solve(&b);
    assert!((&x - &dense).amax() < 1e-9 * dense.amax());
}

#[test]
fn cholesky_refuses_an_indefinite_matrix() {
    let Body { system, ordering, eigenvalues } = body();
    let shifted = system.stiffness.plus_scaled(-1.01 * eigenvalues[0], &system.mass);
    let refused = Cholesky::new(&shifted, ordering).err();
    assert!(matches!(refused, Some(LinalgError::NotPositiveDefinite { n, .. }) if n == system.n_dof()), "{refused:?}");
    let below = system.stiffness.plus_scaled(-0.99 * eigenvalues[0], &system.mass);
    assert!(Cholesky::new(&below, ordering).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn the_inertia_counts_the_eigenvalues_below_any_shift(place in 0.0..1.0f64) {
        let Body { system, ordering, eigenvalues } = body();
        let (low, high) = (0.5 * eigenvalues[0], eigenvalues[eigenvalues.len() - 1] * 1.1);
        let shift = low * (high / low).powf(place);
        let nearest = eigenvalues.iter().map(|l| (l / shift - 1.0).abs()).fold(1.0, f64::min);
        prop_assume!(nearest > 1e-8);
        let matrix = system.stiffness.plus_scaled(-shift, &system.mass);
        let factor = Indefinite::new(&matrix, ordering).expect("regular");
        prop_assert_eq!(factor.negative_eigenvalues(), eigenvalues.iter().filter(|l| **l < shift).count());
        // Control: three eigenvalues further up the count is another one.
        if let Some(up) = eigenvalues.iter().copied().filter(|l| *l > shift).nth(2) {
            let further = Indefinite::new(&system.stiffness.plus_scaled(-up * 1.0000001, &system.mass), ordering).expect("regular");
            prop_assert!(further.negative_eigenvalues() > factor.negative_eigenvalues());
        }
        let b = numbers(system.n_dof(), 2, place);
        let x = factor.solve(&b);
        prop_assert!((&b - matrix.multiply(&x)).amax() < 1e-11 * full(&matrix).amax() * x.amax());
    }
}

#[test]
fn lanczos_finds_the_dense_eigenvalues_with_mass_normalised_shapes() {
    let Body { system, ordering, eigenvalues } = body();
    let factor = Cholesky::new(&system.stiffness, ordering).expect("positive definite");
    let find = |modes: usize, block: usize| {
        let options = LanczosOptions { modes, block, tolerance: 1e-8, beyond: 6, interrupt: None };
        lowest_modes(&system.mass, &|load: &DMatrix<f64>| factor.solve(load), options).expect("converges")
    };
    for (modes, block) in [(1, 1), (12, 1), (12, 4), (40, 8), (system.n_dof(), 8)] {
        let found = find(modes, block);
        assert_eq!(found.eigenvalues.len(), modes);
        let error = worst_ratio(&found.eigenvalues, &eigenvalues[..modes]);
        assert!(error < 1e-10, "{modes} modes, block {block}: {error:.1e}");
        let mass = found.shapes.transpose() * system.mass.multiply(&found.shapes);
        assert!((mass - DMatrix::identity(modes, modes)).amax() < 1e-9);
        let stiffness = found.shapes.transpose() * system.stiffness.multiply(&found.shapes);
        for r in 0..modes {
            assert!((stiffness[(r, r)] / found.eigenvalues[r] - 1.0).abs() < 1e-8);
        }
    }
    assert!(worst_ratio(&find(12, 4).eigenvalues, &eigenvalues[1..13]) > 0.05, "control: shifted by one mode");
}

/// L diag(values) L^T with unit lower triangular L: graded from the first unknown to the last.
fn graded(values: &[f64]) -> DMatrix<f64> {
    let n = values.len();
    let lower = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
        std::cmp::Ordering::Less => 0.0,
        std::cmp::Ordering::Equal => 1.0,
        std::cmp::Ordering::Greater => 0.3 * ((i * n + j) as f64 * 12.9898).sin() / (1.0 + (i - j) as f64),
    });
    let root = DVector::from_iterator(n, values.iter().map(|v| v.sqrt()));
    let scaled = lower * DMatrix::from_diagonal(&root);
    &scaled * scaled.transpose()
}

/// The low eigenvalues as reciprocals of the largest of the inverse, which Cholesky's triangular solves give to high
/// relative accuracy for a graded matrix.
fn by_inverse(a: &DMatrix<f64>) -> Vec<f64> {
    eigenvalues(a, &DMatrix::identity(a.nrows(), a.nrows()), 0.0)
}

fn spectrum() -> Vec<f64> {
    (0..200).map(|i| 10f64.powf(4.0 + 8.0 * i as f64 / 199.0)).collect()
}

/// Largest relative error of the 40 lowest eigenvalues, whatever the order of the unknowns.
fn low_end_error(a: &DMatrix<f64>) -> f64 {
    let n = a.nrows();
    let reference = by_inverse(a);
    let orders: [&dyn Fn(usize) -> usize; 3] = [&|i| i, &|i| n - 1 - i, &|i| (i * 37) % n];
    let error = |order: &&dyn Fn(usize) -> usize| {
        let mixed = DMatrix::from_fn(n, n, |i, j| a[(order(i), order(j))]);
        let eigen = symmetric_eigen(&mixed).expect("converges");
        worst_ratio(&eigen.values.as_slice()[..40], &reference[..40])
    };
    orders.iter().map(error).fold(0.0, f64::max)
}

// An absolute error of eps |A| would be 2.2e-16 x 1e12 / 1e4 = 2e-8 of the lowest eigenvalue.
#[test]
fn the_dense_eigenproblem_is_backward_stable_on_a_graded_matrix() {
    let a = graded(&spectrum());
    let n = a.nrows();
    let eigen = symmetric_eigen(&a).expect("converges");
    assert!((eigen.vectors.transpose() * &eigen.vectors - DMatrix::identity(n, n)).amax() < 1e-12);
    let residual = &a * &eigen.vectors - &eigen.vectors * DMatrix::from_diagonal(&eigen.values);
    assert!(residual.amax() < 1e-13 * a.amax());
    let error = low_end_error(&a);
    assert!(error < 2e-8, "{error:.1e}");
    let mut reference = by_inverse(&a);
    reference[0] *= 1.0 + 1e-6;
    assert!(worst_ratio(&eigen.values.as_slice()[..1], &reference[..1]) > 2e-8, "control");
}

#[test]
fn the_dense_eigenproblem_keeps_the_low_end_of_a_graded_matrix() {
    let error = low_end_error(&graded(&spectrum()));
    assert!(error < 1e-11, "{error:.1e}");
}

/// Lambda + W^T W of a soft and a very stiff spring beside each other, its exact low eigenvalues: two masses on a
/// line, the first on a mount k_1, the second on it by k_2, and a third that nothing holds but a spring of 1 N/m.
fn two_masses(stiff: f64) -> (Vec<f64>, DMatrix<f64>, [f64; 3]) {
    let (soft, m) = (400.0_f64, [3.0_f64, 5.0, 2.0]);
    let rows = [[soft.sqrt() / m[0].sqrt(), 0.0, 0.0], [-stiff.sqrt() / m[0].sqrt(), stiff.sqrt() / m[1].sqrt(), 0.0]];
    let third = [0.0, 0.0, 1.0 / m[2].sqrt()];
    let w = DMatrix::from_fn(3, 3, |i, j| if i < 2 { rows[i][j] } else { third[j] });
    // lambda^2 - b lambda + c = 0 for the pair; the low root by c over the high one, which cancels nothing.
    let b = (soft + stiff) / m[0] + stiff / m[1];
    let c = soft * stiff / (m[0] * m[1]);
    let high = 0.5 * (b + (b * b - 4.0 * c).sqrt());
    (vec![0.0; 3], w, [1.0 / m[2], c / high, high])
}

#[test]
fn soft_springs_keep_their_digits_beside_any_stiff_one() {
    for stiff in [1e4, 1e8, 1e12, 1e16, 1e20] {
        let (lambda, w, exact) = two_masses(stiff);
        let shift = 30.0;
        let raised: Vec<f64> = lambda.iter().map(|l| l + shift).collect();
        let h = flexibility_with_springs(&raised, &w).expect("finite");
        let found = eigen_of_flexibility(&h, shift).expect("converges").values;
        let error = worst_ratio(&found.as_slice()[..2], &exact[..2]);
        assert!(error < 1e-12, "{stiff:e}: {error:.1e}");
        // Control: the sum of the squares in one matrix has lost the soft ones beside the stiffest.
        if stiff > 1e19 {
            let summed = symmetric_eigen(&(w.transpose() * &w)).expect("converges").values;
            assert!(worst_ratio(&summed.as_slice()[..2], &exact[..2]) > 1e-3, "control: {summed}");
        }
    }
}

#[test]
fn a_graded_factor_is_orthonormal_and_inverts_rows_of_any_size() {
    let n = 6;
    let rows = numbers(20, n, 0.7);
    let a = DMatrix::from_fn(20, n, |i, j| rows[(i, j)] * 10f64.powi(i as i32 - 10));
    let factor = graded_factor(&a).expect("full rank");
    let (q, p) = (&factor.span, &factor.rest);
    assert!((q.transpose() * q - DMatrix::identity(n, n)).amax() < 1e-14);
    assert!((q * q.transpose() + p * p.transpose() - DMatrix::identity(20, 20)).amax() < 1e-14);
    assert!((&a * &factor.inverse - q).amax() < 1e-9, "A R^-1 = Q");
    assert!(graded_factor(&DMatrix::from_element(3, 1, f64::INFINITY)).is_err());
    // Rows of a stiff joint twice and a soft one: two directions, and the Gram matrix is theirs.
    let w = DMatrix::from_row_slice(3, 3, &[1e9, 0.0, 0.0, 2e9, 0.0, 0.0, 1.0, 3.0, 0.0]);
    let (v, inverse) = independent_rows(&w).expect("finite");
    assert_eq!(v.ncols(), 2);
    let gram = inverse.clone().try_inverse().expect("regular");
    let (whole, exact) = (&v * gram * v.transpose(), w.transpose() * &w);
    assert!((whole[(0, 0)] / exact[(0, 0)] - 1.0).abs() < 1e-12 && (whole[(1, 1)] / 9.0 - 1.0).abs() < 1e-6);
}

#[test]
fn small_counts_and_spans_are_what_they_say() {
    let a = DMatrix::from_diagonal(&DVector::from_vec(vec![3.0, -1.0, 0.5, -2.0]));
    assert_eq!(count_negative(&a).expect("finite"), 2);
    assert_eq!(count_negative(&-a).expect("finite"), 2);
    let three = numbers(20, 3, 0.1);
    let six = DMatrix::from_fn(20, 6, |i, j| if j < 3 { three[(i, j)] } else { three[(i, j - 3)] + three[(i, j % 2)] });
    let span = orthonormal_span(&six, 1e-10).expect("finite");
    assert_eq!(span.ncols(), 3);
    assert!((&span * span.transpose() * &six - &six).amax() < 1e-13);
    let combine = independent_directions(&(six.transpose() * &six), 1e-10).expect("finite");
    assert_eq!(combine.ncols(), 3);
    assert!(((&six * &combine).transpose() * (&six * &combine) - DMatrix::identity(3, 3)).amax() < 1e-12);
    assert!(orthonormal_span(&DMatrix::from_element(3, 1, f64::NAN), 1e-10).is_err());
    assert!(symmetric_eigen(&DMatrix::from_element(2, 2, f64::NAN)).is_err());
    let b = numbers(7, 9, 3.0);
    assert!((multiply(&three, &three.transpose()) - &three * three.transpose()).amax() < 1e-14);
    assert!((multiply_transposed(&b, &b) - b.transpose() * &b).amax() < 1e-14);
    assert!(
        symmetric_values(&(b.transpose() * &b))[1].abs() < 1e-13,
        "nine columns of seven rows depend on each other"
    );
}
