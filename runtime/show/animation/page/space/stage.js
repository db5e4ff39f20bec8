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
const COARSE = 0.5; // pixels of a picture in motion without a card, of those at rest with one, along a side
const FINEST = 2; // pixels of a screen that are drawn, of each px along a side
const NAMED = 6; // elements that a note has by name
const REST = 250; // ms after which a picture rests; without a card it has more pixels then, for smooth edges

/** Whether a card draws WebGL; for a processor each pixel takes its time. */
function hasCard() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const known = gl?.getExtension("WEBGL_debug_renderer_info");
  return !known || !/swiftshader|llvmpipe|software|basic render/i.test(gl.getParameter(known.UNMASKED_RENDERER_WEBGL));
}

/** Adds a sentence to the caption of a figure. */
function note(figure, text) {
  const caption = figure.querySelector("figcaption");
  const line = document.createElement("span");
  line.style.cssText = "display: block; max-width: 34ch; margin-left: auto; text-align: right; font-weight: 400; color: var(--muted);";
  line.textContent = text;
  caption.append(line);
  caption.hidden = false;
}

/** A run within its figure; `choose(element)` is called for what is clicked on. */
export class Stage {
  constructor(figure, scene, camera, shown, choose) {
    Object.assign(this, { scene, camera, shown, chosen: "", written: 0, following: false, smooth: hasCard() });
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
    const open = scene.run.notUnique;
    if (open.length) {
      const more = open.length > NAMED ? ` and ${open.length - NAMED} more` : "";
      note(figure, `Reactions of ${open.slice(0, NAMED).join(", ")}${more} are not unique; one choice of them is given.`);
    }
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
      const renderer = new globalThis.THREE.WebGLRenderer({ canvas, antialias: this.smooth, alpha: true });
      figure.prepend(canvas);
      this.view = new globalThis.THREE.OrthographicCamera();
      this.root = new globalThis.THREE.Scene();
      this.light = new globalThis.THREE.DirectionalLight(0xffffff, 2.4);
      this.root.add(this.solids.root, new globalThis.THREE.AmbientLight(0xffffff, 1.7), this.light, this.light.target);
      return renderer;
    } catch {
      note(figure, "No solids: this browser has no WebGL.");
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
      const hits = ray.intersectObject(this.solids.root).filter(({ object }) => object.visible).map(({ object }) => object.userData);
      hit = hits.find(({ sheer }) => !sheer) ?? hits[0];
      if (hit?.element) return hit.element;
    }
    const far = ({ at: place }) => {
      const { x, y } = this.camera.toScreen(this.scene.place(place));
      return Math.hypot(x - at.x, y - at.y);
    };
    const [nearest] = this.scene.names.toSorted((a, b) => far(a) - far(b));
    if (nearest && far(nearest) < GRASP * this.scene.size * this.camera.scale) return nearest.element;
    return hit && !this.scene.bodies[hit.body].fixed ? this.scene.bodies[hit.body].name : "";
  }

  /** Brings everything to the present view. */
  look() {
    const { camera, scene, paths } = this;
    for (const { trace: { path }, whole } of paths) whole.setAttribute("d", this.through(path, 0, path[0].length));
    this.drawCorner();
    if (this.renderer && camera.width > 1) {
      const { axes: [right, up, toward], width, height, scale, pivot } = camera;
      const [x, y] = [(width / 2 - camera.x) / scale, (camera.y - height / 2) / scale];
      const depth = toward[0] * pivot.x + toward[1] * pivot.y + toward[2] * pivot.z + DEEP * scene.size;
      const [w, h] = [width / 2 / scale, height / 2 / scale];
      Object.assign(this.view, { left: -w, right: w, top: h, bottom: -h, near: 0, far: 2 * DEEP * scene.size });
      this.view.up.set(...up);
      this.view.position.set(0, 0, 0);
      this.view.lookAt(...toward.map((value) => -value));
      this.view.position.set(...right.map((value, k) => x * value + y * up[k] + depth * toward[k]));
      this.view.updateProjectionMatrix();
      this.light.position.set(...right.map((value, k) => toward[k] + 0.7 * up[k] - 0.4 * value));
      this.renderer.setSize(width, height, false);
    }
    if (this.following) return;
    this.pace(false);
    this.drawArrows(true);
  }

  /** Draws with fewer pixels in motion where there is no card, and with more at rest. */
  pace(playing) {
    this.resolve(playing && !this.smooth ? COARSE : 1);
    clearTimeout(this.resting);
    if (!playing && !this.smooth) this.resting = setTimeout(() => this.resolve(2), REST);
  }

  /** Draws with a share of the screen's pixels along a side. */
  resolve(share) {
    const ratio = share * Math.min(globalThis.devicePixelRatio, FINEST);
    if (!this.renderer || this.renderer.getPixelRatio() === ratio) return;
    this.renderer.setPixelRatio(ratio);
    this.drawArrows(true);
  }

  /** The samples of a path from one to before another, and further points, as a line in px. */
  through([x, y, z], first, last, ...more) {
    const points = Array.from({ length: last - first }, (_, k) => ({ x: x[first + k], y: y[first + k], z: z[first + k] }));
    return through([...points, ...more].map((point) => this.camera.toScreen(point)));
  }

  /** The global axes in the corner, and gravity. */
  drawCorner() {
    const { camera: { axes, height }, scene: { gravity } } = this;
    const way = (vector, long) => axes.slice(0, 2).map((axis) => long * axis.reduce((sum, value, c) => sum + value * vector[c], 0));
    const parts = ["x", "y", "z"].flatMap((letter, k) => {
      const [x, y] = way([0, 1, 2].map((c) => Number(c === k)), TRIAD);
      return [svg("path", { d: `M0 0L${x} ${-y}` }), svg("text", { x: 1.35 * x - 3, y: 4 - 1.35 * y }, letter)];
    });
    this.corner.replaceChildren(svg("g", { transform: `translate(40 ${height - 44})` }, ...parts));
    const size = gravity ? Math.hypot(...gravity) : 0;
    if (!size) return;
    const [x, y] = way(gravity, 1 / size);
    const turn = `rotate(${(Math.atan2(-y, x) * 180) / Math.PI}) scale(${Math.hypot(x, y)} 1)`;
    const line = svg("path", { d: "M-16 0H16M10 -4L16 0L10 4", transform: turn });
    this.corner.append(svg("g", { transform: "translate(26 26)" }, line, svg("text", { x: 24, y: 4 }, `gravity ${short(size)} m/s²`)));
  }

  /** The axes x', y', z' of all bodies that move, as a path. */
  axes() {
    const { camera, scene } = this;
    return scene.poses.flatMap((pose, body) => (scene.bodies[body].fixed ? [] : [0, 1, 2].map((k) => {
      const [x, y, z] = turned(pose.e, [0, 1, 2].map((c) => (c === k ? 4 * scene.u : 0)));
      return through([pose, { x: pose.x + x, y: pose.y + y, z: pose.z + z }].map((at) => camera.toScreen(at)));
    }))).join("");
  }

  /** Draws solids, the ends of paths, axes of bodies and arrows at the present instant, and texts. */
  drawArrows(withText) {
    const { camera, scene, paths } = this;
    if (this.renderer && camera.width > 1) this.renderer.render(this.root, this.view);
    const { low } = scene.at;
    for (const { trace: { path, at }, tail } of paths) {
      tail.setAttribute("d", this.through(path, Math.max(0, low - TAIL), low + 1, scene.place(at)));
    }
    this.frames.setAttribute("d", this.shown.frames ? this.axes() : "");
    const labels = new Labels(camera, []);
    if (this.shown.names) this.names.update(camera, labels, withText);
    this.arrows.update(camera, this.shown, this.chosen, withText, labels);
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
    this.following = playing; // the view is drawn once
    if (this.camera.start) this.camera.follow(this.scene.middle);
    this.following = false;
    this.pace(playing);
    this.drawArrows(withText);
  }
}
