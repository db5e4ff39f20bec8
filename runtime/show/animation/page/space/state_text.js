// A text of the present state in space for screen readers, told when that of the plane is.

import { mixed } from "../poses.js";
import { short } from "../signs.js";
import { tellState as tellPlaneState } from "../state_text.js";

const ROUNDING = 1e-9; // of 1, or of the machine's size: what is nearer to 0 is told as 0

const told = (value, size) => short(Math.abs(value) < ROUNDING * size ? 0 : value);

/** A body as the text of the plane has it, "NAME at x, y, angle": z and the axis stand by its name. */
function planar(body, scene) {
  if (body.fixed) return body;
  const { e } = scene.poses[scene.bodies.indexOf(body)];
  const [size, sign] = [Math.hypot(e[1], e[2], e[3]), e[0] < 0 ? -1 : 1];
  const axis = e.slice(1).map((value) => told(size ? (sign * value) / size : 0, 1));
  const { unit } = scene.run;
  const z = told(mixed(body.pose[2], scene.at) * unit, scene.size * unit);
  const angle = new Proxy([], { get: () => 2 * Math.atan2(size, sign * e[0]) });
  return { ...body, name: `${body.name} (z ${z} m, turned about ${axis.join(", ")})`, pose: [body.pose[0], body.pose[1], angle] };
}

/** Keeps a live region up to date; answers a function that tells all bodies at once. */
export function tellState(region, clock, timeline, scenes) {
  const views = scenes.map((scene) => Object.create(scene, {
    bodies: { get: () => scene.bodies.map((body) => planar(body, scene)) },
  }));
  return tellPlaneState(region, clock, timeline, views);
}
