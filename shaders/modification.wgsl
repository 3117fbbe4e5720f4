// Structural modification: the responses of designs whose springs differ from the base's.
//
// One workgroup: a chunk of frequencies (x), one design (y). Group 0: the base and the designs (shared/springs.wgsl).
// Group 1: values [design, pair, frequency], (re, im), in the units of the scaled rows.

@group(1) @binding(0) var<storage, read_write> values: array<real2>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let design = group.y;
    if in_core(group.x, lane) {
        change_springs(design, group.x * CORE + lane);
        for (var pair = 0u; pair < params.n_pairs; pair++) {
            let at = (design * params.n_pairs + pair) * params.n_frequencies + group.x * CORE + lane - 1u;
            values[at] = response(pair);
        }
    }
}
