// What computes: systems of the machine as run or changed, by workers; maps by WebGPU, else in JavaScript.
"use strict";

// A slider that moves waits no longer than these take.
const POSITIONS_AT_A_TIME = 3;

class Engine {
  constructor(db, workerSource) {
    this.db = db;
    this.gpu = null;
    this.why = "";
    this.nominal = Array.from(db.positions, (_, p) => nominalSystem(db, p));
    this.systems = this.nominal;
    this.key = "";
    this.settings = { factors: null, damping: null };
    this.jobs = 0;
    this.waiting = new Map();
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

  // Whether damping couples the modes of what is shown: its maps are then exact in JavaScript alone.
  isCoupled() {
    return this.systems.some((system) => system.exact);
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
        worker.onmessage = ({ data }) => this.settleJob(data);
        worker.onerror = (event) => this.failJobs(event.message);
        worker.postMessage({ open: this.db.buffer });
        this.workers.push(worker);
      }
    } catch (error) {
      this.workers = [];
    }
  }

  settleJob({ job, result, error }) {
    const { resolve, reject } = this.waiting.get(job);
    this.waiting.delete(job);
    if (error) reject(new Error(error));
    else resolve(result);
  }

  // A worker that failed leaves no job with an answer to come.
  failJobs(message) {
    for (const { reject } of this.waiting.values()) reject(new Error(message));
    this.waiting.clear();
  }

  ask(worker, message) {
    return new Promise((resolve, reject) => {
      const job = ++this.jobs;
      this.waiting.set(job, { resolve, reject });
      worker.postMessage({ job, ...message });
    });
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
    this.settings = { factors, damping: settings.damping };
  }

  async solveAll(factors, damping, changed) {
    const all = Array.from(this.db.positions.keys());
    if (changed) this.startWorkers();
    // Damping alone needs no eigenproblem: quicker here than there and back.
    if (!changed || this.workers.length === 0) return solvePositions(this.db, all, factors, damping);
    const systems = new Array(all.length);
    const shares = this.workers.map(async (worker, w) => {
      const positions = all.filter((p) => p % this.workers.length === w);
      const solved = await this.ask(worker, { positions, factors, damping });
      positions.forEach((p, k) => (systems[p] = solved[k]));
    });
    await Promise.all(shares);
    return systems;
  }

  // A map of one pair at any frequencies (Hz, ascending), um/N times the powers of 1/s, with damping that couples the
  // modes projected on them.
  async map(o, i, frequencies, power) {
    const nInputs = this.db.header.inputs.length;
    if (this.gpu && !this.gpu.lost) {
      try {
        return await this.gpu.map(this.systems, o, i, nInputs, frequencies, power);
      } catch (error) {
        this.gpu.lost = String(error.message || error);
      }
    }
    return sumMap(this.systems, o, i, nInputs, frequencies, power, projectedAt);
  }

  // The same with that damping exact, some positions at a time; null once `isWanted` says no.
  async exactMap(o, i, frequencies, power, isWanted) {
    this.startWorkers();
    const n = 2 * frequencies.length;
    const values = new Float64Array(this.systems.length * n);
    const sum = { o, i, frequencies, power, key: this.key, ...this.settings };
    const { systems } = this;
    let next = 0;
    const share = async (compute) => {
      while (next < systems.length && isWanted()) {
        const positions = Array.from({ length: Math.min(POSITIONS_AT_A_TIME, systems.length - next) }, (_, k) => next + k);
        next += positions.length;
        values.set(await compute(positions), positions[0] * n);
      }
    };
    const here = async (positions) => {
      await new Promise((resolve) => setTimeout(resolve, 0));
      const some = positions.map((p) => systems[p]);
      return sumMap(some, o, i, this.db.header.inputs.length, frequencies, power, responseAt);
    };
    const shares = this.workers.map((worker) => share((positions) => this.ask(worker, { positions, sum })));
    await Promise.all(shares.length > 0 ? shares : [share(here)]);
    return isWanted() ? values : null;
  }
}
