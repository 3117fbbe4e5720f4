//! Quadrature rules on the reference elements and their faces.
//!
//! Weights sum to the reference domain's measure: 1/6 for the tetrahedron, 8 for the brick, 1 for the
//! wedge, 1/2 for the triangle. Brick coordinates run from -1 to 1; a wedge is the triangle
//! (r, s) times t from -1 to 1.

/// A point of a reference element with its weight.
#[derive(Clone, Copy, Debug)]
pub struct SolidPoint {
    /// Coordinates (r, s, t).
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

/// One point, exact to degree 1.
pub fn tet_degree_1() -> Vec<SolidPoint> {
    vec![SolidPoint { at: [0.25; 3], weight: 1.0 / 6.0 }]
}

/// Gauss and Legendre's points on (-1, 1) with their weights, exact to degree 2 n - 1; n is 1, 2 or 3.
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let (two, three) = (1.0 / 3.0_f64.sqrt(), 0.6_f64.sqrt());
    match n {
        1 => vec![(0.0, 2.0)],
        2 => vec![(-two, 1.0), (two, 1.0)],
        3 => vec![(-three, 5.0 / 9.0), (0.0, 8.0 / 9.0), (three, 5.0 / 9.0)],
        _ => panic!("{n} points along a side, allowed are 1, 2, 3"),
    }
}

/// n x n x n points on the brick, exact to degree 2 n - 1 in each coordinate; n is 1, 2 or 3.
pub fn brick(n: usize) -> Vec<SolidPoint> {
    let line = gauss(n);
    let mut points = Vec::with_capacity(n * n * n);
    for (t, wt) in &line {
        for (s, ws) in &line {
            for (r, wr) in &line {
                points.push(SolidPoint { at: [*r, *s, *t], weight: wr * ws * wt });
            }
        }
    }
    points
}

/// A triangle rule times n points along t.
pub fn wedge(triangle: &[TriPoint], n: usize) -> Vec<SolidPoint> {
    let across = |(t, w): (f64, f64)| {
        triangle.iter().map(move |p| SolidPoint { at: [p.at[0], p.at[1], t], weight: p.weight * w })
    };
    gauss(n).into_iter().flat_map(across).collect()
}

/// One point, exact to degree 1.
pub fn tri_degree_1() -> Vec<TriPoint> {
    vec![TriPoint { at: [1.0 / 3.0; 2], weight: 0.5 }]
}

/// Three points inside, exact to degree 2.
pub fn tri_degree_2() -> Vec<TriPoint> {
    let (a, b) = (1.0 / 6.0, 2.0 / 3.0);
    [[a, a], [b, a], [a, b]].map(|at| TriPoint { at, weight: a }).to_vec()
}

/// Four points, exact to degree 2: the stiffness rule of CalculiX's C3D10.
pub fn tet_degree_2() -> Vec<SolidPoint> {
    // (5 - sqrt 5) / 20 and (5 + 3 sqrt 5) / 20.
    let a = (5.0 - 5.0_f64.sqrt()) / 20.0;
    let b = (5.0 + 3.0 * 5.0_f64.sqrt()) / 20.0;
    let weight = 1.0 / 24.0;
    [[a, a, a], [b, a, a], [a, b, a], [a, a, b]].map(|at| SolidPoint { at, weight }).to_vec()
}

/// Fifteen points, exact to degree 5: the consistent-mass rule.
///
/// # Source
/// P. Keast, Moderate-degree tetrahedral quadrature formulas, Comput. Methods Appl. Mech. Eng. 55 (1986).
pub fn tet_degree_5() -> Vec<SolidPoint> {
    let (third, eleventh) = (1.0 / 3.0, 1.0 / 11.0);
    let (centre, face) = (6544.0 / 36015.0 / 6.0, 81.0 / 2240.0 / 6.0);
    let (inner, edge) = (161_051.0 / 2_304_960.0 / 6.0, 338.0 / 5145.0 / 6.0);
    let a = 0.25 * (1.0 - (7.0_f64 / 13.0).sqrt());
    let b = 0.5 - a;
    let point = |at, weight| SolidPoint { at, weight };
    vec![
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
    fn tet_error(rule: &[SolidPoint], degree: u32) -> f64 {
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
        assert!(tet_error(&tet_degree_1(), 1) < 1e-13 && tet_error(&tet_degree_1(), 2) > 1e-3);
        assert!(tri_error(&tri_degree_1(), 1) < 1e-13 && tri_error(&tri_degree_1(), 2) > 1e-3);
        assert!(tri_error(&tri_degree_2(), 2) < 1e-13 && tri_error(&tri_degree_2(), 3) > 1e-3);
        for degree in 0..=5 {
            assert!(tet_error(&tet_degree_5(), degree) < 1e-12, "{degree}");
            assert!(tri_error(&tri_degree_5(), degree) < 1e-12, "{degree}");
        }
        assert!(tet_error(&tet_degree_5(), 6) > 1e-3);
        assert!(tri_error(&tri_degree_5(), 6) > 1e-3);
    }

    #[test]
    fn brick_and_wedge_rules_are_exact_to_their_degree_in_each_coordinate() {
        let sum = |rule: &[SolidPoint], power: [i32; 3]| -> f64 {
            rule.iter().map(|p| p.weight * (0..3).map(|c| p.at[c].powi(power[c])).product::<f64>()).sum()
        };
        let line = |power: i32| if power % 2 == 0 { 2.0 / f64::from(power + 1) } else { 0.0 };
        for n in 1..=3 {
            let degree = 2 * n as i32 - 1;
            for power in 0..=degree {
                let exact = line(power) * line(degree - power) * line(0);
                assert!((sum(&brick(n), [power, degree - power, 0]) - exact).abs() < 1e-14);
                let triangle = factorial(2) * line(power) / factorial(4);
                assert!((sum(&wedge(&tri_degree_2(), n), [2, 0, power]) - triangle).abs() < 1e-14);
            }
            assert!((sum(&brick(n), [degree + 1, 0, 0]) - 4.0 * line(degree + 1)).abs() > 1e-3);
        }
    }
}
