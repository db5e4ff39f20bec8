// The symbols between bodies, drawn anew at each instant: springs, rods, belts; and drivers' signs.

import { inWorld } from "./poses.js";
import { place, roundArrow, svg } from "./signs.js";
import { beltSymbol, rodSymbol, spiralSymbol, springSymbol } from "./springs.js";

function driveSymbol(shape, scene) {
  const { u } = scene;
  const line = shape.turns ? roundArrow(3.4 * u, 1) : `M0 0H${7 * u}M${5.6 * u} ${1.1 * u}L${7 * u} 0L${5.6 * u} ${-1.1 * u}`;
  const node = svg("path", { class: "drive", d: line });
  const update = () => {
    const angle = shape.turns ? 0 : (shape.i ? scene.poses[shape.i.body].phi : 0) + Math.atan2(shape.uy, shape.ux);
    place(node, inWorld(scene.poses, shape.j), angle);
  };
  return { node, update };
}

const SYMBOLS = {
  rod: rodSymbol,
  spring: springSymbol,
  "spiral spring": spiralSymbol,
  belt: beltSymbol,
  drive: driveSymbol,
};

/** The node of a symbol and its update; nothing for what is drawn elsewhere. */
export function drawSymbol(symbol, scene) {
  const make = SYMBOLS[symbol.shape.kind];
  if (!make) return null;
  const drawn = make(symbol.shape, scene, symbol.lines);
  drawn.node.classList.add("symbol");
  drawn.node.dataset.element = symbol.element;
  drawn.node.append(svg("title", {}, `${symbol.element}, ${symbol.type}`));
  return drawn;
}
