//! Colours: a perceptually uniform scale for numbers, a cycle for families.

use super::canvas::Colour;

/// Viridis by Nathaniel Smith and Stéfan van der Walt (public domain, CC0), every eighth of its
/// 256 colours; straight lines between stay within three levels of the original.
const VIRIDIS: [Colour; 33] = [
    [68, 1, 84],
    [71, 13, 96],
    [72, 24, 106],
    [72, 35, 116],
    [71, 45, 123],
    [69, 55, 129],
    [66, 64, 134],
    [62, 73, 137],
    [59, 82, 139],
    [55, 91, 141],
    [51, 99, 141],
    [47, 107, 142],
    [44, 114, 142],
    [41, 122, 142],
    [38, 130, 142],
    [35, 137, 142],
    [33, 145, 140],
    [31, 152, 139],
    [31, 160, 136],
    [34, 167, 133],
    [40, 174, 128],
    [50, 182, 122],
    [63, 188, 115],
    [78, 195, 107],
    [94, 201, 98],
    [112, 207, 87],
    [132, 212, 75],
    [152, 216, 62],
    [173, 220, 48],
    [194, 223, 35],
    [216, 226, 25],
    [236, 229, 27],
    [253, 231, 37],
];

/// Colours that stay apart in print and for the common forms of colour blindness, dark enough for
/// lines on white.
const CYCLE: [Colour; 8] = [
    [0, 90, 160],
    [200, 85, 0],
    [0, 125, 90],
    [190, 30, 90],
    [110, 80, 170],
    [130, 95, 20],
    [20, 145, 185],
    [90, 90, 90],
];

/// The colour of a number between 0 and 1; numbers outside take the nearer end.
pub(super) fn viridis(t: f64) -> Colour {
    let at = t.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let i = (at as usize).min(VIRIDIS.len() - 2);
    mix(VIRIDIS[i], VIRIDIS[i + 1], at - i as f64)
}

/// The colour of a family, counted from 1.
pub(super) fn family(number: usize) -> Colour {
    CYCLE[number.saturating_sub(1) % CYCLE.len()]
}

/// A colour between two, `t` from 0 to 1.
fn mix(a: Colour, b: Colour, t: f64) -> Colour {
    std::array::from_fn(|c| {
        (f64::from(a[c]) + (f64::from(b[c]) - f64::from(a[c])) * t).round() as u8
    })
}

/// A colour made darker (below 1) or brighter, each part by the same factor.
pub(super) fn shade(colour: Colour, factor: f64) -> Colour {
    colour.map(|c| (f64::from(c) * factor).round().clamp(0.0, 255.0) as u8)
}
