// Numbers in f64 (wgpu's SHADER_F64). The low parts of frequencies are 0.

alias real = f64;
alias real2 = vec2<f64>;

fn difference(a: real2, b: real2) -> real {
    return (a.x - b.x) + (a.y - b.y);
}
