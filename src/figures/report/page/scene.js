// A picture in space by three.js: camera, turning and zooming by pointer and by keys, labels as text over the canvas.
"use strict";

class Scene3d {
  // Draws into a host element; throws where the browser has no WebGL.
  constructor(host, name) {
    this.host = host;
    // Smooth edges cost a software renderer more than the picture itself.
    this.software = softwareRenderer();
    const antialias = !this.software;
    this.renderer = new THREE.WebGLRenderer({ antialias, alpha: true, preserveDrawingBuffer: true });
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", name);
    this.overlay = document.createElement("div");
    this.overlay.className = "labels";
    this.overlay.setAttribute("aria-hidden", "true");
    host.append(this.canvas, this.overlay);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.addEventListener("change", () => this.draw());
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    this.labels = [];
    this.waiting = false;
    new ResizeObserver(() => this.resize()).observe(host);
  }

  // Looks at a point from an angle round the vertical and above the horizon, rad, at a distance.
  look(target, turn, rise, distance) {
    this.home = { target, turn, rise, distance };
    const flat = Math.cos(rise) * distance;
    const offset = [flat * Math.sin(turn), distance * Math.sin(rise), flat * Math.cos(turn)];
    this.camera.position.set(target[0] + offset[0], target[1] + offset[1], target[2] + offset[2]);
    this.controls.target.set(...target);
    this.controls.update();
    this.draw();
  }

  key(event) {
    const { target } = this.controls;
    const offset = this.camera.position.clone().sub(target);
    const distance = offset.length();
    const turn = Math.atan2(offset.x, offset.z);
    const rise = Math.asin(offset.y / distance);
    const steps = {
      ArrowLeft: [-0.1, 0, 1],
      ArrowRight: [0.1, 0, 1],
      ArrowUp: [0, 0.08, 1],
      ArrowDown: [0, -0.08, 1],
      "+": [0, 0, 0.9],
      "-": [0, 0, 1 / 0.9],
    };
    if (event.key === "Home") {
      const { home } = this;
      this.look(home.target, home.turn, home.rise, home.distance);
    } else if (steps[event.key]) {
      const [dTurn, dRise, zoom] = steps[event.key];
      const up = Math.min(1.5, Math.max(-1.5, rise + dRise));
      const home = this.home;
      this.look([target.x, target.y, target.z], turn + dTurn, up, distance * zoom);
      this.home = home;
    } else {
      return;
    }
    event.preventDefault();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  // Draws at the next frame, once however often it is asked.
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.render();
    });
  }

  render() {
    this.renderer.render(this.scene, this.camera);
    this.placeLabels();
  }

  // Waits until what was drawn is on the canvas.
  finish() {
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  // Texts at points in space: [{ text, at: [x, y, z], kind }].
  setLabels(labels) {
    this.overlay.replaceChildren();
    this.labels = labels.map((label) => {
      const element = document.createElement("span");
      element.textContent = label.text;
      element.className = label.kind || "tick";
      this.overlay.append(element);
      return { ...label, element, half: element.offsetWidth / 2, point: new THREE.Vector3() };
    });
  }

  placeLabels() {
    const { clientWidth: width, clientHeight: height } = this.host;
    for (const label of this.labels) {
      const at = label.point.set(...label.at).project(this.camera);
      // What an axis is called stays in the picture.
      const inside = (x) => Math.min(Math.max(x, label.half), Math.max(label.half, width - label.half));
      const x = label.kind === "axis" ? inside((at.x * 0.5 + 0.5) * width) : (at.x * 0.5 + 0.5) * width;
      const y = (0.5 - at.y * 0.5) * height;
      label.element.style.transform = `translate(-50%, -50%) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    }
  }
}

// Whether WebGL draws on the processor.
function softwareRenderer() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const names = gl && gl.getExtension("WEBGL_debug_renderer_info");
  const name = names ? gl.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  if (gl) gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

// Lines through pairs of points.
function lineSegments(points, colour) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points.flat()), 3));
  return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: colour }));
}

// The colour scale of a shader as a uniform.
function scaleUniform(name) {
  return scaleColours(name).map((c) => new THREE.Vector3(c[0] / 255, c[1] / 255, c[2] / 255));
}

// Fragments of a lit surface that is coloured by t, 0 to 1.
const SCALE_SHADER = `
varying float t;
varying vec3 place;
uniform vec3 colours[COLOURS];
vec3 scaleColour(float t) {
  float at = clamp(t, 0.0, 1.0) * float(COLOURS - 1);
  int k = min(int(at), COLOURS - 2);
  return mix(colours[k], colours[k + 1], at - float(k));
}
vec3 lit(vec3 colour, vec3 place) {
  vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
  float light = abs(dot(normal, normalize(vec3(0.4, 0.8, 0.45))));
  return colour * (0.62 + 0.42 * light);
}
void main() {
  gl_FragColor = vec4(lit(scaleColour(t), place), 1.0);
}
`;
