//! How far a frequency is from its value on an infinitely fine mesh (Richardson's extrapolation).
//!
//! ```text
//! f(h) = f* + c h^p      h0 > h1 > h2:  (f0 - f1) / (f1 - f2) = (h0^p - h1^p) / (h1^p - h2^p)
//! f* = f2 - (f1 - f2) h2^p / (h1^p - h2^p)
//! ```
//!
//! Three meshes give the order p; with two it is assumed. A sequence that turns round has no order.
//!
//! # Source
//! P. J. Roache, J. Fluids Eng. 116 (1994) 405.

/// Orders that can be observed: below the first a sequence does not converge, above the last its
/// differences are rounding or chance.
const ORDERS: [f64; 2] = [0.3, 8.0];
/// Relative differences below this are no sequence any more.
const SETTLED: f64 = 1e-8;

/// A frequency's estimate from meshes of two or three sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extrapolation {
    /// Order p, observed from three meshes or assumed with two; `None` where the frequency has settled.
    pub order: Option<f64>,
    /// f*, Hz.
    pub limit: f64,
    /// Distance of the finest mesh's frequency from f*, relative to f*; positive if it lies above.
    pub error: f64,
}

/// Why there is no estimate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConvergenceError {
    /// The differences change their sign.
    #[error("not monotone: {coarse:.6}, {middle:.6}, {fine:.6} Hz from coarse to fine")]
    NotMonotone {
        /// Coarsest mesh, Hz.
        coarse: f64,
        /// Middle mesh, Hz.
        middle: f64,
        /// Finest mesh, Hz.
        fine: f64,
    },
    /// The differences do not shrink as any order would have them.
    #[error("no order from {} to {} fits {coarse:.6}, {middle:.6}, {fine:.6} Hz from coarse to fine", ORDERS[0], ORDERS[1])]
    NoOrder {
        /// Coarsest mesh, Hz.
        coarse: f64,
        /// Middle mesh, Hz.
        middle: f64,
        /// Finest mesh, Hz.
        fine: f64,
    },
}

/// The estimate from two or three (mesh size, frequency in Hz), coarsest first; `assumed` is the order
/// that two meshes go by.
///
/// # Errors
/// [`ConvergenceError`] for three frequencies that no order fits.
pub fn extrapolate(meshes: &[(f64, f64)], assumed: f64) -> Result<Extrapolation, ConvergenceError> {
    assert!(matches!(meshes.len(), 2 | 3), "two or three meshes, not {}", meshes.len());
    assert!(meshes.windows(2).all(|m| m[0].0 > m[1].0), "mesh sizes fall: {meshes:?}");
    let [(h1, f1), (h2, f2)] = meshes[meshes.len() - 2..] else { unreachable!("two are left") };
    if meshes.iter().all(|(_, f)| (f - f2).abs() <= SETTLED * f2.abs()) {
        return Ok(Extrapolation { order: None, limit: f2, error: 0.0 });
    }
    let order = if let [(h0, f0), ..] = *meshes
        && meshes.len() == 3
    {
        observed([h0, h1, h2], [f0, f1, f2])?
    } else {
        assumed
    };
    let limit = f2 - (f1 - f2) / ((h1 / h2).powf(order) - 1.0);
    Ok(Extrapolation { order: Some(order), limit, error: f2 / limit - 1.0 })
}

fn observed([h0, h1, h2]: [f64; 3], [coarse, middle, fine]: [f64; 3]) -> Result<f64, ConvergenceError> {
    let (first, second) = (coarse - middle, middle - fine);
    if first * second <= 0.0 {
        return Err(ConvergenceError::NotMonotone { coarse, middle, fine });
    }
    // The right side grows with p.
    let excess = |p: f64| (h0.powf(p) - h1.powf(p)) / (h1.powf(p) - h2.powf(p)) - first / second;
    let [mut low, mut high] = ORDERS;
    if excess(low) > 0.0 || excess(high) < 0.0 {
        return Err(ConvergenceError::NoOrder { coarse, middle, fine });
    }
    for _ in 0..60 {
        let p = 0.5 * (low + high);
        if excess(p) > 0.0 { high = p } else { low = p }
    }
    Ok(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::{ConvergenceError, extrapolate};

    fn sequence(order: f64, limit: f64, c: f64) -> Vec<(f64, f64)> {
        [0.4, 0.23, 0.1].map(|h: f64| (h, limit + c * h.powf(order))).to_vec()
    }

    #[test]
    fn a_sequence_of_any_order_is_recognised_and_its_limit_found() {
        for order in [0.5, 1.0, 2.0, 4.0, 6.5] {
            for c in [3.0, -0.2] {
                let meshes = sequence(order, 87.3, c);
                let three = extrapolate(&meshes, 99.0).unwrap();
                assert!((three.order.unwrap() - order).abs() < 1e-6, "{three:?}");
                assert!((three.limit - 87.3).abs() < 1e-9 && three.error * c > 0.0, "{three:?}");
                let two = extrapolate(&meshes[1..], order).unwrap();
                assert!((two.limit - 87.3).abs() < 1e-9, "{two:?}");
                // Negative control: another order misses the limit.
                assert!((extrapolate(&meshes[1..], order + 1.0).unwrap().limit - 87.3).abs() > 5e-9);
            }
        }
    }

    #[test]
    fn a_sequence_that_turns_or_grows_is_refused_and_a_settled_one_has_no_order() {
        let with = |f: [f64; 3]| extrapolate(&[(0.4, f[0]), (0.2, f[1]), (0.1, f[2])], 2.0);
        assert!(matches!(with([50.0, 49.0, 49.5]), Err(ConvergenceError::NotMonotone { .. })));
        assert!(matches!(with([50.0, 49.9, 49.0]), Err(ConvergenceError::NoOrder { .. })));
        assert!(matches!(with([60.0, 49.000001, 49.0]), Err(ConvergenceError::NoOrder { .. })));
        let settled = with([49.0 + 1e-8, 49.0 - 1e-8, 49.0]).unwrap();
        assert!(settled.order.is_none() && settled.error == 0.0);
    }
}
