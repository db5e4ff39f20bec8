// From a place in space to px: a direction of view, and zoom and pan in its plane, as in the plane.

import { Camera as PlaneCamera, steer } from "../camera.js";
import { extent } from "./scene.js";

const STEEP = Math.PI / 2; // rad, the view from above
const SLOW = 0.008; // rad that a px turns the view

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const mixedOf = (a, b, c, s) => a.map((value, k) => c * value + s * b[k]);

/** A camera on points in turn, and on more of them with all; it goes along with a point if one is given. */
export class Camera extends PlaneCamera {
  constructor(machine, whole, from = null) {
    super([-1, -1, 1, 1], [-1, -1, 1, 1]);
    const [low, high] = extent(machine);
    const center = low.map((value, k) => (value + high[k]) / 2 || 0);
    Object.assign(this, { solid: [machine, whole], center, start: from, now: from });
    this.orient({ right: [1, 0, 0], up: [0, 0, 1], azimuth: 0, height: 0 });
  }

  /** Takes a right and an upward axis, and its usual view. */
  orient(usual) {
    this.usual = usual;
    this.front = cross(usual.right, usual.up);
    this.face(usual.azimuth, usual.height);
    this.fit();
  }

  /** Looks from an azimuth and a height, rad: both 0 is the view from the front. */
  face(azimuth, height) {
    const { right, up } = this.usual;
    const pivot = this.axes && this.toScreen(this.pivot);
    this.azimuth = azimuth;
    this.tilt = Math.min(Math.max(height, -STEEP), STEEP);
    const [c, s, ch, sh] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(this.tilt), Math.sin(this.tilt)];
    const level = mixedOf(this.front, right, c, s);
    const toward = mixedOf(level, up, ch, sh);
    const across = mixedOf(right, this.front, c, -s);
    this.axes = [across, cross(toward, across), toward];
    if (this.start) [this.from, this.to] = [this.flat(this.start), this.flat(this.now)];
    if (!pivot) return;
    const moved = this.toScreen(this.pivot);
    this.x += pivot.x - moved.x;
    this.y += pivot.y - moved.y;
  }

  fit() {
    if (this.axes) {
      const shown = this.boxes.indexOf(this.box);
      this.boxes = this.solid.map((points) => this.flatBox(points));
      this.box = this.boxes[shown];
    }
    super.fit();
  }

  /** The middle of the machine, about which the view turns. */
  get pivot() {
    const [x, y, z] = this.center.map((value, k) => value + (this.follows ? this.now["xyz"[k]] - this.start["xyz"[k]] : 0));
    return { x, y, z };
  }

  flatBox(points) {
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    for (let k = 0; k + 2 < points.length; k += 3) {
      const { x, y } = this.flat({ x: points[k], y: points[k + 1], z: points[k + 2] });
      [x, y, x, y].forEach((value, j) => {
        box[j] = j < 2 ? Math.min(box[j], value) : Math.max(box[j], value);
      });
    }
    return box.every(Number.isFinite) ? box : [-1, -1, 1, 1];
  }

  /** A place in the plane of the view, in the unit of the scene. */
  flat({ x, y, z }) {
    return { x: dot(this.axes[0], [x, y, z]), y: dot(this.axes[1], [x, y, z]) };
  }

  toScreen(place) {
    return super.toScreen("z" in place ? this.flat(place) : place);
  }

  /** Turns all views by px of a drag. */
  turn(dx, dy) {
    for (const camera of this.linked) {
      camera.face(camera.azimuth - SLOW * dx, camera.tilt + SLOW * dy);
      camera.moved = true;
      camera.changed();
    }
  }

  /** Looks along an axis from its positive side, `sign` -1 from the other; without one the usual way. */
  lookAlong(axis, sign = 1) {
    for (const camera of this.linked) {
      const { right, up, azimuth, height } = camera.usual;
      if (axis === undefined) camera.face(azimuth, height);
      else {
        const toward = [0, 1, 2].map((k) => (k === axis ? sign : 0));
        const upright = Math.abs(dot(toward, up)) > 0.5;
        camera.face(upright ? 0 : Math.atan2(dot(toward, right), dot(toward, camera.front)), STEEP * dot(toward, up));
      }
      camera.fit();
    }
  }

  /** Goes along with its point, which is here now. */
  follow(point) {
    this.now = point;
    super.follow(this.flat(point));
  }
}

/** Lets a drag turn the view, and with shift or another button move it; a click is told apart. */
export function steerInSpace(element, camera, onClick) {
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  steer(element, camera, onClick, (event, at) => {
    let last = at;
    const moves = event.button > 0 || event.shiftKey;
    return (now) => {
      const [dx, dy] = [now.x - last.x, now.y - last.y];
      last = now;
      if (moves) camera.pan(dx, dy);
      else camera.turn(dx, dy);
    };
  });
}
