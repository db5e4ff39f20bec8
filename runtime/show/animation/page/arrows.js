// Arrows of applied forces, reactions and torques, in px above the machine, with body and point.

import { acts, inWorld, mixed } from "./poses.js";
import { roundArrow, svg, withUnit } from "./signs.js";

const LONGEST = 0.17; // of the smaller side of the picture, for the largest force of the run
const CAP = 1.5; // impacts may exceed it; arrows do not
const LETTER = 6.4; // px, width of a letter
const LINE = 15; // px, height of a line
const ROUND = 24; // px, radius of a torque's arrow

/** The arrows of a scene: {node, update(camera, shown)}. */
export function drawArrows(scene) {
  const node = svg("g", { class: "arrows" });
  const arrows = scene.symbols.flatMap((symbol) => {
    const sources = { force: applied, reaction, torque }[symbol.shape.kind]?.(symbol, scene) ?? [];
    return sources.map((source) => ({ symbol, ...source, ...parts(node, symbol, source) }));
  });
  const largest = scales(scene, arrows);
  const update = (camera, shown, chosen, withText) => {
    if (!(camera.width > 0 && camera.height > 0)) return; // before the page has its layout
    const taken = [];
    const length = LONGEST * Math.min(camera.width, camera.height);
    for (const arrow of arrows) {
      const { symbol } = arrow;
      const visible = (shown[arrow.kind] || chosen === symbol.element) && acts(symbol, scene.t);
      const now = visible ? arrow.now() : null;
      const drawn = now && Math.hypot(now.fx ?? 0, now.fy ?? 0, now.torque ?? 0) > 1e-9 * largest[arrow.unit];
      arrow.group.toggleAttribute("hidden", !drawn);
      if (drawn) draw(arrow, now, camera, length / largest[arrow.unit], length);
      if (drawn && withText) arrow.text.textContent = arrow.label(now);
      if (drawn) settle(arrow.text, camera, taken);
    }
  };
  return { node, update, largest };
}

/** Moves a text within the picture, and down from others that it would cover. */
function settle(text, camera, taken) {
  const width = LETTER * text.textContent.length;
  const end = text.getAttribute("text-anchor") === "end";
  let [x, y] = ["x", "y"].map((name) => Number(text.getAttribute(name)));
  x = end ? Math.max(x, width + 4) : Math.min(x, camera.width - width - 4);
  const left = end ? x - width : x;
  const hit = (box) => left < box.right && left + width > box.left && Math.abs(y - box.y) < LINE;
  for (let tries = 0; tries < 6 && taken.some(hit); tries += 1) y += LINE;
  taken.push({ left, right: left + width, y });
  text.setAttribute("x", x);
  text.setAttribute("y", y);
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
    label: (now) => `${element} on ${on}: ${withUnit(Math.hypot(now.fx, now.fy), "N")}`,
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
      label: (now) => label(withUnit(Math.hypot(now.fx, now.fy), "N")),
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

/** By unit the size that the longest arrow has: nearly the largest of the run, impacts left out. */
function scales(scene, arrows) {
  const sizes = { N: [], "N m": [] };
  scene.survey(() => {
    for (const { unit, now, symbol } of arrows) {
      const { fx = 0, fy = 0, torque: moment = 0 } = now();
      const size = Math.hypot(fx, fy, moment);
      if (acts(symbol, scene.t) && Number.isFinite(size)) sizes[unit].push(size);
    }
  });
  const high = (values) => values.toSorted((a, b) => a - b)[Math.floor(0.98 * (values.length - 1))] || 1;
  return { N: high(sizes.N), "N m": high(sizes["N m"]) };
}

function draw(arrow, now, camera, scale, length) {
  const at = camera.toScreen(now);
  if (arrow.kind === "torque") {
    const share = Math.min(Math.abs(now.torque) * (1 / length) * scale, CAP);
    const radius = ROUND * (0.45 + 0.55 * share);
    arrow.line.setAttribute("d", roundArrow(radius, -now.torque));
    arrow.line.setAttribute("transform", `translate(${at.x} ${at.y})`);
    arrow.text.setAttribute("x", at.x + radius + 4);
    arrow.text.setAttribute("y", at.y - radius);
    return;
  }
  const size = Math.hypot(now.fx, now.fy);
  const long = Math.max(Math.min(size * scale, CAP * length), 2);
  const [ux, uy] = [now.fx / size, -now.fy / size];
  const [x, y] = [at.x + long * ux, at.y + long * uy];
  const head = Math.min(9, 0.6 * long);
  const [bx, by] = [x - head * ux, y - head * uy];
  const [sx, sy] = [0.45 * head * uy, -0.45 * head * ux];
  arrow.line.setAttribute(
    "d",
    `M${at.x} ${at.y}L${x} ${y}M${bx + sx} ${by + sy}L${x} ${y}L${bx - sx} ${by - sy}`,
  );
  arrow.text.setAttribute("x", x + 8 * ux + (ux < 0 ? -4 : 4));
  arrow.text.setAttribute("y", y + 8 * uy + 4);
  arrow.text.setAttribute("text-anchor", ux < -0.2 ? "end" : "start");
}
