// The map by WebGPU, with the text of shaders/modal_sum.wgsl: one pair in a duo, f32 with frequencies as hi + lo.
"use strict";

// Of the shader's text: invocations a workgroup times the frequencies of each.
const GPU_CHUNK = 256;

class Gpu {
  // The device, or why there is none.
  static async open(source) {
    if (!navigator.gpu) return { why: "this browser has no WebGPU here" };
    try {
      const adapter = await navigator.gpu.requestAdapter();
      if (!adapter) return { why: "WebGPU finds no adapter" };
      const device = await adapter.requestDevice();
      device.pushErrorScope("validation");
      const module = device.createShaderModule({ code: source, label: "modal_sum" });
      const pipeline = await device.createComputePipelineAsync({
        layout: "auto",
        label: "modal_sum",
        compute: { module, entryPoint: "main" },
      });
      const error = await device.popErrorScope();
      if (error) return { why: `the shader was refused: ${error.message}` };
      const info = adapter.info || {};
      const name = [info.vendor, info.architecture, info.description].filter(Boolean).join(" ") || "unnamed adapter";
      return { gpu: new Gpu(device, pipeline, name) };
    } catch (error) {
      return { why: String(error.message || error) };
    }
  }

  constructor(device, pipeline, name) {
    this.device = device;
    this.pipeline = pipeline;
    this.name = name;
    this.buffers = new Map();
    this.lost = null;
    device.lost.then((info) => {
      this.lost = info.message || "the device was lost";
    });
  }

  // A buffer of at least some bytes, kept from map to map.
  buffer(name, bytes, usage) {
    const kept = this.buffers.get(name);
    if (kept && kept.size >= bytes) return kept;
    if (kept) kept.destroy();
    const made = this.device.createBuffer({ label: name, size: Math.max(64, Math.ceil(bytes / 4) * 4), usage });
    this.buffers.set(name, made);
    return made;
  }

  upload(name, words, usage) {
    const buffer = this.buffer(name, words.byteLength, usage | GPUBufferUsage.COPY_DST);
    this.device.queue.writeBuffer(buffer, 0, words);
    return buffer;
  }

  // A map of one pair, um/N times the powers of 1/s: [position, frequency, re | im].
  async map(systems, o, i, nInputs, frequencies, power) {
    const packed = pack(systems, o, i, nInputs, frequencies, power);
    const bytes = systems.length * frequencies.length * 8;
    const storage = GPUBufferUsage.STORAGE;
    const inputs = [
      this.upload("parameters", packed.params, GPUBufferUsage.UNIFORM),
      this.upload("frequencies", packed.frequencies, storage),
      this.upload("modes", packed.modes, storage),
      this.upload("residual", packed.residual, storage),
    ];
    const output = this.buffer("values", bytes, storage | GPUBufferUsage.COPY_SRC);
    const staging = this.buffer("read back", bytes, GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST);
    const bind = (group, buffers) =>
      this.device.createBindGroup({
        layout: this.pipeline.getBindGroupLayout(group),
        entries: buffers.map((buffer, binding) => ({ binding, resource: { buffer } })),
      });
    const encoder = this.device.createCommandEncoder();
    const pass = encoder.beginComputePass();
    pass.setPipeline(this.pipeline);
    pass.setBindGroup(0, bind(0, inputs));
    pass.setBindGroup(1, bind(1, [output]));
    pass.dispatchWorkgroups(Math.ceil(frequencies.length / GPU_CHUNK), systems.length, 1);
    pass.end();
    encoder.copyBufferToBuffer(output, 0, staging, 0, bytes);
    this.device.queue.submit([encoder.finish()]);
    await staging.mapAsync(GPUMapMode.READ, 0, bytes);
    const values = new Float32Array(staging.getMappedRange(0, bytes).slice(0));
    staging.unmap();
    if (frequencies[0] === 0 && power === 2) {
      systems.forEach((system, p) => {
        values[2 * p * frequencies.length] = acceleranceAtRest(system, o, i) * 1e6;
        values[2 * p * frequencies.length + 1] = 0;
      });
    }
    return values;
  }
}

// The request as the shader reads it: frequencies divided by a power of two, responses in um/N.
function pack(systems, o, i, nInputs, frequencies, power) {
  const highest = frequencies[frequencies.length - 1];
  const scale = highest > 0 ? 2 ** Math.ceil(Math.log2(highest)) : 1;
  const unit = (TAU * scale) ** power * 1e6;
  const nModes = systems.reduce((most, system) => Math.max(most, system.n), 0);
  const nDegrees = systems.reduce((most, system) => Math.max(most, system.degrees), 0);
  const params = new Uint32Array([frequencies.length, systems.length, nModes, nDegrees, 1, 1, power, 0]);
  const grid = new Float32Array(2 * frequencies.length);
  frequencies.forEach((f, k) => split(grid, 2 * k, f / scale));
  const modes = new Float32Array(6 * nModes * systems.length);
  const residual = new Float32Array(4 * nDegrees * systems.length);
  systems.forEach((system, p) => {
    const { n, frequency, viscous, loss, outputs, inputs } = system;
    for (let r = 0; r < nModes; r++) {
      const at = 6 * (p * nModes + r);
      if (r >= n) {
        // A mode that is not there: no residue, and a denominator that is never 0.
        modes[at + 3] = 1;
        continue;
      }
      split(modes, at, frequency[r] / scale);
      modes[at + 2] = viscous[r] / scale;
      modes[at + 3] = loss[r] / (scale * scale);
      modes[at + 4] = (outputs[o * n + r] * inputs[i * n + r] * unit) / (TAU * TAU * scale * scale);
    }
    let [pr, pi] = [unit, 0];
    for (let k = 0; k < system.degrees; k++) {
      const from = k * (system.residual.length / system.degrees) + 2 * (o * nInputs + i);
      const [cr, ci] = [system.residual[from], system.residual[from + 1]];
      const at = 4 * (p * nDegrees + k);
      residual[at] = cr * pr - ci * pi;
      residual[at + 2] = cr * pi + ci * pr;
      [pr, pi] = [-pi * TAU * scale, pr * TAU * scale];
    }
  });
  return { params, frequencies: grid, modes, residual };
}

// A number as hi + lo.
function split(array, at, value) {
  array[at] = value;
  array[at + 1] = value - array[at];
}
