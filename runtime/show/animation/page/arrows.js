// Arrows of applied forces, reactions and torques, in px above the machine, with body and point.

import { columnOf } from "./labels.js";
import { mixed } from "./poses.js";
import { roundArrow, svg, withUnit } from "./signs.js";

const LONGEST = 0.17; // of the smaller side of the picture, for the largest force of all runs
const COMMON = 0.98; // of the instants of an arrow have no larger force than that which sets the scale
const CAP = 1.5; // impacts may exceed it; their arrows are cut, and have two strokes across
const ROUND = 24; // px, radius of a torque's arrow
const CUT = 5; // px, half length of the strokes across an arrow that is cut

/** The arrows of a scene: {node, largest, update(camera, shown …)}; `largest` may be set. */
export function drawArrows(scene) {
  const node = svg("g", { class: "arrows" });
  const arrows = scene.run.arrows.map((row) => {
    const line = svg("path", { class: `arrow ${row.style}` });
    const text = svg("text", { class: `arrow-text ${row.style}` });
    const group = svg("g", { hidden: "" }, line, text);
    group.dataset.element = row.element;
    node.append(group);
    return { ...row, group, line, text };
  });
  const all = { node, largest: largestOf(scene, arrows), update };
  function update(camera, shown, chosen, withText, labels) {
    if (!(camera.width > 0 && camera.height > 0)) return; // before the page has its layout
    const length = LONGEST * Math.min(camera.width, camera.height);
    for (const arrow of arrows) {
      const { element, style, unit, label } = arrow;
      const visible = (shown[style] || chosen === element) && scene.acts(element);
      const now = arrow.value.map((values) => mixed(values, scene.at));
      const [size, largest] = [Math.hypot(...now), all.largest[unit]];
      const drawn = visible && size > 1e-9 * largest;
      arrow.group.toggleAttribute("hidden", !drawn);
      if (!drawn) continue;
      const place = draw(arrow, now, camera.toScreen(scene.place(arrow.at)), size / largest, length);
      if (withText) arrow.text.textContent = `${label}: ${withUnit(now.length > 1 ? size : now[0], unit)}`;
      labels.place(arrow, columnOf(place), withText, chosen === element);
    }
  }
  return all;
}

/** By unit the largest size of any arrow, of each its common ones: an impact does not set the scale. */
function largestOf(scene, arrows) {
  const sizes = arrows.map(() => []);
  scene.survey(() => {
    arrows.forEach(({ value, element }, k) => {
      const size = Math.hypot(...value.map((values) => mixed(values, scene.at)));
      if (scene.acts(element) && Number.isFinite(size)) sizes[k].push(size);
    });
  });
  const common = sizes.map((values) => values.toSorted((a, b) => a - b)[Math.ceil(COMMON * (values.length - 1))] ?? 0);
  const largest = (unit) => Math.max(0, ...common.filter((_, k) => arrows[k].unit === unit)) || 1;
  return { N: largest("N"), "N m": largest("N m") };
}

/** Draws an arrow whose size is `share` of the largest, and returns where its text may stand. */
function draw({ group, line }, [fx, fy], at, share, length) {
  const part = Math.min(share, CAP);
  group.classList.toggle("cut", share > CAP);
  if (fy === undefined) {
    const radius = ROUND * (0.45 + 0.55 * part);
    const cut = share > CAP ? across(radius, 0, 1, 0) : "";
    line.setAttribute("d", roundArrow(radius, -fx) + cut);
    line.setAttribute("transform", `translate(${at.x} ${at.y})`);
    return { x: at.x + radius + 4, y: at.y - radius };
  }
  const size = Math.hypot(fx, fy);
  const long = Math.max(part * length, 2);
  const [ux, uy] = [fx / size, -fy / size];
  const [x, y] = [at.x + long * ux, at.y + long * uy];
  const head = Math.min(9, 0.6 * long);
  const [bx, by] = [x - head * ux, y - head * uy];
  const [sx, sy] = [0.45 * head * uy, -0.45 * head * ux];
  const cut = share > CAP ? across(at.x + 0.6 * long * ux, at.y + 0.6 * long * uy, ux, uy) : "";
  line.setAttribute("d", `M${at.x} ${at.y}L${x} ${y}M${bx + sx} ${by + sy}L${x} ${y}L${bx - sx} ${by - sy}${cut}`);
  return { x: x + 8 * ux + (ux < 0 ? -4 : 4), y: y + 8 * uy + 4, end: ux < -0.2 };
}

/** Two strokes across a line along (ux, uy). */
function across(x, y, ux, uy) {
  const stroke = (shift) => {
    const [cx, cy] = [x + shift * ux, y + shift * uy];
    const [dx, dy] = [CUT * (0.5 * ux - uy), CUT * (0.5 * uy + ux)];
    return `M${cx - dx} ${cy - dy}L${cx + dx} ${cy + dy}`;
  };
  return stroke(-2.5) + stroke(2.5);
}
