// A text of the present state for screen readers: polite, at rest after a moment, in motion seldom.

import { mixed } from "./poses.js";
import { short } from "./signs.js";

const MAX_BODIES = 8; // that are told unasked
const AT_REST = 500; // ms without a change, after which the state is told
const IN_MOTION = 6000; // ms between two texts while it plays

/** Where the bodies of a scene are, in a sentence. */
export function stateOf(scene, all = false) {
  const moving = scene.bodies.filter(({ fixed }) => !fixed);
  const told = all ? moving : moving.slice(0, MAX_BODIES);
  const more = moving.length - told.length;
  const texts = told.map(({ name, pose }) => {
    const { unit } = scene.run;
    const [x, y, phi] = pose.map((values, k) => short(mixed(values, scene.at) * (k < 2 ? unit : 1)));
    return `${name} at x ${x} m, y ${y} m, angle ${phi} rad`;
  });
  return [...texts, ...(more ? [`and ${more} more bodies, which the key i tells`] : [])].join("; ");
}

/** Keeps a live region up to date; answers a function that tells all bodies at once. */
export function tellState(region, clock, timeline, scenes) {
  let timer;
  let last = 0;
  const tell = (all = false) => {
    last = performance.now();
    const event = timeline.latest;
    const runs = scenes.map((scene) => (scenes.length > 1 ? `${scene.run.label}: ` : "") + stateOf(scene, all));
    const where = `${clock.playing ? "Playing" : "Paused"} at ${timeline.instant(clock.t)} of ${timeline.instant(clock.end)} seconds.`;
    region.textContent = [where, `${runs.join(". ")}.`, event ? `Last event: ${timeline.words(event)}.` : ""].join(" ");
  };
  clock.onTick(() => {
    if (clock.playing && performance.now() - last < IN_MOTION) return;
    clearTimeout(timer);
    if (clock.playing) tell();
    else timer = setTimeout(() => tell(), AT_REST);
  });
  tell();
  return () => {
    clearTimeout(timer);
    tell(true);
  };
}
