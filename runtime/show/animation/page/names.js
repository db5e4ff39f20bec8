// Names of joints beside their symbols, in px above the machine.

import { placesOf } from "./strokes.js";
import { acts, inWorld } from "./poses.js";
import { svg } from "./signs.js";

const BESIDE = 0.9; // of the size of a pin, in both directions

/** The names of a scene: {node, update(camera)}. */
export function drawNames(scene) {
  const node = svg("g", { class: "names" });
  const named = new Map();
  for (const symbol of scene.symbols) {
    const [spot] = symbol.role === "joint" ? placesOf(symbol.shape).toReversed() : [];
    if (!spot || named.has(symbol.element) || symbol.shape.kind === "reaction") continue;
    const text = svg("text");
    text.textContent = symbol.element;
    node.append(text);
    named.set(symbol.element, { symbol, spot, text });
  }
  const update = (camera) => {
    const beside = BESIDE * scene.u * camera.scale + 5;
    for (const { symbol, spot, text } of named.values()) {
      const at = camera.toScreen(inWorld(scene.poses, spot));
      text.toggleAttribute("hidden", !acts(symbol, scene.t));
      text.setAttribute("x", at.x + beside);
      text.setAttribute("y", at.y - beside);
    }
  };
  return { node, update };
}
