//! Whole parts against exact and published solutions.

mod support;

use nalgebra::DMatrix;
use std::f64::consts::{PI, TAU};
use stiffmap::linalg::{Cholesky, LanczosOptions, Spectrum, lowest_modes};
use stiffmap::mesh::Mesh;
use stiffmap::solid::{SecondOrder, SolidError, assemble};
use support::dense::{eigenvalues, full};
use support::{box_mesh, part, steel, worst_ratio};

fn system(mesh: &Mesh, clamped: &[&str]) -> SecondOrder {
    assemble(&part("body", clamped, vec![]), mesh).expect("assembles")
}

/// The lowest modes of K + s M by the crate's factor and Lanczos.
fn lanczos(system: &SecondOrder, modes: usize, block: usize, shift: f64) -> Spectrum {
    let ordering = system.ordering().expect("METIS orders it");
    let shifted = system.stiffness.plus_scaled(shift, &system.mass);
    let factor = Cholesky::new(&shifted, &ordering).expect("positive definite");
    let options = LanczosOptions { modes, block, tolerance: 1e-8, beyond: 0, interrupt: None };
    let mut spectrum =
        lowest_modes(&system.mass, &|load: &DMatrix<f64>| factor.solve(load), options).expect("converges");
    spectrum.eigenvalues.iter_mut().for_each(|l| *l -= shift);
    spectrum
}

fn hertz(spectrum: &Spectrum) -> Vec<f64> {
    spectrum.eigenvalues.iter().map(|l| l.max(0.0).sqrt() / TAU).collect()
}

/// Least-squares slope of log error over log h.
fn slope(h: &[f64], error: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> = h.iter().zip(error).map(|(h, e)| (h.ln(), e.ln())).collect();
    let n = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (xy, xx) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + (x - mx) * (y - my), b + (x - mx).powi(2)));
    xy / xx
}

// Lame's equivoluminal modes of a free cube, u = (sin kx cos ky, -cos kx sin ky, 0) with k = pi / a about its centre,
// satisfy the equations and all free faces exactly at f = c_s / (sqrt 2 a), whatever Poisson's ratio; three of them, one
// a pair of axes. (Lame, Lecons sur la theorie mathematique de l'elasticite, 1852; Graff, Wave Motion in Elastic Solids.)
#[test]
fn a_free_cube_has_lames_triple_root_and_the_error_falls_with_the_fourth_power_of_h() {
    let side = 0.1;
    let m = steel();
    let exact = (m.young / (2.0 * (1.0 + m.poisson)) / m.density).sqrt() / (2f64.sqrt() * side);
    let sizes = [4, 6, 8];
    let mut errors = Vec::new();
    for n in sizes {
        let body = system(&box_mesh([0.0; 3], [side; 3], [n; 3]), &[]);
        let frequencies = hertz(&lanczos(&body, 24, 8, 1e8));
        // The mode whose frequency is nearest, from above: Ritz values of a conforming model.
        let mut near: Vec<f64> = frequencies[6..].iter().map(|f| f / exact - 1.0).collect();
        near.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        assert!(near[..3].iter().all(|e| *e > 0.0), "from above: {near:?}");
        errors.push(near[2]);
    }
    println!("Lame error {errors:?}");
    let h: Vec<f64> = sizes.iter().map(|n| 1.0 / *n as f64).collect();
    let (early, late) = (slope(&h[..2], &errors[..2]), slope(&h[1..], &errors[1..]));
    assert!(late > early && (3.5..4.2).contains(&late), "orders {early:.2}, {late:.2}, which approach 4: {errors:?}");
    assert!(errors[2] < 1e-3, "{errors:?}");
}

#[test]
fn lanczos_loses_no_partner_of_a_repeated_frequency_of_a_free_cube() {
    let body = system(&box_mesh([0.0; 3], [0.1; 3], [2; 3]), &[]);
    let shift = 1e8;
    let reference = eigenvalues(&full(&body.stiffness), &full(&body.mass), shift);
    let pairs = reference[6..30].windows(2).filter(|w| w[1] / w[0] - 1.0 < 1e-9).count();
    assert!(pairs >= 3, "the cube's symmetry gives exact double roots; found {pairs}");
    for block in [1, 3, 8] {
        let found = lanczos(&body, 30, block, shift);
        let largest = found.eigenvalues[..6].iter().fold(0.0f64, |m, l| m.max(l.abs()));
        assert!(largest < 1e-9 * reference[6], "block {block}: rigid motions at {largest:.1e}");
        let error = worst_ratio(&found.eigenvalues[6..], &reference[6..30]);
        assert!(error < 1e-9, "block {block}: {error:.1e}");
        // Control: without one partner the lists no longer agree.
        let at = (6..29).find(|&r| reference[r + 1] / reference[r] - 1.0 < 1e-9).expect("a pair");
        let mut lost = found.eigenvalues.clone();
        lost.remove(at);
        assert!(worst_ratio(&lost[6..], &reference[6..29]) > 1e-3);
        let gram = found.shapes.transpose() * body.mass.multiply(&found.shapes);
        assert!((gram - DMatrix::identity(30, 30)).amax() < 1e-10);
    }
}

/// Bending frequencies (Hz) of a clamped-free Timoshenko beam of square section.
///
/// T. C. Huang, The effect of rotatory inertia and of shear deformation on the frequency and normal mode equations of
/// uniform beams with simple end conditions, J. Appl. Mech. 28 (1961), eq. for the clamped-free beam; shear coefficient
/// 10 (1 + nu) / (12 + 11 nu) of Cowper (1966).
fn timoshenko(length: f64, width: f64, count: usize) -> Vec<f64> {
    let m = steel();
    let (area, second) = (width * width, width.powi(4) / 12.0);
    let shear = m.young / (2.0 * (1.0 + m.poisson));
    let kappa = 10.0 * (1.0 + m.poisson) / (12.0 + 11.0 * m.poisson);
    let r2 = second / (area * length * length);
    let s2 = m.young * second / (kappa * area * shear * length * length);
    let equation = |b: f64| {
        let root = ((r2 - s2).powi(2) + 4.0 / (b * b)).sqrt();
        let (alpha, beta) = ((0.5 * (root - r2 - s2)).sqrt(), (0.5 * (root + r2 + s2)).sqrt());
        2.0 + (b * b * (r2 - s2).powi(2) + 2.0) * (b * alpha).cosh() * (b * beta).cos()
            - b * (r2 + s2) / (1.0 - b * b * r2 * s2).sqrt() * (b * alpha).sinh() * (b * beta).sin()
    };
    let mut found = Vec::new();
    let (mut b, step) = (0.5, 0.01);
    while found.len() < count {
        if equation(b) * equation(b + step) < 0.0 {
            let (mut low, mut high) = (b, b + step);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if equation(low) * equation(middle) <= 0.0 { high = middle } else { low = middle }
            }
            let omega = low * (m.young * second / (m.density * area)).sqrt() / (length * length);
            found.push(omega / TAU);
        }
        b += step;
    }
    found
}

#[test]
fn a_cantilever_agrees_with_timoshenkos_beam_and_not_with_eulers() {
    let (length, width) = (0.5, 0.05);
    let body = system(&box_mesh([0.0; 3], [width, width, length], [2, 2, 20]), &["ZMIN"]);
    let frequencies = hertz(&lanczos(&body, 10, 8, 0.0));
    let beam = timoshenko(length, width, 3);
    let m = steel();
    println!("{frequencies:?}\n{beam:?}");
    // Each bending frequency comes twice, for x and y; torsion and extension lie between.
    let nearest_two = |f: f64| {
        let mut off: Vec<f64> = frequencies.iter().map(|g| (g / f - 1.0).abs()).collect();
        off.sort_by(f64::total_cmp);
        [off[0], off[1]]
    };
    for f in &beam {
        let off = nearest_two(*f);
        assert!(off[1] < 0.012, "{f} Hz: {off:?}");
    }
    // A rod's extension, E / rho, and Saint-Venant's torsion, J = 0.1406 w^4 for a square (Timoshenko and Goodier); the
    // clamp holds the warping back, which shortens the free length by a share of w / L.
    let extension = (m.young / m.density).sqrt() / (4.0 * length);
    let shear = m.young / (2.0 * (1.0 + m.poisson));
    let torsion = (0.140_577 * 6.0 * shear / m.density).sqrt() / (4.0 * length);
    assert!(nearest_two(extension)[0] < 0.005 && nearest_two(torsion)[0] < 0.025, "{extension} {torsion}");
    let euler = 61.697 / (TAU * length * length) * (m.young * width * width / (12.0 * m.density)).sqrt();
    assert!((euler / beam[2] - 1.0).abs() > 0.08, "control: Euler's third frequency, {euler:.0} Hz, is far off");
}

// At the clamp's edge the stress is singular (exponent some 0.71 for nu = 0.3), which holds the order of the frequency
// near 2 x 0.71 however fine the elements; the error is measured against Richardson's limit of the series itself.
#[test]
fn a_cantilevers_frequency_falls_towards_its_limit() {
    let first = |n: usize| {
        let body = system(&box_mesh([0.0; 3], [0.05, 0.05, 0.2], [n, n, 4 * n]), &["ZMIN"]);
        hertz(&lanczos(&body, 4, 4, 0.0))[0]
    };
    let values = [1, 2, 4].map(first);
    let order = ((values[0] - values[1]) / (values[1] - values[2])).log2();
    println!("cantilever {values:?}, order {order:.2}");
    assert!(values[0] > values[1] && values[1] > values[2], "Ritz values fall: {values:?}");
    assert!((1.4..3.0).contains(&order), "order {order:.2} of {values:?}");
    assert!(values[1] / values[2] - 1.0 < 6e-3);
}

#[test]
fn a_slender_free_beam_agrees_with_eulers() {
    // Free-free Euler beam, beta L = 4.730041; shear and rotation lower it by some 0.2 % at w / L = 0.02.
    let (length, width) = (1.0, 0.02);
    let m = steel();
    let body = system(&box_mesh([0.0; 3], [width, width, length], [1, 1, 24]), &[]);
    let frequencies = hertz(&lanczos(&body, 10, 8, 1e5));
    let euler = 4.730_041_f64.powi(2) / (TAU * length * length) * (m.young * width * width / (12.0 * m.density)).sqrt();
    for r in [6, 7] {
        let off = frequencies[r] / euler - 1.0;
        assert!((-0.004..0.001).contains(&off), "{} Hz against {euler} Hz", frequencies[r]);
    }
    assert!(PI * euler > frequencies[8], "the next pair lies at 2.757 times the first");
}

#[test]
fn a_mesh_in_pieces_an_inverted_element_and_a_clamp_on_a_line_are_refused() {
    let good = box_mesh([0.0; 3], [0.1; 3], [1; 3]);
    let mut inverted = good.clone();
    inverted.cells[3].nodes.swap(0, 1);
    assert!(matches!(
        assemble(&part("a", &[], vec![]), &inverted),
        Err(SolidError::InvertedElement { element: 4, .. })
    ));
    let mut pieces = good.clone();
    let other = box_mesh([1.0, 0.0, 0.0], [0.1; 3], [1; 3]);
    let first = pieces.nodes.len();
    pieces.nodes.extend(other.nodes);
    pieces.node_labels.extend(other.node_labels);
    pieces.cells.extend(other.cells.into_iter().map(|mut c| {
        c.nodes.iter_mut().for_each(|n| *n += first);
        c
    }));
    assert!(matches!(assemble(&part("a", &[], vec![]), &pieces), Err(SolidError::Pieces { pieces: 2, .. })));
    let mut line = good.clone();
    line.node_sets.insert("EDGE".into(), vec![0, 1, 2]);
    assert!(matches!(assemble(&part("a", &["EDGE"], vec![]), &line), Err(SolidError::ClampOnLine { .. })));
    assert!(matches!(assemble(&part("a", &["FLOOR"], vec![]), &good), Err(SolidError::UnknownSet { .. })));
    let mut bare = good.clone();
    bare.cells[2].material = None;
    assert!(matches!(assemble(&part("a", &[], vec![]), &bare), Err(SolidError::NoMaterial { element: 3, .. })));
    assert!(assemble(&part("a", &["ZMIN"], vec![]), &good).is_ok());
}
