// Arrows of applied forces, reactions and torques, in px above the machine, with body and point.

import { columnOf } from "./labels.js";
import { acts, inWorld, mixed } from "./poses.js";
import { roundArrow, svg, withUnit } from "./signs.js";

const LONGEST = 0.17; // of the smaller side of the picture, for the largest force of all runs
const CAP = 1.5; // impacts may exceed it; their arrows are cut, and have two strokes across
const COMMON = 0.98; // of the instants of an arrow have no larger force than that which sets the scale
const ROUND = 24; // px, radius of a torque's arrow
const CUT = 5; // px, half length of the strokes across an arrow that is cut

/** The arrows of a scene: {node, largest, update(camera, shown …)}; `largest` may be set. */
export function drawArrows(scene) {
  const node = svg("g", { class: "arrows" });
  const kinds = { force: applied, "opposite force": applied, reaction, torque, drive, spring: tension, "spiral spring": torsion,
    "contact side": push };
  const arrows = scene.symbols.flatMap((symbol) => {
    const sources = kinds[symbol.shape.kind]?.(symbol, scene) ?? [];
    return sources.map((source) => ({ symbol, ...source, ...parts(node, symbol, source) }));
  });
  const all = { node, largest: largestOf(scene, arrows), update };
  function update(camera, shown, chosen, withText, labels) {
    if (!(camera.width > 0 && camera.height > 0)) return; // before the page has its layout
    const length = LONGEST * Math.min(camera.width, camera.height);
    for (const arrow of arrows) {
      const { symbol } = arrow;
      const visible = (shown[arrow.kind] || chosen === symbol.element) && acts(symbol, scene.t);
      const now = visible ? arrow.now() : null;
      const drawn = now && sizeOf(now) > 1e-9 * all.largest[arrow.unit];
      arrow.group.toggleAttribute("hidden", !drawn);
      if (!drawn) continue;
      const place = draw(arrow, now, camera, sizeOf(now) / all.largest[arrow.unit], length);
      if (withText) arrow.text.textContent = arrow.label(now);
      labels.place(arrow, columnOf(place), withText, chosen === symbol.element);
    }
  }
  return all;
}

function sizeOf({ fx = 0, fy = 0, torque: moment = 0 }) {
  return Math.hypot(fx, fy, moment);
}

function parts(node, symbol, { kind }) {
  const line = svg("path", { class: `arrow ${kind}` });
  const text = svg("text", { class: `arrow-text ${kind}` });
  const group = svg("g", { hidden: "" }, line, text);
  group.dataset.element = symbol.element;
  node.append(group);
  return { group, line, text };
}

function applied(symbol, scene) {
  const { shape, element } = symbol;
  const on = scene.bodies[shape.at.body].name;
  return [{
    kind: "force",
    unit: "N",
    now: () => ({ ...inWorld(scene.poses, shape.at), fx: shape.fx, fy: shape.fy }),
    label: (now) => `${element} on ${on}: ${withUnit(sizeOf(now), "N")}`,
  }];
}

/** What a spring, damper or actuator exerts on its two bodies, where the run has it. */
function tension(symbol, scene) {
  const { shape, element } = symbol;
  const series = scene.byName.get(`${element}.force`);
  if (!series) return [];
  return [[shape.i, shape.j], [shape.j, shape.i]].filter(([at]) => !scene.bodies[at.body].fixed).map(([at, other]) => ({
    kind: "force",
    unit: "N",
    now: () => {
      const [here, there] = [inWorld(scene.poses, at), inWorld(scene.poses, other)];
      const [dx, dy] = [there.x - here.x, there.y - here.y];
      const share = mixed(series.values, scene.at) / (Math.hypot(dx, dy) || 1);
      return { ...here, fx: share * dx, fy: share * dy };
    },
    label: (now) => `${element} on ${scene.bodies[at.body].name}: ${withUnit(sizeOf(now), "N")}`,
  }));
}

/** The force of a contact on a body at the place where it touches, along the gap, where the run has it. */
function push(symbol, scene) {
  const { shape, element } = symbol;
  const series = scene.byName.get(`${element}.${shape.force}`);
  if (!series) return [];
  const others = scene.symbols.filter(({ element: name, shape: other }) =>
    name === element && other !== shape && other.kind === shape.kind && other.body === shape.body && other.force === shape.force);
  return [{
    kind: "reaction",
    unit: "N",
    now: () => {
      const isNearest = others.every(({ shape: other }) => !(other.gap < shape.gap)); // of a stop with two limits and one force
      const force = isNearest ? mixed(series.values, scene.at) : 0;
      return { x: shape.x, y: shape.y, fx: force * shape.gx, fy: force * shape.gy };
    },
    label: (now) => `${element} on ${scene.bodies[shape.body].name}: ${withUnit(sizeOf(now), "N")}`,
  }];
}

/** What a torsion spring exerts on its first body, where the run has it. */
function torsion(symbol, scene) {
  const { shape, element } = symbol;
  const series = scene.byName.get(`${element}.torque`);
  if (!series) return [];
  const on = scene.bodies[shape.i.body].name;
  return [{
    kind: "torque",
    unit: "N m",
    now: () => ({ ...inWorld(scene.poses, shape.j), torque: mixed(series.values, scene.at) }),
    label: (now) => `${element} on ${on}: ${withUnit(now.torque, "N m")}`,
  }];
}

function reaction(symbol, scene) {
  const { shape, element } = symbol;
  const [fx, fy, moment] = ["fx", "fy", "torque"].map((part) => scene.byName.get(`${element}.${part}`));
  const [by, on] = [shape.by, shape.on].map((body) => scene.bodies[body]?.name ?? "ground");
  const value = (series) => (series ? mixed(series.values, scene.at) : 0);
  const label = (size) => `${element}, ${by} on ${on}: ${size}`;
  const found = [];
  if (fx || fy) {
    found.push({
      kind: "reaction",
      unit: "N",
      now: () => {
        const [a, b] = [value(fx), value(fy)];
        return { x: shape.x, y: shape.y, fx: a * shape.ux - b * shape.uy, fy: a * shape.uy + b * shape.ux };
      },
      label: (now) => label(withUnit(sizeOf(now), "N")),
    });
  }
  if (moment) {
    found.push({
      kind: "torque",
      unit: "N m",
      now: () => ({ x: shape.x, y: shape.y, torque: value(moment) }),
      label: (now) => label(withUnit(now.torque, "N m")),
    });
  }
  return found;
}

/** What a driver exerts on its second body, where the run has it. */
function drive(symbol, scene) {
  const { shape, element } = symbol;
  const word = shape.turns ? "torque" : "force";
  const series = scene.byName.get(`${element}.${word}`);
  if (!series) return [];
  const unit = shape.turns ? "N m" : "N";
  return [{
    kind: shape.turns ? "torque" : "reaction",
    unit,
    now: () => {
      const value = mixed(series.values, scene.at);
      if (shape.turns) return { ...inWorld(scene.poses, shape.j), torque: value };
      const angle = (shape.i ? scene.poses[shape.i.body].phi : 0) + Math.atan2(shape.uy, shape.ux);
      return { ...inWorld(scene.poses, shape.j), fx: value * Math.cos(angle), fy: value * Math.sin(angle) };
    },
    label: (now) => `${element} on ${scene.bodies[shape.j.body].name}: ${withUnit(now.torque ?? sizeOf(now), unit)}`,
  }];
}

function torque(symbol, scene) {
  const { shape, element } = symbol;
  const on = scene.bodies[shape.at.body].name;
  return [{
    kind: "torque",
    unit: "N m",
    now: () => ({ ...inWorld(scene.poses, shape.at), torque: shape.torque }),
    label: (now) => `${element} on ${on}: ${withUnit(now.torque, "N m")}`,
  }];
}

/** By unit the largest size of any arrow, of each its common ones: an impact does not set the scale. */
function largestOf(scene, arrows) {
  const sizes = arrows.map(() => []);
  scene.survey(() => {
    arrows.forEach(({ now, symbol }, k) => {
      const size = sizeOf(now());
      if (acts(symbol, scene.t) && Number.isFinite(size)) sizes[k].push(size);
    });
  });
  const common = sizes.map((values) => values.toSorted((a, b) => a - b)[Math.ceil(COMMON * (values.length - 1))] ?? 0);
  const largest = (unit) => Math.max(0, ...common.filter((_, k) => arrows[k].unit === unit)) || 1;
  return { N: largest("N"), "N m": largest("N m") };
}

/** Draws an arrow whose size is `share` of the largest, and answers where its text may stand. */
function draw(arrow, now, camera, share, length) {
  const at = camera.toScreen(now);
  const part = Math.min(share, CAP);
  arrow.group.classList.toggle("cut", share > CAP);
  if (arrow.kind === "torque") {
    const radius = ROUND * (0.45 + 0.55 * part);
    const cut = share > CAP ? across(radius, 0, 1, 0) : "";
    arrow.line.setAttribute("d", roundArrow(radius, -now.torque) + cut);
    arrow.line.setAttribute("transform", `translate(${at.x} ${at.y})`);
    return { x: at.x + radius + 4, y: at.y - radius };
  }
  const size = Math.hypot(now.fx, now.fy);
  const long = Math.max(part * length, 2);
  const [ux, uy] = [now.fx / size, -now.fy / size];
  const [x, y] = [at.x + long * ux, at.y + long * uy];
  const head = Math.min(9, 0.6 * long);
  const [bx, by] = [x - head * ux, y - head * uy];
  const [sx, sy] = [0.45 * head * uy, -0.45 * head * ux];
  const cut = share > CAP ? across(at.x + 0.6 * long * ux, at.y + 0.6 * long * uy, ux, uy) : "";
  arrow.line.setAttribute(
    "d",
    `M${at.x} ${at.y}L${x} ${y}M${bx + sx} ${by + sy}L${x} ${y}L${bx - sx} ${by - sy}${cut}`,
  );
  return { x: x + 8 * ux + (ux < 0 ? -4 : 4), y: y + 8 * uy + 4, end: ux < -0.2 };
}

/** Two strokes across a line along (ux, uy). */
function across(x, y, ux, uy) {
  const stroke = (shift) => {
    const [cx, cy] = [x + shift * ux, y + shift * uy];
    const [dx, dy] = [CUT * (0.5 * ux - uy), CUT * (0.5 * uy + ux)];
    return `M${cx - dx} ${cy - dy}L${cx + dx} ${cy + dy}`;
  };
  return stroke(-2.5) + stroke(2.5);
}
