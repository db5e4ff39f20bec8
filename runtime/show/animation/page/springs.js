// Elements between two places: springs, dampers, actuators, spiral springs, rods, belts.

import { inWorld } from "./poses.js";
import { svg, through } from "./signs.js";

/** A node for what lies between the places i and j; codegen/drawing/spring_lines.py made its lines. */
export function springSymbol(shape, scene, lines) {
  const half = scene.run.spring * scene.size;
  const paths = lines.map(([style]) => svg("path", { class: style }));
  const node = svg("g", {}, ...paths);
  const update = () => {
    const [from, to] = [inWorld(scene.poses, shape.i), inWorld(scene.poses, shape.j)];
    const [dx, dy] = [to.x - from.x, to.y - from.y];
    const across = half / (Math.hypot(dx, dy) || 1);
    const at = ([s, n]) => ({ x: from.x + s * dx - n * across * dy, y: from.y + s * dy + n * across * dx });
    paths.forEach((path, k) => path.setAttribute("d", through(lines[k][1].map(at))));
  };
  return { node, update };
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
