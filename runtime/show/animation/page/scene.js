// A run as a scene: where its bodies are at one instant, and what acts then.

import { inWorld, locate, mixed, pairs, poseOf, summed } from "./poses.js";

const SURVEYED = 240; // instants at which extents are taken
const FAR = 4; // times the machine's size that it travels, above which the view goes along
const LARGEST_TURN = 0.3; // rad between samples, above which the nearer one is shown

/** The largest turn of a body from each sample to the next, rad. */
function turnsBetween(bodies, count) {
  return Float64Array.from({ length: Math.max(count - 1, 1) }, (_, k) =>
    bodies.reduce((largest, { pose: [, , phi] }) => Math.max(largest, Math.abs(phi[k + 1] - phi[k]) || 0), 0),
  );
}

/** A box without a point. */
export function empty() {
  return [Infinity, Infinity, -Infinity, -Infinity];
}

/** Enlarges a box by another one. */
export function include(box, other) {
  other.forEach((value, k) => {
    box[k] = k < 2 ? Math.min(box[k], value) : Math.max(box[k], value);
  });
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
    this.ties = symbols.flatMap(({ element, role, ties, lines, i, j }) => {
      const pair = (role === "joint" && ties) || (lines && [i.body ?? 0, j.body ?? 0]);
      return pair ? [{ element, pair }] : [];
    });
    this.tied = new Set(this.ties.map(({ element }) => element));
    this.gravity = symbols.find(({ gravity }) => gravity)?.gravity;
    this.byName = new Map(run.series.map((one) => [one.name, one]));
    this.show(this.start);
    this.still = { held: empty(), floor: empty() }; // boxes round lines of the ground that stand still
    this.moving = this.strokes.filter(({ body, shift }) => shift || !this.bodies[body].fixed);
    for (const { body, corners, shift, element } of this.strokes) {
      const box = this.still[this.tied.has(element) ? "held" : "floor"];
      if (this.bodies[body].fixed && !shift) for (const { x, y } of corners.map((at) => this.place({ body, ...at }))) include(box, [x, y, x, y]);
    }
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

  /** The bodies that joints and springs hold to the ground at present; all where they hold none. */
  get held() {
    const ties = this.ties.filter(({ element }) => this.acts(element));
    if (ties.length === this.heldBy?.length && ties.every((tie, k) => tie === this.heldBy[k])) return this.heldBodies;
    const every = this.bodies.map((_, body) => body);
    const bodies = new Set(every.filter((body) => this.bodies[body].fixed));
    const fixed = bodies.size;
    for (let known = 0; known < bodies.size; ) {
      known = bodies.size;
      for (const { pair } of ties) if (pair.some((body) => bodies.has(body))) pair.forEach((body) => bodies.add(body));
    }
    [this.heldBy, this.heldBodies] = [ties, bodies.size > fixed ? bodies : new Set(every)];
    return this.heldBodies;
  }

  /** The middle of the bodies that are held, at the present instant. */
  get middle() {
    const moving = [...this.held].filter((body) => !this.bodies[body].fixed);
    const mean = (c) => moving.reduce((sum, body) => sum + this.poses[body][c], 0) / Math.max(moving.length, 1);
    return { x: mean("x"), y: mean("y") };
  }

  /** The bodies that fly away: they leave those that are held by more than the machine's size. */
  get away() {
    const [near, away] = [empty(), new Set()];
    this.survey(() => this.enlarge(near, this.held));
    this.survey(() => this.poses.forEach(({ x, y }, body) => {
      const far = Math.max(near[0] - x, near[1] - y, x - near[2], y - near[3]);
      if (!this.held.has(body) && far > this.size) away.add(body);
    }));
    return away;
  }

  /**
   * Boxes [x least, y least, x largest, y largest] of the view: of the machine, of all of the run;
   * and whether the machine travels so far that the first is one to go along with its middle.
   */
  get view() {
    const [machine, whole] = [empty(), empty()];
    const [around, { x, y }] = [empty(), this.middle];
    const [away, every] = [this.away, this.bodies.map((_, body) => body)];
    this.survey(() => {
      const now = this.enlarge(empty(), new Set(every.filter((body) => this.held.has(body) || !away.has(body))));
      if (!now.every(Number.isFinite)) return;
      const { x: dx, y: dy } = this.middle;
      include(machine, now);
      include(around, [now[0] + x - dx, now[1] + y - dy, now[2] + x - dx, now[3] + y - dy]);
      include(whole, this.enlarge(empty()));
    });
    const reach = (box) => Math.max(box[2] - box[0], box[3] - box[1]);
    const follows = reach(machine) > FAR * Math.max(reach(around), this.size);
    return { machine: follows ? around : machine, whole, follows };
  }

  /**
   * Enlarges a box by all points at the present instant, or those of some bodies; by lines of the
   * ground that hold none of these, such as a floor, only as far as these lie.
   */
  enlarge(box, only) {
    const add = ({ x, y }, margin = 0) => {
      box[0] = Math.min(box[0], x - margin);
      box[1] = Math.min(box[1], y - margin);
      box[2] = Math.max(box[2], x + margin);
      box[3] = Math.max(box[3], y + margin);
    };
    const counts = (body) => !only || only.has(body);
    this.bodies.forEach(({ outlines }, body) => {
      if (counts(body)) for (const point of outlines.flat()) add(this.place({ body, ...point }));
    });
    const corners = ([left, bottom, right, top]) => (left > right ? [] : [{ x: left, y: bottom }, { x: right, y: top }]);
    const floors = corners(this.still.floor);
    for (const point of corners(this.still.held)) add(point);
    for (const { body, corners: points, shift, element } of this.moving) {
      if (!counts(body)) continue;
      const frame = shift && [poseOf(shift, this.at)];
      const placed = points.map((at) => this.place({ ...(frame ? inWorld(frame, { body: 0, ...at }) : at), body }));
      if (this.bodies[body].fixed && !this.tied.has(element)) floors.push(...placed);
      else placed.forEach((point) => add(point));
    }
    const { links, names, drives, traces } = this;
    const places = [...links.flatMap(({ i, j }) => [i, j]), ...[...names, ...drives, ...traces].map(({ at }) => at)];
    for (const place of places) if (place.path || counts(place.body)) add(this.place(place), 3 * this.u);
    const room = 4 * this.u;
    const [left, bottom, right, top] = [box[0] - room, box[1] - room, box[2] + room, box[3] + room];
    for (const { x, y } of floors) add(!only ? { x, y } : { x: Math.min(Math.max(x, left), right), y: Math.min(Math.max(y, bottom), top) });
    return box;
  }

  /** The number of a body's colour; the ground has none. */
  number(body) {
    return this.bodies[body].fixed ? "ground" : (body - 1) % 7;
  }

  /** The colour of a body's series, or of those of a point of it, as of its lines; else `other`. */
  colorOf({ owner }, other) {
    const point = this.traces.find(({ element }) => element === owner);
    const body = point?.at.body ?? this.bodies.findIndex(({ name }) => name === owner);
    return body > 0 && !this.bodies[body].fixed ? `line-${this.number(body)}` : other;
  }
}
