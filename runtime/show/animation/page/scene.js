// A run as a scene: its bodies and symbols at one instant, and what holds over all instants.

import { placesOf } from "./strokes.js";
import { inWorld, instants, locate, poseOf, refresh } from "./poses.js";

const LOOKS = 240; // instants at which extents are taken

function pairs(numbers) {
  return Array.from({ length: numbers.length / 2 }, (_, k) => ({ x: numbers[2 * k], y: numbers[2 * k + 1] }));
}

/** The scene of a run; `show(t)` brings poses and moving numbers to an instant. */
export class Scene {
  constructor(run, arrays) {
    this.run = run;
    this.size = run.size;
    this.u = 0.0115 * run.size; // the radius of a pin
    this.times = instants(arrays[run.t[0]], arrays[run.t[1]]);
    this.bodies = run.bodies.map((body) => ({ ...body, pose: body.pose.map((k) => arrays[k]) }));
    this.symbols = run.symbols.map((symbol) => ({
      ...symbol,
      moving: symbol.moving.map(({ path, values }) => ({ path, values: arrays[values] })),
    }));
    this.strokes = run.strokes.map((stroke) => ({ ...stroke, points: pairs(arrays[stroke.points]) }));
    this.series = run.series.map((one) => ({ ...one, values: arrays[one.values] }));
    this.byName = new Map(this.series.map((one) => [one.name, one]));
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
    this.poses = this.bodies.map((body) => poseOf(body, this.at));
    for (const symbol of this.symbols) if (symbol.moving.length) refresh(symbol, this.at);
  }

  /** The number of a body's colour; the ground has none. */
  number(body) {
    return this.bodies[body].fixed ? "ground" : (body - 1) % 7;
  }

  /** Calls a function at some instants of the run, and goes back to the present one. */
  survey(look) {
    const { t } = this;
    const step = Math.max(1, Math.floor(this.times.length / LOOKS));
    for (let k = 0; k < this.times.length; k += step) {
      this.show(this.times[k]);
      look();
    }
    this.show(t ?? this.start);
  }

  /** Where the machine is at first, and its size round that. */
  get first() {
    const [left, bottom, right, top] = this.extent(null);
    return [left - this.size, bottom - this.size, right + this.size, top + this.size];
  }

  /**
   * All points that are to be seen over the run: [x least, y least, x largest, y largest], m; with
   * `near` true, without what flies away from where the machine is at first by more than its size; null: now.
   */
  extent(near) {
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    const limit = near ? this.first : null;
    const add = ({ x, y }, margin = 0) => {
      if (limit && (x < limit[0] || y < limit[1] || x > limit[2] || y > limit[3])) return;
      box[0] = Math.min(box[0], x - margin);
      box[1] = Math.min(box[1], y - margin);
      box[2] = Math.max(box[2], x + margin);
      box[3] = Math.max(box[3], y + margin);
    };
    const look = () => {
      this.bodies.forEach(({ outlines }, body) => {
        for (const [x, y] of outlines.flat()) add(inWorld(this.poses, { body, x, y }));
      });
      for (const { body, points } of this.strokes) {
        for (const { x, y } of points) add(inWorld(this.poses, { body, x, y }));
      }
      for (const { shape } of this.symbols) {
        if (["force", "torque", "reaction", "gravity"].includes(shape.kind)) continue;
        for (const spot of placesOf(shape)) add(inWorld(this.poses, spot), 3 * this.u);
      }
    };
    if (near === null) look();
    else this.survey(look);
    return box.every(Number.isFinite) ? box : [-1, -1, 1, 1];
  }
}
