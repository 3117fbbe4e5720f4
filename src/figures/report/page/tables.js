// Tables: families, modes at the cursor, MAC between two positions, what was run.
"use strict";

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

function table(caption, head, rows) {
  const cell = (tag, text) => element(tag, { textContent: text, scope: tag === "th" ? "col" : "" });
  return element(
    "table",
    {},
    element("caption", { textContent: caption }),
    element("thead", {}, element("tr", {}, ...head.map((text) => cell("th", text)))),
    element("tbody", {}, ...rows.map((row) => element("tr", {}, ...row.map((text) => cell("td", text))))),
  );
}

function familyTable(header) {
  const rows = header.table
    .filter((row) => row.max_hz > 0)
    .map((row) => [
      row.family,
      row.min_hz.toFixed(2),
      row.max_hz.toFixed(2),
      row.difference_percent.toFixed(1),
      mm(row.position_of_min_m),
      mm(row.position_of_max_m),
      row.interior_extremum ? "yes" : "no",
      row.reduction_error === null || row.reduction_error === undefined ? "–" : row.reduction_error.toExponential(1),
    ]);
  const axis = header.axis;
  const head = ["family", "min [Hz]", "max [Hz]", "difference [%]", `min at ${axis} [mm]`, `max at ${axis} [mm]`];
  return table("Families over the travel, as run", [...head, "extremum inside", "reduction error"], rows);
}

function mm(metres) {
  return digits(1e3 * metres, 6);
}

// Modes at a position: as run, and what the settings make of them by rank; `now` are the settings' elastic frequencies
// as far as the page reaches, or null.
function modeTable(db, p, now) {
  const listed = db.shape("family")[1];
  const at = (name, r) => db.values(name)[p * listed + r];
  const within = db.header.accuracy ? db.header.accuracy.frequency : [];
  const rows = [];
  let elastic = 0;
  for (let r = 0; r < listed; r++) {
    const family = at("family", r);
    if (family === 0) continue;
    const f = at("family_frequency", r);
    const free = f === 0;
    const own = free ? "–" : digits(100 * at("family_ratio", r), 4);
    const row = [r + 1, family, free ? "0 (free)" : f.toFixed(3), own];
    if (now && free) row.push("–", "–");
    else if (now && elastic < now.length) row.push(now[elastic].toFixed(3), within[elastic]?.toExponential(1) ?? "not measured");
    else if (now) row.push("– (beyond the page's reach)", "–");
    if (!free) elastic++;
    rows.push(row);
  }
  const head = ["rank", "family", "as run [Hz]", "damping [%]"];
  if (now) head.push("with the settings [Hz]", "off by at most");
  return table(`Modes at ${db.header.axis} = ${mm(db.positions[p])} mm`, head, rows);
}

// MAC between the modes at two positions, on a canvas: rows the first, columns the second.
function drawMac(canvas, db, p, q, scale) {
  const [listed, rank] = [db.shape("shape_coefficient")[1], db.shape("shape_coefficient")[2]];
  const [left, below, key] = [48, 44, 62];
  const side = Math.max(4, Math.floor((Math.min(canvas.parentElement.clientWidth, 530) - left - key) / listed));
  const whole = side * listed;
  // Twice the pixels, for print.
  [canvas.width, canvas.height] = [2 * (left + whole + key), 2 * (whole + below)];
  [canvas.style.width, canvas.style.height] = [`${left + whole + key}px`, `${whole + below}px`];
  const context = canvas.getContext("2d");
  context.scale(2, 2);
  const colours = scaleColours(scale);
  const values = [];
  for (let a = 0; a < listed; a++) {
    for (let b = 0; b < listed; b++) {
      const mac = macOf(db, rank, listed, p, a, q, b);
      values.push(mac);
      context.fillStyle = `rgb(${colourAt(colours, mac).join(",")})`;
      context.fillRect(left + b * side, (listed - 1 - a) * side, side, side);
    }
  }
  // Ranks along both sides, and what the colours mean.
  for (let y = 0; y < whole; y++) {
    context.fillStyle = `rgb(${colourAt(colours, 1 - y / (whole - 1)).join(",")})`;
    context.fillRect(left + whole + 16, y, 14, 1);
  }
  context.fillStyle = css("--ink");
  context.font = "12px system-ui, sans-serif";
  const write = (text, x, y, align) => {
    context.textAlign = align;
    context.textBaseline = "middle";
    context.fillText(text, x, y);
  };
  for (let rank = 1; rank <= listed; rank = rank === 1 ? 5 : rank + 5) {
    const centre = (rank - 0.5) * side;
    write(String(rank), left - 6, whole - centre, "right");
    write(String(rank), left + centre, whole + 12, "center");
  }
  for (const value of [0, 0.5, 1]) write(String(value), left + whole + 36, 7 + (1 - value) * (whole - 14), "left");
  write(`rank at ${mm(db.positions[q])} mm`, left + whole / 2, whole + 32, "center");
  context.translate(10, whole / 2);
  context.rotate(-Math.PI / 2);
  write(`rank at ${mm(db.positions[p])} mm`, 0, 0, "center");
  const best = [];
  for (let a = 0; a < listed; a++) best.push(Math.max(...values.slice(a * listed, (a + 1) * listed)));
  const weakest = best.indexOf(Math.min(...best));
  canvas.setAttribute("aria-label", `MAC matrix; weakest best match ${best[weakest].toFixed(2)} for rank ${weakest + 1}`);
  return { values, listed };
}

// How far and how accurately the page follows its sliders.
function reachText(header) {
  const { accuracy } = header;
  if (!accuracy) return "How far changed machines hold was not measured: an earlier version wrote this page's data.";
  const off = accuracy.frequency.reduce((most, error) => Math.max(most, error), 0);
  const share = (value) => value.toExponential(1);
  const own = accuracy.response === null ? "" : `${share(accuracy.response)} of the norm with the run's damping, `;
  return (
    `Changed machines: frequencies up to ${accuracy.reach_hz.toFixed(0)} Hz within ${share(off)}, responses within ` +
    `${own}${share(accuracy.response_least)} of it at a damping ratio of ${accuracy.least_ratio}, measured against the ` +
    `whole model at ${accuracy.settings} settings over the range of the sliders. Frequencies beyond are not shown.`
  );
}

function remarks(db, manifest) {
  const { header } = db;
  const lines = [];
  const { settings = {} } = manifest;
  if (settings.exactly_n_modes) {
    const left = settings.truncation_error.toExponential(1);
    lines.push(`The map as run sums exactly the modes that were asked for, which leaves out ${left} of the norm; changed machines are summed over all modes.`);
  }
  if (db.positions.length < header.positions_of_run) {
    lines.push(`This page holds ${db.positions.length} of the run's ${header.positions_of_run} positions.`);
  }
  lines.push(...header.free_motions.map((text) => `Free motion at 0 Hz: ${text}.`));
  for (const v of header.veerings) {
    const place = `${mm(v.from_m)} and ${mm(v.to_m)} mm`;
    lines.push(`Families ${v.families.join(" and ")} veer between ${place} (MAC ${v.mac.toFixed(2)}): both labellings are conventions there.`);
  }
  return lines.map((textContent) => element("p", { className: "hint", textContent }));
}

// What was run, from the manifest.
function runFacts(manifest) {
  const rows = [];
  const add = (name, value) => {
    if (value !== undefined && value !== null && value !== "") rows.push([name, value]);
  };
  add("machine file", manifest.machine_file);
  add("stiffmap", manifest.version);
  const { counts = {}, settings = {}, backend = {} } = manifest;
  for (const key of ["nodes", "elements", "unknowns", "fixed_basis_coordinates", "positions", "frequencies"]) {
    add(key.replaceAll("_", " "), counts[key]);
  }
  add("modes in the map a position", `${counts.modes_in_map_fewest} to ${counts.modes_in_map_most}`);
  add("damping ratios", (settings.damping_ratios || []).join(", "));
  add("map computed by", [backend.backend, backend.adapter && backend.adapter.name, backend.precision].filter(Boolean).join(", "));
  const seconds = Object.values(manifest.seconds || {}).reduce((sum, s) => sum + s, 0);
  add("seconds", seconds.toFixed(2));
  const checks = (manifest.checks || []).map((check) => [
    check.passed ? "passed" : "FAILED",
    check.name,
    check.figure.toExponential(1),
    check.bound.toExponential(1),
  ]);
  const hashes = Object.entries(manifest.input_hashes || {}).map(([file, hash]) => [file, hash.slice(0, 16)]);
  const parts = [
    table("Run", ["", ""], rows),
    table("Accuracy", ["", "check", "figure", "bound"], checks),
    table("Inputs", ["file", "BLAKE3 (first 16 digits)"], hashes),
  ];
  const warnings = manifest.warnings || [];
  if (warnings.length > 0) parts.push(element("ul", {}, ...warnings.map((w) => element("li", { textContent: w }))));
  return parts;
}
