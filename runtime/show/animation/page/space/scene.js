// A run in space as a scene: poses are {x, y, z, e}, e the four Euler parameters.

import { locate, mixed } from "../poses.js";
import { Scene as PlaneScene } from "../scene.js";

const FAR = 4; // times the machine's size that it travels, above which the view goes along
const RARELY = 3; // of the surveyed instants one gives points to the view
const LARGEST_TURN = 0.3; // rad between samples, above which the nearer one is shown

/** A list of points in turn, without one: what a view has to show. */
export function empty() {
  return [];
}

/** Adds the points of another list. */
export function include(points, others) {
  for (const value of others) points.push(value);
}

/** A vector of a body {e} in global axes. */
export function turned([e0, e1, e2, e3], [x, y, z]) {
  const [tx, ty, tz] = [2 * (e2 * z - e3 * y), 2 * (e3 * x - e1 * z), 2 * (e1 * y - e2 * x)];
  return [x + e0 * tx + e2 * tz - e3 * ty, y + e0 * ty + e3 * tx - e1 * tz, z + e0 * tz + e1 * ty - e2 * tx];
}

/** Euler parameters between two samples; p and -p are the same attitude. */
function attitude(arrays, { low, high, share }) {
  const [a, b] = [low, high].map((k) => arrays.map((values) => values[k]));
  const sign = a.reduce((sum, value, k) => sum + value * b[k], 0) < 0 ? -1 : 1;
  const e = a.map((value, k) => value + share * (sign * b[k] - value));
  const size = Math.hypot(...e) || 1;
  return e.map((value) => value / size);
}

/** The largest turn of a body from each sample to the next, rad. */
function turnsBetween(bodies, count) {
  const turn = (e, k) => 2 * Math.acos(Math.min(1, Math.abs(e.reduce((sum, one) => sum + one[k] * one[k + 1], 0))));
  return Float64Array.from({ length: Math.max(count - 1, 1) }, (_, k) =>
    bodies.reduce((largest, { turn: e }) => Math.max(largest, turn(e, k) || 0), 0));
}

/** Least and largest coordinates of points in turn: [[x, y, z], [x, y, z]]. */
export function extent(points) {
  const box = [Infinity, -Infinity].map((value) => [value, value, value]);
  points.forEach((value, k) => {
    box[0][k % 3] = Math.min(box[0][k % 3], value);
    box[1][k % 3] = Math.max(box[1][k % 3], value);
  });
  return box;
}

/** The scene of a run, in its unit of length; `show(t)` brings poses to an instant. */
export class Scene extends PlaneScene {
  constructor(run) {
    super(run);
    this.joints = run.symbols.filter(({ shape }) => shape === "wrench").length;
    this.turns = turnsBetween(this.bodies, this.times.length);
    this.largestTurn = this.turns.reduce((largest, turn) => Math.max(largest, turn), 0);
    this.corners = this.bodies.map(({ fixed }, body) => {
      const own = run.solids.filter((one) => one.body === body).map(ends);
      return fixed ? own.flatMap(corners) : corners(own.flat());
    });
    this.show(this.start);
  }

  show(t) {
    this.t = t;
    this.at = locate(this.times, t);
    if (this.turns[this.at.low] > LARGEST_TURN) this.at.share = Math.round(this.at.share);
    this.poses = this.bodies.map(({ pose, turn }) => {
      const [x, y, z] = pose.map((values) => mixed(values, this.at));
      return { x, y, z, e: attitude(turn, this.at) };
    });
  }

  /** A place of a body, or a path, at the present instant. */
  place(place) {
    if (place.path) {
      const [x, y, z] = place.path.map((values) => mixed(values, this.at));
      return { x, y, z };
    }
    const pose = this.poses[place.body];
    const [x, y, z] = turned(pose.e, [place.x, place.y, place.z]);
    return { x: pose.x + x, y: pose.y + y, z: pose.z + z };
  }

  /** The middle of the bodies that are held, at the present instant. */
  get middle() {
    const moving = [...this.held].filter((body) => !this.bodies[body].fixed);
    const mean = (c) => moving.reduce((sum, body) => sum + this.poses[body][c], 0) / Math.max(moving.length, 1);
    return { x: mean("x"), y: mean("y"), z: mean("z") };
  }

  /** The corners of boxes about some bodies at the present instant, in turn. */
  points(bodies) {
    return [...bodies].flatMap((body) => this.corners[body].flatMap(([x, y, z]) => {
      const at = this.place({ body, x, y, z });
      return Number.isFinite(at.x + at.y + at.z) ? [at.x, at.y, at.z] : [];
    }));
  }

  /** Points of the bodies that are held and of all; and whether they travel so far that the view goes along. */
  get view() {
    const [machine, whole, around] = [[], [], []];
    const { middle } = this;
    let count = 0;
    this.survey(() => {
      count += 1;
      if (count % RARELY !== 1) return;
      const now = this.points(this.held);
      const shift = ["x", "y", "z"].map((c) => middle[c] - this.middle[c]);
      include(machine, now);
      include(around, now.map((value, k) => value + shift[k % 3]));
      include(whole, this.points(this.bodies.keys()));
    });
    const [far, near] = [machine, around].map(extent).map(([low, high]) => Math.max(...high.map((value, k) => value - low[k])));
    const follows = far > FAR * Math.max(near, this.size);
    return { machine: follows ? around : machine, whole, follows };
  }
}

/** The corners of a solid in its body, or the ends of its axes, in turn. */
function ends({ corners: own, matrix: m }) {
  if (own) return [...own];
  return [0, 1, 2].flatMap((axis) => [1, -1].flatMap((sign) => [0, 4, 8].map((row) => m[row + 3] + sign * m[row + axis])));
}

/** The corners of the box about points in turn; none without a point. */
function corners(points) {
  const box = extent(points);
  const numbers = points.length ? [0, 1, 2, 3, 4, 5, 6, 7] : [];
  return numbers.map((number) => [0, 1, 2].map((k) => box[(number >> k) & 1][k]));
}
