// A text of the present state for screen readers: polite, at rest after a moment, in motion seldom.

import { mixed } from "./poses.js";
import { short } from "./signs.js";

const MOST = 8; // bodies that are told
const AT_REST = 500; // ms without a change, after which the state is told
const IN_MOTION = 6000; // ms between two texts while it plays

/** Where the bodies of a scene are, in a sentence. */
export function stateOf(scene) {
  const told = scene.bodies.filter(({ fixed }) => !fixed).slice(0, MOST);
  return told.map(({ name, pose }) => {
    const [x, y, phi] = pose.map((values) => short(mixed(values, scene.at)));
    return `${name} at x ${x} m, y ${y} m, angle ${phi} rad`;
  }).join("; ");
}

/** Keeps a live region up to date. */
export function tellState(region, clock, timeline, scenes) {
  let timer;
  let last = 0;
  const tell = () => {
    last = performance.now();
    const event = timeline.latest;
    const runs = scenes.map((scene) => (scenes.length > 1 ? `${scene.run.label}: ` : "") + stateOf(scene));
    const where = `${clock.playing ? "Playing" : "Paused"} at ${short(clock.t)} of ${short(clock.end)} seconds.`;
    region.textContent = [where, `${runs.join(". ")}.`, event ? `Last event: ${timeline.words(event)}.` : ""].join(" ");
  };
  clock.onTick(() => {
    if (clock.playing && performance.now() - last < IN_MOTION) return;
    clearTimeout(timer);
    if (clock.playing) tell();
    else timer = setTimeout(tell, AT_REST);
  });
  tell();
}
