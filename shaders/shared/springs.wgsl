// The base's receptances (group 0) and their change by the springs of a design at one frequency.
//
// H = H_pp - H_ps (Delta^-1 + H_ss)^-1 H_sp, one spring after the other: with h_k its column in the machine so far,
//
// H <- H - h_k h_k^T delta_k / (1 + delta_k h_kk),   delta_k = stiffness_k + j omega damping_k
//
// which is the elimination of the bordered matrix in a form that a change of 0 leaves as it is. Rows are scaled by
// powers of two so that each diagonal entry is at most about 1.
//
// receptances  [entry of the lower triangle, row by row | omega][slot]  (re, im); (omega, 0)
// changes      [design, spring, 2]                                      (re, im) of the stiffness; (damping, 0)
// pairs        [pair]                                                   place of the entry
//
// A chunk is CORE frequencies and one neighbour on either side; slot chunk CORE + lane, so the grid's ends stand twice.
// The generated header defines SPRINGS, ROWS (springs, then ports), ENTRIES and CORE.

struct Params {
    // Frequencies of the tile without neighbours.
    n_frequencies: u32,
    n_slots: u32,
    n_designs: u32,
    n_pairs: u32,
    // 0 at run time.
    zero: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> receptances: array<real2>;
@group(0) @binding(2) var<storage, read> changes: array<real2>;
@group(0) @binding(3) var<storage, read> pairs: array<u32>;

var<private> matrix: array<real2, ENTRIES>;

fn product(a: real2, b: real2) -> real2 {
    return real2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

fn inverse(a: real2) -> real2 {
    let square = a.x * a.x + a.y * a.y;
    return real2(a.x, -a.y) / square;
}

// Whether a lane's frequency belongs to the chunk and lies inside the tile.
fn in_core(chunk: u32, lane: u32) -> bool {
    return lane >= 1u && lane <= CORE && chunk * CORE + lane <= params.n_frequencies;
}

// Leaves the changed machine's receptances between its ports in the last rows of `matrix`.
fn change_springs(design: u32, slot: u32) {
    for (var e = 0u; e < ENTRIES; e++) {
        matrix[e] = receptances[e * params.n_slots + slot];
    }
    let omega = receptances[ENTRIES * params.n_slots + slot].x;
    for (var k = 0u; k < SPRINGS; k++) {
        let at = 2u * (design * SPRINGS + k);
        let delta = changes[at] + real2(real(0.0), omega * changes[at + 1u].x);
        let own = matrix[k * (k + 1u) / 2u + k];
        let gain = product(delta, inverse(real2(real(1.0), real(0.0)) + product(delta, own)));
        if gain.x != real(0.0) || gain.y != real(0.0) {
            for (var i = k + 1u; i < ROWS; i++) {
                let row = i * (i + 1u) / 2u;
                let factor = product(gain, matrix[row + k]);
                for (var j = k + 1u; j <= i; j++) {
                    matrix[row + j] -= product(factor, matrix[j * (j + 1u) / 2u + k]);
                }
            }
        }
    }
}
