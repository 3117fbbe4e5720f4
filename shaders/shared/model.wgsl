// The read-only model (group 0) and the modal sum at one position and WAYS frequencies.
//
//            n                         residue_r
// H(f) = [  sum  ------------------------------------------------------ + sum C_k f^k ] (j f)^power
//           r=1   (f_r - f)(f_r + f) + j (loss_r + viscous_r f)            k
//
// in um/N (times the powers of 1/s), with frequencies in units of a power of two of Hz; the host folds the units into
// residue, viscous, loss and C. Pairs of (output, input) come in duos: a real2 holds two of them.
//
// frequencies  [frequency]                  (hi, lo)
// modes        [position, mode, 2 + duo]    (f_r hi, lo), (viscous, loss), residues of each duo
// residual     [position, k, duo, re | im]  real parts of a duo, imaginary parts of a duo

struct Params {
    n_frequencies: u32,
    n_positions: u32,
    n_modes: u32,
    n_degrees: u32,
    n_pairs: u32,
    n_duos: u32,
    power: u32,
    // 0 at run time; see difference().
    zero: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> frequencies: array<real2>;
@group(0) @binding(2) var<storage, read> modes: array<real2>;
@group(0) @binding(3) var<storage, read> residual: array<real2>;

// Sums at WAYS frequencies, which share each load of a mode: [way, duo].
struct Sum {
    re: array<real2, WAYS * DUOS>,
    im: array<real2, WAYS * DUOS>,
}

// Frequency number of a way: neighbours in a workgroup stay neighbours in memory.
fn way(first: u32, k: u32) -> u32 {
    return first + k * WORKGROUP;
}

// Sums DUOS duos from first_duo on, at the frequencies way(first, 0), way(first, 1), ...; beyond the last, the last.
fn modal_sum(position: u32, first: u32, first_duo: u32) -> Sum {
    var f: array<real2, WAYS>;
    for (var k = 0u; k < WAYS; k++) {
        f[k] = frequencies[min(way(first, k), params.n_frequencies - 1u)];
    }
    var sum: Sum;

    // The residual by Horner's rule from the highest power.
    for (var degree = params.n_degrees; degree > 0u; degree--) {
        let base = 2u * ((position * params.n_degrees + degree - 1u) * params.n_duos + first_duo);
        for (var d = 0u; d < DUOS; d++) {
            let re = residual[base + 2u * d];
            let im = residual[base + 2u * d + 1u];
            for (var k = 0u; k < WAYS; k++) {
                sum.re[k * DUOS + d] = sum.re[k * DUOS + d] * f[k].x + re;
                sum.im[k * DUOS + d] = sum.im[k * DUOS + d] * f[k].x + im;
            }
        }
    }

    let stride = 2u + params.n_duos;
    var base = position * params.n_modes * stride;
    for (var r = 0u; r < params.n_modes; r++) {
        let f_r = modes[base];
        let damping = modes[base + 1u];
        var residues: array<real2, DUOS>;
        for (var d = 0u; d < DUOS; d++) {
            residues[d] = modes[base + 2u + first_duo + d];
        }
        for (var k = 0u; k < WAYS; k++) {
            let u = difference(f_r, f[k]) * (f_r.x + f[k].x);
            let v = damping.x * f[k].x + damping.y;
            let inverse = real(1.0) / (u * u + v * v);
            let g = u * inverse;
            let h = -v * inverse;
            for (var d = 0u; d < DUOS; d++) {
                sum.re[k * DUOS + d] += residues[d] * g;
                sum.im[k * DUOS + d] += residues[d] * h;
            }
        }
        base += stride;
    }

    // Times (j f)^power: 0 receptance, 1 mobility, 2 accelerance.
    for (var i = 0u; i < params.power; i++) {
        for (var k = 0u; k < WAYS; k++) {
            for (var d = 0u; d < DUOS; d++) {
                let re = sum.re[k * DUOS + d];
                sum.re[k * DUOS + d] = -sum.im[k * DUOS + d] * f[k].x;
                sum.im[k * DUOS + d] = re * f[k].x;
            }
        }
    }
    return sum;
}
