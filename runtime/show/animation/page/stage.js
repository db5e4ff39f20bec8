// The picture of one run: layers of SVG, brought up to an instant.

import { drawArrows } from "./arrows.js";
import { steer } from "./camera.js";
import { drawFlashes } from "./flashes.js";
import { Hold } from "./hold.js";
import { drawNames, Labels } from "./labels.js";
import { drawBodies, drawDrives, drawLinks } from "./lines.js";
import { place, short, svg } from "./signs.js";
import { drawTraces } from "./traces.js";

const SPACING = 0.04; // of the machine's size: of the places on edges that texts avoid
const MAX_PLACES = 12; // of an edge
const SLACK = 2; // px by which a pointer may be led away from a machine that it turns
const TEXTS = 100; // ms between changes of the numbers at arrows

let grounds = 0;

/** Places along the edges of an outline, which texts avoid. */
function edgePlaces(line, body, size) {
  return line.flatMap(({ x, y }, k) => {
    const next = line[(k + 1) % line.length];
    const long = Math.hypot(next.x - x, next.y - y);
    const count = Math.min(Math.floor(long / (SPACING * size)), MAX_PLACES);
    return Array.from({ length: count }, (_, j) => {
      const share = (j + 0.5) / count;
      return { body, x: x + share * (next.x - x), y: y + share * (next.y - y) };
    });
  });
}

/**
 * A run within its figure; `choose(element)` is called for what is clicked on, `seek(t)` with the
 * instants to which a driven machine is turned by hand.
 */
export class Stage {
  constructor(figure, scene, camera, shown, choose, seek) {
    Object.assign(this, { scene, camera, shown, seek, chosen: "", written: 0 });
    this.svg = figure.querySelector("svg");
    this.svg.setAttribute("aria-label", ["Picture of", [scene.run.title, scene.run.label].filter(Boolean).join(", ")].join(" "));
    const world = svg("g", { class: "world" });
    const names = ["traces", "ground", "bodies", "between", "joints", "extras"];
    const layers = Object.fromEntries(names.map((name) => [name, svg("g", { class: name })]));
    world.append(...Object.values(layers));
    layers.ground.id = `ground-${(grounds += 1)}`; // seen through the bodies that stand before it
    layers.ground.classList.add("world"); // which the rules of its lines ask for, also in the second one
    layers.bodies.after(svg("use", { class: "through", href: `#${layers.ground.id}` }));
    this.world = world;
    this.moving = [];
    this.add(layers.traces, drawTraces(scene));
    for (const part of drawBodies(scene)) this.add(layers[part.layer], [part]);
    this.add(layers.between, [...drawLinks(scene), ...drawDrives(scene)]);
    this.add(layers.extras, this.frames());
    this.intermittent = Object.keys(scene.run.acts).map((element) => ({
      element,
      nodes: [...world.querySelectorAll(`[data-element="${CSS.escape(element)}"]`)],
    }));
    this.flashes = drawFlashes(scene);
    this.arrows = drawArrows(scene);
    this.names = drawNames(scene);
    world.append(this.flashes.node);
    this.svg.append(world, this.names.node, this.arrows.node, ...this.gravity());
    camera.onChange(() => this.look());
    steer(this.svg, camera, (event) => {
      const target = event.target.closest("[data-element], [data-body]");
      if (target) choose(target.dataset.element ?? target.dataset.body);
    }, (event, at) => this.grab(event, at));
    this.svg.classList.toggle("driven", Boolean(scene.run.driven));
    this.ended = figure.querySelector(".ended");
    this.edges = scene.bodies.flatMap(({ outlines }, body) => outlines.flatMap((line) => edgePlaces(line, body, scene.size)));
    this.look();
  }

  /** A function that turns a driven machine by the body under the pointer; none elsewhere. */
  grab(event, at) {
    const name = this.scene.run.driven && event.target.closest("[data-body]")?.dataset.body;
    const body = this.scene.bodies.findIndex((one) => one.name === name && !one.fixed);
    if (body < 0) return undefined;
    const hold = new Hold(this.scene, body, this.camera.toWorld(at));
    return (now) => this.seek(hold.nearest(this.camera.toWorld(now), SLACK / this.camera.scale));
  }

  add(layer, parts) {
    for (const part of parts) {
      layer.append(part.node);
      part.update();
      this.moving.push(part);
    }
  }

  /** Axes of each body, and its centre of mass, which is its origin. */
  frames() {
    const { u } = this.scene;
    return this.scene.bodies.flatMap((body, number) => {
      if (body.fixed) return [];
      const axes = svg("path", { class: "frame", d: `M0 ${4 * u}V0H${4 * u}` });
      const quarter = `M0 0H${u}A${u} ${u} 0 0 1 0 ${u}ZM0 0H${-u}A${u} ${u} 0 0 1 0 ${-u}Z`;
      const mass = svg("g", { class: "mass" }, svg("circle", { r: u }), svg("path", { d: quarter }));
      const node = svg("g", {}, axes, mass, svg("title", {}, `${body.name}: centre of mass`));
      return [{ node, update: () => place(node, this.scene.poses[number], this.scene.poses[number].phi) }];
    });
  }

  /** The direction of gravity, in the corner. */
  gravity() {
    if (!this.scene.gravity) return [];
    const [gx, gy] = this.scene.gravity;
    const turn = `rotate(${(Math.atan2(-gy, gx) * 180) / Math.PI})`;
    const line = svg("path", { d: "M-16 0H16M10 -4L16 0L10 4", transform: turn });
    const text = svg("text", { x: 24, y: 4 }, `gravity ${short(Math.hypot(gx, gy))} m/s²`);
    return [svg("g", { class: "gravity", transform: "translate(26 26)" }, line, text)];
  }

  look() {
    this.world.setAttribute("transform", this.camera.matrix);
    this.drawArrows(true);
  }

  drawArrows(withText) {
    const { scene, camera } = this;
    const edges = withText ? this.edges.map((at) => camera.toScreen(scene.place(at))) : [];
    const labels = new Labels(camera, edges);
    if (this.shown.names) this.names.update(camera, labels, withText);
    this.arrows.update(camera, this.shown, this.chosen, withText, labels);
  }

  choose(element) {
    this.chosen = element;
    for (const node of this.svg.querySelectorAll("[data-element], [data-body]")) {
      node.classList.toggle("chosen", element !== "" && [node.dataset.element, node.dataset.body].includes(element));
    }
    this.drawArrows(true);
  }

  /** Brings everything to an instant of a clock; texts change seldom while it plays. */
  draw(t, { speed, playing }) {
    const early = t < this.scene.start;
    this.ended.hidden = !early && t <= this.scene.end;
    if (!this.ended.hidden) {
      this.ended.textContent = early ? `begins at t = ${short(this.scene.start)} s` : `ended at t = ${short(this.scene.end)} s`;
    }
    this.scene.show(Math.min(Math.max(t, this.scene.start), this.scene.end));
    if (this.camera.from) this.camera.follow(this.scene.middle);
    for (const { update } of this.moving) update();
    for (const { element, nodes } of this.intermittent) {
      for (const node of nodes) node.toggleAttribute("hidden", !this.scene.acts(element));
    }
    this.flashes.update(speed);
    const now = performance.now();
    const withText = !playing || now - this.written > TEXTS;
    if (withText) this.written = now;
    this.drawArrows(withText);
  }
}
