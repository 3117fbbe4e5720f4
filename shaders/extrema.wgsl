// Extrema of changed machines: where |H| and -Re H have local maxima on the grid, without writing the responses.
//
// One workgroup: a chunk of frequencies (x), one design (y). Group 0: the base and the designs (shared/springs.wgsl).
// Group 1: maxima [design, chunk, pair]. A maximum is at least as large as its neighbours and, within its chunk, at
// most SHARE of the chunk's largest value below it.

struct Maxima {
    // Largest |H|^2 of the chunk.
    peak: real,
    // Largest -Re H of the chunk.
    dip: real,
    // One bit a frequency of the chunk.
    peaks: vec2<u32>,
    dips: vec2<u32>,
}

@group(1) @binding(0) var<storage, read_write> maxima: array<Maxima>;

const LOWEST: real = real(-3.0e38);

var<workgroup> goals: array<real2, WORKGROUP>;
var<workgroup> tops: array<real2, WORKGROUP>;
var<workgroup> bits: array<atomic<u32>, 4>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let design = group.y;
    let inside = in_core(group.x, lane);
    change_springs(design, group.x * CORE + lane);
    for (var pair = 0u; pair < params.n_pairs; pair++) {
        let h = response(pair);
        let here = real2(h.x * h.x + h.y * h.y, -h.x);
        workgroupBarrier();
        goals[lane] = here;
        tops[lane] = select(real2(LOWEST, LOWEST), here, inside);
        if lane < 4u {
            atomicStore(&bits[lane], 0u);
        }
        for (var width = WORKGROUP / 2u; width > 0u; width /= 2u) {
            workgroupBarrier();
            if lane < width {
                tops[lane] = max(tops[lane], tops[lane + width]);
            }
        }
        workgroupBarrier();
        let top = tops[0];
        if inside {
            let bar = top - real(SHARE) * abs(top);
            let before = goals[lane - 1u];
            let after = goals[lane + 1u];
            let word = (lane - 1u) / 32u;
            let bit = 1u << ((lane - 1u) % 32u);
            if here.x >= bar.x && here.x >= before.x && here.x >= after.x {
                atomicOr(&bits[word], bit);
            }
            if here.y >= bar.y && here.y >= before.y && here.y >= after.y {
                atomicOr(&bits[2u + word], bit);
            }
        }
        workgroupBarrier();
        if lane == 0u {
            let peaks = vec2<u32>(atomicLoad(&bits[0]), atomicLoad(&bits[1]));
            let dips = vec2<u32>(atomicLoad(&bits[2]), atomicLoad(&bits[3]));
            maxima[(design * groups.x + group.x) * params.n_pairs + pair] = Maxima(top.x, top.y, peaks, dips);
        }
    }
}
