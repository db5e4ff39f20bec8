// Names of joints and of tracked points beside their symbols, in px above the machine.

import { cornersOf } from "./labels.js";
import { acts, inWorld } from "./poses.js";
import { svg } from "./signs.js";
import { placesOf } from "./strokes.js";

const BESIDE = 0.9; // of the size of a pin, in both directions

/** The names of a scene: {node, update(camera, labels, anew)}. */
export function drawNames(scene) {
  const node = svg("g", { class: "names" });
  const named = new Map();
  for (const symbol of scene.symbols) {
    const isNamed = symbol.role === "joint" || symbol.shape.kind === "trace";
    const [place] = isNamed ? placesOf(symbol.shape).toReversed() : [];
    if (!place || named.has(symbol.element) || symbol.shape.kind === "reaction") continue;
    const text = svg("text");
    text.textContent = symbol.element;
    node.append(text);
    named.set(symbol.element, { symbol, place, text });
  }
  const update = (camera, labels, anew) => {
    const beside = BESIDE * scene.u * camera.scale + 5;
    for (const entry of named.values()) {
      if (!acts(entry.symbol, scene.t)) entry.text.setAttribute("hidden", "");
      else labels.place(entry, cornersOf(camera.toScreen(inWorld(scene.poses, entry.place)), beside), anew);
    }
  };
  return { node, update };
}
