// Bodies, and all lines that are fixed in them: pins, supports, guides, wheels, racks, profiles.
// codegen/drawing/rigid_strokes.py made the lines; figures have the same ones.

import { shiftOf } from "./poses.js";
import { place, svg, through } from "./signs.js";

const GRASP = 0.028; // of the machine's size: how near to a pin a click is one on it

/** The nodes of all bodies by layer, each {layer, node, update}; the largest bodies at the back. */
export function drawBodies(scene) {
  const sizes = scene.bodies.map((_, body) => area(scene, body));
  const order = scene.bodies.map((_, body) => body).toSorted((a, b) => sizes[b] - sizes[a]);
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
          const now = shiftOf(shift, scene.at);
          place(one, now, now.phi);
        }
      };
      return { layer, node, update };
    });
  });
}

function outlined(body) {
  const lines = body.outlines.map((corners) => through(corners.map(([x, y]) => ({ x, y })), true));
  if (!lines.length) return [];
  const title = svg("title", {}, body.name);
  const edges = lines.map((d) => svg("path", { class: "edge", d }));
  const insides = lines.map((d) => svg("path", { class: "inside", d }));
  return [svg("g", {}, title, ...edges, ...insides)];
}

function drawStroke(scene, { style, layer, element, closed, points }) {
  const node = svg("g", { class: "stroke" }, svg("path", { class: style, d: through(points, closed) }));
  if (!element) return node;
  node.dataset.element = element;
  const known = scene.symbols.find((symbol) => symbol.element === element);
  node.append(svg("title", {}, known ? `${element}, ${known.type}` : element));
  if (layer === "joints" || layer === "between") {
    const [x, y] = ["x", "y"].map((c) => points.reduce((sum, p) => sum + p[c], 0) / points.length);
    node.append(svg("circle", { class: "grasp", cx: x, cy: y, r: GRASP * scene.size }));
  }
  return node;
}

/** The area of a body's largest closed line, m². */
function area(scene, body) {
  const outlines = scene.bodies[body].outlines.map((line) => line.map(([x, y]) => ({ x, y })));
  const strokes = scene.strokes.filter((one) => one.body === body && one.closed).map(({ points }) => points);
  const sizes = [...outlines, ...strokes].map((points) =>
    Math.abs(points.reduce((sum, p, k) => sum + p.x * points.at(k - 1).y - p.y * points.at(k - 1).x, 0)) / 2,
  );
  return Math.max(0, ...sizes);
}

/** The places of a shape, those of a profile left out. */
export function placesOf(shape) {
  return Object.values(shape).filter((value) => value && typeof value === "object" && "body" in value && "x" in value);
}
