// Contacts that close: a ring that grows where they touch, and the bodies that hit each other.

import { inWorld, locate, mixed } from "./poses.js";
import { place, svg } from "./signs.js";

const LASTS = 0.35; // s of the viewer's time

/** Where bodies hit each other at an instant: the side with the smallest gap, of a stop with two limits. */
function placeOfHit(sides, at) {
  const places = sides.map(({ moving }) => Object.fromEntries(moving.map(({ path, values }) => [path[0], mixed(values, at)])));
  return places.filter(({ x, y }) => Number.isFinite(x + y)).toSorted((a, b) => a.gap - b.gap)[0];
}

/** The flashes of a scene: {node, update(speed)}. */
export function drawFlashes(scene) {
  const hits = scene.run.events.filter(({ flash }) => flash);
  const node = svg("g", { class: "flashes" });
  const contacts = scene.symbols.filter(({ element }) => hits.some((hit) => hit.element === element));
  const rings = new Map();
  for (const { element, shape } of contacts) {
    const spot = shape.at ?? shape.j ?? shape.center ?? null;
    const bodies = shape.bodies ?? [];
    const sides = scene.symbols.filter((symbol) => symbol.element === element && symbol.shape.kind === "contact side");
    if (rings.has(element) || !(spot || bodies.length)) continue;
    const ring = svg("circle", { class: "flash", hidden: "" });
    node.append(ring);
    rings.set(element, { ring, sides, spot, body: bodies.find((k) => !scene.bodies[k].fixed) });
  }
  const update = (speed) => {
    for (const [element, { ring, sides, spot, body }] of rings) {
      const last = hits.findLast((hit) => hit.element === element && hit.t <= scene.t + 1e-12);
      const age = last ? (scene.t - last.t) / (LASTS * speed) : 2;
      ring.toggleAttribute("hidden", age > 1);
      if (age > 1) continue;
      const hit = spot ? inWorld(scene.poses, spot) : placeOfHit(sides, locate(scene.times, last.t));
      place(ring, hit ?? scene.poses[body]);
      ring.setAttribute("r", (1 + 4 * age) * scene.u);
      ring.style.opacity = 1 - age;
    }
  };
  return { node, update };
}
