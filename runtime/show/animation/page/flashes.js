// Contacts that close: a ring that grows where bodies hit each other.

import { place, svg } from "./signs.js";

const LASTS = 0.35; // s of the viewer's time

/** The flashes of a scene: {node, update(speed)}. */
export function drawFlashes(scene) {
  const hits = scene.run.events.filter(({ at }) => at);
  const rings = new Map(hits.map(({ element }) => [element, svg("circle", { class: "flash", hidden: "" })]));
  const node = svg("g", { class: "flashes" }, ...rings.values());
  const update = (speed) => {
    for (const [element, ring] of rings) {
      const last = hits.findLast((hit) => hit.element === element && hit.t <= scene.t + 1e-12);
      const age = last ? (scene.t - last.t) / (LASTS * speed) : 2;
      ring.toggleAttribute("hidden", age > 1);
      if (age > 1) continue;
      place(ring, scene.place(last.at));
      ring.setAttribute("r", (1 + 4 * age) * scene.u);
      ring.style.opacity = 1 - age;
    }
  };
  return { node, update };
}
