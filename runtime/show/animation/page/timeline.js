// The time line: a slider with marks of events, and steps from one to the next.

const MAX_MARKS = 400; // that are drawn; of more, those far enough apart to be told apart
const MAX_DIGITS = 9; // behind the point

/** The time line of a clock, with the events of all runs. */
export class Timeline {
  constructor(root, clock, runs) {
    Object.assign(this, { clock });
    this.slider = root.querySelector("input");
    this.output = root.querySelector(".now");
    this.happened = document.querySelector(".happened");
    this.events = runs
      .flatMap((run, k) => run.events.map((event) => ({ ...event, run: k, label: runs.length > 1 ? run.label : "" })))
      .toSorted((a, b) => a.t - b.t);
    this.eventDigits = this.digitsOfEvents();
    this.slider.min = clock.start;
    this.slider.max = clock.end;
    this.slider.step = (clock.end - clock.start) / 10000 || 1;
    this.slider.addEventListener("input", () => clock.seek(Number(this.slider.value)));
    this.mark(root.querySelector(".marks"));
    this.list(document.querySelector("#events ol"));
    clock.onTick(() => this.show());
    this.show();
  }

  /** Digits behind the point that tell events at different instants apart. */
  digitsOfEvents() {
    const gaps = this.events.slice(1).map(({ t }, k) => t - this.events[k].t).filter((gap) => gap > 0);
    const least = gaps.reduce((smallest, gap) => Math.min(smallest, gap), Infinity);
    const needed = Number.isFinite(least) ? Math.ceil(-Math.log10(least) - 1e-6) : 0;
    return Math.min(Math.max(needed, this.digits), MAX_DIGITS);
  }

  words(event) {
    return `${event.t.toFixed(this.eventDigits)} s: ${event.label ? `${event.label}, ` : ""}${event.text}`;
  }

  mark(line) {
    const span = this.clock.end - this.clock.start || 1;
    const gap = span / MAX_MARKS;
    let last = -Infinity;
    for (const event of this.events) {
      if (this.events.length > MAX_MARKS && event.t - last < gap) continue;
      last = event.t;
      const mark = document.createElement("i");
      mark.style.left = `${(100 * (event.t - this.clock.start)) / span}%`;
      mark.className = `mark run-${event.run % 7}${event.flash ? " hit" : ""}`;
      mark.title = this.words(event);
      mark.addEventListener("click", () => this.clock.seek(event.t));
      line.append(mark);
    }
  }

  list(list) {
    for (const event of this.events.slice(0, MAX_MARKS)) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = this.words(event);
      button.addEventListener("click", () => this.clock.seek(event.t));
      const row = document.createElement("li");
      row.append(button);
      list.append(row);
    }
    const more = this.events.length - MAX_MARKS;
    if (more > 0) {
      const row = document.createElement("li");
      row.textContent = `and ${more} more`;
      list.append(row);
    }
    document.querySelector("#events").hidden = !this.events.length;
  }

  /** The event after the present instant, or before it. */
  neighbour(forward) {
    const near = 1e-9 * (this.clock.end - this.clock.start);
    if (forward) return this.events.find(({ t }) => t > this.clock.t + near);
    return this.events.findLast(({ t }) => t < this.clock.t - near);
  }

  goToEvent(forward) {
    const event = this.neighbour(forward);
    if (!event) return;
    this.clock.stopAt(event.t);
  }

  /** The last event up to the present instant. */
  get latest() {
    return this.events.findLast(({ t }) => t <= this.clock.t);
  }

  show() {
    const { t } = this.clock;
    this.slider.value = t;
    this.slider.setAttribute("aria-valuetext", `${this.instant(t)} seconds`);
    const text = `${this.instant(t)} s`;
    if (this.output.textContent !== text) this.output.textContent = text;
    const event = this.latest;
    const words = event ? this.words(event) : "";
    if (this.happened.textContent !== words) this.happened.textContent = words;
    this.happened.classList.toggle("fresh", Boolean(event) && t - event.t < 0.4 * this.clock.speed);
  }

  /** An instant with so many digits that steps are told apart. */
  instant(t) {
    return t.toFixed(this.digits);
  }

  get digits() {
    const span = this.clock.end - this.clock.start || 1;
    return Math.min(Math.max(3 - Math.floor(Math.log10(span)), 2), MAX_DIGITS);
  }
}
