// Elements between two places: springs, dampers, actuators, spiral springs, rods, belts.

import { inWorld } from "./poses.js";
import { svg, through } from "./signs.js";

const COILS = 7;

/** A node for what lies between the places i and j, drawn along x and stretched to its length. */
export function springSymbol(shape, scene) {
  const parts = [];
  if (shape.elastic) parts.push("spring");
  if (shape.damper) parts.push("damper");
  if (shape.actuator) parts.push("actuator");
  const paths = parts.map((part) => svg("path", { class: part }));
  const node = svg("g", {}, ...paths);
  const update = () => {
    const [from, to] = [inWorld(scene.poses, shape.i), inWorld(scene.poses, shape.j)];
    const length = Math.hypot(to.x - from.x, to.y - from.y);
    const angle = Math.atan2(to.y - from.y, to.x - from.x);
    const turn = `rotate(${(angle * 180) / Math.PI})`;
    node.setAttribute("transform", `translate(${from.x} ${from.y})${turn}`);
    paths.forEach((path, k) => {
      const offset = (k - (parts.length - 1) / 2) * 4.4 * scene.u;
      path.setAttribute("d", LINES[parts[k]](length, scene.u, offset));
    });
  };
  return { node, update };
}

const LINES = { spring: coil, damper: dashpot, actuator: cylinder };

function coil(length, u, offset) {
  const lead = Math.min(0.15 * length, 2 * u);
  const height = 1.8 * u;
  const pitch = (length - 2 * lead) / COILS;
  let line = `M0 0L${0.5 * lead} ${offset}H${lead}`;
  for (let k = 0; k < COILS; k += 1) {
    const x = lead + k * pitch;
    line += `L${x + 0.25 * pitch} ${offset + height}L${x + 0.75 * pitch} ${offset - height}`;
  }
  return `${line}L${length - lead} ${offset}H${length - 0.5 * lead}L${length} 0`;
}

function dashpot(length, u, offset) {
  const [from, to, height] = [0.3 * length, 0.62 * length, 1.5 * u];
  const piston = Math.min(Math.max(0.5 * length, from + 0.4 * u), to);
  return (
    `M0 0L${0.08 * length} ${offset}H${from}M${to} ${offset - height}H${from}V${offset + height}H${to}` +
    `M${piston} ${offset - 0.8 * height}V${offset + 0.8 * height}M${piston} ${offset}` +
    `H${0.92 * length}L${length} 0`
  );
}

function cylinder(length, u, offset) {
  const [from, to, height] = [0.15 * length, 0.6 * length, 1.5 * u];
  return (
    `M0 0L${0.08 * length} ${offset}H${from}V${offset + height}H${to}V${offset - height}H${from}V${offset}` +
    `M${0.45 * length} ${offset - height}V${offset + height}M${0.45 * length} ${offset}` +
    `H${0.92 * length}L${length} 0`
  );
}

/** A spiral that winds with the angle between its bodies. */
export function spiralSymbol(shape, scene) {
  const kind = shape.elastic ? "spring" : shape.damper ? "damper" : "actuator";
  const path = svg("path", { class: kind });
  const node = svg("g", {}, path);
  const update = () => {
    const at = inWorld(scene.poses, shape.j);
    const from = scene.poses[shape.i.body].phi;
    const wound = scene.poses[shape.j.body].phi - from;
    const turns = 2.5 * 2 * Math.PI + Math.max(Math.min(wound, 12), -12);
    const points = Array.from({ length: 60 }, (_, k) => {
      const share = k / 59;
      const radius = (1.8 + 2.6 * share) * scene.u;
      const angle = from + wound - turns * share;
      return { x: at.x + radius * Math.cos(angle), y: at.y + radius * Math.sin(angle) };
    });
    path.setAttribute("d", through(points));
  };
  return { node, update };
}

/** A massless rod; its pins are fixed in the bodies that they hold. */
export function rodSymbol(shape, scene) {
  const path = svg("path", { class: "rod" });
  const node = svg("g", {}, path);
  const update = () => {
    const ends = [inWorld(scene.poses, shape.i), inWorld(scene.poses, shape.j)];
    path.setAttribute("d", through(ends));
  };
  return { node, update };
}

/** A belt round two wheels: two tangents and an arc on each wheel. */
export function beltSymbol(shape, scene) {
  const path = svg("path", { class: "belt" });
  const node = svg("g", {}, path);
  const update = () => {
    const [a, b] = [inWorld(scene.poses, shape.i), inWorld(scene.poses, shape.j)];
    path.setAttribute("d", beltLine(a, b, shape.radius_i, shape.radius_j, shape.crossed));
  };
  return { node, update };
}

function beltLine(a, b, radiusA, radiusB, crossed) {
  const distance = Math.hypot(b.x - a.x, b.y - a.y);
  const along = Math.atan2(b.y - a.y, b.x - a.x);
  const sum = crossed ? radiusA + radiusB : radiusA - radiusB;
  const lean = Math.acos(Math.max(-1, Math.min(1, sum / Math.max(distance, 1e-12))));
  const at = (center, radius, angle) =>
    `${center.x + radius * Math.cos(angle)} ${center.y + radius * Math.sin(angle)}`;
  const flip = crossed ? Math.PI : 0;
  const wrapA = 2 * (Math.PI - lean) > Math.PI ? 1 : 0;
  const wrapB = crossed ? wrapA : 2 * lean > Math.PI ? 1 : 0;
  return (
    `M${at(a, radiusA, along + lean)}L${at(b, radiusB, along + lean + flip)}` +
    `A${radiusB} ${radiusB} 0 ${wrapB} ${crossed ? 1 : 0} ${at(b, radiusB, along - lean + flip)}` +
    `L${at(a, radiusA, along - lean)}A${radiusA} ${radiusA} 0 ${wrapA} 0 ${at(a, radiusA, along + lean)}`
  );
}
