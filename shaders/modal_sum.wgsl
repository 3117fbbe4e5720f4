// Modal sum: the responses of a tile of positions and frequencies.
//
// One invocation: one frequency (x), one position (y), up to 2 DUOS pairs (z).
// Group 0: the model (shared/model.wgsl). Group 1: values [position, pair, frequency], (re, im).

@group(1) @binding(0) var<storage, read_write> values: array<real2>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let frequency = id.x;
    let position = id.y;
    let first_duo = id.z * DUOS;
    if frequency >= params.n_frequencies || position >= params.n_positions {
        return;
    }
    let sum = modal_sum(position, frequency, first_duo);
    for (var d = 0u; d < DUOS; d++) {
        let pair = 2u * (first_duo + d);
        let at = (position * params.n_pairs + pair) * params.n_frequencies + frequency;
        if pair < params.n_pairs {
            values[at] = real2(sum.re[d].x, sum.im[d].x);
        }
        if pair + 1u < params.n_pairs {
            values[at + params.n_frequencies] = real2(sum.re[d].y, sum.im[d].y);
        }
    }
}
