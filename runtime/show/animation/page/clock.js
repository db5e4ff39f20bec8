// The one clock of all runs: play, pause, speed, loop, steps.

export const SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];

const AIM = 8; // s that a whole run takes, where it would be much shorter or longer at its own speed
const FRAME = 1 / 60; // s of the viewer's time that a step takes

/** A clock from `start` to `end`, s; its listeners are called with each new instant. */
export class Clock {
  constructor(start, end) {
    Object.assign(this, { start, end, t: start, playing: false, loop: false, listeners: [] });
    const span = end - start;
    const suited = span >= 2 && span <= 60 ? 1 : span / AIM;
    this.speed = SPEEDS.reduce((a, b) => (Math.abs(Math.log(b / suited)) < Math.abs(Math.log(a / suited)) ? b : a));
  }

  onTick(listener) {
    this.listeners.push(listener);
  }

  seek(t) {
    this.t = Math.min(Math.max(t, this.start), this.end);
    this.tell();
  }

  tell() {
    for (const listener of this.listeners) listener(this.t);
  }

  play() {
    if (this.playing || this.end <= this.start) return;
    if (this.t >= this.end) this.t = this.start;
    this.playing = true;
    this.last = undefined;
    const frame = (now) => {
      if (!this.playing) return;
      const passed = this.last === undefined ? 0 : Math.min((now - this.last) / 1000, 0.25);
      this.last = now;
      this.advance(passed * this.speed);
      if (this.playing) requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
    this.tell();
  }

  advance(step) {
    const t = this.t + step;
    if (t >= this.end && !this.loop) this.playing = false;
    this.seek(t >= this.end && this.loop ? this.start + ((t - this.start) % (this.end - this.start)) : t);
  }

  pause() {
    this.playing = false;
    this.tell();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  /** Frames forward or back, at rest. */
  step(frames) {
    this.playing = false;
    this.seek(this.t + frames * FRAME * this.speed);
  }

  /** Another speed, `places` further in the list. */
  change(places) {
    const place = Math.min(Math.max(SPEEDS.indexOf(this.speed) + places, 0), SPEEDS.length - 1);
    this.speed = SPEEDS[place];
    this.tell();
  }
}
