// The page: settings in, surface, curves and tables out.
"use strict";

const $ = (id) => document.getElementById(id);

// What the heights and curves show: unit by quantity, and the number of a response in um/N times the powers of 1/s.
const QUANTITIES = {
  0: { name: "Receptance", unit: "µm/N", factor: 1 },
  1: { name: "Mobility", unit: "µm/(N s)", factor: 1 },
  2: { name: "Accelerance", unit: "m/(N s²)", factor: 1e-6 },
  stiffness: { name: "Dynamic stiffness 1/H", unit: "N/µm", factor: 1 },
};
const PARTS = {
  log: (re, im) => Math.hypot(re, im),
  linear: (re, im) => Math.hypot(re, im),
  real: (re) => re,
  imaginary: (re, im) => im,
  phase: (re, im) => (Math.atan2(im, re) * 180) / Math.PI,
};
// A logarithmic scale spans this many powers of ten at most.
const DECADES = 5;
const GROUPS = {
  guides: "stiffness of the guides",
  bearings: "stiffness of the bearings",
  screws: "diameter of the screw",
  dampers: "stiffness of the spring-dampers",
};

const stiffmap = { timings: {}, errors: [] };
window.stiffmap = stiffmap;

class Page {
  constructor(db, manifest) {
    this.db = db;
    this.manifest = manifest;
    const { header } = db;
    const listed = Array.from(db.positions.keys());
    this.order = listed.sort((a, b) => db.positions[a] - db.positions[b]);
    this.along = this.order.map((p) => db.positions[p] * 1e3);
    const lowest = db.frequencies[0];
    const highest = db.frequencies[db.frequencies.length - 1];
    this.limits = [lowest, highest > lowest ? highest : lowest + 1];
    this.state = {
      output: 0,
      input: 0,
      quantity: String(Math.max(0, ["receptance", "mobility", "accelerance"].indexOf(header.quantity))),
      part: "log",
      colours: "viridis",
      position: 0,
      frequency: 0.5 * (lowest + highest),
      from: this.limits[0],
      to: this.limits[1],
      resolution: 450,
      damping: null,
      factors: Object.fromEntries(header.groups.map((group) => [group.name, 1])),
      reference: 0,
      mode: 0,
      amplitude: 0.05,
    };
    this.busy = null;
    this.again = false;
    // Resolves once what is shown has its damping exactly.
    this.settled = Promise.resolve();
    this.round = 0;
    // Frequencies of a changed machine above this one are not the machine's.
    this.reach = header.accuracy ? header.accuracy.reach_hz : header.highest_hz;
  }

  // Opens what computes and what draws, then shows the machine as run.
  async start(shader, withoutGpu) {
    const source = `${$("shared").textContent}`;
    this.engine = new Engine(this.db, source);
    buildControls(this);
    try {
      this.surface = this.order.length > 1 ? new Surface($("surface")) : null;
      if (!this.surface) $("surface-panel").hidden = true;
    } catch (error) {
      fail(`The surfaces are not drawn: ${error.message || error}. Curves and tables are complete.`);
    }
    this.curves = buildCurves(this);
    await this.engine.open(shader, withoutGpu);
    $("reach").textContent = reachText(this.db.header);
    await this.refresh();
    stiffmap.timings.first = performance.now();
    this.startShapes();
    $("facts").append(...runFacts(this.manifest));
    $("family-table").append(familyTable(this.db.header));
    $("remarks").append(...remarks(this.db, this.manifest));
    setTimeout(() => this.engine.startWorkers(), 100);
  }

  startShapes() {
    // Parts given by matrices alone have no surface.
    if (this.db.values("skin_node").length === 0) $("shape-panel").hidden = true;
    else this.openShapes();
    this.showShape();
    this.showMac();
  }

  openShapes() {
    try {
      this.shapes = new Shapes($("shape"), this.db);
      this.shapes.setColours(this.state.colours);
    } catch (error) {
      fail(`Mode shapes are not drawn: ${error.message || error}.`);
    }
  }

  // Takes changes of the state; resolves once the surface shows them.
  async set(changes) {
    Object.assign(this.state, changes);
    showControls(this);
    await this.refresh();
  }

  // Computes and draws; while that runs, further calls are answered by one more run with the newest state.
  refresh() {
    this.again = true;
    this.round++;
    if (!this.busy) {
      this.busy = this.run().finally(() => {
        this.busy = null;
      });
    }
    return this.busy;
  }

  async run() {
    while (this.again) {
      this.again = false;
      try {
        await this.once();
      } catch (error) {
        fail(`The map was not computed: ${error.message || error}`);
        throw error;
      }
      await new Promise((resolve) => setTimeout(resolve, 0));
      if (!this.again) this.showRest();
    }
    this.settled = this.settle();
    this.settled.catch((error) => fail(`The map with exact damping was not computed: ${error.message || error}`));
  }

  // Where damping couples the modes: surface and curves with that damping exact, once nothing moves.
  async settle() {
    const { state, engine, round } = this;
    if (!engine.isCoupled()) return;
    const { frequencies } = this.map;
    const isWanted = () => round === this.round;
    const values = await engine.exactMap(state.output, state.input, frequencies, this.power(), isWanted);
    if (!values) return;
    this.map = { frequencies, values: this.withinReach(frequencies, values), engine: "JavaScript", exact: true };
    this.drawSurface(frequencies, this.map.values);
    this.showEngine();
    this.showRest();
  }

  // What single responses are computed by: as the surface that is shown.
  responses() {
    return this.map.exact ? responseAt : projectedAt;
  }

  power() {
    return this.state.quantity === "stiffness" ? 0 : Number(this.state.quantity);
  }

  isChanged() {
    return this.engine.key !== "";
  }

  // A map of changed machines without what is beyond the page's reach.
  withinReach(frequencies, values) {
    if (!this.isChanged() || frequencies[frequencies.length - 1] <= this.reach) return values;
    const n = frequencies.length;
    for (let at = 0; at < values.length; at++) if (frequencies[(at >> 1) % n] > this.reach) values[at] = NaN;
    return values;
  }

  showEngine() {
    const { engine, map } = this;
    let text = `Maps computed by ${engine.engineName()}`;
    if (engine.isCoupled()) {
      text += map.exact
        ? "; shown: by JavaScript, with the damping of joints and parts exact"
        : "; shown: with the damping of joints and parts projected on the modes while settings change, exact in a moment";
    }
    $("engine").textContent = text;
  }

  grid() {
    const { from, to, resolution } = this.state;
    return Float64Array.from({ length: resolution }, (_, k) => from + ((to - from) * k) / (resolution - 1));
  }

  async once() {
    const started = performance.now();
    const { state, engine } = this;
    const grid = this.grid();
    const { factors, damping } = state;
    await engine.solve({ factors, damping });
    const solved = performance.now();
    const values = await engine.map(state.output, state.input, grid, this.power());
    const summed = performance.now();
    const exact = !engine.isCoupled();
    this.map = { frequencies: grid, values: this.withinReach(grid, values), engine: engine.engineName(), exact };
    this.drawSurface(grid, this.map.values);
    await this.painted();
    const drawn = performance.now();
    const [all, solve, sum, draw] = [drawn - started, solved - started, summed - solved, drawn - summed];
    stiffmap.timings.last = { all, solve, sum, draw, factor: factors.guides, at: drawn };
    const split = `${solve.toFixed(0)} to solve, ${sum.toFixed(0)} to sum, ${draw.toFixed(0)} to draw`;
    $("timing").textContent = `${this.order.length} × ${grid.length} pairs in ${all.toFixed(0)} ms (${split})`;
    this.showEngine();
  }

  // Resolves after the frame that shows the surface.
  painted() {
    if (document.visibilityState === "hidden") return null;
    return new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve, 0)));
  }

  // A response as what is shown, from um/N times the powers of 1/s.
  shown(re, im) {
    const { quantity, part } = this.state;
    const { factor } = QUANTITIES[quantity];
    if (quantity === "stiffness") {
      const square = re * re + im * im;
      return PARTS[part](re / square, -im / square);
    }
    return PARTS[part](re * factor, im * factor);
  }

  label() {
    const { quantity, part, output, input } = this.state;
    const { name, unit } = QUANTITIES[quantity];
    const { outputs, inputs } = this.db.header;
    const pair = `${outputs[output]}/${inputs[input]}`;
    if (part === "phase") return `Phase of ${name} ${pair} [°]`;
    const what = { log: `|${name}|`, linear: `|${name}|`, real: `Re ${name}`, imaginary: `Im ${name}` }[part];
    return `${what} ${pair} [${unit}]`;
  }

  drawSurface(grid, values) {
    if (!this.surface) return;
    const { order, state } = this;
    const n = grid.length;
    const numbers = new Float32Array(order.length * n);
    let [low, high] = [Infinity, -Infinity];
    order.forEach((p, row) => {
      for (let k = 0; k < n; k++) {
        const at = 2 * (p * n + k);
        const value = this.shown(values[at], values[at + 1]);
        numbers[row * n + k] = value;
        if (!Number.isFinite(value)) continue;
        if (value < low && (state.part !== "log" || value > 0)) low = value;
        if (value > high) high = value;
      }
    });
    const scale = heightScale(state.part, low, high);
    // What is not known lies on the floor.
    for (let k = 0; k < numbers.length; k++) numbers[k] = Number.isFinite(numbers[k]) ? scale.at(numbers[k]) : 0;
    const [x0, x1] = [grid[0], grid[n - 1]];
    const [z0, z1] = [this.along[0], this.along[this.along.length - 1]];
    this.surface.setGrid(
      Array.from(grid, (f) => (f - x0) / (x1 - x0)),
      this.along.map((z) => (z - z0) / (z1 - z0)),
    );
    const axes = {
      x: {
        ticks: roundTicks(x0, x1, 6).map((f) => ({ at: (f - x0) / (x1 - x0), text: digits(f, 5) })),
        label: "Frequency [Hz]",
      },
      z: {
        ticks: roundTicks(z0, z1, 4).map((z) => ({ at: (z - z0) / (z1 - z0), text: digits(z, 5) })),
        label: `Position ${this.db.header.axis} [mm]`,
      },
      y: { ticks: scale.ticks, label: this.label() },
    };
    // While a slider moves, the axes seldom change.
    const key = JSON.stringify([axes, isDark()]);
    if (key !== this.axesKey) this.surface.setAxes(axes);
    this.axesKey = key;
    this.surface.setHeights(numbers);
    this.placeCursor();
  }

  placeCursor() {
    if (!this.surface || !this.surface.mesh) return;
    const { from, to, resolution, frequency, position } = this.state;
    const column = Math.round(((frequency - from) / (to - from)) * (resolution - 1));
    const row = this.order.indexOf(position);
    this.surface.setCursor(Math.min(Math.max(column, 0), resolution - 1), row);
  }

  // Elastic frequencies of the settings' machine at a position, by rank, as far as the page reaches.
  drawnFrequencies(position) {
    return Array.from(this.engine.systems[position].frequency).filter((f) => f > 0 && f <= this.reach);
  }

  // Everything beside the surface.
  showRest() {
    showCurves(this);
    const { position } = this.state;
    $("mode-table").replaceChildren(
      modeTable(this.db, position, this.isChanged() ? this.drawnFrequencies(position) : null),
    );
  }

  moveCursor(changes) {
    Object.assign(this.state, changes);
    showControls(this);
    this.placeCursor();
    this.showRest();
    if (changes.position !== undefined) {
      this.showShape();
      this.showMac();
    }
  }

  showShape() {
    if (!this.shapes) return;
    const { position, mode, amplitude } = this.state;
    const listed = this.db.shape("family")[1];
    const family = this.db.values("family")[position * listed + mode];
    const f = this.db.values("family_frequency")[position * listed + mode];
    this.shapes.show(position, mode, amplitude);
    const place = `${this.db.header.axis} = ${mm(this.db.positions[position])} mm`;
    const what = f === 0 ? "free motion at 0 Hz" : `${f.toFixed(2)} Hz`;
    $("shape-caption").textContent =
      `Rank ${mode + 1}, family ${family}, ${what} at ${place}; largest displacement ${digits(this.shapes.largest, 3)} kg^(−1/2), drawn exaggerated; colours from none to the largest.`;
  }

  showMac() {
    const { position, reference, colours } = this.state;
    const { values, listed } = drawMac($("mac"), this.db, position, reference, colours);
    let worst = 0;
    for (let r = 1; r < listed; r++) if (values[r * listed + r] < values[worst * listed + worst]) worst = r;
    const [a, b] = [position, reference].map((p) => `${mm(this.db.positions[p])} mm`);
    $("mac-caption").textContent =
      `Rows: ranks 1 to ${listed} at ${a}; columns: at ${b}. Smallest on the diagonal: ${digits(values[worst * listed + worst], 3)} at rank ${worst + 1}.`;
  }

  setColours() {
    const { colours } = this.state;
    if (this.surface) this.surface.setColours(colours);
    if (this.shapes) this.shapes.setColours(colours);
    this.showMac();
  }

  // After a change between light and dark.
  recolour() {
    this.drawSurface(this.map.frequencies, this.map.values);
    this.showRest();
  }
}

// Heights 0 to 1 of what is shown, with ticks.
function heightScale(part, low, high) {
  if (!(high >= low)) [low, high] = [0, 1];
  if (part === "log") {
    const top = Math.log10(high > 0 ? high : 1);
    const bottom = Math.max(low > 0 ? Math.log10(low) : top - 1, top - DECADES);
    const range = top > bottom ? top - bottom : 1;
    const ticks = [];
    for (let k = Math.ceil(bottom); k <= top; k++) ticks.push({ at: (k - bottom) / range, text: `10${raised(k)}` });
    return { ticks, at: (v) => Math.max(0, (Math.log10(Math.max(v, 1e-300)) - bottom) / range) };
  }
  if (part === "linear") low = 0;
  if (part === "phase") [low, high] = [-180, 180];
  const range = high > low ? high - low : 1;
  const ticks = part === "phase" ? [-180, -90, 0, 90, 180] : roundTicks(low, high, 5);
  return { ticks: ticks.map((v) => ({ at: (v - low) / range, text: digits(v, 3) })), at: (v) => (v - low) / range };
}

function fail(text) {
  stiffmap.errors.push(text);
  $("failure").textContent = text;
  $("failure").hidden = false;
}

stiffmap.ready = (async () => {
  const element = $("database");
  const bytes = fromBase64(element.textContent.trim());
  if (checksum(bytes) !== element.dataset.checksum) {
    throw new Error("the file is damaged; `stiffmap figures` writes it again from its folder");
  }
  const db = openDatabase(bytes);
  const manifest = JSON.parse($("manifest").textContent);
  const page = new Page(db, manifest);
  stiffmap.page = page;
  const withoutGpu = /[?#&]webgpu=off/.test(location.href);
  await page.start($("modal_sum.wgsl").textContent, withoutGpu);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => page.recolour());
  window.addEventListener("beforeprint", () => {
    for (const view of [page.surface, page.shapes]) if (view) view.view.resize();
  });
  return page;
})();
stiffmap.ready.catch((error) => fail(`The page could not be shown: ${error.message || error}`));
