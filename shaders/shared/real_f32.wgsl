// Numbers in f32. Frequencies are pairs (hi, lo) with hi + lo the f64 value to 48 bits.
// The generated header before this file defines WORKGROUP, WAYS, STEPS, DUOS and SPLIT.

alias real = f32;
alias real2 = vec2<f32>;

// a - b as (hi - hi) + (lo - lo). The first difference passes through an integer xor with a uniform that is 0 at run
// time, so that no compiler can reassociate the floats and lose the low parts.
fn difference(a: real2, b: real2) -> real {
    let high = bitcast<f32>(bitcast<u32>(a.x - b.x) ^ params.zero);
    return select(high, high + (a.y - b.y), SPLIT);
}
