//! Training footprints lie closer where a footprint hangs over the end of its rail.

use stiffmap::reduction::{RailSpring, RailTraining};
use stiffmap::solid::{Face, Surface};

/// A rail from z = 0 to z = 1 m.
fn rail() -> Surface {
    let corner = |x: f64, z: f64| [x, 0.0, z];
    let [a, b, c] = [corner(0.0, 0.0), corner(0.05, 0.0), corner(0.0, 1.0)];
    let middle = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|i| 0.5 * (p[i] + q[i]));
    Surface {
        faces: vec![Face {
            nodes: vec![0, 1, 2, 3, 4, 5],
            coordinates: vec![a, b, c, middle(a, b), middle(b, c), middle(c, a)],
        }],
    }
}

fn training(centres: Vec<f64>) -> RailTraining {
    let spring = RailSpring { point: [0.0; 3], direction: [1.0, 0.0, 0.0], rotation: false };
    RailTraining { interface: 0, direction: [0.0, 0.0, 1.0], footprint: 0.2, centres, springs: vec![spring] }
}

#[test]
fn whole_footprints_keep_their_spacing() {
    let centres = vec![0.2, 0.25, 0.3, 0.35];
    assert_eq!(training(centres.clone()).footprints(&rail()), centres);
}

#[test]
fn overhanging_footprints_are_four_times_as_close() {
    let found = training(vec![0.02, 0.06, 0.1, 0.14]).footprints(&rail());
    // Centres below 0.1 m overhang: two intervals are divided, the last is not.
    let expected = [0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1, 0.14];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
}

#[test]
fn the_gap_between_two_ranges_is_not_filled() {
    let centres = vec![0.05, 0.95];
    assert_eq!(training(centres.clone()).footprints(&rail()), centres);
}
