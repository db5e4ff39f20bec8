// A run as a scene: its bodies and symbols at one instant, and what holds over all instants.

import { placesOf } from "./strokes.js";
import { angles, inWorld, instants, locate, poseOf, refresh, shiftOf } from "./poses.js";

const SURVEYED = 240; // instants at which extents are taken
const LENGTHS = new Set(["x", "y", "radius", "radius_i", "radius_j", "clearance", "gap"]);
const LARGEST_TURN = 0.3; // rad between samples, above which the nearer one is shown

function pairs(numbers, unit) {
  return Array.from({ length: numbers.length / 2 }, (_, k) => ({ x: numbers[2 * k] / unit, y: numbers[2 * k + 1] / unit }));
}

/** The unit of length of a scene, m: browsers paint nothing whose lengths are 1e-6 or 1e6. */
function unitFor(size) {
  return size >= 0.1 && size <= 100 ? 1 : 10 ** Math.round(Math.log10(size));
}

/** A shape whose places and lengths are in another unit. */
function rescaled(value, unit, name = "") {
  if (typeof value === "number") return LENGTHS.has(name) ? value / unit : value;
  if (Array.isArray(value)) return value.map((part) => rescaled(part, unit));
  if (!value || typeof value !== "object") return value;
  return Object.fromEntries(Object.entries(value).map(([key, part]) => [key, rescaled(part, unit, key)]));
}

function divided(values, unit) {
  return unit === 1 ? values : Float64Array.from(values, (value) => value / unit);
}

function poseArrays([x, y, wrapped, turns], arrays, unit) {
  return [divided(arrays[x], unit), divided(arrays[y], unit), angles(arrays[wrapped], arrays[turns])];
}

/** The largest turn of a body from each sample to the next, rad. */
function turnsBetween(bodies, count) {
  return Float64Array.from({ length: Math.max(count - 1, 1) }, (_, k) =>
    bodies.reduce((largest, { pose: [, , phi] }) => Math.max(largest, Math.abs(phi[k + 1] - phi[k]) || 0), 0),
  );
}

/** Spans of time whose bounds are those of samples, which have 48 bits; the last one has no end. */
function spans(acts, times) {
  const end = times.at(-1);
  const close = 1e-12 * Math.max(Math.abs(times[0]), Math.abs(end));
  return acts.map(([from, to]) => [from - close, to >= end - close ? Infinity : to - close]);
}

/** The scene of a run; `show(t)` brings poses and moving numbers to an instant. */
export class Scene {
  constructor(run, arrays, size = run.size) {
    this.run = run;
    this.unit = unitFor(size); // m, the same for all runs of a machine; all lengths of the scene are in it
    const { unit } = this;
    this.size = run.size / unit;
    this.u = 0.0115 * this.size; // the radius of a pin
    this.times = instants(arrays[run.t[0]], arrays[run.t[1]]);
    this.bodies = run.bodies.map((body) => ({
      ...body,
      outlines: body.outlines.map((line) => line.map((corner) => corner.map((value) => value / unit))),
      pose: poseArrays(body.pose, arrays, unit),
    }));
    this.turns = turnsBetween(this.bodies, this.times.length);
    this.largestTurn = this.turns.reduce((largest, turn) => Math.max(largest, turn), 0);
    this.symbols = run.symbols.map((symbol) => ({
      ...symbol,
      shape: rescaled(symbol.shape, unit),
      ...(symbol.acts && { acts: spans(symbol.acts, this.times) }),
      moving: symbol.moving.map(({ path, values }) => ({
        path,
        values: LENGTHS.has(path.at(-1)) ? divided(arrays[values], unit) : arrays[values],
      })),
    }));
    this.strokes = run.strokes.map((stroke) => ({
      ...stroke,
      points: pairs(arrays[stroke.points], unit),
      shift: stroke.shift?.map((k, part) => (part < 2 ? divided(arrays[k], unit) : arrays[k])),
    }));
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
    if (this.turns[this.at.low] > LARGEST_TURN) this.at.share = Math.round(this.at.share);
    this.poses = this.bodies.map((body) => poseOf(body, this.at));
    for (const symbol of this.symbols) if (symbol.moving.length) refresh(symbol, this.at);
  }

  /** Whether bodies turn so fast that samples are shown and nothing between them. */
  get isCoarse() {
    return this.largestTurn > LARGEST_TURN;
  }

  /** The number of a body's colour; the ground has none. */
  number(body) {
    return this.bodies[body].fixed ? "ground" : (body - 1) % 7;
  }

  /** Calls a function at some instants of the run, and goes back to the present one. */
  survey(look) {
    const { t } = this;
    const step = Math.max(1, Math.floor(this.times.length / SURVEYED));
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
   * All points that are to be seen over the run: [x least, y least, x largest, y largest], in units; with
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
      for (const { body, points, shift } of this.strokes) {
        const frame = shift ? [shiftOf(shift, this.at)] : [];
        for (const point of points) {
          const place = frame.length ? inWorld(frame, { body: 0, ...point }) : point;
          add(inWorld(this.poses, { ...place, body }));
        }
      }
      for (const { shape } of this.symbols) {
        if (["force", "opposite force", "torque", "reaction", "gravity"].includes(shape.kind)) continue;
        for (const spot of placesOf(shape)) add(inWorld(this.poses, spot), 3 * this.u);
      }
    };
    if (near === null) look();
    else this.survey(look);
    return box.every(Number.isFinite) ? box : [-1, -1, 1, 1];
  }
}
