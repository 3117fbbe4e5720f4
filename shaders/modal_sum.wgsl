// Modal sum: the responses of a tile of positions and frequencies.
//
// One invocation: WAYS frequencies (x), one position (y), up to 2 DUOS pairs (z).
// Group 0: the model (shared/model.wgsl). Group 1: values [position, pair, frequency], (re, im).

@group(1) @binding(0) var<storage, read_write> values: array<real2>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    // From the workgroup: the compiler sees that the whole group reads the same modes.
    let position = group.y;
    let first_duo = group.z * DUOS;
    let first = group.x * WAYS * WORKGROUP + lane;
    let sum = modal_sum(position, first, first_duo);
    for (var k = 0u; k < WAYS; k++) {
        let frequency = way(first, k);
        if frequency < params.n_frequencies {
            for (var d = 0u; d < DUOS; d++) {
                let pair = 2u * (first_duo + d);
                let at = (position * params.n_pairs + pair) * params.n_frequencies + frequency;
                if pair < params.n_pairs {
                    values[at] = real2(sum.re[k * DUOS + d].x, sum.im[k * DUOS + d].x);
                }
                if pair + 1u < params.n_pairs {
                    values[at + params.n_frequencies] = real2(sum.re[k * DUOS + d].y, sum.im[k * DUOS + d].y);
                }
            }
        }
    }
}
