"use strict";
// Surfaces drawn on a canvas, far faces first: no library, no graphics card, nothing to fetch.

const SCENES = JSON.parse(document.getElementById("scenes").textContent);
const COLOURS = SCENES.colours.map(hex => [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16)));
const LIGHT = [0.25, 0.45, 0.86]; // right, up, towards the eye

function unpack(text, Kind) {
  const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  return new Kind(bytes.buffer);
}

function surfaceOf(packed) {
  const before = unpack(packed.before, Int16Array), after = unpack(packed.after, Int16Array);
  return {
    corners: packed.corners, unit: packed.unit, before, after,
    faces: unpack(packed.faces, Uint16Array), values: unpack(packed.values, Uint8Array),
  };
}

class Viewer {
  constructor(figure) {
    const scene = SCENES.samples[figure.dataset.sample];
    this.canvas = figure.querySelector("canvas");
    this.surfaces = {};
    for (const [name, packed] of Object.entries(scene.surfaces)) this.surfaces[name] = surfaceOf(packed);
    this.shown = figure.querySelector("input[type=radio]:checked").value;
    this.share = 1.0;
    this.edges = true;
    this.home();
    const bar = figure.querySelector(".bar");
    bar.style.background = `linear-gradient(to right, ${SCENES.colours.join()})`;
    this.listen(figure);
    this.draw();
  }

  home() { this.azimuth = 0.52; this.elevation = 0.49; this.zoom = 1.0; }

  listen(figure) {
    const on = (selector, kind, act) => figure.querySelectorAll(selector).forEach(part =>
      part.addEventListener(kind, event => { act(event); this.draw(); }));
    on("input[type=radio]", "change", event => { this.shown = event.target.value; });
    on("input[type=range]", "input", event => { this.share = event.target.value / 100; });
    on("input[type=checkbox]", "change", event => { this.edges = event.target.checked; });
    on("button", "click", () => this.home());
    this.canvas.addEventListener("pointerdown", event => this.canvas.setPointerCapture(event.pointerId));
    this.canvas.addEventListener("pointermove", event => {
      if (event.buttons) this.turn(-0.01 * event.movementX, 0.01 * event.movementY);
    });
    this.canvas.addEventListener("keydown", event => {
      const step = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
      if (step) { event.preventDefault(); this.turn(...step); }
      if (event.key === "+" || event.key === "-") { this.zoom *= event.key === "+" ? 1.1 : 1 / 1.1; this.draw(); }
    });
  }

  turn(azimuth, elevation) {
    this.azimuth += azimuth;
    this.elevation = Math.max(-1.57, Math.min(1.57, this.elevation + elevation));
    this.draw();
  }

  // page coordinates (right, up, towards the eye) of every point, in mm about the middle
  project(surface) {
    const [ca, sa] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    const [ce, se] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    const count = surface.before.length, page = new Float32Array(count);
    let top = 0;
    for (let k = 2; k < count; k += 3) top = Math.max(top, surface.before[k]);
    for (let k = 0; k < count; k += 3) {
      const at = axis => surface.before[k + axis] + this.share * (surface.after[k + axis] - surface.before[k + axis]);
      const x = at(0) * surface.unit, y = at(1) * surface.unit, z = (at(2) - 0.5 * top) * surface.unit;
      const away = ca * y - sa * x;
      page[k] = ca * x + sa * y;
      page[k + 1] = ce * z + se * away;
      page[k + 2] = se * z - ce * away;
    }
    return page;
  }

  // faces that look at the eye, the farthest first, with their light
  seen(surface, page) {
    const found = [], { corners, faces } = surface;
    for (let f = 0; f < faces.length; f += corners) {
      const [a, b, c, d] = [0, 1, 2, corners - 1].map(k => 3 * faces[f + k]);
      const u = [0, 1, 2].map(k => page[c + k] - page[a + k]), v = [0, 1, 2].map(k => page[d + k] - page[b + k]);
      const normal = corners === 3 ? cross([0, 1, 2].map(k => page[b + k] - page[a + k]), u) : cross(u, v);
      if (normal[2] <= 0) continue;
      const size = Math.hypot(...normal) || 1;
      const light = normal.reduce((sum, part, k) => sum + part * LIGHT[k], 0) / size;
      found.push([f, page[a + 2] + page[b + 2] + page[c + 2] + page[d + 2], 0.72 + 0.28 * Math.max(0, light)]);
    }
    return found.sort((one, other) => one[1] - other[1]);
  }

  draw() {
    const ratio = window.devicePixelRatio || 1, box = this.canvas.getBoundingClientRect();
    const width = Math.round((box.width || 640) * ratio), height = Math.round((box.height || 400) * ratio);
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    const pen = this.canvas.getContext("2d"), surface = this.surfaces[this.shown];
    pen.fillStyle = "#fff";
    pen.fillRect(0, 0, width, height);
    const page = this.project(surface), { corners, faces, values } = surface;
    const scale = this.zoom * 0.8 * height / SCENES.extent_mm;
    pen.lineWidth = 0.6 * ratio;
    pen.lineJoin = "round";
    for (const [f, , light] of this.seen(surface, page)) {
      let value = 0;
      pen.beginPath();
      for (let k = 0; k < corners; k++) {
        const point = faces[f + k];
        value += values[point] / corners;
        pen.lineTo(0.5 * width + scale * page[3 * point], 0.5 * height - scale * page[3 * point + 1]);
      }
      pen.closePath();
      const colour = COLOURS[Math.min(COLOURS.length - 1, Math.floor(value / 256 * COLOURS.length))];
      pen.fillStyle = `rgb(${colour.map(part => Math.round(part * light))})`;
      pen.fill();
      pen.strokeStyle = this.edges ? "rgba(20,20,20,0.45)" : pen.fillStyle;
      pen.stroke();
    }
    this.ruler(pen, scale, height, ratio);
  }

  ruler(pen, scale, height, ratio) {
    pen.fillStyle = pen.strokeStyle = "#1d2329";
    pen.fillRect(12 * ratio, height - 14 * ratio, 10 * scale, 2 * ratio);
    pen.font = `${12 * ratio}px sans-serif`;
    pen.fillText("10 mm", 12 * ratio, height - 20 * ratio);
  }
}

function cross(u, v) {
  return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
}

const viewers = [...document.querySelectorAll(".viewer")].map(figure => new Viewer(figure));
window.addEventListener("resize", () => viewers.forEach(viewer => viewer.draw()));
document.addEventListener("toggle", () => viewers.forEach(viewer => viewer.draw()), true);
