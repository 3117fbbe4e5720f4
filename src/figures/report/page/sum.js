// The modal sum in f64: what shaders/modal_sum.wgsl computes, where there is no WebGPU and for single curves.

// Accelerance of a pair at 0 Hz, 1/kg: what free motions give; every elastic mode is multiplied by 0.
function acceleranceAtRest({ n, frequency, outputs, inputs }, o, i) {
  let sum = 0;
  for (let r = 0; r < n; r++) if (frequency[r] === 0) sum += outputs[o * n + r] * inputs[i * n + r];
  return sum;
}

// Response of one output to one input at a frequency (Hz), m/N times the powers of 1/s, into value [re, im].
function responseAt(system, o, i, nInputs, f, power, value) {
  if (system.exact && !(f === 0 && power === 2)) exactAt(system.exact, o, i, f, power, value);
  else projectedAt(system, o, i, nInputs, f, power, value);
}

// The same with what dampers and loss factors of joints and parts give to each mode alone; all there is without them.
function projectedAt(system, o, i, nInputs, f, power, value) {
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

// A map of one pair, um/N times the powers of 1/s: [position, frequency, re | im]; `at` is one of both above.
function sumMap(systems, o, i, nInputs, frequencies, power, at) {
  const values = new Float64Array(systems.length * frequencies.length * 2);
  const value = [0, 0];
  let place = 0;
  for (const system of systems) {
    for (const f of frequencies) {
      at(system, o, i, nInputs, f, power, value);
      values[place++] = value[0] * 1e6;
      values[place++] = value[1] * 1e6;
    }
  }
  return values;
}

const GOLDEN = 0.6180339887498949;

// Largest |H| of a pair in a window: the best of the modes' own peaks and the window's ends, by golden sections
// within half a band to either side. Where damping couples the modes the peaks are looked for by projection, which costs
// little, and with `response` exact the highest three are compared and refined exactly.
function largestResponse(system, o, i, nInputs, from, to, response) {
  const value = [0, 0];
  const magnitude = (at) => (f) => {
    at(system, o, i, nInputs, f, 0, value);
    return Math.hypot(value[0], value[1]);
  };
  const [quick, exact] = [magnitude(projectedAt), magnitude(response)];
  const isCoupled = system.exact && response !== projectedAt;
  const starts = [from, to];
  for (let r = 0; r < system.n; r++) {
    const f = system.frequency[r];
    if (f > from && f < to) starts.push(f);
  }
  const half = (f) => {
    const r = system.frequency.indexOf(f);
    return r < 0 ? 0.02 * f + 0.1 : Math.max(system.viscous[r] + system.loss[r] / f, 1e-3 * f);
  };
  const found = starts.map((f) => ({ f, value: quick(f) })).sort((a, b) => b.value - a.value);
  let best = found[0];
  let width = half(best.f);
  const refined = (of, f, half) => {
    let [a, b] = [Math.max(from, f - half), Math.min(to, f + half)];
    let [c, d] = [b - GOLDEN * (b - a), a + GOLDEN * (b - a)];
    let [vc, vd] = [of(c), of(d)];
    for (let step = 0; step < 20; step++) {
      if (vc > vd) {
        [b, d, vd] = [d, c, vc];
        c = b - GOLDEN * (b - a);
        vc = of(c);
      } else {
        [a, c, vc] = [c, d, vd];
        d = a + GOLDEN * (b - a);
        vd = of(d);
      }
    }
    const middle = 0.5 * (a + b);
    return { f: middle, value: of(middle) };
  };
  if (isCoupled) best = { f: best.f, value: exact(best.f) };
  for (const start of found.slice(0, 3)) {
    if (start.value < 0.5 * found[0].value) break;
    const peak = refined(quick, start.f, half(start.f));
    const candidate = isCoupled ? { f: peak.f, value: exact(peak.f) } : peak;
    if (candidate.value > best.value) [best, width] = [candidate, half(start.f)];
  }
  if (!isCoupled) return best;
  const last = refined(exact, best.f, width);
  return last.value > best.value ? last : best;
}
