// A run as a scene: where its bodies are at one instant, and what acts then.

import { inWorld, locate, mixed, pairs, poseOf, summed } from "./poses.js";

const SURVEYED = 240; // instants at which extents are taken
const LARGEST_TURN = 0.3; // rad between samples, above which the nearer one is shown

/** The largest turn of a body from each sample to the next, rad. */
function turnsBetween(bodies, count) {
  return Float64Array.from({ length: Math.max(count - 1, 1) }, (_, k) =>
    bodies.reduce((largest, { pose: [, , phi] }) => Math.max(largest, Math.abs(phi[k + 1] - phi[k]) || 0), 0),
  );
}

/** The scene of a run, in its unit of length; `show(t)` brings poses to an instant. */
export class Scene {
  constructor(run) {
    this.run = run;
    this.size = run.size;
    this.u = run.pin;
    this.times = summed(...run.t);
    this.bodies = run.bodies.map(({ pose: [x, y, ...turn], outlines, ...body }) => ({
      ...body,
      outlines: outlines.map(pairs),
      pose: [x, y, summed(...turn)],
    }));
    this.strokes = run.strokes.map((stroke) => ({ ...stroke, corners: pairs(stroke.points) }));
    this.turns = turnsBetween(this.bodies, this.times.length);
    this.largestTurn = this.turns.reduce((largest, turn) => Math.max(largest, turn), 0);
    const { symbols } = run;
    this.kinds = Object.fromEntries([...symbols, ...run.arrows].map(({ element, kind }) => [element, kind]));
    this.links = symbols.filter(({ lines }) => lines);
    this.drives = symbols.filter(({ shape }) => shape === "drive");
    this.traces = symbols.filter(({ path }) => path);
    const named = symbols.filter(({ role, shape, at }) => at && (role === "joint" || shape === "trace"));
    this.names = [...new Map(named.toReversed().map((one) => [one.element, one])).values()].toReversed();
    this.joints = symbols.filter(({ shape }) => shape === "reaction").length;
    this.gravity = symbols.find(({ gravity }) => gravity)?.gravity;
    this.byName = new Map(run.series.map((one) => [one.name, one]));
    this.show(this.start);
  }

  get start() {
    return this.times[0];
  }

  get end() {
    return this.times.at(-1);
  }

  show(t) {
    this.t = t;
    this.at = locate(this.times, t);
    if (this.turns[this.at.low] > LARGEST_TURN) this.at.share = Math.round(this.at.share);
    this.poses = this.bodies.map(({ pose }) => poseOf(pose, this.at));
  }

  /** A place of a body, or a path, at the present instant. */
  place(place) {
    if (!place.path) return inWorld(this.poses, place);
    const [x, y] = place.path.map((values) => mixed(values, this.at));
    return { x, y };
  }

  /** Whether an element that comes and goes acts at the present instant. */
  acts(element) {
    return this.run.acts[element]?.some(([from, to]) => from <= this.t && this.t < to) ?? true;
  }

  /** Whether bodies turn so fast that samples are shown and nothing between them. */
  get isCoarse() {
    return this.largestTurn > LARGEST_TURN;
  }

  /** Calls a function at some instants of the run, and goes back to the present one. */
  survey(look) {
    const { t } = this;
    const step = Math.max(1, Math.floor(this.times.length / SURVEYED));
    for (let k = 0; k < this.times.length; k += step) {
      this.show(this.times[k]);
      look();
    }
    this.show(t);
  }

  /**
   * All points that are to be seen over the run: [x least, y least, x largest, y largest]; within a
   * limit of this form, if any, beyond which points have flown away.
   */
  extent(limit) {
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    this.survey(() => this.enlarge(box, limit));
    return box.every(Number.isFinite) ? box : [-1, -1, 1, 1];
  }

  /** Where the machine is at first, and its size round that. */
  get first() {
    const [left, bottom, right, top] = this.enlarge([Infinity, Infinity, -Infinity, -Infinity]);
    return [left - this.size, bottom - this.size, right + this.size, top + this.size];
  }

  /** Enlarges a box by all points at the present instant. */
  enlarge(box, limit) {
    const add = ({ x, y }, margin = 0) => {
      if (limit && (x < limit[0] || y < limit[1] || x > limit[2] || y > limit[3])) return;
      box[0] = Math.min(box[0], x - margin);
      box[1] = Math.min(box[1], y - margin);
      box[2] = Math.max(box[2], x + margin);
      box[3] = Math.max(box[3], y + margin);
    };
    this.bodies.forEach(({ outlines }, body) => {
      for (const point of outlines.flat()) add(this.place({ body, ...point }));
    });
    for (const { body, corners, shift } of this.strokes) {
      const frame = shift && [poseOf(shift, this.at)];
      for (const point of corners) add(this.place({ ...(frame ? inWorld(frame, { body: 0, ...point }) : point), body }));
    }
    const { links, names, drives, traces } = this;
    const places = [...links.flatMap(({ i, j }) => [i, j]), ...[...names, ...drives, ...traces].map(({ at }) => at)];
    for (const place of places) add(this.place(place), 3 * this.u);
    return box;
  }

  /** The number of a body's colour; the ground has none. */
  number(body) {
    return this.bodies[body].fixed ? "ground" : (body - 1) % 7;
  }
}
