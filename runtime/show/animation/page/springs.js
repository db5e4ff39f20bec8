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

/** Torsion springs, dampers and motors about a pin; codegen/drawing/spring_lines.py has their lines. */
export function spiralSymbol(shape, scene, lines) {
  const paths = lines.map(([style]) => svg("path", { class: style }));
  const node = svg("g", {}, ...paths);
  const update = () => {
    const center = inWorld(scene.poses, shape.j);
    const [from, to] = [scene.poses[shape.i.body].phi, scene.poses[shape.j.body].phi];
    const at = ([pins, share, offset]) => around(center, pins * scene.u, from + share * (to - from) + offset);
    paths.forEach((path, k) => path.setAttribute("d", through(lines[k][1].map(at))));
  };
  return { node, update };
}

function around({ x, y }, radius, angle) {
  return { x: x + radius * Math.cos(angle), y: y + radius * Math.sin(angle) };
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

/** A belt round two wheels; codegen/drawing/wheel_lines.py has its points and the angle β. */
export function beltSymbol(shape, scene, [[, points]]) {
  const path = svg("path", { class: "belt" });
  const node = svg("g", {}, path);
  const radii = [Math.abs(shape.radius_i), Math.abs(shape.radius_j)];
  const update = () => {
    const centers = [inWorld(scene.poses, shape.i), inWorld(scene.poses, shape.j)];
    const [dx, dy] = [centers[1].x - centers[0].x, centers[1].y - centers[0].y];
    const cosine = (radii[0] + (shape.crossed ? radii[1] : -radii[1])) / (Math.hypot(dx, dy) || Infinity);
    const beta = Math.acos(Math.max(-1, Math.min(1, cosine)));
    const heading = Math.atan2(dy, dx);
    const at = ([wheel, share, offset]) => around(centers[wheel], radii[wheel], heading + share * beta + offset);
    path.setAttribute("d", through(points.map(at)));
  };
  return { node, update };
}
