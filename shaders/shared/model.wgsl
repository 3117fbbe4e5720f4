// The read-only model (group 0) and the modal sum at one (position, frequency) pair.
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

struct Sum {
    re: array<real2, DUOS>,
    im: array<real2, DUOS>,
}

// Sums DUOS duos from first_duo on.
fn modal_sum(position: u32, frequency: u32, first_duo: u32) -> Sum {
    let f = frequencies[frequency];
    var sum = residual_polynomial(position, f.x, first_duo);

    let stride = 2u + params.n_duos;
    var base = position * params.n_modes * stride;
    for (var r = 0u; r < params.n_modes; r++) {
        let f_r = modes[base];
        let damping = modes[base + 1u];
        let u = difference(f_r, f) * (f_r.x + f.x);
        let v = damping.x * f.x + damping.y;
        let inverse = real(1.0) / (u * u + v * v);
        let g = u * inverse;
        let h = -v * inverse;
        for (var d = 0u; d < DUOS; d++) {
            let residues = modes[base + 2u + first_duo + d];
            sum.re[d] += residues * g;
            sum.im[d] += residues * h;
        }
        base += stride;
    }
    return times_power(sum, f.x);
}

// sum C_k f^k by Horner's rule from the highest power.
fn residual_polynomial(position: u32, f: real, first_duo: u32) -> Sum {
    var sum: Sum;
    for (var k = params.n_degrees; k > 0u; k--) {
        let base = 2u * ((position * params.n_degrees + k - 1u) * params.n_duos + first_duo);
        for (var d = 0u; d < DUOS; d++) {
            sum.re[d] = sum.re[d] * f + residual[base + 2u * d];
            sum.im[d] = sum.im[d] * f + residual[base + 2u * d + 1u];
        }
    }
    return sum;
}

// Times (j f)^power: 0 receptance, 1 mobility, 2 accelerance.
fn times_power(sum: Sum, f: real) -> Sum {
    var product = sum;
    for (var i = 0u; i < params.power; i++) {
        for (var d = 0u; d < DUOS; d++) {
            let re = product.re[d];
            product.re[d] = -product.im[d] * f;
            product.im[d] = re * f;
        }
    }
    return product;
}
