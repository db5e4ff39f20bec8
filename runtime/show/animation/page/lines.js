// Bodies with the lines that are fixed in them, lines between bodies, and signs of drivers.
// codegen/drawing made the lines; figures have the same ones.

import { poseOf } from "./poses.js";
import { place, roundArrow, svg, through } from "./signs.js";

const GRASP = 0.028; // of the machine's size: how near to a pin a click is one on it

/** The nodes of all bodies by layer, each {layer, node, update}; the largest bodies at the back. */
export function drawBodies(scene) {
  const order = scene.bodies.map((_, body) => body).toSorted((a, b) => scene.bodies[b].area - scene.bodies[a].area);
  return order.flatMap((body) => {
    const parts = { ground: [], bodies: outlined(scene.bodies[body]), between: [], joints: [] };
    const strokes = scene.strokes.filter((stroke) => stroke.body === body);
    strokes.sort((a, b) => a.depth - b.depth);
    for (const stroke of strokes) {
      stroke.node = drawStroke(scene, stroke);
      parts[stroke.layer].push(stroke.node);
    }
    const moved = strokes.filter(({ shift }) => shift);
    return Object.entries(parts).filter(([, nodes]) => nodes.length).map(([layer, nodes]) => {
      const node = svg("g", { class: `body body-${scene.number(body)}` }, ...nodes);
      node.dataset.body = scene.bodies[body].name;
      const own = moved.filter(({ node: one }) => node.contains(one));
      const update = () => {
        place(node, scene.poses[body], scene.poses[body].phi);
        for (const { node: one, shift } of own) {
          const now = poseOf(shift, scene.at);
          place(one, now, now.phi);
        }
      };
      return { layer, node, update };
    });
  });
}

function outlined({ name, outlines }) {
  if (!outlines.length) return [];
  const paths = ["edge", "inside"].flatMap((style) =>
    outlines.map((line) => svg("path", { class: style, d: through(line, true) })));
  return [svg("g", {}, svg("title", {}, name), ...paths)];
}

/** Marks a node as an element's, with its name and kind as a title. */
function belonging(node, scene, element) {
  const kind = scene.kinds[element];
  node.dataset.element = element;
  node.append(svg("title", {}, kind ? `${element}, ${kind}` : element));
  return node;
}

function drawStroke(scene, { style, layer, element, closed, corners: points }) {
  const node = svg("g", { class: "stroke" }, svg("path", { class: style, d: through(points, closed) }));
  if (!element) return node;
  belonging(node, scene, element);
  if (layer === "joints" || layer === "between") {
    const [x, y] = ["x", "y"].map((c) => points.reduce((sum, p) => sum + p[c], 0) / points.length);
    node.append(svg("circle", { class: "grasp", cx: x, cy: y, r: GRASP * scene.size }));
  }
  return node;
}

/** The nodes of springs, rods and belts, each {node, update}. */
export function drawLinks(scene) {
  return scene.links.map((link) => {
    const paths = link.lines.map(({ style }) => svg("path", { class: style }));
    const node = belonging(svg("g", { class: "symbol" }, ...paths), scene, link.element);
    const put = (at) => paths.forEach((path, k) => path.setAttribute("d", through(link.lines[k].points.map(at))));
    const update = () => {
      const ends = [scene.place(link.i), scene.place(link.j)];
      const [dx, dy] = [ends[1].x - ends[0].x, ends[1].y - ends[0].y];
      put(link.half_width ? along(ends[0], dx, dy, link.half_width) : round(ends, ...anglesOf(link, scene, dx, dy)));
    };
    return { node, update };
  });
}

/** Where a point of a straight line is: s of the way along (dx, dy), and n half widths to its left. */
function along({ x, y }, dx, dy, half) {
  const across = half / (Math.hypot(dx, dy) || 1);
  return ([s, n]) => ({ x: x + s * dx - n * across * dy, y: y + s * dy + n * across * dx });
}

/** Where a point of a line round two places is; `wound` of codegen/drawing has its formula. */
function round(centers, alpha, beta) {
  return ([center, radius, share, offset]) => {
    const angle = alpha + share * beta + offset;
    const { x, y } = centers[center];
    return { x: x + radius * Math.cos(angle), y: y + radius * Math.sin(angle) };
  };
}

/** The two angles of a torsion spring between two bodies, or of a belt. */
function anglesOf({ turns, belt }, scene, dx, dy) {
  if (turns) {
    const [from, to] = turns.map((body) => scene.poses[body].phi);
    return [from, to - from];
  }
  const cosine = belt / (Math.hypot(dx, dy) || Infinity);
  return [Math.atan2(dy, dx), Math.acos(Math.max(-1, Math.min(1, cosine)))];
}

/** The signs of drivers, each {node, update}. */
export function drawDrives(scene) {
  const { u } = scene;
  return scene.drives.map(({ element, at, turns, angle, body }) => {
    const d = turns ? roundArrow(3.4 * u, 1) : `M0 0H${7 * u}M${5.6 * u} ${1.1 * u}L${7 * u} 0L${5.6 * u} ${-1.1 * u}`;
    const sign = svg("path", { class: "driver", d });
    const node = belonging(svg("g", { class: "symbol" }, sign), scene, element);
    const update = () => place(sign, scene.place(at), turns ? 0 : scene.poses[body].phi + angle);
    return { node, update };
  });
}
