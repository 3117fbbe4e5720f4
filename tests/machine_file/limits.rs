//! What cannot be computed with is refused with its place and what is allowed.

use super::full::{FULL, read_full};
use super::*;

/// A key as the full machine gives it, its value, and the largest and smallest size allowed in its unit.
const LIMITS: &[(&str, &str, f64, Option<f64>)] = &[
    ("origin = [0, 0, 0]", "origin = [0, 0, @]", 1e5, None),
    ("step = \"5 mm\"", "step = @", 1e5, None),
    ("footprint = \"90 mm\"", "footprint = @", 1e5, Some(1e-5)),
    ("diameter = \"40 mm\"", "diameter = @", 1e5, Some(1e-12)),
    ("backlash = \"10 um\"", "backlash = @", 1e5, None),
    ("young = \"115 GPa\"", "young = @", 1e16, Some(1.0)),
    ("density = \"7200 kg/m3\"", "density = @", 1e9, Some(1e-6)),
    ("y = 77e6", "y = @", 1e22, Some(1e-9)),
    ("rx = 1e7", "rx = @", 1e22, Some(1e-9)),
    ("stiffness = \"1 N/um\"", "stiffness = @", 1e22, Some(1e-9)),
    ("x = \"100 N s/m\"", "x = @", 1e12, None),
    ("damping = \"10 N s/m\"\nbacklash", "damping = @\nbacklash", 1e12, None),
    ("band = \"5 kHz\"", "band = @", 1e9, None),
    ("alpha = 1", "alpha = @", 1e6, None),
    ("beta = 1e-6", "beta = @", 10.0, None),
    ("breakaway = \"80 N\"", "breakaway = @", 1e12, None),
    ("stribeck = \"1 mm/s\"", "stribeck = @", 1e6, Some(1e-12)),
];

#[test]
fn a_value_beyond_what_can_be_computed_with_is_refused_and_one_within_is_read() {
    let full = FULL;
    for (given, key, largest, smallest) in LIMITS {
        assert!(full.contains(given), "{given:?} is not in the full machine");
        let with = |value: f64| read_full(&full.replacen(given, &key.replace('@', &format!("{value:e}")), 1));
        let refused = |value: f64| {
            let said = with(value).map_or_else(|error| error.to_string(), |_| panic!("{key} accepts {value:e}"));
            let place = said.starts_with('/') && said.contains("machine.toml:");
            let words = [&format!("{value:e}"), "allowed: ", &format!("{largest:e}"), "correct the value or its unit"];
            assert!(place && words.iter().all(|word| said.contains(word)), "{said}");
        };
        with(*largest).unwrap_or_else(|error| panic!("{error}"));
        refused(1.01 * largest);
        refused(1e305);
        if let Some(smallest) = smallest {
            with(*smallest).unwrap_or_else(|error| panic!("{error}"));
            refused(0.99 * smallest);
            refused(1e-300);
        }
    }
}

#[test]
fn coordinates_of_any_sign_and_tiny_ones_are_read() {
    accepted("[\"0 mm\", \"-100 mm\"]", "[0, -0.1]");
    accepted("from = \"10 mm\", to = \"30 mm\"", "from = -1e5, to = 1e-300");
    refused_change(
        "from = \"10 mm\", to = \"30 mm\"",
        "from = -1.1e5, to = 1",
        &["within.from: found -1.1e5", "1e5 m"],
    );
}

#[test]
fn a_poisson_ratio_at_which_a_stiffness_is_infinite_is_refused() {
    for bad in ["0.5", "0.49999999", "-1", "-0.99999999"] {
        let said = read_full(&FULL.replacen("poisson = 0.26", &format!("poisson = {bad}"), 1)).unwrap_err();
        assert!(said.to_string().contains(&format!("poisson: found {bad}")), "{said}");
    }
}
