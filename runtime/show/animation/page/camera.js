// Zoom and pan: from metres to px. Each run has a camera; those of a page move together.

/**
 * A camera on a box [x least, y least, x largest, y largest], m, and on a larger one with all. It
 * goes along with a point, m, if one is given.
 */
export class Camera {
  constructor(box, whole, from = null) {
    this.boxes = [box, whole];
    this.box = box;
    Object.assign(this, { from, to: from });
    this.width = 1;
    this.height = 1;
    this.listeners = [];
    this.linked = [this];
    this.fit();
  }

  onChange(listener) {
    this.listeners.push(listener);
  }

  changed() {
    for (const listener of this.listeners) listener();
  }

  /** The size of the picture, px; keeps what is at its centre. */
  resize(width, height) {
    if (width === this.width && height === this.height) return;
    const [ratio, zoomed] = [this.scale / this.fitting(), this.moved];
    const center = this.toWorld({ x: this.width / 2, y: this.height / 2 });
    [this.width, this.height] = [width, height];
    if (zoomed) {
      this.scale = ratio * this.fitting();
      this.centerOn(center);
    } else this.fit();
  }

  fitting() {
    const [left, bottom, right, top] = this.box;
    const margin = 26;
    const [w, h] = [Math.max(this.width - 2 * margin, 40), Math.max(this.height - 2 * margin, 40)];
    return Math.min(w / Math.max(right - left, 1e-12), h / Math.max(top - bottom, 1e-12));
  }

  /** Shows the machine; once more, also what flies away from it. */
  toggleFit() {
    const next = this.boxes[0] === this.box ? 1 : 0;
    for (const camera of this.linked) {
      if (!this.moved) camera.box = camera.boxes[next];
      if (camera !== this) camera.fit();
    }
    this.fit();
  }

  fit() {
    const [left, bottom, right, top] = this.box;
    this.scale = this.fitting();
    this.moved = false;
    const [dx, dy] = this.follows ? [this.to.x - this.from.x, this.to.y - this.from.y] : [0, 0];
    this.centerOn({ x: (left + right) / 2 + dx, y: (bottom + top) / 2 + dy });
  }

  /** Whether it goes along with a point; with all of a run in the picture it stands still. */
  get follows() {
    return this.from !== null && this.box === this.boxes[0];
  }

  /** Goes along with its point, which is here now. */
  follow(point) {
    const [dx, dy] = [point.x - this.to.x, point.y - this.to.y];
    this.to = point;
    if (!this.follows || (dx === 0 && dy === 0)) return;
    this.x -= this.scale * dx;
    this.y += this.scale * dy;
    this.changed();
  }

  centerOn({ x, y }) {
    this.x = this.width / 2 - this.scale * x;
    this.y = this.height / 2 + this.scale * y;
    this.changed();
  }

  pan(dx, dy) {
    for (const camera of this.linked) camera.shift(dx, dy);
  }

  shift(dx, dy) {
    this.x += dx;
    this.y += dy;
    this.moved = true;
    this.changed();
  }

  /** Zooms by a factor about a point of the picture, px; its centre unless given. */
  zoom(factor, about) {
    for (const camera of this.linked) camera.enlarge(factor, about);
  }

  enlarge(factor, about = { x: this.width / 2, y: this.height / 2 }) {
    const limited = Math.min(Math.max(factor, (0.1 * this.fitting()) / this.scale), (500 * this.fitting()) / this.scale);
    this.x = about.x + limited * (this.x - about.x);
    this.y = about.y + limited * (this.y - about.y);
    this.scale *= limited;
    this.moved = true;
    this.changed();
  }

  toScreen({ x, y }) {
    return { x: this.x + this.scale * x, y: this.y - this.scale * y };
  }

  toWorld({ x, y }) {
    return { x: (x - this.x) / this.scale, y: (this.y - y) / this.scale };
  }

  get matrix() {
    return `matrix(${this.scale} 0 0 ${-this.scale} ${this.x} ${this.y})`;
  }
}

/**
 * Lets mouse, wheel and fingers move the camera over an element; a click is told apart. What
 * `grab(event, place)` returns, if anything, is called with the places of the pointer instead.
 */
export function steer(element, camera, onClick, grab) {
  const pointers = new Map();
  let moved = 0;
  let pull;
  const place = (event) => {
    const box = element.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  element.addEventListener("pointerdown", (event) => {
    pointers.set(event.pointerId, place(event));
    moved = 0;
    pull = pointers.size === 1 ? grab(event, place(event)) : undefined;
  });
  element.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = place(event);
    moved += Math.hypot(now.x - before.x, now.y - before.y);
    const others = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    if (others.length === 1) {
      const [other] = others;
      const distance = (at) => Math.max(Math.hypot(at.x - other.x, at.y - other.y), 1);
      camera.zoom(distance(now) / distance(before), other);
    } else if (pull) {
      if (moved > 4) pull(now);
    } else if (!others.length) {
      const scrolls = event.pointerType === "touch"; // one finger up or down scrolls the page
      camera.pan(now.x - before.x, scrolls ? 0 : now.y - before.y);
    }
    if (moved > 4 && !element.hasPointerCapture(event.pointerId)) element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, now);
  });
  // A finger that holds something does not scroll the page.
  element.addEventListener("touchstart", (event) => pull && event.preventDefault(), { passive: false });
  for (const kind of ["pointerup", "pointercancel"]) {
    element.addEventListener(kind, (event) => {
      if (kind === "pointerup" && pointers.has(event.pointerId) && moved <= 4) onClick(event);
      pointers.delete(event.pointerId);
    });
  }
  element.addEventListener("wheel", (event) => {
    // In a frame of a notebook the wheel scrolls the notebook, until a click gives the frame the focus.
    if (globalThis.parent !== globalThis && !event.ctrlKey && !document.hasFocus()) return;
    event.preventDefault();
    camera.zoom(Math.exp(-0.0015 * event.deltaY), place(event));
  }, { passive: false });
  element.addEventListener("dblclick", () => camera.toggleFit());
}
