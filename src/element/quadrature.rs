//! Quadrature rules on the reference tetrahedron and triangle.
//!
//! Weights sum to the reference domain's measure (1/6 and 1/2).

/// A point of the reference tetrahedron with its weight.
#[derive(Clone, Copy, Debug)]
pub struct TetPoint {
    /// Coordinates (r, s, t); the fourth barycentric coordinate is 1 - r - s - t and belongs to node 1.
    pub at: [f64; 3],
    /// Weight.
    pub weight: f64,
}

/// A point of the reference triangle with its weight.
#[derive(Clone, Copy, Debug)]
pub struct TriPoint {
    /// Coordinates (r, s).
    pub at: [f64; 2],
    /// Weight.
    pub weight: f64,
}

/// Four points, exact to degree 2: the stiffness rule of CalculiX's C3D10.
pub fn tet_degree_2() -> [TetPoint; 4] {
    // (5 - sqrt 5) / 20 and (5 + 3 sqrt 5) / 20.
    let a = (5.0 - 5.0_f64.sqrt()) / 20.0;
    let b = (5.0 + 3.0 * 5.0_f64.sqrt()) / 20.0;
    let weight = 1.0 / 24.0;
    [[a, a, a], [b, a, a], [a, b, a], [a, a, b]].map(|at| TetPoint { at, weight })
}

/// Fifteen points, exact to degree 5: the consistent-mass rule.
///
/// # Source
/// P. Keast, Moderate-degree tetrahedral quadrature formulas, Comput. Methods Appl. Mech. Eng. 55 (1986).
pub fn tet_degree_5() -> [TetPoint; 15] {
    let (third, eleventh) = (1.0 / 3.0, 1.0 / 11.0);
    let (centre, face) = (6544.0 / 36015.0 / 6.0, 81.0 / 2240.0 / 6.0);
    let (inner, edge) = (161_051.0 / 2_304_960.0 / 6.0, 338.0 / 5145.0 / 6.0);
    let a = 0.25 * (1.0 - (7.0_f64 / 13.0).sqrt());
    let b = 0.5 - a;
    let point = |at, weight| TetPoint { at, weight };
    [
        point([0.25, 0.25, 0.25], centre),
        point([third, third, third], face),
        point([0.0, third, third], face),
        point([third, 0.0, third], face),
        point([third, third, 0.0], face),
        point([eleventh, eleventh, eleventh], inner),
        point([8.0 * eleventh, eleventh, eleventh], inner),
        point([eleventh, 8.0 * eleventh, eleventh], inner),
        point([eleventh, eleventh, 8.0 * eleventh], inner),
        point([b, a, a], edge),
        point([a, b, a], edge),
        point([a, a, b], edge),
        point([a, b, b], edge),
        point([b, a, b], edge),
        point([b, b, a], edge),
    ]
}

/// Seven points, exact to degree 5, for surface integrals.
///
/// # Source
/// J. Radon, Zur mechanischen Kubatur, Monatsh. Math. 52 (1948).
pub fn tri_degree_5() -> [TriPoint; 7] {
    let root = 15.0_f64.sqrt();
    let (a, b) = ((6.0 - root) / 21.0, (6.0 + root) / 21.0);
    let (wa, wb) = ((155.0 - root) / 2400.0, (155.0 + root) / 2400.0);
    let point = |r, s, weight| TriPoint { at: [r, s], weight };
    [
        point(1.0 / 3.0, 1.0 / 3.0, 9.0 / 80.0),
        point(a, a, wa),
        point(1.0 - 2.0 * a, a, wa),
        point(a, 1.0 - 2.0 * a, wa),
        point(b, b, wb),
        point(1.0 - 2.0 * b, b, wb),
        point(b, 1.0 - 2.0 * b, wb),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: u32) -> f64 {
        (1..=n).map(f64::from).product()
    }

    /// Largest error over all monomials of a total degree.
    fn tet_error(rule: &[TetPoint], degree: u32) -> f64 {
        let mut worst = 0.0_f64;
        for i in 0..=degree {
            for j in 0..=degree - i {
                let k = degree - i - j;
                let exact = factorial(i) * factorial(j) * factorial(k) / factorial(degree + 3);
                let sum: f64 = rule
                    .iter()
                    .map(|p| p.weight * p.at[0].powi(i as i32) * p.at[1].powi(j as i32) * p.at[2].powi(k as i32))
                    .sum();
                worst = worst.max((sum - exact).abs() / exact);
            }
        }
        worst
    }

    fn tri_error(rule: &[TriPoint], degree: u32) -> f64 {
        let mut worst = 0.0_f64;
        for i in 0..=degree {
            let j = degree - i;
            let exact = factorial(i) * factorial(j) / factorial(degree + 2);
            let sum: f64 = rule.iter().map(|p| p.weight * p.at[0].powi(i as i32) * p.at[1].powi(j as i32)).sum();
            worst = worst.max((sum - exact).abs() / exact);
        }
        worst
    }

    #[test]
    fn each_rule_is_exact_to_its_degree_and_no_further() {
        for degree in 0..=2 {
            assert!(tet_error(&tet_degree_2(), degree) < 1e-13);
        }
        assert!(tet_error(&tet_degree_2(), 3) > 1e-3);
        for degree in 0..=5 {
            assert!(tet_error(&tet_degree_5(), degree) < 1e-12, "{degree}");
            assert!(tri_error(&tri_degree_5(), degree) < 1e-12, "{degree}");
        }
        assert!(tet_error(&tet_degree_5(), 6) > 1e-3);
        assert!(tri_error(&tri_degree_5(), 6) > 1e-3);
    }
}
