// The settings' controls and the curves beside the surface.
"use strict";

function buildControls(page) {
  const { db, state } = page;
  const { header } = db;
  const options = (select, names) =>
    names.forEach((name, k) => select.append(element("option", { value: String(k), textContent: name })));
  options($("output"), header.outputs);
  options($("input"), header.inputs);
  for (const name of ["output", "input"]) {
    $(name).addEventListener("change", () => page.set({ [name]: Number($(name).value) }));
  }
  for (const name of ["quantity", "part"]) {
    $(name).addEventListener("change", () => page.set({ [name]: $(name).value }));
  }
  $("colours").addEventListener("change", () => {
    state.colours = $("colours").value;
    page.setColours();
  });
  $("position").max = page.order.length - 1;
  $("position").disabled = page.order.length < 2;
  $("position").addEventListener("input", () => page.moveCursor({ position: page.order[Number($("position").value)] }));
  $("frequency").addEventListener("input", () => page.moveCursor({ frequency: Number($("frequency").value) }));
  const [low, high] = page.limits;
  for (const name of ["from", "to"]) {
    Object.assign($(name), { min: low, max: high, step: (high - low) / 900 });
    $(name).addEventListener("input", () => page.set(window_(page, name, Number($(name).value))));
  }
  $("resolution").addEventListener("input", () => page.set({ resolution: Number($("resolution").value) }));
  if (header.accuracy) $("damping").min = header.accuracy.least_ratio;
  $("damping").addEventListener("input", () => page.set({ damping: Number($("damping").value) }));
  buildFactors(page);
  $("reset").addEventListener("click", () => {
    const factors = Object.fromEntries(Object.keys(state.factors).map((name) => [name, 1]));
    page.set({ damping: null, factors });
  });
  buildShapeControls(page);
  showControls(page);
}

// The window's ends keep a hundredth of the range between them.
function window_(page, name, value) {
  const { from, to } = page.state;
  const least = (page.limits[1] - page.limits[0]) / 100;
  const changes = name === "from" ? { from: Math.min(value, to - least), to } : { from, to: Math.max(value, from + least) };
  changes.frequency = Math.min(Math.max(page.state.frequency, changes.from), changes.to);
  return changes;
}

function buildFactors(page) {
  const { header } = page.db;
  for (const group of header.groups) {
    const label = GROUPS[group.name];
    const [low, high] = group.range;
    const id = `factor-${group.name}`;
    const input = element("input", { id, type: "range", min: low, max: high, step: 0.01, value: 1 });
    input.setAttribute("aria-label", `${label}, times that of the run: ${group.joints.join(", ")}`);
    input.title = group.joints.join(", ");
    input.addEventListener("input", () => {
      page.set({ factors: { ...page.state.factors, [group.name]: Number(input.value) } });
    });
    $("reset").before(element("label", {}, `${label} `, element("output", { id: `${id}-value` }), input));
  }
  if (header.lossy_parts.length > 0) {
    const text = `Joints keep their stiffness here while parts damp by loss factors of their own (${header.lossy_parts.join(", ")}): what these give to a changed mode is not in this page. A damping ratio for all modes replaces them and frees the sliders.`;
    $("reset").before(element("p", { id: "reason", textContent: text }));
  }
}

function buildShapeControls(page) {
  const { db, state } = page;
  const listed = db.shape("family")[1];
  const first = Array.from({ length: listed }, (_, r) => r).find((r) => db.values("family_frequency")[r] > 0);
  state.mode = first ?? 0;
  for (let r = 0; r < listed; r++) $("mode").append(element("option", { value: String(r) }));
  $("mode").addEventListener("change", () => {
    state.mode = Number($("mode").value);
    page.showShape();
  });
  $("amplitude").addEventListener("input", () => {
    state.amplitude = Number($("amplitude").value);
    page.showShape();
  });
  $("play").addEventListener("click", () => {
    const on = $("play").getAttribute("aria-pressed") !== "true";
    $("play").setAttribute("aria-pressed", String(on));
    $("play").textContent = on ? "Stop" : "Play";
    if (page.shapes) page.shapes.play(on);
  });
  $("reference").max = page.order.length - 1;
  $("reference").addEventListener("input", () => {
    state.reference = page.order[Number($("reference").value)];
    showControls(page);
    page.showMac();
  });
  state.reference = page.order[0];
}

// Brings the controls to the state.
function showControls(page) {
  const { db, state, order } = page;
  const { header } = db;
  for (const name of ["output", "input", "quantity", "part", "colours", "mode"]) $(name).value = String(state[name]);
  $("position").value = order.indexOf(state.position);
  $("position-value").textContent = `${header.axis} = ${mm(db.positions[state.position])} mm`;
  Object.assign($("frequency"), { min: state.from, max: state.to });
  $("frequency").value = state.frequency;
  $("frequency-value").textContent = `${state.frequency.toFixed(1)} Hz`;
  for (const name of ["from", "to"]) {
    $(name).value = state[name];
    $(`${name}-value`).textContent = `${state[name].toFixed(0)} Hz`;
  }
  $("resolution").value = state.resolution;
  $("resolution-value").textContent = state.resolution;
  const ratio = state.damping ?? header.damping_ratios[0] ?? 0;
  $("damping").value = ratio;
  $("damping-value").textContent = state.damping === null ? "as run" : digits(ratio, 3);
  const held = header.lossy_parts.length > 0 && state.damping === null;
  for (const group of header.groups) {
    const factor = state.factors[group.name];
    $(`factor-${group.name}`).value = factor;
    $(`factor-${group.name}`).disabled = held;
    const diameter = group.diameter ? ` (${(1e3 * group.diameter * factor).toFixed(1)} mm)` : "";
    $(`factor-${group.name}-value`).textContent = `× ${factor.toFixed(2)}${diameter}`;
  }
  $("reference").value = order.indexOf(state.reference);
  $("reference-value").textContent = `${mm(db.positions[state.reference])} mm`;
  const listed = db.shape("family")[1];
  Array.from($("mode").options).forEach((option, r) => {
    const f = db.values("family_frequency")[state.position * listed + r];
    const family = db.values("family")[state.position * listed + r];
    option.textContent = f === 0 ? `${r + 1}: free motion` : `${r + 1}: ${f.toFixed(2)} Hz, family ${family}`;
  });
}

function buildCurves(page) {
  const nearest = (value) => {
    const distance = (p) => Math.abs(page.db.positions[p] * 1e3 - value);
    return page.order.reduce((best, p) => (distance(p) < distance(best) ? p : best));
  };
  const toPosition = (value) => page.moveCursor({ position: nearest(value) });
  if (page.surface) {
    let pressed = null;
    page.surface.canvas.addEventListener("pointerdown", (event) => (pressed = [event.clientX, event.clientY]));
    page.surface.canvas.addEventListener("pointerup", (event) => {
      if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
      const hit = page.surface.pick(event);
      if (hit) page.moveCursor({ position: page.order[hit.row], frequency: page.map.frequencies[hit.column] });
    });
  }
  return {
    frequency: new Curve($("over-frequency"), "Frequency response at the cursor's position", (f) =>
      page.moveCursor({ frequency: Math.min(Math.max(f, page.state.from), page.state.to) }),
    ),
    position: new Curve($("over-position"), "Response over position at the cursor's frequency", toPosition),
    families: new Curve($("eigenfrequencies"), "Eigenfrequencies over position by families", toPosition),
    stiffness: new Curve($("stiffness"), "Smallest dynamic stiffness over position by direction", toPosition),
  };
}

function showCurves(page) {
  const { state, engine, db, order, along, curves } = page;
  const nInputs = db.header.inputs.length;
  const power = page.power();
  const response = page.responses();
  const value = [0, 0];
  const at = (system, f) => {
    response(system, state.output, state.input, nInputs, f, power, value);
    const shown = page.shown(value[0] * 1e6, value[1] * 1e6);
    return Number.isFinite(shown) ? shown : null;
  };
  const log = state.part === "log";
  const changed = page.isChanged();
  const accent = css("--accent");
  const quiet = css("--quiet");
  const series = (now, before) => [
    ...(changed ? [{ label: "as run", values: before, colour: quiet, dash: [5, 4], width: 1.2 }] : []),
    { label: "response", values: now, colour: accent },
  ];
  const place = `${db.header.axis} = ${mm(db.positions[state.position])} mm`;
  $("frequency-title").textContent = `Frequency response at ${place}`;
  const count = 1200;
  const grid = Array.from({ length: count }, (_, k) => state.from + ((state.to - state.from) * k) / (count - 1));
  // Changed machines are drawn as far as the page reaches.
  const known = (systems, f) => systems === engine.nominal || f <= page.reach;
  const over = (systems) => grid.map((f) => (known(systems, f) ? at(systems[state.position], f) : null));
  curves.frequency.marker = state.frequency;
  const [nowF, beforeF] = [over(engine.systems), changed ? over(engine.nominal) : null];
  curves.frequency.show(grid, series(nowF, beforeF), { x: "Frequency [Hz]", y: page.label() }, log);
  $("position-title").textContent = `Response over position at ${state.frequency.toFixed(1)} Hz`;
  const along_ = (systems) => order.map((p) => (known(systems, state.frequency) ? at(systems[p], state.frequency) : null));
  curves.position.marker = db.positions[state.position] * 1e3;
  const axis = `Position ${db.header.axis} [mm]`;
  const [nowP, beforeP] = [along_(engine.systems), changed ? along_(engine.nominal) : null];
  curves.position.show(along, series(nowP, beforeP), { x: axis, y: page.label() }, log);
  for (const curve of [curves.families, curves.stiffness]) curve.setMarker(db.positions[state.position] * 1e3);
  const key = `${engine.key} ${page.map.exact} ${state.from} ${state.to} ${isDark()}`;
  if (key === page.shownKey) return;
  page.shownKey = key;
  showFamilies(page, axis, changed);
  showStiffness(page, axis, changed);
}

function showFamilies(page, axis, changed) {
  const { db, order, along, engine, curves } = page;
  const listed = db.shape("family")[1];
  const families = new Map();
  order.forEach((p, row) => {
    for (let r = 0; r < listed; r++) {
      const family = db.values("family")[p * listed + r];
      const f = db.values("family_frequency")[p * listed + r];
      if (family === 0 || f === 0) continue;
      if (!families.has(family)) families.set(family, new Array(order.length).fill(null));
      families.get(family)[row] = f;
    }
  });
  const series = Array.from(families, ([family, values]) => ({
    label: `family ${family}`,
    values,
    colour: familyColour(family),
    points: order.length < 2,
  }));
  if (changed) {
    const now = order.map((p) => page.drawnFrequencies(p));
    for (let r = 0; r < families.size; r++) {
      const values = now.map((list) => list[r] ?? null);
      const style = { colour: css("--ink"), dash: [2, 3], width: 1, points: order.length < 2 };
      series.push({ label: `rank ${r + 1} with the settings`, values, ...style });
    }
  }
  curves.families.show(along, series, { x: axis, y: "Frequency [Hz]" }, false);
}

function showStiffness(page, axis, changed) {
  const { db, order, along, engine, curves, state } = page;
  const { outputs, inputs } = db.header;
  const directions = outputs.map((name, o) => ({ name, o, i: inputs.indexOf(name) })).filter(({ i }) => i >= 0);
  page.weakest = directions.map(({ name, o, i }, k) => {
    const to = changed ? Math.min(state.to, page.reach) : state.to;
    const found = order.map((p) => largestResponse(engine.systems[p], o, i, inputs.length, state.from, to, page.responses()));
    return { name, colour: familyColour(k + 1), found, values: found.map(({ value }) => 1e-6 / value) };
  });
  const series = page.weakest.map(({ name, values, colour }) => ({
    label: name,
    values,
    colour,
    points: order.length < 2,
  }));
  curves.stiffness.show(along, series, { x: axis, y: "1/|H| [N/µm]" }, false);
  $("stiffness-key").replaceChildren(
    ...page.weakest.map(({ name, colour, values, found }) => {
      const least = values.indexOf(Math.min(...values));
      const place = `${mm(db.positions[order[least]])} mm, ${found[least].f.toFixed(1)} Hz`;
      const text = element("span", { textContent: `${name}: ${digits(values[least], 4)} N/µm at ${place}` });
      text.style.color = colour;
      return text;
    }),
  );
}
