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

/// The scale in steps too fine to see.
const TABLE: [Colour; 1024] = {
    let mut table = [[0; 3]; 1024];
    let mut i = 0;
    while i < 1024 {
        let at = i as f64 / 1023.0 * 32.0;
        let k = if i == 1023 { 31 } else { at as usize };
        let mut c = 0;
        while c < 3 {
            let (a, b) = (VIRIDIS[k][c] as f64, VIRIDIS[k + 1][c] as f64);
            table[i][c] = (a + (b - a) * (at - k as f64) + 0.5) as u8;
            c += 1;
        }
        i += 1;
    }
    table
};

/// The colour of a number between 0 and 1; numbers outside take the nearer end.
pub(super) fn viridis(t: f64) -> Colour {
    static SCALE: [Colour; 1024] = TABLE;
    SCALE[(t.clamp(0.0, 1.0) * 1023.0 + 0.5) as usize]
}

/// The colour of a family, counted from 1.
pub(super) fn family(number: usize) -> Colour {
    CYCLE[number.saturating_sub(1) % CYCLE.len()]
}

/// A colour made darker (below 1) or brighter, each part by the same factor.
pub(super) fn shade(colour: Colour, factor: f64) -> Colour {
    colour.map(|c| (f64::from(c) * factor + 0.5) as u8)
}
