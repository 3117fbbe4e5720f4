// The modal database: a hash (for programs that read the file), a header and named arrays (docs/report.md). Read by the page and by its workers.
"use strict";

const ARRAY_TYPES = { f64: Float64Array, f32: Float32Array, u32: Uint32Array, i16: Int16Array };

function openDatabase(buffer) {
  const bytes = new Uint8Array(buffer);
  const length = Number(new DataView(buffer).getBigUint64(48, true));
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(56, 56 + length)));
  const start = Math.ceil((56 + length) / 8) * 8;
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

// FNV-1a over the bytes: each step is a bijection, so one changed byte always changes the sum.
function checksum(buffer) {
  let sum = 0x811c9dc5;
  for (const byte of new Uint8Array(buffer)) sum = Math.imul(sum ^ byte, 0x01000193);
  return (sum >>> 0).toString(16).padStart(8, "0");
}

function fromBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text).buffer;
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes.buffer;
}
