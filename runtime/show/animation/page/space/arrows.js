// Arrows of forces and torques in space: as long as they look from where they are seen.

import { drawArrows as drawPlaneArrows } from "../arrows.js";
import { columnOf } from "../labels.js";
import { mixed } from "../poses.js";
import { withUnit } from "../signs.js";

const LONGEST = 0.17; // of the smaller side of the picture, for the largest force of all runs
const CAP = 1.5; // impacts may exceed it
const HEAD = 9; // px

/** The arrows of a scene: {node, largest, update(camera, shown …)}, as in the plane. */
export function drawArrows(scene) {
  const { node, largest } = drawPlaneArrows(scene);
  const arrows = scene.run.arrows.map((row, k) => {
    const group = node.children[k];
    return { ...row, group, line: group.firstChild, text: group.lastChild };
  });
  const { symbols } = scene.run;
  const joints = new Set(symbols.filter(({ role, ties }) => role === "joint" && ties).map(({ element }) => element));
  const all = { node, largest, update };
  function update(camera, shown, chosen, withText, labels) {
    if (!(camera.width > 0 && camera.height > 0)) return; // before the page has its layout
    const length = LONGEST * Math.min(camera.width, camera.height);
    for (const arrow of arrows) {
      const { element, style, unit, label } = arrow;
      const held = style === "torque" && joints.has(element); // a reaction, too
      const visible = ((shown[style] && (!held || shown.reaction)) || chosen === element) && scene.acts(element);
      const now = arrow.value.map((values) => mixed(values, scene.at));
      const size = Math.hypot(...now);
      const drawn = visible && size > 1e-9 * all.largest[unit];
      arrow.group.toggleAttribute("hidden", !drawn);
      if (!drawn) continue;
      const share = size / all.largest[unit];
      arrow.group.classList.toggle("cut", share > CAP);
      const { x, y } = camera.flat({ x: now[0], y: now[1], z: now[2] });
      const long = (Math.min(share, CAP) * length) / size;
      const place = draw(arrow, camera.toScreen(scene.place(arrow.at)), long * x, -long * y, share > CAP);
      if (withText) arrow.text.textContent = `${label}: ${withUnit(size, unit)}`;
      labels.place(arrow, columnOf(place), withText, chosen === element);
    }
  }
  return all;
}

/** Draws an arrow from a place by (dx, dy) px, a torque with two heads; returns where its text may stand. */
function draw({ line, style }, at, dx, dy, cut) {
  const long = Math.max(Math.hypot(dx, dy), 2);
  const [ux, uy, head] = [dx / long, dy / long, Math.min(HEAD, 0.6 * long)];
  const on = (far, aside = 0) => `${at.x + far * ux - aside * uy} ${at.y + far * uy + aside * ux}`;
  const wings = (far, wide = 0.45) => `M${on(far - head, wide * head)}L${on(far)}L${on(far - head, -wide * head)}`;
  const more = (cut ? wings(0.5 * long, 1) + wings(0.6 * long, 1) : "") + (style === "torque" ? wings(long - 0.7 * head) : "");
  line.setAttribute("d", `M${on(0)}L${on(long)}${wings(long)}${more}`);
  return { x: at.x + (long + 8) * ux + (ux < 0 ? -4 : 4), y: at.y + (long + 8) * uy + 4, end: ux < -0.2 };
}
