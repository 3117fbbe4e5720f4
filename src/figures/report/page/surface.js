// The response as a surface over frequency (to the right) and position (into the depth), heights and colours from one
// number a vertex, so that a new map is one upload.
"use strict";

const BOX = { width: 1.6, height: 0.75, depth: 1.1 };

class Surface {
  constructor(host) {
    this.view = new Scene3d(host, "Response over position and frequency");
    this.uniforms = { colours: { value: scaleUniform("viridis") } };
    this.material = new THREE.ShaderMaterial({
      uniforms: this.uniforms,
      side: THREE.DoubleSide,
      defines: { COLOURS: this.uniforms.colours.value.length },
      vertexShader: `
        attribute float height;
        varying float t;
        varying vec3 place;
        void main() {
          vec3 at = vec3(position.x, height * ${BOX.height.toFixed(4)}, position.z);
          t = height;
          place = at;
          gl_Position = projectionMatrix * modelViewMatrix * vec4(at, 1.0);
        }`,
      fragmentShader: SCALE_SHADER,
    });
    this.lineMaterial = new THREE.ShaderMaterial({
      uniforms: { ink: { value: new THREE.Vector3() } },
      transparent: true,
      vertexShader: `
        attribute float height;
        void main() {
          vec3 at = vec3(position.x, height * ${BOX.height.toFixed(4)} + 0.002, position.z);
          gl_Position = projectionMatrix * modelViewMatrix * vec4(at, 1.0);
        }`,
      fragmentShader: `
        uniform vec3 ink;
        void main() {
          gl_FragColor = vec4(ink, 0.35);
        }`,
    });
    this.mesh = null;
    this.cursor = null;
    this.canvas = this.view.canvas;
    this.view.look([BOX.width / 2, BOX.height * 0.36, -BOX.depth / 2], 0.5, 0.5, 3.05);
  }

  // A grid of x (frequencies) and z (positions), both 0 to 1.
  setGrid(x, z) {
    const key = `${x.length} ${z.length} ${x[0]} ${x[1]}`;
    if (key === this.key) return;
    this.key = key;
    this.x = x;
    this.z = z;
    const [columns, rows] = [x.length, z.length];
    const places = new Float32Array(3 * columns * rows);
    for (let r = 0, at = 0; r < rows; r++) {
      for (let c = 0; c < columns; c++, at += 3) {
        places[at] = x[c] * BOX.width;
        places[at + 2] = -z[r] * BOX.depth;
      }
    }
    const indices = cellIndices(columns, this.drawnRows(rows));
    if (this.mesh) {
      this.view.scene.remove(this.mesh, this.wires);
      this.mesh.geometry.dispose();
      this.wires.geometry.dispose();
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
    this.heights = new THREE.BufferAttribute(new Float32Array(columns * rows), 1);
    geometry.setAttribute("height", this.heights);
    geometry.setIndex(new THREE.BufferAttribute(indices, 1));
    this.mesh = new THREE.Mesh(geometry, this.material);
    this.mesh.frustumCulled = false;
    const wires = new THREE.BufferGeometry();
    wires.setAttribute("position", geometry.getAttribute("position"));
    wires.setAttribute("height", this.heights);
    wires.setIndex(new THREE.BufferAttribute(wireIndices(columns, rows), 1));
    this.wires = new THREE.LineSegments(wires, this.lineMaterial);
    this.wires.frustumCulled = false;
    this.view.scene.add(this.mesh, this.wires);
  }

  // Rows that cells are drawn between: every one, or every second of many where the processor draws.
  drawnRows(rows) {
    const step = this.view.software && rows > 60 ? 2 : 1;
    const drawn = Array.from({ length: Math.ceil(rows / step) }, (_, k) => k * step);
    if (drawn[drawn.length - 1] !== rows - 1) drawn.push(rows - 1);
    return drawn;
  }

  // Heights 0 to 1, [position, frequency].
  setHeights(heights) {
    this.heights.array.set(heights);
    this.heights.needsUpdate = true;
    this.view.draw();
  }

  setColours(name) {
    const colours = scaleUniform(name);
    this.uniforms.colours.value = colours;
    this.material.defines.COLOURS = colours.length;
    this.material.needsUpdate = true;
    this.view.draw();
  }

  // Lines on the surface at a column and a row of the grid.
  setCursor(column, row) {
    if (!this.mesh) return;
    if (this.cursor) this.view.scene.remove(this.cursor);
    const [columns, rows] = [this.x.length, this.z.length];
    const heights = this.heights.array;
    const point = (c, r) => [
      this.x[c] * BOX.width,
      heights[r * columns + c] * BOX.height + 0.006,
      -this.z[r] * BOX.depth,
    ];
    const points = [];
    for (let c = 0; c + 1 < columns; c++) points.push(point(c, row), point(c + 1, row));
    for (let r = 0; r + 1 < rows; r++) points.push(point(column, r), point(column, r + 1));
    this.cursor = lineSegments(points, css("--cursor"));
    this.cursor.frustumCulled = false;
    this.view.scene.add(this.cursor);
    this.view.draw();
  }

  // The box with ticks: axes { x, z, y } of { ticks: [{ at, text }], label }.
  setAxes(axes) {
    if (this.frame) this.view.scene.remove(this.frame);
    const { width: w, height: h, depth: d } = BOX;
    const points = [];
    const labels = [];
    const edge = (a, b) => points.push(a, b);
    edge([0, 0, 0], [w, 0, 0]);
    edge([w, 0, 0], [w, 0, -d]);
    edge([0, 0, 0], [0, 0, -d]);
    edge([0, 0, -d], [w, 0, -d]);
    edge([0, 0, 0], [0, h, 0]);
    edge([0, 0, -d], [0, h, -d]);
    edge([w, 0, -d], [w, h, -d]);
    edge([0, h, 0], [0, h, -d]);
    edge([0, h, -d], [w, h, -d]);
    for (const { at, text } of axes.x.ticks) {
      edge([at * w, 0, 0], [at * w, 0, 0.03]);
      edge([at * w, 0, -d], [at * w, h, -d]);
      labels.push({ text, at: [at * w, 0, 0.08] });
    }
    for (const { at, text } of axes.z.ticks) {
      edge([w, 0, -at * d], [w + 0.03, 0, -at * d]);
      edge([0, 0, -at * d], [0, h, -at * d]);
      labels.push({ text, at: [w + 0.09, 0, -at * d] });
    }
    for (const { at, text } of axes.y.ticks) {
      edge([0, at * h, 0], [-0.03, at * h, 0]);
      edge([0, at * h, -d], [w, at * h, -d]);
      edge([0, at * h, 0], [0, at * h, -d]);
      labels.push({ text, at: [-0.09, at * h, 0] });
    }
    labels.push({ text: axes.x.label, at: [w / 2, 0, 0.24], kind: "axis" });
    labels.push({ text: axes.z.label, at: [w + 0.3, 0, -d / 2], kind: "axis" });
    labels.push({ text: axes.y.label, at: [0, h + 0.09, 0], kind: "axis" });
    this.frame = lineSegments(points, css("--grid"));
    const ink = new THREE.Color(css("--ink"));
    this.lineMaterial.uniforms.ink.value.set(ink.r, ink.g, ink.b);
    this.view.scene.add(this.frame);
    this.view.setLabels(labels);
    this.view.draw();
  }

  // Column and row of the surface under a pointer, if there is one.
  pick(event) {
    if (!this.mesh) return null;
    const bounds = this.canvas.getBoundingClientRect();
    const pointer = new THREE.Vector2(
      ((event.clientX - bounds.left) / bounds.width) * 2 - 1,
      1 - ((event.clientY - bounds.top) / bounds.height) * 2,
    );
    const caster = new THREE.Raycaster();
    caster.setFromCamera(pointer, this.view.camera);
    const { origin, direction } = caster.ray;
    const nearest = (list, value) =>
      list.reduce((best, v, k) => (Math.abs(v - value) < Math.abs(list[best] - value) ? k : best), 0);
    // Along the ray until it is below the surface.
    for (let step = 0; step < 1500; step++) {
      const t = 1 + step * 0.005;
      const [x, y, z] = [origin.x + t * direction.x, origin.y + t * direction.y, origin.z + t * direction.z];
      const [u, v] = [x / BOX.width, -z / BOX.depth];
      if (u < 0 || u > 1 || v < 0 || v > 1) continue;
      const [column, row] = [nearest(this.x, u), nearest(this.z, v)];
      if (y <= this.heights.array[row * this.x.length + column] * BOX.height) return { column, row };
    }
    return null;
  }
}

// Two triangles a cell between neighbouring rows of a list.
function cellIndices(columns, rows) {
  const indices = new Uint32Array(6 * (columns - 1) * (rows.length - 1));
  let at = 0;
  for (let r = 0; r + 1 < rows.length; r++) {
    for (let c = 0; c + 1 < columns; c++) {
      const [a, b] = [rows[r] * columns + c, rows[r + 1] * columns + c];
      indices[at++] = a;
      indices[at++] = a + 1;
      indices[at++] = b;
      indices[at++] = a + 1;
      indices[at++] = b + 1;
      indices[at++] = b;
    }
  }
  return indices;
}

// Some lines of constant position.
function wireIndices(columns, rows) {
  const indices = [];
  const marked = (count, lines) => {
    const wanted = Math.min(count, lines);
    return Array.from({ length: wanted }, (_, k) => Math.round((k * (count - 1)) / Math.max(1, wanted - 1)));
  };
  for (const r of marked(rows, 13)) {
    for (let c = 0; c + 1 < columns; c++) indices.push(r * columns + c, r * columns + c + 1);
  }
  return new Uint32Array(indices);
}
