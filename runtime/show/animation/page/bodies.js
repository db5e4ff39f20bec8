// Bodies: from their outlines, or as links between the places at which elements take hold of them.

import { place, svg, through } from "./signs.js";

/** The places of a shape, those of a profile left out. */
export function placesOf(shape) {
  return Object.values(shape).filter((value) => value && typeof value === "object" && "body" in value && "x" in value);
}

/** A node for each body and its update. */
export function drawBodies(scene) {
  return scene.bodies.flatMap((body, number) => {
    const node = svg("g", { class: `body body-${scene.number(number)}${body.fixed ? " fixed" : ""}` });
    node.dataset.body = body.name;
    node.append(svg("title", {}, body.name), ...(body.outlines.length ? outlined(body) : linked(scene, number)));
    if (node.childElementCount < 2) return [];
    return [{ node, update: () => place(node, scene.poses[number], scene.poses[number].phi) }];
  });
}

function outlined(body) {
  return body.outlines.map((corners) =>
    svg("path", { class: "outline", d: through(corners.map(([x, y]) => ({ x, y })), true) }),
  );
}

/** A rounded bar through the places of a body, round its hull where there are more than two. */
function linked(scene, number) {
  if (scene.bodies[number].fixed) return [];
  const held = scene.symbols
    .filter(({ shape, role }) => role !== "force" && !["wheel", "rack", "profile"].includes(shape.kind))
    .flatMap(({ shape }) => placesOf(shape).filter(({ body }) => body === number));
  const points = hull(held);
  if (!points.length) return [];
  const line = points.length > 1 ? through(points, points.length > 2) : `${through(points)}h0`;
  const u = scene.u;
  return [
    svg("path", { class: "bar-edge", d: line, style: `stroke-width: ${3.4 * u}` }),
    svg("path", { class: "bar", d: line, style: `stroke-width: ${2.8 * u}` }),
  ];
}

/** The convex hull of points, counter-clockwise (A. M. Andrew, 1979). */
export function hull(points) {
  const sorted = [...new Map(points.map((p) => [`${p.x.toPrecision(9)},${p.y.toPrecision(9)}`, p])).values()];
  sorted.sort((a, b) => a.x - b.x || a.y - b.y);
  if (sorted.length < 3) return sorted;
  const turn = (o, a, b) => (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
  const half = (side) => {
    const line = [];
    for (const p of side) {
      while (line.length > 1 && turn(line.at(-2), line.at(-1), p) <= 0) line.pop();
      line.push(p);
    }
    return line.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.toReversed())];
}
