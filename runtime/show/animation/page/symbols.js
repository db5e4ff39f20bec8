// The symbols of elements: each a function from a shape to a node and what brings it up to date.

import { inWorld } from "./poses.js";
import { hatchedLine, place, ring, roundArrow, support, svg, through } from "./signs.js";
import { beltSymbol, rodSymbol, spiralSymbol, springSymbol } from "./springs.js";

/** The angle of a direction of a body in global axes, rad. */
function direction(scene, body, ux, uy) {
  return scene.poses[body].phi + Math.atan2(uy, ux);
}

function pinSymbol(shape, scene) {
  const fixed = [shape.i, shape.j].some(({ body }) => scene.bodies[body].fixed);
  const node = svg("g", {}, ...(fixed ? [support(scene.u)] : []), ring(scene.u));
  return { node, update: () => place(node, inWorld(scene.poses, shape.i)) };
}

function slideSymbol(shape, scene) {
  const { u } = scene;
  const [from, to] = scene.travel(shape);
  const fixed = scene.bodies[shape.i.body].fixed;
  const [left, right] = [from - 4 * u, to + 4 * u];
  const lower = svg("g", { transform: `translate(0 ${-1.6 * u})` });
  const upper = svg("g", { transform: `translate(0 ${1.6 * u}) scale(1 -1)` });
  for (const side of [lower, upper]) {
    side.append(fixed ? hatchedLine(left, right, u) : svg("path", { class: "rail", d: `M${left} 0H${right}` }));
  }
  const guide = svg("g", {}, lower, upper);
  const block = svg("rect", { class: "block", x: -2.6 * u, y: -1.5 * u, width: 5.2 * u, height: 3 * u, rx: 0.3 * u });
  const carriage = svg("g", {}, block);
  const update = () => {
    const angle = direction(scene, shape.i.body, shape.ux, shape.uy);
    place(guide, inWorld(scene.poses, shape.i), angle);
    place(carriage, inWorld(scene.poses, shape.j), angle);
  };
  return { node: svg("g", {}, guide, carriage), update };
}

function slotSymbol(shape, scene) {
  const { u } = scene;
  const [from, to] = scene.travel(shape);
  const width = 1.25 * u;
  const slot = svg("rect", {
    class: "slot", x: from - 2 * u, y: -width, width: to - from + 4 * u, height: 2 * width, rx: width,
  });
  const pin = ring(0.9 * u);
  const update = () => {
    place(slot, inWorld(scene.poses, shape.i), direction(scene, shape.i.body, shape.ux, shape.uy));
    place(pin, inWorld(scene.poses, shape.j));
  };
  return { node: svg("g", {}, slot, pin), update };
}

function fixingSymbol(shape, scene) {
  const { u } = scene;
  const node = svg("rect", { class: "fixing", x: -0.8 * u, y: -0.8 * u, width: 1.6 * u, height: 1.6 * u });
  return { node, update: () => place(node, inWorld(scene.poses, shape.i), scene.poses[shape.i.body].phi) };
}

function wheelSymbol(shape, scene) {
  const { radius, toothed, internal } = shape;
  const { count, phase } = toothed ? scene.teeth(shape) : { count: 0, phase: 0 };
  const line = toothed ? teeth(radius, count, phase, internal) : circle(radius);
  const rim = internal ? circle(1.18 * radius) : "";
  const color = scene.number(shape.center.body);
  const disc = svg("path", { class: `wheel body-${color}`, d: rim + line, "fill-rule": "evenodd" });
  const spoke = svg("path", { class: "spoke", d: `M${0.55 * radius} 0H${0.85 * radius}` });
  const node = svg("g", {}, disc, ...(internal ? [] : [spoke]));
  const update = () => place(node, inWorld(scene.poses, shape.center), scene.poses[shape.center.body].phi);
  return { node, update, below: true };
}

function circle(radius) {
  return `M${radius} 0A${radius} ${radius} 0 0 1 ${-radius} 0A${radius} ${radius} 0 0 1 ${radius} 0Z`;
}

function teeth(radius, count, phase, internal) {
  const height = ((2 * Math.PI * radius) / count) * 0.32 * (internal ? -1 : 1);
  const pitch = (2 * Math.PI) / count;
  const points = [];
  for (let k = 0; k < count; k += 1) {
    for (const [share, side] of [[-0.3, -1], [-0.14, 1], [0.14, 1], [0.3, -1]]) {
      const angle = phase + (k + share) * pitch;
      const r = radius + side * height;
      points.push({ x: r * Math.cos(angle), y: r * Math.sin(angle) });
    }
  }
  return through(points, true);
}

function rackSymbol(shape, scene) {
  const { u } = scene;
  const [from, to] = scene.reach(shape);
  const pitch = scene.pitch || 2 * u;
  let line = `M${from} 0H${to}`;
  if (shape.toothed) {
    const height = 0.32 * pitch;
    line = `M${from} ${-height}`;
    for (let x = Math.ceil(from / pitch) * pitch; x < to; x += pitch) {
      line += `L${x - 0.3 * pitch} ${-height}L${x - 0.14 * pitch} ${height}`;
      line += `L${x + 0.14 * pitch} ${height}L${x + 0.3 * pitch} ${-height}`;
    }
    line += `L${to} ${-height}V${-height - 1.2 * u}H${from}Z`;
  }
  const fixed = scene.bodies[shape.i.body].fixed && !shape.toothed;
  const node = fixed
    ? hatchedLine(from, to, u)
    : svg("path", { class: shape.toothed ? `rack body-${scene.number(shape.i.body)}` : "rail", d: line });
  const outer = svg("g", {}, node);
  const update = () =>
    place(outer, inWorld(scene.poses, shape.i), direction(scene, shape.i.body, shape.ux, shape.uy));
  return { node: outer, update, below: true };
}

function profileSymbol(shape, scene) {
  const points = shape.curve;
  if (points.length < 2) return { node: svg("g"), update: () => {} };
  const [{ body }] = points;
  const gap = Math.hypot(points[0].x - points.at(-1).x, points[0].y - points.at(-1).y);
  const closed = gap < 1e-3 * scene.size;
  const kind = closed ? `profile body-${scene.number(body)}` : "rail";
  const node = svg("path", { class: kind, d: through(points, closed) });
  return { node, update: () => place(node, scene.poses[body], scene.poses[body].phi), below: true };
}

function bearingSymbol(shape, scene) {
  const journal = 1.2 * scene.u;
  const hole = svg("circle", { class: "hole", r: journal + shape.clearance });
  const pin = svg("circle", { class: "journal", r: journal });
  const update = () => {
    place(hole, inWorld(scene.poses, shape.i));
    place(pin, inWorld(scene.poses, shape.j));
  };
  return { node: svg("g", {}, hole, pin), update };
}

function markSymbol(shape, scene) {
  const u = 0.7 * scene.u;
  const node = svg("path", { class: "mark", d: `M${-u} 0H${u}M0 ${-u}V${u}` });
  return { node, update: () => place(node, inWorld(scene.poses, shape.at)) };
}

function driveSymbol(shape, scene) {
  const { u } = scene;
  const line = shape.turns ? roundArrow(2.6 * u, 1) : `M0 0H${5 * u}M${4 * u} ${0.8 * u}L${5 * u} 0L${4 * u} ${-0.8 * u}`;
  const node = svg("path", { class: "drive", d: line });
  const update = () => {
    const angle = shape.turns ? 0 : direction(scene, shape.i.body, shape.ux, shape.uy);
    place(node, inWorld(scene.poses, shape.j), angle);
  };
  return { node, update };
}

const SYMBOLS = {
  pin: pinSymbol,
  slide: slideSymbol,
  slot: slotSymbol,
  rod: rodSymbol,
  fixing: fixingSymbol,
  spring: springSymbol,
  "spiral spring": spiralSymbol,
  wheel: wheelSymbol,
  rack: rackSymbol,
  belt: beltSymbol,
  profile: profileSymbol,
  bearing: bearingSymbol,
  mark: markSymbol,
  drive: driveSymbol,
};

/** The node of a symbol and its update; nothing for arrows and traces, which are drawn elsewhere. */
export function drawSymbol(symbol, scene) {
  const make = SYMBOLS[symbol.shape.kind];
  if (!make) return null;
  const drawn = make(symbol.shape, scene);
  drawn.node.classList.add("symbol");
  drawn.node.dataset.element = symbol.element;
  drawn.node.append(svg("title", {}, `${symbol.element}, ${symbol.type}`));
  return drawn;
}
