// A run as a scene: its bodies and symbols at one instant, and what holds over all instants.

import { placesOf } from "./bodies.js";
import { inWorld, instants, locate, poseOf, refresh } from "./poses.js";

const LOOKS = 240; // instants at which extents are taken

/** The scene of a run; `show(t)` brings poses and moving numbers to an instant. */
export class Scene {
  constructor(run, arrays) {
    this.run = run;
    this.size = run.size;
    this.u = 0.016 * run.size;
    this.times = instants(arrays[run.t[0]], arrays[run.t[1]]);
    this.bodies = run.bodies.map((body) => ({ ...body, pose: body.pose.map((k) => arrays[k]) }));
    this.symbols = run.symbols.map((symbol) => ({
      ...symbol,
      moving: symbol.moving.map(({ path, values }) => ({ path, values: arrays[values] })),
    }));
    this.series = run.series.map((one) => ({ ...one, values: arrays[one.values] }));
    this.byName = new Map(this.series.map((one) => [one.name, one]));
    this.mesh();
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
    if (this.bodies[body].fixed) return "ground";
    return this.bodies.slice(0, body).filter(({ fixed }) => !fixed).length % 7;
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

  /** How far place j moves along (ux, uy) of body i from place i: [least, largest], m. */
  travel(shape) {
    const span = [Infinity, -Infinity];
    const size = Math.hypot(shape.ux, shape.uy) || 1;
    this.survey(() => {
      const [from, to] = [inWorld(this.poses, shape.i), inWorld(this.poses, shape.j)];
      const { c, s } = this.poses[shape.i.body];
      const [dx, dy] = [to.x - from.x, to.y - from.y];
      const along = ((c * dx + s * dy) * shape.ux + (c * dy - s * dx) * shape.uy) / size;
      span[0] = Math.min(span[0], along);
      span[1] = Math.max(span[1], along);
    });
    return span;
  }

  /** How long the line of a rack is: as far as the wheels of its element come, [from, to], m. */
  reach(shape) {
    const wheels = this.symbols.filter(
      (other) => other.shape.kind === "wheel" && this.sameElement(other.shape, shape),
    );
    const span = [-0.3 * this.size, 0.3 * this.size];
    for (const { shape: wheel } of wheels) {
      const [from, to] = this.travel({ ...shape, j: wheel.center });
      span[0] = Math.min(span[0], from - wheel.radius);
      span[1] = Math.max(span[1], to + wheel.radius);
    }
    return span;
  }

  sameElement(one, other) {
    const owner = (shape) => this.symbols.find((symbol) => symbol.shape === shape)?.element;
    return owner(one) === owner(other);
  }

  /** Number and phase of teeth of all wheels, so that wheels of one element mesh at the start. */
  mesh() {
    const wheels = this.symbols.filter(({ shape }) => shape.kind === "wheel" && shape.toothed);
    this.wheels = new Map();
    if (!wheels.length) return;
    this.pitch = (2 * Math.PI * Math.min(...wheels.map(({ shape }) => shape.radius))) / 14;
    this.at = locate(this.times, this.times[0]);
    this.poses = this.bodies.map((body) => poseOf(body, this.at));
    for (const { element, shape } of wheels) {
      const key = wheelKey(shape);
      if (this.wheels.has(key)) continue;
      const count = Math.max(8, Math.round((2 * Math.PI * shape.radius) / this.pitch));
      const mate = wheels.find(
        (other) => other.element === element && other.shape !== shape && this.wheels.has(wheelKey(other.shape)),
      );
      const phase = mate ? this.meshing(shape, count, mate.shape) : 0;
      this.wheels.set(key, { count, phase });
    }
  }

  /** The phase at which a gap of a wheel faces a tooth of its mate, or a tooth one of a ring. */
  meshing(shape, count, mate) {
    const other = this.wheels.get(wheelKey(mate));
    const [own, its] = [inWorld(this.poses, shape.center), inWorld(this.poses, mate.center)];
    const ring = shape.internal || mate.internal;
    const out = Math.atan2(own.y - its.y, own.x - its.x);
    const angle = mate.internal ? out : ring ? out + Math.PI : out;
    const facing = ring ? angle : out + Math.PI;
    const turned = (angle - this.poses[mate.center.body].phi - other.phase) * (other.count / (2 * Math.PI));
    const share = turned - Math.floor(turned);
    const shift = ring ? share : 0.5 - share;
    return facing - this.poses[shape.center.body].phi - (shift * 2 * Math.PI) / count;
  }

  teeth(shape) {
    return this.wheels.get(wheelKey(shape));
  }

  /** All points that are to be seen over the run: [x least, y least, x largest, y largest], m. */
  extent() {
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    const add = ({ x, y }, margin = 0) => {
      box[0] = Math.min(box[0], x - margin);
      box[1] = Math.min(box[1], y - margin);
      box[2] = Math.max(box[2], x + margin);
      box[3] = Math.max(box[3], y + margin);
    };
    this.survey(() => {
      this.bodies.forEach(({ outlines }, body) => {
        for (const [x, y] of outlines.flat()) add(inWorld(this.poses, { body, x, y }));
      });
      for (const { shape } of this.symbols) {
        if (["force", "torque", "reaction", "gravity"].includes(shape.kind)) continue;
        const margin = shape.kind === "wheel" ? shape.radius : 3 * this.u;
        for (const spot of placesOf(shape)) add(inWorld(this.poses, spot), margin);
        for (const spot of shape.curve ?? []) add(inWorld(this.poses, spot));
      }
    });
    return box.every(Number.isFinite) ? box : [-1, -1, 1, 1];
  }
}

function wheelKey({ center, radius }) {
  return [center.body, center.x.toPrecision(9), center.y.toPrecision(9), radius.toPrecision(9)].join();
}
