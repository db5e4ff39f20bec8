// Curves over time, drawn by Bokeh in panels; the player fills them and moves their time cursor.

import { inflated } from "./data.js";
import { mixed } from "./poses.js";
import { short, svg } from "./signs.js";

const ROUNDING = 1e-12; // of the largest value of a curve: what is nearer to 0 is shown as 0
const TEXTS = 120; // ms between changes of the numbers in legends
const SIDEWAYS = 8; // px that a finger moves along a curve before it moves the time
const DEFAULTS = [
  ["All bodies", /^angle/], ["All bodies", /^angular velocity/], ["Joints", /, N$/], ["Energy", /^energy/],
  ["All bodies", /^position/], ["All bodies", /^velocity/], ["Effects", /./], ["Drivers", /./], ["", /./],
];
const DASHES = [[], [6, 3], [2, 2], [8, 3, 2, 3]];
const PALE = 0.55; // opacity of curves of a colour whose dashes are all taken
const COLORS = { "Joints N": "reaction", "Drivers N": "driver", "Effects N": "force" }; // by section and unit

/** The colour of a name in the style sheet. */
export function color(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Runs the script of Bokeh that the page carries, and draws the empty panels. */
export async function loadPanels(library, panels) {
  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await inflated(library));
  document.head.append(script);
  const { documents, item } = JSON.parse(panels);
  const [views] = await globalThis.Bokeh.embed.embed_items(documents, [item]);
  return views.roots.toSorted((a, b) => (a.model.name < b.model.name ? -1 : 1));
}

/** The groups of all runs: those of the same title are one, with the names of their series. */
function joined(scenes) {
  const groups = new Map();
  for (const { run } of scenes) {
    for (const group of run.groups) {
      const key = `${group.section}/${group.title}`;
      const known = groups.get(key) ?? { ...group, names: [] };
      const names = group.series.map((k) => run.series[k].name);
      known.names = [...new Set([...known.names, ...names])];
      known.constant &&= group.constant;
      groups.set(key, known);
    }
  }
  return [...groups.values()];
}

/** What Bokeh draws has no names to be told by: the focus passes it by, and fingers scroll over it. */
export function keepOutOfFocus(element) {
  for (const node of element.querySelectorAll("*")) {
    if (node.shadowRoot) keepOutOfFocus(node.shadowRoot);
    if (node.hasAttribute("tabindex") || node.getRootNode() !== document) {
      if (node.tabIndex >= 0) node.tabIndex = -1;
      if (node.style) node.style.touchAction = "pan-y";
    }
  }
}

/** All panels of a page. */
export class Curves {
  constructor(sections, views, scenes, clock) {
    Object.assign(this, { scenes, clock });
    this.groups = joined(scenes);
    this.panels = sections.map((section, k) => new Panel(section, views[k], this));
    const chosen = this.defaultGroups();
    this.panels.forEach((panel, k) => panel.show(chosen[k] ?? null));
    const range = views[0].model.x_range;
    range.start = clock.start;
    range.end = clock.end;
    range.reset_start = clock.start;
    range.reset_end = clock.end;
    this.paint();
    clock.onTick(() => this.move());
    for (const name of ["start", "end"]) range.properties[name].change.connect(() => this.move());
    new ResizeObserver(() => requestAnimationFrame(() => this.move())).observe(sections[0].parentElement);
    this.move();
  }

  /** The groups that are shown at first. */
  defaultGroups() {
    const chosen = [];
    for (const [section, title] of DEFAULTS) {
      const fits = (group) => (!section || group.section === section) && title.test(group.title);
      const found = this.groups.find((group) => fits(group) && !group.constant && !chosen.includes(group));
      if (found) chosen.push(found);
    }
    return chosen;
  }

  /** Shows what belongs to a joint, an effect or a body. */
  showElement(element) {
    const all = this.groups.filter(({ owner, section }) => owner === element && section !== "All bodies");
    const moving = all.filter(({ constant }) => !constant);
    const own = moving.length ? moving : all;
    const free = [2, 3];
    own.slice(0, free.length).forEach((group, k) => this.panels[free[k]].show(group));
    return own.length;
  }

  paint() {
    for (const panel of this.panels) panel.paint();
  }

  move() {
    const now = performance.now();
    const withText = !this.clock.playing || now - (this.written ?? 0) > TEXTS;
    if (withText) this.written = now;
    for (const panel of this.panels) panel.move(this.clock.t, withText);
  }
}

class Panel {
  constructor(section, view, curves) {
    Object.assign(this, { section, view, curves, plot: view.model, lines: [] });
    this.select = section.querySelector("select");
    this.legend = section.querySelector(".legend");
    this.cursor = section.querySelector(".cursor");
    this.frame = section.querySelector(".plot");
    this.offer();
    this.select.addEventListener("change", () => this.show(curves.groups[Number(this.select.value)] ?? null));
    this.listen();
  }

  offer() {
    this.select.append(new Option("nothing", ""));
    const sections = new Map();
    this.curves.groups.forEach(({ section, title }, k) => {
      if (!sections.has(section)) {
        const part = document.createElement("optgroup");
        part.label = section;
        sections.set(section, part);
        this.select.append(part);
      }
      sections.get(section).append(new Option(title, k));
    });
  }

  /** Clicks and hovering move the machine; dragging does too, where no tool of Bokeh is chosen. */
  listen() {
    const { clock } = this.curves;
    const at = (event) => {
      const { left, width } = this.view.frame.bbox;
      const share = (event.clientX - this.frame.getBoundingClientRect().left - left) / width;
      const { start, end } = this.plot.x_range;
      return share < 0 || share > 1 ? null : start + share * (end - start);
    };
    const go = (event) => {
      const t = at(event);
      if (t !== null) clock.seek(t);
    };
    const usesTool = () => this.plot.toolbar.gestures.pan.active !== null;
    this.frame.addEventListener("click", (event) => !usesTool() && go(event));
    let from = 0;
    this.frame.addEventListener("pointerdown", (event) => {
      from = event.clientX;
    });
    this.frame.addEventListener("pointermove", (event) => {
      const dragged = event.buttons > 0;
      if (event.pointerType === "touch" && Math.abs(event.clientX - from) < SIDEWAYS) return;
      if (dragged ? !usesTool() : !clock.playing && event.pointerType === "mouse") go(event);
    });
  }

  show(group) {
    const { scenes, groups } = this.curves;
    this.select.value = group ? groups.indexOf(group) : "";
    this.frame.hidden = !group;
    this.section.setAttribute("aria-label", group ? `Curves of ${group.title}` : "No curves");
    this.legend.replaceChildren();
    this.lines = [];
    if (!group) return;
    const several = scenes.length > 1;
    const all = group.names
      .flatMap((name, k) => scenes.map((scene, run) => ({ name, scene, run, k, series: scene.byName.get(name) })))
      .filter(({ series }) => series);
    this.lines = all.slice(0, this.plot.renderers.length);
    const counts = {}; // of curves so far that share a colour
    this.plot.renderers.forEach((renderer, k) => {
      const line = this.lines[k];
      renderer.visible = Boolean(line);
      const data = line ? { t: line.scene.times, y: Float64Array.from(line.series.values) } : { t: [], y: [] };
      renderer.data_source.data = data;
      if (!line) return;
      line.renderer = renderer;
      const other = group.unit === "N m" ? "torque" : (COLORS[`${group.section} ${group.unit}`] ?? "ink");
      line.color = several ? `line-${line.run % 7}` : line.scene.colorOf(line.series, other);
      const count = (counts[line.color] = (counts[line.color] ?? -1) + 1);
      line.dash = DASHES[count % DASHES.length];
      renderer.glyph.line_dash = { value: line.dash };
      renderer.glyph.line_alpha = { value: count < DASHES.length ? 1 : PALE };
      this.legend.append(this.chip(line, several));
    });
    if (all.length > this.lines.length) {
      const more = document.createElement("span");
      more.textContent = `and ${all.length - this.lines.length} more curves`;
      this.legend.append(more);
    }
    this.plot.left[0].axis_label = group.unit;
    this.paint();
    this.move(this.curves.clock.t, true);
  }

  chip(line, several) {
    const chip = document.createElement("button");
    chip.type = "button";
    chip.className = "chip";
    chip.setAttribute("aria-pressed", "true");
    chip.title = "show or hide this curve";
    const stroke = { d: "M0 3H22", stroke: `var(--${line.color})`, "stroke-dasharray": line.dash.join(" ") };
    line.value = document.createElement("b");
    chip.append(svg("svg", { viewBox: "0 0 22 6", "aria-hidden": "true" }, svg("path", stroke)),
      several ? `${line.name}, ${line.scene.run.label} ` : `${line.name} `, line.value);
    chip.addEventListener("click", () => {
      line.renderer.visible = !line.renderer.visible;
      chip.setAttribute("aria-pressed", String(line.renderer.visible));
    });
    return chip;
  }

  /** The colours of the page's theme. */
  paint() {
    const [ink, muted, grid] = ["ink", "muted", "grid"].map(color);
    for (const axis of [...this.plot.below, ...this.plot.left]) {
      Object.assign(axis, {
        axis_line_color: muted, major_tick_line_color: muted, minor_tick_line_color: null,
        major_label_text_color: ink, axis_label_text_color: ink, axis_label_text_font_style: "normal",
      });
    }
    for (const part of this.plot.center) if ("grid_line_color" in part) part.grid_line_color = grid;
    for (const line of this.lines) line.renderer.glyph.line_color = { value: color(line.color) };
  }

  /** Moves the time cursor, and writes the values at it. */
  move(t, withText) {
    const { left, width, top, height } = this.view.frame.bbox;
    const { start, end } = this.plot.x_range;
    const share = (t - start) / (end - start);
    this.cursor.hidden = !(share >= 0 && share <= 1) || !(width > 0);
    this.cursor.style.transform = `translate(${left + share * width}px, ${top}px)`;
    this.cursor.style.height = `${height}px`;
    if (!withText) return;
    for (const line of this.lines) {
      line.largest ??= line.series.values.reduce((size, one) => Math.max(size, Math.abs(one)), 0);
      const now = mixed(line.series.values, line.scene.at);
      line.value.textContent = short(Math.abs(now) < ROUNDING * line.largest ? 0 : now);
    }
  }
}
