//! Which designs a sample holds.

use super::*;
use stiffmap::sweep::sobol::coordinate;

/// Points 1, 5, 42 and 9999 of SciPy 1.17's `qmc.Sobol(16, scramble=False, bits=32)`.
const SCIPY: [(u64, [f64; 16]); 4] = [
    (1, [0.5; 16]),
    (
        5,
        [
            0.875, 0.875, 0.125, 0.375, 0.875, 0.625, 0.875, 0.375, 0.375, 0.125, 0.375, 0.875, 0.875, 0.125, 0.875,
            0.375,
        ],
    ),
    (
        42,
        [
            0.984375, 0.328125, 0.015625, 0.734375, 0.453125, 0.484375, 0.984375, 0.609375, 0.796875, 0.609375,
            0.078125, 0.140625, 0.765625, 0.296875, 0.921875, 0.671875,
        ],
    ),
    (
        9999,
        [
            0.06707763671875,
            0.92144775390625,
            0.98272705078125,
            0.33941650390625,
            0.22332763671875,
            0.13494873046875,
            0.05023193359375,
            0.72698974609375,
            0.35882568359375,
            0.99395751953125,
            0.79681396484375,
            0.43975830078125,
            0.19744873046875,
            0.49957275390625,
            0.27117919921875,
            0.49884033203125,
        ],
    ),
];

#[test]
fn sobols_points_are_scipys() {
    for (index, point) in SCIPY {
        for (d, expected) in point.iter().enumerate() {
            assert_eq!(f64::from(coordinate(index, d)) / 4_294_967_296.0, *expected, "point {index}, dimension {d}");
        }
    }
    assert_ne!(coordinate(5, 1), coordinate(5, 2), "control: dimensions differ");
}

fn places(text: &str) -> Vec<Vec<f64>> {
    let study = read(text).unwrap();
    let one = |i| study.variables.iter().zip(study.values(i)).map(|(v, x)| v.place(x)).collect();
    (0..study.sampling.designs).map(one).collect()
}

#[test]
fn a_latin_hypercube_has_one_design_in_every_slice() {
    let designs = places(STUDY);
    assert_eq!(designs.len(), 24);
    for d in 0..2 {
        let mut slices: Vec<usize> = designs.iter().map(|p| (p[d] * 24.0) as usize).collect();
        slices.sort_unstable();
        assert_eq!(slices, (0..24).collect::<Vec<_>>(), "variable {d}");
    }
    assert_eq!(designs, places(STUDY), "the same again");
    assert_ne!(designs, places(&changed("seed = 7", "seed = 8")), "another seed");
}

#[test]
fn sobols_sequence_fills_every_half_and_a_seed_shifts_it() {
    let method = |seed: &str| {
        changed(
            "method = \"latin-hypercube\"\ndesigns = 24\nseed = 7",
            &format!("method = \"sobol\"\ndesigns = 32\n{seed}"),
        )
    };
    for text in [method(""), method("seed = 3")] {
        let designs = places(&text);
        for d in 0..2 {
            assert_eq!(designs.iter().filter(|p| p[d] < 0.5).count(), 16);
        }
    }
    assert_ne!(places(&method("")), places(&method("seed = 3")));
}

#[test]
fn a_grid_has_every_combination_the_last_variable_fastest() {
    let text = changed("method = \"latin-hypercube\"\ndesigns = 24\nseed = 7", "method = \"grid\"");
    let text = text.replace("scale = \"log\"", "scale = \"log\"\npoints = 3");
    let text = text.replace("range = [\"10 mm\", \"25 mm\"]", "values = [\"10 mm\", \"16 mm\"]");
    let study = read(&text).unwrap();
    let designs: Vec<Vec<f64>> = (0..study.sampling.designs).map(|i| study.values(i)).collect();
    let expected = [[25e6, 0.01], [25e6, 0.016], [50e6, 0.01], [50e6, 0.016], [100e6, 0.01], [100e6, 0.016]];
    assert_eq!(designs, expected);
}
