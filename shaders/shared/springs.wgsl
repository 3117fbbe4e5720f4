// The base's receptances (group 0) and their change by the springs of a design at one frequency.
//
// H = H_pp - H_ps (Delta^-1 + H_ss)^-1 H_sp, one spring after the other: with h_k its column in the machine so far,
//
// H <- H - h_k h_k^T delta_k / (1 + delta_k h_kk),   delta_k = stiffness_k + j omega damping_k
//
// which is the elimination of the bordered matrix in a form that a change of 0 leaves as it is. It is taken column by
// column, four rows at a time in registers: what an invocation reads of its memory is what it costs. Rows are scaled
// by powers of two so that each diagonal entry is at most about 1.
//
// receptances  [entry of the lower triangle, row by row | omega][slot]  (re, im); (omega, 0)
// changes      [design, spring, 2]                                      (re, im) of the stiffness; (damping, 0)
// pairs        [pair, 3]                                                places of the entry, of its row's first
//                                                                       entry and of its column's as a row
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
var<private> gains: array<real2, ROWS>;
var<private> weights: array<real2, ROWS>;

// Place of a row's first entry.
fn first(row: u32) -> u32 {
    return row * (row + 1u) / 2u;
}

fn last(row: u32) -> u32 {
    return min(row, ROWS - 1u);
}

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

// Puts the springs' columns h_k into `matrix` and their gains delta_k / (1 + delta_k h_kk) beside them.
fn change_springs(design: u32, slot: u32) {
    for (var e = 0u; e < ENTRIES; e++) {
        matrix[e] = receptances[e * params.n_slots + slot];
    }
    let omega = receptances[ENTRIES * params.n_slots + slot].x;
    for (var k = 0u; k < SPRINGS; k++) {
        let own = first(k);
        for (var m = 0u; m < k; m++) {
            weights[m] = product(gains[m], matrix[own + m]);
        }
        for (var i = k; i < ROWS; i += 4u) {
            // Beyond the last row the last again.
            let row = vec4<u32>(first(i), first(last(i + 1u)), first(last(i + 2u)), first(last(i + 3u)));
            var a = matrix[row.x + k];
            var b = matrix[row.y + k];
            var c = matrix[row.z + k];
            var d = matrix[row.w + k];
            for (var m = 0u; m < k; m++) {
                let weight = weights[m];
                a -= product(matrix[row.x + m], weight);
                b -= product(matrix[row.y + m], weight);
                c -= product(matrix[row.z + m], weight);
                d -= product(matrix[row.w + m], weight);
            }
            matrix[row.x + k] = a;
            matrix[row.y + k] = b;
            matrix[row.z + k] = c;
            matrix[row.w + k] = d;
        }
        let at = 2u * (design * SPRINGS + k);
        let delta = changes[at] + real2(real(0.0), omega * changes[at + 1u].x);
        gains[k] = product(delta, inverse(real2(real(1.0), real(0.0)) + product(delta, matrix[own + k])));
    }
}

// The changed machine's receptance between a pair of ports.
fn response(pair: u32) -> real2 {
    let row = pairs[3u * pair + 1u];
    let column = pairs[3u * pair + 2u];
    var h = matrix[pairs[3u * pair]];
    for (var m = 0u; m < SPRINGS; m++) {
        h -= product(product(gains[m], matrix[row + m]), matrix[column + m]);
    }
    return h;
}
