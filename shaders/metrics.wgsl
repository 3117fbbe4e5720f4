// Metrics: largest |H| and smallest Re H of each pair at each position, without writing the map.
//
// One workgroup: STEPS times WAYS frequencies for each of its WORKGROUP invocations (x), one position (y), up to
// 2 DUOS pairs (z). Of equal values the lowest frequency wins, as on the processor.
// Group 0: the model (shared/model.wgsl). Group 1: extrema [position, chunk of frequencies, pair].

struct Extrema {
    // Largest |H|^2, (um/N)^2.
    peak: real,
    // Smallest Re H, um/N.
    real_part: real,
    peak_at: u32,
    real_part_at: u32,
}

@group(1) @binding(0) var<storage, read_write> extrema: array<Extrema>;

const NOWHERE: u32 = 0xffffffffu;

var<workgroup> candidates: array<Extrema, WORKGROUP>;

fn better(a: Extrema, b: Extrema) -> Extrema {
    var best = a;
    if b.peak > a.peak || (b.peak == a.peak && b.peak_at < a.peak_at) {
        best.peak = b.peak;
        best.peak_at = b.peak_at;
    }
    if b.real_part < a.real_part || (b.real_part == a.real_part && b.real_part_at < a.real_part_at) {
        best.real_part = b.real_part;
        best.real_part_at = b.real_part_at;
    }
    return best;
}

fn entry(re: real, im: real, frequency: u32) -> Extrema {
    return Extrema(re * re + im * im, re, frequency, frequency);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let position = group.y;
    let first_duo = group.z * DUOS;
    var best: array<Extrema, 2u * DUOS>;
    for (var i = 0u; i < 2u * DUOS; i++) {
        best[i] = Extrema(real(-1.0), real(3.0e38), NOWHERE, NOWHERE);
    }
    for (var step = 0u; step < STEPS; step++) {
        let first = (group.x * STEPS + step) * WAYS * WORKGROUP + lane;
        let sum = modal_sum(position, first, first_duo);
        for (var k = 0u; k < WAYS; k++) {
            let frequency = way(first, k);
            if frequency < params.n_frequencies {
                for (var d = 0u; d < DUOS; d++) {
                    let re = sum.re[k * DUOS + d];
                    let im = sum.im[k * DUOS + d];
                    best[2u * d] = better(best[2u * d], entry(re.x, im.x, frequency));
                    best[2u * d + 1u] = better(best[2u * d + 1u], entry(re.y, im.y, frequency));
                }
            }
        }
    }
    for (var i = 0u; i < 2u * DUOS; i++) {
        workgroupBarrier();
        candidates[lane] = best[i];
        for (var width = WORKGROUP / 2u; width > 0u; width /= 2u) {
            workgroupBarrier();
            if lane < width {
                candidates[lane] = better(candidates[lane], candidates[lane + width]);
            }
        }
        let pair = 2u * first_duo + i;
        if lane == 0u && pair < params.n_pairs {
            extrema[(position * groups.x + group.x) * params.n_pairs + pair] = candidates[0];
        }
    }
}
