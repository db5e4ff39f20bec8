// Turning a driven machine by hand: a point of a body follows the pointer through the run.

import { inWorld, poseOf } from "./poses.js";

const CLOSED = 1e-3; // of the size, or rad: a motion whose ends are nearer goes round

/** A hold on a body at a point of the picture, {x, y} in the unit of the scene. */
export class Hold {
  constructor(scene, body, { x, y }) {
    const pose = scene.poses[body];
    const [dx, dy] = [x - pose.x, y - pose.y];
    Object.assign(this, { scene, pose: scene.bodies[body].pose, way: 1 });
    this.point = { body: 0, x: pose.c * dx + pose.s * dy, y: pose.c * dy - pose.s * dx };
    this.last = scene.times.length - 1;
    this.closed = scene.bodies.every(({ pose: arrays }) => {
      const [a, b] = [0, this.last].map((low) => poseOf(arrays, { low, high: low, share: 0 }));
      const moved = Math.hypot(b.x - a.x, b.y - a.y) / scene.size;
      return Math.max(moved, Math.hypot(b.c - a.c, b.s - a.s)) < CLOSED;
    });
  }

  /** A number of a sample, which in a closed motion goes round; none beyond the ends. */
  sample(number) {
    if (this.closed) return (number + this.last) % this.last;
    return number < 0 || number > this.last ? undefined : number;
  }

  /** Where the point that is held is at a sample. */
  at(sample) {
    return inWorld([poseOf(this.pose, { low: sample, high: sample, share: 0 })], this.point);
  }

  /**
   * The time at which the point is nearest to another one, of those that lead there without a
   * detour of more than `slack`; where both ways do, time goes on as it went.
   */
  nearest(to, slack) {
    const ways = [this.way, -this.way].map((way) => ({ way, ...this.walk(way, to, slack) }));
    const best = ways[1].distance < ways[0].distance - slack ? ways[1] : ways[0];
    if (best.sample !== this.scene.at.low) this.way = best.way;
    const lows = [best.sample - 1, best.sample].map((low) => this.sample(low));
    const parts = lows.map((low) => this.between(low, to)).filter(Boolean);
    return parts.toSorted((a, b) => a.distance - b.distance)[0]?.t ?? this.scene.t;
  }

  /** The nearest sample on the way, from the present one on. */
  walk(way, to, slack) {
    const distance = (sample) => Math.hypot(this.at(sample).x - to.x, this.at(sample).y - to.y);
    const start = this.scene.at.low;
    let best = { sample: start, distance: distance(start) };
    for (let step = 1; step <= this.last; step += 1) {
      const sample = this.sample(start + way * step);
      const now = sample === undefined ? Infinity : distance(sample);
      if (now > best.distance + slack) break;
      if (now < best.distance) best = { sample, distance: now };
    }
    return best;
  }

  /** The nearest instant between a sample and the next one. */
  between(low, to) {
    const { times } = this.scene;
    if (!(low < this.last)) return null;
    const [a, b] = [this.at(low), this.at(low + 1)];
    const [dx, dy] = [b.x - a.x, b.y - a.y];
    const along = ((to.x - a.x) * dx + (to.y - a.y) * dy) / (dx * dx + dy * dy);
    const share = Math.min(Math.max(along || 0, 0), 1);
    const distance = Math.hypot(a.x + share * dx - to.x, a.y + share * dy - to.y);
    return { t: times[low] + share * (times[low + 1] - times[low]), distance };
  }
}
