// Paths of tracked points: the whole path pale, the last part of it strong, and the point itself.

import { place, svg, through } from "./signs.js";

const TAIL = 90; // samples of the strong part

/** The traces of a scene, each {node, update}. */
export function drawTraces(scene) {
  return scene.traces.map(({ element, at, path: [x, y] }) => {
    const points = Array.from(x, (value, k) => ({ x: value, y: y[k] }));
    const tail = svg("path", { class: "tail" });
    const dot = svg("circle", { class: "traced", r: 0.5 * scene.u });
    const whole = svg("path", { class: "trace", d: through(points) });
    const node = svg("g", {}, svg("title", {}, `path of ${element}`), whole, tail, dot);
    const update = () => {
      const now = scene.place(at);
      tail.setAttribute("d", through([...points.slice(Math.max(0, scene.at.low - TAIL), scene.at.low + 1), now]));
      place(dot, now);
    };
    return { node, update };
  });
}
