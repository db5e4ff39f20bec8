// The picture of one run in space: solids in WebGL, and above them names, arrows and paths in SVG.

import { drawFlashes } from "../flashes.js";
import { drawNames, Labels } from "../labels.js";
import { short, svg, through } from "../signs.js";
import { drawArrows } from "./arrows.js";
import { steerInSpace } from "./camera.js";
import { turned } from "./scene.js";
import { buildSolids } from "./solids.js";

const TEXTS = 100; // ms between changes of the numbers at arrows
const TAIL = 90; // samples of the strong part of a path
const GRASP = 0.028; // of the machine's size: how near to a joint a click is one on it
const DEEP = 100; // machine's sizes that the view reaches before and behind
const TRIAD = 26; // px, length of the global axes in the corner

/** A run within its figure; `choose(element)` is called for what is clicked on. */
export class Stage {
  constructor(figure, scene, camera, shown, choose) {
    Object.assign(this, { scene, camera, shown, chosen: "", written: 0 });
    this.svg = figure.querySelector("svg");
    this.svg.setAttribute("aria-label", ["Picture of", [scene.run.title, scene.run.label].filter(Boolean).join(", ")].join(" "));
    this.svg.style.touchAction = "none";
    camera.orient(scene.run.view);
    this.solids = buildSolids(scene);
    this.renderer = this.webgl(figure);
    const flat = Object.create(scene, {
      place: { value: (at) => camera.toScreen(scene.place(at)) },
      u: { get: () => scene.u * camera.scale },
    });
    this.flashes = drawFlashes(flat);
    this.arrows = drawArrows(scene);
    this.names = drawNames(scene);
    this.paths = scene.traces.map((trace) => ({ trace, whole: svg("path", { class: "trace" }), tail: svg("path", { class: "tail" }) }));
    const traces = svg("g", { class: "traces" }, ...this.paths.flatMap(({ whole, tail }) => [whole, tail]));
    this.frames = svg("path", { class: "frame" });
    this.world = svg("g", { class: "world" }, traces, svg("g", { class: "extras" }, this.frames), this.flashes.node);
    this.corner = svg("g", { class: "gravity" });
    this.svg.append(this.world, this.names.node, this.arrows.node, this.corner);
    camera.onChange(() => this.look());
    steerInSpace(this.svg, camera, (event) => {
      const found = this.pick(event);
      if (found) choose(found);
    });
    this.ended = figure.querySelector(".ended");
    const paint = () => this.paint();
    new MutationObserver(paint).observe(document.documentElement, { attributeFilter: ["data-theme"] });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
    this.solids.update();
    this.paint();
  }

  /** The renderer of a canvas below the texts; none, and a note, where the browser has no WebGL. */
  webgl(figure) {
    const canvas = document.createElement("canvas");
    canvas.style.cssText = "position: absolute; inset: 0; width: 100%; height: 100%;";
    canvas.setAttribute("aria-hidden", "true");
    try {
      const renderer = new globalThis.THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
      figure.prepend(canvas);
      this.view = new globalThis.THREE.OrthographicCamera();
      this.root = new globalThis.THREE.Scene();
      this.light = new globalThis.THREE.DirectionalLight(0xffffff, 2.4);
      this.root.add(this.solids.root, new globalThis.THREE.AmbientLight(0xffffff, 1.7), this.light, this.light.target);
      return renderer;
    } catch {
      const caption = figure.querySelector("figcaption");
      caption.textContent = `${caption.textContent} No solids: this browser has no WebGL.`.trim();
      caption.hidden = false;
      return null;
    }
  }

  /** Takes the colours of the page's theme. */
  paint() {
    this.solids.paint(this.chosen);
    this.look();
  }

  /** The element or the body under the pointer: a joint also where the click is near it. */
  pick(event) {
    const box = this.svg.getBoundingClientRect();
    const at = { x: event.clientX - box.left, y: event.clientY - box.top };
    let hit;
    if (this.renderer) {
      const ray = new globalThis.THREE.Raycaster();
      ray.setFromCamera(new globalThis.THREE.Vector2((2 * at.x) / box.width - 1, 1 - (2 * at.y) / box.height), this.view);
      hit = ray.intersectObject(this.solids.root).find(({ object }) => object.visible)?.object.userData;
      if (hit?.element) return hit.element;
    }
    const near = this.scene.names.map(({ element, at: place }) => {
      const { x, y } = this.camera.toScreen(this.scene.place(place));
      return { element, far: Math.hypot(x - at.x, y - at.y) };
    }).filter(({ far }) => far < GRASP * this.scene.size * this.camera.scale);
    const [nearest] = near.toSorted((a, b) => a.far - b.far);
    return nearest?.element ?? (hit && !this.scene.bodies[hit.body].fixed ? this.scene.bodies[hit.body].name : "");
  }

  /** Brings everything to the present view. */
  look() {
    const { camera, scene, paths } = this;
    for (const { trace: { path: [x, y, z] }, whole } of paths) {
      whole.setAttribute("d", through(Array.from(x, (_, k) => camera.toScreen({ x: x[k], y: y[k], z: z[k] }))));
    }
    this.drawCorner();
    if (this.renderer && camera.width > 1) {
      const [right, up, toward] = camera.axes;
      const { width, height } = camera;
      const [x, y] = [(width / 2 - camera.x) / camera.scale, (camera.y - height / 2) / camera.scale];
      const deep = DEEP * scene.size;
      const middle = camera.pivot;
      const depth = toward[0] * middle.x + toward[1] * middle.y + toward[2] * middle.z;
      const eye = [0, 1, 2].map((k) => x * right[k] + y * up[k] + (depth + deep) * toward[k]);
      const [w, h] = [width / 2 / camera.scale, height / 2 / camera.scale];
      Object.assign(this.view, { left: -w, right: w, top: h, bottom: -h, near: 0, far: 2 * deep });
      this.view.position.set(...eye);
      this.view.up.set(...up);
      this.view.lookAt(...eye.map((value, k) => value - toward[k]));
      this.view.updateProjectionMatrix();
      this.light.target.position.set(0, 0, 0);
      this.light.position.set(...[0, 1, 2].map((k) => toward[k] + 0.7 * up[k] - 0.4 * right[k]));
      this.renderer.setPixelRatio(globalThis.devicePixelRatio);
      this.renderer.setSize(width, height, false);
    }
    this.drawMoving(true);
  }

  /** The global axes in the corner, and gravity. */
  drawCorner() {
    const { axes, height } = this.camera;
    const way = (vector, long) => [0, 1].map((k) => long * axes[k].reduce((sum, value, c) => sum + value * vector[c], 0));
    const parts = ["x", "y", "z"].flatMap((letter, k) => {
      const [x, y] = way([0, 1, 2].map((c) => Number(c === k)), TRIAD);
      return [svg("path", { d: `M0 0L${x} ${-y}` }), svg("text", { x: 1.35 * x - 3, y: 4 - 1.35 * y }, letter)];
    });
    this.corner.replaceChildren(svg("g", { transform: `translate(40 ${height - 44})` }, ...parts));
    const { gravity } = this.scene;
    const size = gravity ? Math.hypot(...gravity) : 0;
    if (!size) return;
    const [x, y] = way(gravity, 16 / size);
    const long = Math.hypot(x, y) || 1;
    const turn = `rotate(${(Math.atan2(-y, x) * 180) / Math.PI}) scale(${long / 16} 1)`;
    const line = svg("path", { d: "M-16 0H16M10 -4L16 0L10 4", transform: turn });
    const text = svg("text", { x: 24, y: 4 }, `gravity ${short(size)} m/s²`);
    this.corner.append(svg("g", { transform: "translate(26 26)" }, line, text));
  }

  /** Draws solids, the ends of paths and axes of bodies at the present instant, and texts. */
  drawMoving(withText) {
    const { camera, scene, paths } = this;
    if (this.renderer && camera.width > 1) this.renderer.render(this.root, this.view);
    for (const { trace: { path: [x, y, z], at }, tail } of paths) {
      const { low } = scene.at;
      const first = Math.max(0, low - TAIL);
      const points = Array.from({ length: low + 1 - first }, (_, k) => ({ x: x[first + k], y: y[first + k], z: z[first + k] }));
      tail.setAttribute("d", through([...points, scene.place(at)].map((point) => camera.toScreen(point))));
    }
    this.frames.setAttribute("d", this.shown.frames ? this.axes() : "");
    this.drawArrows(withText);
  }

  /** The axes x', y', z' of all bodies that move, as a path. */
  axes() {
    const { camera, scene } = this;
    return scene.poses.flatMap((pose, body) => (scene.bodies[body].fixed ? [] : [0, 1, 2].map((k) => {
      const way = turned(pose.e, [0, 1, 2].map((c) => (c === k ? 4 * scene.u : 0)));
      return through([pose, { x: pose.x + way[0], y: pose.y + way[1], z: pose.z + way[2] }].map((at) => camera.toScreen(at)));
    }))).join("");
  }

  drawArrows(withText) {
    const labels = new Labels(this.camera, []);
    if (this.shown.names) this.names.update(this.camera, labels, withText);
    this.arrows.update(this.camera, this.shown, this.chosen, withText, labels);
    this.frames.setAttribute("d", this.shown.frames ? this.axes() : "");
  }

  choose(element) {
    this.chosen = element;
    this.paint();
  }

  /** Brings everything to an instant of a clock; texts change seldom while it plays. */
  draw(t, { speed, playing }) {
    const early = t < this.scene.start;
    this.ended.hidden = !early && t <= this.scene.end;
    if (!this.ended.hidden) {
      this.ended.textContent = early ? `begins at t = ${short(this.scene.start)} s` : `ended at t = ${short(this.scene.end)} s`;
    }
    this.scene.show(Math.min(Math.max(t, this.scene.start), this.scene.end));
    this.solids.update();
    this.flashes.update(speed);
    const now = performance.now();
    const withText = !playing || now - this.written > TEXTS;
    if (withText) this.written = now;
    if (this.camera.start) this.camera.follow(this.scene.middle);
    this.drawMoving(withText);
  }
}
