// The machine at a position as a sum of modes: as it was run, or with changed joints and damping.
//
// A system: { n, frequency, viscous, loss, outputs, inputs, residual, degrees }, with viscous = 2 zeta f and
// loss = eta f^2 (Hz, Hz^2), shapes [port, mode], residual [degree, output, input, re | im] in powers of j omega. Where
// damping couples the modes these are projected on them, and `exact` (exact.js) holds what they leave out.

const TAU = 2 * Math.PI;
// The share of the largest motion of the ports below which a free motion is not felt. Which motions are free is a
// count that the program finds from the joints; a mode at 0.1 Hz on soft mounts is not one.
const FELT = 1e-6;
// A mode that only springs damp has no damping in the sum that they are eliminated from: this loss factor keeps it finite.
const FLOOR = 1e-9;

function sizes(db) {
  const { outputs, inputs, springs, symmetric } = db.header;
  return { s: springs.length, o: outputs.length, i: inputs.length, extra: symmetric ? 0 : inputs.length };
}

// The system that the run's map was summed from, with the sums of its dissipating springs where damping couples modes.
function nominalSystem(db, p) {
  const { o, i } = sizes(db);
  const system = storedSums(db, p, "nominal", o, i, db.header.symmetric);
  const { coupled } = db.header;
  if (!coupled) return system;
  const { springs, complex, symmetric } = coupled;
  const parts = complex ? 2 : 1;
  const of = (name) => db.values(name).subarray(p * springs, (p + 1) * springs);
  system.exact = {
    ...storedSums(db, p, "coupled", (o + springs) * parts, (i + springs) * parts, symmetric),
    springs,
    complex,
    damper: of("coupled_viscous"),
    structural: of("coupled_structural"),
  };
  return system;
}

// Sums over modes between so many output and input rows, from the arrays whose names begin so.
function storedSums(db, p, prefix, o, i, symmetric) {
  const m = db.shape(`${prefix}_frequency`)[1];
  const degrees = db.shape(`${prefix}_residual`)[1];
  const n = db.values(`${prefix}_count`)[p];
  const part = (name, k) => db.values(`${prefix}_${name}`).subarray(p * k, (p + 1) * k);
  const frequency = part("frequency", m).slice(0, n);
  const rows = (name, k) => {
    const all = part(name, k * m);
    const out = new Float64Array(k * n);
    for (let a = 0; a < k; a++) out.set(all.subarray(a * m, a * m + n), a * n);
    return out;
  };
  const outputs = rows("outputs", o);
  const inputs = symmetric ? outputs : rows("inputs", i);
  const viscous = part("ratio", m).slice(0, n).map((zeta, r) => 2 * zeta * frequency[r]);
  const loss = part("loss", m).slice(0, n).map((eta, r) => eta * frequency[r] * frequency[r]);
  const residual = part("residual", degrees * o * i * 2);
  return { n, frequency, viscous, loss, outputs, inputs, residual, degrees };
}

// Changes of the springs' stiffness at a position: factors [spring].
function changes(db, p, factors) {
  const { s } = sizes(db);
  const stiffness = db.values("stiffness");
  const changed = [];
  for (let k = 0; k < s; k++) {
    const dk = (factors[k] - 1) * stiffness[p * s + k];
    if (dk !== 0) changed.push({ spring: k, dk });
  }
  return changed;
}

// F = (I + dk C)^-1 dk between the changed springs, made symmetric.
function changeMatrix(changed, flexibility, width) {
  const n = changed.length;
  const a = new Float64Array(n * n);
  const f = new Float64Array(n * n);
  for (let i = 0; i < n; i++) {
    for (let j = 0; j < n; j++) {
      const c = flexibility[changed[i].spring * width + changed[j].spring];
      a[i * n + j] = (i === j ? 1 : 0) + changed[i].dk * c;
    }
    f[i * n + i] = changed[i].dk;
  }
  for (let k = 0; k < n; k++) {
    let pivot = k;
    for (let i = k + 1; i < n; i++) if (Math.abs(a[i * n + k]) > Math.abs(a[pivot * n + k])) pivot = i;
    for (let j = 0; j < n && pivot !== k; j++) {
      [a[k * n + j], a[pivot * n + j]] = [a[pivot * n + j], a[k * n + j]];
      [f[k * n + j], f[pivot * n + j]] = [f[pivot * n + j], f[k * n + j]];
    }
    for (let i = 0; i < n; i++) {
      if (i === k) continue;
      const factor = a[i * n + k] / a[k * n + k];
      if (factor === 0) continue;
      for (let j = k; j < n; j++) a[i * n + j] -= factor * a[k * n + j];
      for (let j = 0; j < n; j++) f[i * n + j] -= factor * f[k * n + j];
    }
  }
  for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) f[i * n + j] /= a[i * n + i];
  for (let i = 0; i < n; i++) {
    for (let j = 0; j < i; j++) f[i * n + j] = f[j * n + i] = 0.5 * (f[i * n + j] + f[j * n + i]);
  }
  return f;
}

const scratch = { size: 0 };

function scratchFor(n, m) {
  if (scratch.size < n * n) {
    scratch.size = n * n;
    scratch.matrix = new Float64Array(n * n);
    scratch.vectors = [0, 1, 2].map(() => new Float64Array(n));
  }
  return { matrix: scratch.matrix, vectors: scratch.vectors, rows: new Float64Array(m * n) };
}

// The system with springs times their factors; damping is one ratio for all modes, or null for the machine's own.
function changedSystem(db, p, factors, damping) {
  const { s, o, i, extra } = sizes(db);
  const width = s + o + extra;
  const stride = db.shape("local_eigenvalue")[1];
  const n = db.values("local_count")[p];
  const eigenvalues = db.values("local_eigenvalue").subarray(p * stride, p * stride + n);
  const rows = db.values("local_rows").subarray(p * width * stride, (p + 1) * width * stride);
  const flexibility = db.values("local_residual").subarray(p * width * width, (p + 1) * width * width);
  const stiffness = db.values("stiffness").subarray(p * s, (p + 1) * s);
  const lossy = damping === null ? db.header.springs.map((spring, k) => ({ ...spring, k })).filter(damps) : [];
  const wanted = [];
  for (let k = s; k < width; k++) wanted.push(k);
  for (const spring of lossy) wanted.push(spring.k);

  const changed = changes(db, p, factors);
  const nc = changed.length;
  const f = changeMatrix(changed, flexibility, width);
  const forces = new Float64Array(nc * n);
  for (let a = 0; a < nc; a++) {
    for (let b = 0; b < nc; b++) {
      const value = f[a * nc + b];
      const row = changed[b].spring * stride;
      for (let r = 0; r < n; r++) forces[a * n + r] += value * rows[row + r];
    }
  }
  const space = scratchFor(n, wanted.length);
  wanted.forEach((k, w) => {
    for (let r = 0; r < n; r++) space.rows[w * n + r] = rows[k * stride + r];
    for (let a = 0; a < nc; a++) {
      const c = flexibility[k * width + changed[a].spring];
      for (let r = 0; r < n; r++) space.rows[w * n + r] -= c * forces[a * n + r];
    }
  });
  // Rows and columns of what no coordinate carries: ports, then the springs that dissipate.
  const ports = (first, count) => Array.from({ length: count }, (_, k) => first + k);
  const springs = lossy.map((spring) => spring.k);
  const direct = directFlexibility(changed, f, flexibility, width, [
    [...ports(s, o), ...springs],
    [...ports(extra > 0 ? s + o : s, i), ...springs],
  ]);
  const d = new Float64Array(n);
  if (nc === 0) {
    d.set(eigenvalues);
  } else {
    const { matrix } = space;
    matrix.fill(0, 0, n * n);
    for (let r = 0; r < n; r++) matrix[r * n + r] = eigenvalues[r];
    for (let a = 0; a < nc; a++) {
      const row = changed[a].spring * stride;
      for (let r = 0; r < n; r++) {
        const scale = rows[row + r] / (TAU * TAU);
        for (let q = 0; q <= r; q++) matrix[r * n + q] += scale * forces[a * n + q];
      }
    }
    eigenRows(n, matrix, space.rows, wanted.length, d, space.vectors);
  }
  // The machine's own loss factor makes every stiffness complex, that of the rest too.
  const eta = damping === null ? db.header.loss_factor : 0;
  for (let at = 0; at < direct.length; at += 2) {
    const value = direct[at] / (1 + eta * eta);
    [direct[at], direct[at + 1]] = [value, -eta * value];
  }
  const free = db.values("local_free")[p];
  const shapes = { ports: width - s, lossy, factors, stiffness, rows: space.rows, n, free };
  return modalSystem(db, d, shapes, direct, damping);
}

function damps(spring) {
  return spring.damping > 0 || spring.loss_factor > 0;
}

// C - C_s F C_s between rows and columns as a residual of degree 0.
function directFlexibility(changed, f, c, width, [rows, columns]) {
  const nc = changed.length;
  const residual = new Float64Array(rows.length * columns.length * 2);
  rows.forEach((ra, a) => {
    const through = new Float64Array(nc);
    for (let k = 0; k < nc; k++) {
      for (let l = 0; l < nc; l++) through[l] += c[ra * width + changed[k].spring] * f[k * nc + l];
    }
    columns.forEach((rb, b) => {
      let value = c[ra * width + rb];
      for (let l = 0; l < nc; l++) value -= through[l] * c[rb * width + changed[l].spring];
      residual[2 * (a * columns.length + b)] = value;
    });
  });
  return residual;
}

// Orders the modes, leaves out free motions that the ports do not feel and gives each its damping.
function modalSystem(db, eigenvalues, shapes, residual, damping) {
  const { o, i } = sizes(db);
  const { ports, rows, n, lossy } = shapes;
  const springs = lossy.length;
  const order = Array.from(eigenvalues.keys()).sort((a, b) => eigenvalues[a] - eigenvalues[b]);
  const hertz = (r) => Math.sqrt(Math.max(eigenvalues[r], 0));
  const norm = (r, from, to) => {
    let sum = 0;
    for (let k = from; k < to; k++) sum += rows[k * n + r] * rows[k * n + r];
    return Math.sqrt(sum);
  };
  const motion = (r) => norm(r, 0, o) * norm(r, ports - i, ports);
  const largest = order.reduce((top, r) => Math.max(top, motion(r)), 0);
  const kept = order.map((r, rank) => ({ r, free: rank < shapes.free })).filter(({ r, free }) => !free || motion(r) > FELT * largest);
  const size = kept.length;
  // Outputs and springs, inputs and springs over the modes that are kept.
  const over = (list) => {
    const out = new Float64Array(list.length * size);
    list.forEach((row, a) => kept.forEach(({ r }, q) => (out[a * size + q] = rows[row * n + r])));
    return out;
  };
  const list = (first, count) => Array.from({ length: count }, (_, k) => first + k);
  const own = list(ports, springs);
  const frequency = new Float64Array(size);
  const system = { n: size, frequency, degrees: 1, residual };
  const projected = { viscous: new Float64Array(size), loss: new Float64Array(size) };
  const whole = { viscous: new Float64Array(size), loss: new Float64Array(size) };
  let elastic = 0;
  kept.forEach(({ r, free }, q) => {
    if (free) return;
    const f = hertz(r);
    const [zeta, eta] = modeDamping(db.header, elastic++, f, damping);
    const [dampers, losses] = springDamping(shapes, r, f);
    frequency[q] = f;
    projected.viscous[q] = 2 * (zeta + dampers) * f;
    projected.loss[q] = (eta + losses) * f * f;
    whole.viscous[q] = 2 * zeta * f;
    whole.loss[q] = (2 * zeta + eta < FLOOR ? FLOOR : eta) * f * f;
  });
  const outputs = over(list(0, o));
  const inputs = db.header.symmetric ? outputs : over(list(ports - i, i));
  Object.assign(system, projected, { outputs, inputs });
  if (springs === 0) return system;
  system.residual = withoutSprings(residual, o, i, springs);
  if (db.header.projected) return system;
  system.exact = {
    ...whole,
    n: size,
    frequency,
    outputs: over([...list(0, o), ...own]),
    inputs: over([...list(ports - i, i), ...own]),
    residual,
    degrees: 1,
    springs,
    complex: false,
    damper: lossy.map((spring) => spring.damping),
    structural: lossy.map(({ k, loss_factor }) => loss_factor * shapes.factors[k] * shapes.stiffness[k]),
  };
  return system;
}

// The residual between ports alone.
function withoutSprings(residual, o, i, springs) {
  const out = new Float64Array(o * i * 2);
  for (let a = 0; a < o; a++) {
    const from = 2 * a * (i + springs);
    out.set(residual.subarray(from, from + 2 * i), 2 * a * i);
  }
  return out;
}

// Viscous ratio and loss factor of a mode by what damps all of the machine.
function modeDamping(header, elastic, f, damping) {
  if (damping !== null) return [damping, 0];
  const omega = TAU * f;
  const ratios = header.damping_ratios;
  let zeta = ratios.length > 0 ? ratios[Math.min(elastic, ratios.length - 1)] : 0;
  if (header.rayleigh) zeta += 0.5 * (header.rayleigh[0] / omega + header.rayleigh[1] * omega);
  return [zeta, header.loss_factor];
}

// What dampers and loss factors of joints add, projected on the mode.
function springDamping(shapes, r, f) {
  const omega = TAU * f;
  let [zeta, eta] = [0, 0];
  shapes.lossy.forEach((spring, k) => {
    const elongation = shapes.rows[(shapes.ports + k) * shapes.n + r];
    const square = elongation * elongation;
    zeta += (spring.damping * square) / (2 * omega);
    eta += (spring.loss_factor * shapes.factors[spring.k] * shapes.stiffness[spring.k] * square) / (omega * omega);
  });
  return [zeta, eta];
}
