//! Sobol's sequence in up to sixteen dimensions.
//!
//! Direction numbers: S. Joe and F. Y. Kuo, Constructing Sobol sequences with better two-dimensional projections,
//! SIAM J. Sci. Comput. 30 (2008), file `new-joe-kuo-6.21201`, the first sixteen dimensions. Points are numbered in
//! the order of Gray codes (Antonov and Saleev), as in SciPy's `qmc.Sobol`.

/// Dimensions at most.
pub const MOST_DIMENSIONS: usize = 16;
/// Bits of a coordinate: the sequence has 2^32 points.
pub const BITS: u32 = 32;

/// Degree s, coefficients a of the primitive polynomial, and m_1..m_s, for dimensions 2 to 16.
const JOE_KUO: [(u32, u32, &[u32]); 15] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
    (5, 13, &[1, 1, 1, 3, 11]),
    (5, 14, &[1, 3, 5, 5, 31]),
    (6, 1, &[1, 3, 3, 9, 7, 49]),
    (6, 13, &[1, 1, 1, 15, 21, 21]),
    (6, 16, &[1, 3, 1, 13, 27, 49]),
];

/// Coordinate of a point as an integer of 32 bits: the coordinate times 2^32.
pub fn coordinate(index: u64, dimension: usize) -> u32 {
    assert!(dimension < MOST_DIMENSIONS, "dimension {dimension} of {MOST_DIMENSIONS}");
    assert!(index < 1 << BITS, "point {index} of 2^{BITS}");
    let gray = index ^ (index >> 1);
    let directions = directions(dimension);
    (0..BITS).filter(|bit| gray >> bit & 1 == 1).fold(0, |x, bit| x ^ directions[bit as usize])
}

/// Direction numbers v_1..v_32 of a dimension, as integers of 32 bits.
fn directions(dimension: usize) -> [u32; BITS as usize] {
    let mut v = [0_u32; BITS as usize];
    let Some((degree, a, m)) = dimension.checked_sub(1).map(|d| JOE_KUO[d]) else {
        return std::array::from_fn(|i| 1 << (BITS - 1 - i as u32));
    };
    let s = degree as usize;
    for i in 0..BITS as usize {
        v[i] = if i < s {
            m[i] << (BITS - 1 - i as u32)
        } else {
            let first = v[i - s] ^ (v[i - s] >> s);
            (1..s).filter(|k| a >> (s - 1 - k) & 1 == 1).fold(first, |x, k| x ^ v[i - k])
        };
    }
    v
}
