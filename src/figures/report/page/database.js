// The modal database: a header and named arrays (docs/report.md). Read by the page and by its workers.
"use strict";

const ARRAY_TYPES = { f64: Float64Array, f32: Float32Array, u32: Uint32Array, i16: Int16Array };

function openDatabase(buffer) {
  const bytes = new Uint8Array(buffer);
  const length = Number(new DataView(buffer).getBigUint64(16, true));
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(24, 24 + length)));
  const start = Math.ceil((24 + length) / 8) * 8;
  const arrays = new Map();
  for (const entry of header.arrays) {
    const count = entry.shape.reduce((product, extent) => product * extent, 1);
    arrays.set(entry.name, {
      shape: entry.shape,
      values: new ARRAY_TYPES[entry.kind](buffer, start + entry.offset, count),
    });
  }
  const values = (name) => (arrays.has(name) ? arrays.get(name).values : null);
  const shape = (name) => arrays.get(name).shape;
  return { buffer, header, values, shape, positions: values("position"), frequencies: values("frequency") };
}

function fromBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text).buffer;
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes.buffer;
}
