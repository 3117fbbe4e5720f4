// The modal sum in f64: what shaders/modal_sum.wgsl computes, where there is no WebGPU and for single curves.

// Accelerance of a pair at 0 Hz, 1/kg: what free motions give; every elastic mode is multiplied by 0.
function acceleranceAtRest({ n, frequency, outputs, inputs }, o, i) {
  let sum = 0;
  for (let r = 0; r < n; r++) if (frequency[r] === 0) sum += outputs[o * n + r] * inputs[i * n + r];
  return sum;
}

// Response of one output to one input at a frequency (Hz), m/N times the powers of 1/s, into value [re, im].
function responseAt(system, o, i, nInputs, f, power, value) {
  const { n, frequency, viscous, loss, outputs, inputs, residual, degrees } = system;
  if (f === 0 && power === 2) {
    value[0] = acceleranceAtRest(system, o, i);
    value[1] = 0;
    return;
  }
  const omega = TAU * f;
  let re = 0;
  let im = 0;
  for (let r = 0; r < n; r++) {
    const u = (frequency[r] - f) * (frequency[r] + f);
    const v = loss[r] + viscous[r] * f;
    const a = (outputs[o * n + r] * inputs[i * n + r]) / (TAU * TAU * (u * u + v * v));
    re += a * u;
    im -= a * v;
  }
  let [pr, pi] = [1, 0];
  for (let k = 0; k < degrees; k++) {
    const at = k * (residual.length / degrees) + 2 * (o * nInputs + i);
    const cr = residual[at];
    const ci = residual[at + 1];
    re += cr * pr - ci * pi;
    im += cr * pi + ci * pr;
    [pr, pi] = [-pi * omega, pr * omega];
  }
  for (let k = 0; k < power; k++) [re, im] = [-im * omega, re * omega];
  value[0] = re;
  value[1] = im;
}

// A map of one pair, um/N times the powers of 1/s: [position, frequency, re | im].
function sumMap(systems, o, i, nInputs, frequencies, power) {
  const values = new Float64Array(systems.length * frequencies.length * 2);
  const value = [0, 0];
  let at = 0;
  for (const system of systems) {
    for (const f of frequencies) {
      responseAt(system, o, i, nInputs, f, power, value);
      values[at++] = value[0] * 1e6;
      values[at++] = value[1] * 1e6;
    }
  }
  return values;
}

const GOLDEN = 0.6180339887498949;

// Largest |H| of a pair in a window: the best of the modes' own peaks and the window's ends, by golden sections
// within half a band to either side.
function largestResponse(system, o, i, nInputs, from, to) {
  const value = [0, 0];
  const magnitude = (f) => {
    responseAt(system, o, i, nInputs, f, 0, value);
    return Math.hypot(value[0], value[1]);
  };
  const starts = [from, to];
  for (let r = 0; r < system.n; r++) {
    const f = system.frequency[r];
    if (f > from && f < to) starts.push(f);
  }
  const found = starts.map((f) => ({ f, value: magnitude(f) })).sort((a, b) => b.value - a.value);
  let best = found[0];
  for (const start of found.slice(0, 3)) {
    if (start.value < 0.5 * best.value) break;
    const r = system.frequency.indexOf(start.f);
    const half = r < 0 ? 0.02 * start.f + 0.1 : Math.max(system.viscous[r] + system.loss[r] / start.f, 1e-3 * start.f);
    let [a, b] = [Math.max(from, start.f - half), Math.min(to, start.f + half)];
    for (let step = 0; step < 20; step++) {
      const [c, d] = [b - GOLDEN * (b - a), a + GOLDEN * (b - a)];
      if (magnitude(c) > magnitude(d)) b = d;
      else a = c;
    }
    const middle = 0.5 * (a + b);
    const candidate = { f: middle, value: magnitude(middle) };
    if (candidate.value > best.value) best = candidate;
  }
  return best;
}
