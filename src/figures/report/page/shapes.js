// Mode shapes: the parts' thinned surfaces, deforming at a mode and a position, coloured by displacement.
"use strict";

class Shapes {
  constructor(host, db) {
    this.db = db;
    this.view = new Scene3d(host, "Mode shape");
    const nodes = db.values("skin_node");
    this.nodes = nodes;
    this.rank = db.shape("shape_coefficient")[2];
    this.listed = db.shape("shape_coefficient")[1];
    this.uniforms = {
      colours: { value: scaleUniform("viridis") },
      swing: { value: 1 },
      amplitude: { value: 0 },
    };
    const material = new THREE.ShaderMaterial({
      uniforms: this.uniforms,
      side: THREE.DoubleSide,
      defines: { COLOURS: this.uniforms.colours.value.length },
      vertexShader: `
        attribute vec3 shift;
        uniform float swing;
        uniform float amplitude;
        varying float t;
        varying vec3 place;
        void main() {
          vec3 at = position + swing * amplitude * shift;
          t = length(shift);
          place = at;
          gl_Position = projectionMatrix * modelViewMatrix * vec4(at, 1.0);
        }`,
      fragmentShader: SCALE_SHADER,
    });
    const geometry = new THREE.BufferGeometry();
    this.places = new THREE.BufferAttribute(new Float32Array(nodes.length), 3);
    this.shifts = new THREE.BufferAttribute(new Float32Array(nodes.length), 3);
    geometry.setAttribute("position", this.places);
    geometry.setAttribute("shift", this.shifts);
    geometry.setIndex(new THREE.BufferAttribute(db.values("skin_triangle"), 1));
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    this.material = material;
    this.view.scene.add(mesh);
    this.frame();
    this.playing = false;
  }

  // Height upwards: the machine's z stands where the picture's y is.
  upright(target, at, x, y, z) {
    target[at] = x;
    target[at + 1] = z;
    target[at + 2] = -y;
  }

  frame() {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (let k = 0; k < this.nodes.length; k++) {
      low[k % 3] = Math.min(low[k % 3], this.nodes[k]);
      high[k % 3] = Math.max(high[k % 3], this.nodes[k]);
    }
    this.size = Math.hypot(...high.map((v, c) => v - low[c])) || 1;
    const centre = high.map((v, c) => 0.5 * (v + low[c]));
    this.view.camera.near = this.size * 0.01;
    this.view.camera.far = this.size * 20;
    this.view.look([centre[0], centre[2], -centre[1]], 0.6, 0.25, 2.0 * this.size);
  }

  // Shows a mode (place in the list) at a position; amplitude is a share of the machine's size.
  show(p, mode, amplitude) {
    const { db, rank } = this;
    const scales = db.values("shape_scale");
    const surface = db.values("shape_surface");
    const coefficients = db.values("shape_coefficient").subarray((p * this.listed + mode) * rank);
    const count = this.nodes.length;
    const shape = new Float32Array(count);
    for (let k = 0; k < rank; k++) {
      const factor = (coefficients[k] / 32767) * scales[k];
      const column = surface.subarray(k * count, (k + 1) * count);
      for (let i = 0; i < count; i++) shape[i] += factor * column[i];
    }
    let largest = 0;
    let along = 0;
    const shifts = this.shifts.array;
    for (let i = 0; i < count; i += 3) largest = Math.max(largest, Math.hypot(shape[i], shape[i + 1], shape[i + 2]));
    const scale = largest > 0 ? 1 / largest : 0;
    const before = shifts.slice();
    for (let i = 0; i < count; i += 3) {
      this.upright(shifts, i, shape[i] * scale, shape[i + 1] * scale, shape[i + 2] * scale);
    }
    // A shape's sign is free: the one that goes on from what was shown.
    for (let i = 0; i < count; i++) along += before[i] * shifts[i];
    if (along < 0) for (let i = 0; i < count; i++) shifts[i] = -shifts[i];
    const direction = db.header.direction.map((c) => c * db.positions[p]);
    for (const part of db.header.parts) {
      const moved = part.moves ? direction : [0, 0, 0];
      for (let node = part.first_node; node < part.first_node + part.nodes; node++) {
        const at = 3 * node;
        const [x, y, z] = [0, 1, 2].map((c) => this.nodes[at + c] + moved[c]);
        this.upright(this.places.array, at, x, y, z);
      }
    }
    this.places.needsUpdate = true;
    this.shifts.needsUpdate = true;
    this.uniforms.amplitude.value = amplitude * this.size;
    this.largest = largest;
    this.view.draw();
  }

  setColours(name) {
    const colours = scaleUniform(name);
    this.uniforms.colours.value = colours;
    this.material.defines.COLOURS = colours.length;
    this.material.needsUpdate = true;
    this.view.draw();
  }

  play(on) {
    this.playing = on;
    const start = performance.now();
    const step = (now) => {
      if (!this.playing) {
        this.uniforms.swing.value = 1;
        this.view.draw();
        return;
      }
      this.uniforms.swing.value = Math.cos(((now - start) / 1000) * Math.PI);
      this.view.render();
      requestAnimationFrame(step);
    };
    if (on) requestAnimationFrame(step);
  }

  // MAC of two listed modes: the mass matrix is the identity in the space of the shapes.
  mac(p, a, q, b) {
    const { rank, listed } = this;
    return macOf(this.db, rank, listed, p, a, q, b);
  }
}

function macOf(db, rank, listed, p, a, q, b) {
  const all = db.values("shape_coefficient");
  const [from, to] = [(p * listed + a) * rank, (q * listed + b) * rank];
  let [aa, bb, ab] = [0, 0, 0];
  for (let k = 0; k < rank; k++) {
    aa += all[from + k] * all[from + k];
    bb += all[to + k] * all[to + k];
    ab += all[from + k] * all[to + k];
  }
  return aa > 0 && bb > 0 ? (ab * ab) / (aa * bb) : 0;
}
