// What computes: systems of the machine as run or changed, by workers; maps by WebGPU, else in JavaScript.
"use strict";

class Engine {
  constructor(db, workerSource) {
    this.db = db;
    this.gpu = null;
    this.why = "";
    this.nominal = Array.from(db.positions, (_, p) => nominalSystem(db, p));
    this.systems = this.nominal;
    this.key = "";
    this.jobs = 0;
    this.workerSource = workerSource;
    this.workers = null;
  }

  // Opens the device; `off` keeps to JavaScript.
  async open(shader, off) {
    if (off) {
      this.why = "WebGPU was switched off for this page";
      return;
    }
    const { gpu, why } = await Gpu.open(shader);
    this.gpu = gpu || null;
    this.why = why || "";
  }

  // Which of both computes maps, in words.
  engineName() {
    if (this.gpu && !this.gpu.lost) return `WebGPU (${this.gpu.name})`;
    return `JavaScript, since ${this.gpu ? this.gpu.lost : this.why}`;
  }

  // Workers, started before they are first needed; none where the browser refuses them.
  startWorkers() {
    if (this.workers) return;
    this.workers = [];
    const wanted = Math.min(4, Math.max(1, navigator.hardwareConcurrency || 2), this.db.positions.length);
    try {
      const url = URL.createObjectURL(new Blob([this.workerSource], { type: "text/javascript" }));
      for (let w = 0; w < wanted; w++) {
        const worker = new Worker(url);
        worker.postMessage({ open: this.db.buffer });
        this.workers.push(worker);
      }
    } catch (error) {
      this.workers = [];
    }
  }

  // Factor of each spring.
  factors(settings) {
    const factors = new Float64Array(this.db.header.springs.length).fill(1);
    for (const group of this.db.header.groups) {
      const given = settings.factors[group.name] ?? 1;
      for (const k of group.springs) factors[k] = group.name === "screws" ? given * given : given;
    }
    return factors;
  }

  // Makes `systems` those of the settings { factors: { group: factor }, damping: ratio or null }.
  async solve(settings) {
    const factors = this.factors(settings);
    const changed = factors.some((factor) => factor !== 1);
    const key = changed || settings.damping !== null ? JSON.stringify([Array.from(factors), settings.damping]) : "";
    if (key === this.key) return;
    let systems = this.nominal;
    if (key !== "") systems = await this.solveAll(factors, settings.damping, changed);
    this.systems = systems;
    this.key = key;
  }

  async solveAll(factors, damping, changed) {
    const all = Array.from(this.db.positions.keys());
    if (changed) this.startWorkers();
    // Damping alone needs no eigenproblem: quicker here than there and back.
    if (!changed || this.workers.length === 0) return solvePositions(this.db, all, factors, damping);
    const job = ++this.jobs;
    const systems = new Array(all.length);
    const shares = this.workers.map((worker, w) => {
      const positions = all.filter((p) => p % this.workers.length === w);
      return new Promise((resolve, reject) => {
        worker.onerror = (event) => reject(new Error(event.message));
        worker.onmessage = ({ data }) => {
          if (data.job !== job) return;
          if (data.error) reject(new Error(data.error));
          else data.positions.forEach((p, k) => (systems[p] = data.systems[k]));
          resolve();
        };
        worker.postMessage({ job, positions, factors, damping });
      });
    });
    await Promise.all(shares);
    return systems;
  }

  // A map of one pair at any frequencies (Hz, ascending), um/N times the powers of 1/s.
  async map(o, i, frequencies, power) {
    const nInputs = this.db.header.inputs.length;
    if (this.gpu && !this.gpu.lost) {
      try {
        return await this.gpu.map(this.systems, o, i, nInputs, frequencies, power);
      } catch (error) {
        this.gpu.lost = String(error.message || error);
      }
    }
    return sumMap(this.systems, o, i, nInputs, frequencies, power);
  }
}
