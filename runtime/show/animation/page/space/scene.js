// A run in space as a scene: poses are {x, y, z, e}, e the four Euler parameters.

import { locate, mixed } from "../poses.js";
import { Scene as PlaneScene } from "../scene.js";

const FAR = 4; // times the machine's size that it travels, above which the view goes along
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

/** Least and largest coordinates of points in turn: [x, y, z, x, y, z]. */
function extent(points) {
  const box = [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];
  points.forEach((value, k) => {
    box[k % 3] = Math.min(box[k % 3], value);
    box[3 + (k % 3)] = Math.max(box[3 + (k % 3)], value);
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
    this.extents = this.bodies.map((_, body) => [[0, 0, 0], ...run.solids.filter((one) => one.body === body).flatMap(ends)]);
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

  /** The points of some bodies at the present instant, in turn. */
  points(bodies) {
    return [...bodies].flatMap((body) => this.extents[body].flatMap((point) => {
      const { x, y, z } = this.place({ body, x: point[0], y: point[1], z: point[2] });
      return this.bodies[body].fixed && !point.some(Boolean) ? [] : [x, y, z];
    })).filter(Number.isFinite);
  }

  /** The bodies that fly away: they leave those that are held by more than the machine's size. */
  get away() {
    const [near, away] = [[], new Set()];
    this.survey(() => include(near, this.points(this.held)));
    const box = extent(near);
    this.survey(() => this.poses.forEach(({ x, y, z }, body) => {
      const far = Math.max(...[x, y, z].map((value, k) => Math.max(box[k] - value, value - box[k + 3])));
      if (!this.held.has(body) && far > this.size) away.add(body);
    }));
    return away;
  }

  /** Points of the machine and of all of the run; and whether it travels so far that the view goes along. */
  get view() {
    const [machine, whole, around] = [[], [], []];
    const { away, middle } = this;
    const every = this.bodies.map((_, body) => body);
    this.survey(() => {
      const now = this.points(every.filter((body) => this.held.has(body) || !away.has(body)));
      const shift = ["x", "y", "z"].map((c) => middle[c] - this.middle[c]);
      include(machine, now);
      include(around, now.map((value, k) => value + shift[k % 3]));
      include(whole, this.points(every));
    });
    const reach = (points) => Math.max(...extent(points).slice(3).map((high, k) => high - extent(points)[k]));
    const follows = reach(machine) > FAR * Math.max(reach(around), this.size);
    return { machine: follows ? around : machine, whole, follows };
  }
}

/** The middle of a solid and the ends of its three axes, in its body. */
function ends({ matrix: m }) {
  const middle = [m[3], m[7], m[11]];
  return [0, 1, 2].flatMap((axis) => [1, -1].map((sign) => middle.map((value, k) => value + sign * m[4 * k + axis])));
}
