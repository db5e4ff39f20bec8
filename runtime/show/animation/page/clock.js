// The one clock of all runs: play, pause, speed, loop, steps.

const [SHORTEST, LONGEST, USUAL] = [2, 60, 10]; // s that a run takes: as runtime/show/movie.py has them
const SLOWER = 9; // choices of speed below the usual one, a factor of a thousand
const FASTER = 5; // choices above it
const FRAME = 1 / 60; // s of the viewer's time that a step takes

/** Speeds to choose from, 1, 2 or 5 times a power of ten; a run takes about ten seconds at the usual one. */
function speedsFor(span) {
  const usual = (span >= SHORTEST && span <= LONGEST) || !(span > 0) ? 1 : span / USUAL;
  const power = Math.floor(Math.log10(usual));
  const rest = usual / 10 ** power;
  const middle = 3 * power + (rest < 1.5 ? 0 : rest < 3.5 ? 1 : rest < 7.5 ? 2 : 3);
  return Array.from({ length: SLOWER + FASTER + 1 }, (_, k) => {
    const number = middle + k - SLOWER;
    const exponent = Math.floor(number / 3);
    return Number(`${[1, 2, 5][number - 3 * exponent]}e${exponent}`);
  });
}

/** A clock from `start` to `end`, s; its listeners are called with each new instant. */
export class Clock {
  constructor(start, end) {
    Object.assign(this, { start, end, t: start, playing: false, loop: true, listeners: [] });
    this.speeds = speedsFor(end - start);
    this.speed = this.speeds[SLOWER];
  }

  onTick(listener) {
    this.listeners.push(listener);
  }

  seek(t) {
    this.t = Math.min(Math.max(t, this.start), this.end);
    this.notify();
  }

  stopAt(t) {
    this.playing = false;
    this.seek(t);
  }

  notify() {
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
    this.notify();
  }

  advance(step) {
    const t = this.t + step;
    if (t >= this.end && !this.loop) this.playing = false;
    this.seek(t >= this.end && this.loop ? this.start + ((t - this.start) % (this.end - this.start)) : t);
  }

  pause() {
    this.playing = false;
    this.notify();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  /** Frames forward or back, at rest. */
  step(frames) {
    this.stopAt(this.t + frames * FRAME * this.speed);
  }

  /** Another speed, `places` further in the list. */
  change(places) {
    const place = Math.min(Math.max(this.speeds.indexOf(this.speed) + places, 0), this.speeds.length - 1);
    this.speed = this.speeds[place];
    this.notify();
  }
}
