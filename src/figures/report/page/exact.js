// Responses with dampers and loss factors of joints, exactly, as src/frf/exact.rs has them. With the receptances of the
// machine without what its springs dissipate, between ports p and these springs s, and G = diag(j eta k + j omega c),
//
//   H = H_pp - H_ps (1/G + H_ss)^-1 H_sp.
//
// system.exact: { n, frequency, viscous, loss, outputs, inputs, residual, degrees } as of a system, with rows of outputs
// (inputs), then springs, and springs, damper [spring], structural [spring]; where it is complex, imaginary parts follow
// all real parts of the rows, since parts with loss factors have complex modes.

// The rows of the springs mode by mode: real parts on the left, imaginary parts, the same on the right.
function springsByMode(exact) {
  const { n, springs: s, complex, outputs, inputs } = exact;
  const parts = complex ? 2 : 1;
  const packed = new Float64Array(n * s * 2 * parts);
  const rows = [outputs, inputs].map((all) => ({ all, count: all.length / n / parts }));
  for (let r = 0; r < n; r++) {
    let at = r * s * 2 * parts;
    for (const { all, count } of rows) {
      for (let part = 0; part < parts; part++) {
        for (let k = 0; k < s; k++) packed[at++] = all[(part * count + count - s + k) * n + r];
      }
    }
  }
  return packed;
}

const bordered = { size: 0 };

// H between one output, then springs, and one input, then springs, without what these springs dissipate.
function borderedAt(exact, o, i, f) {
  const { n, springs: s, complex, frequency, viscous, loss, outputs, inputs } = exact;
  const size = 1 + s;
  if (bordered.size !== size) {
    Object.assign(bordered, { size, re: new Float64Array(size * size), im: new Float64Array(size * size) });
    for (const name of ["lr", "li", "rr", "ri"]) bordered[name] = new Float64Array(size);
  }
  if (!exact.packed) exact.packed = springsByMode(exact);
  const { packed } = exact;
  const { re, im, lr, li, rr, ri } = bordered;
  re.fill(0);
  im.fill(0);
  const parts = complex ? 2 : 1;
  const [leftRows, rightRows] = [outputs.length / n / parts, inputs.length / n / parts];
  for (let r = 0; r < n; r++) {
    const u = (frequency[r] - f) * (frequency[r] + f);
    const v = loss[r] + viscous[r] * f;
    const scale = 1 / (TAU * TAU * (u * u + v * v));
    const gr = u * scale;
    const gi = -v * scale;
    const at = r * s * 2 * parts;
    if (!complex) {
      lr[0] = outputs[o * n + r];
      rr[0] = inputs[i * n + r];
      for (let k = 0; k < s; k++) lr[k + 1] = rr[k + 1] = packed[at + k];
      // The springs' block is symmetric: its lower triangle, the row of the output and the column of the input.
      for (let a = 0; a < size; a++) {
        const x = gr * lr[a];
        const y = gi * lr[a];
        const end = a === 0 ? size : a + 1;
        for (let b = 0, k = a * size; b < end; b++, k++) {
          re[k] += x * rr[b];
          im[k] += y * rr[b];
        }
      }
      continue;
    }
    lr[0] = outputs[o * n + r];
    li[0] = outputs[(leftRows + o) * n + r];
    rr[0] = inputs[i * n + r];
    ri[0] = inputs[(rightRows + i) * n + r];
    for (let k = 0; k < s; k++) {
      lr[k + 1] = packed[at + k];
      li[k + 1] = packed[at + s + k];
      rr[k + 1] = packed[at + 2 * s + k];
      ri[k + 1] = packed[at + 3 * s + k];
    }
    for (let a = 0; a < size; a++) {
      const x = gr * lr[a] - gi * li[a];
      const y = gr * li[a] + gi * lr[a];
      for (let b = 0, k = a * size; b < size; b++, k++) {
        re[k] += x * rr[b] - y * ri[b];
        im[k] += x * ri[b] + y * rr[b];
      }
    }
  }
  for (let a = 1; a < size && !complex; a++) {
    for (let b = a + 1; b < size; b++) {
      re[a * size + b] = re[b * size + a];
      im[a * size + b] = im[b * size + a];
    }
  }
  addResidual(exact, o, i, f, leftRows - s, rightRows - s);
  return bordered;
}

// The residual polynomial in j omega between the same rows.
function addResidual({ springs: s, residual, degrees, complex }, o, i, f, nOutputs, nInputs) {
  const { re, im } = bordered;
  const columns = (nInputs + s) * (complex ? 2 : 1);
  let [pr, pi] = [1, 0];
  for (let d = 0; d < degrees; d++) {
    const from = d * (residual.length / degrees);
    for (let a = 0; a <= s; a++) {
      const row = from + 2 * (a === 0 ? o : nOutputs + a - 1) * columns;
      for (let b = 0; b <= s; b++) {
        const at = row + 2 * (b === 0 ? i : nInputs + b - 1);
        const k = a * (1 + s) + b;
        re[k] += residual[at] * pr - residual[at + 1] * pi;
        im[k] += residual[at] * pi + residual[at + 1] * pr;
      }
    }
    [pr, pi] = [-pi * TAU * f, pr * TAU * f];
  }
}

// Response of one output to one input at a frequency (Hz), m/N times the powers of 1/s, into value [re, im].
function exactAt(exact, o, i, f, power, value) {
  const { re, im, size } = borderedAt(exact, o, i, f);
  const omega = TAU * f;
  for (let k = 1; k < size; k++) {
    const g = exact.structural[k - 1] + omega * exact.damper[k - 1];
    if (g === 0) continue;
    // 1 / (H_kk + 1/G), with 1/G = -j/g.
    const own = k * size;
    const br = re[own + k];
    const bi = im[own + k] - 1 / g;
    const square = br * br + bi * bi;
    const ir = br / square;
    const ii = -bi / square;
    // Rows and columns of the ports, then of the springs that are still there.
    for (let a = 0; a < size; a = a === 0 ? k + 1 : a + 1) {
      const row = a * size;
      const hr = re[row + k];
      const hi = im[row + k];
      const fr = hr * ir - hi * ii;
      const fi = hr * ii + hi * ir;
      re[row] -= fr * re[own] - fi * im[own];
      im[row] -= fr * im[own] + fi * re[own];
      for (let b = k + 1; b < size; b++) {
        const cr = re[own + b];
        const ci = im[own + b];
        re[row + b] -= fr * cr - fi * ci;
        im[row + b] -= fr * ci + fi * cr;
      }
    }
  }
  let [hr, hi] = [re[0], im[0]];
  for (let k = 0; k < power; k++) [hr, hi] = [-hi * omega, hr * omega];
  value[0] = hr;
  value[1] = hi;
}
