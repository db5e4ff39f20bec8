// The player: reads the data, builds stages, time line, controls and curves.

import { Camera } from "./camera.js";
import { Clock } from "./clock.js";
import { connectControls, makeActions } from "./controls.js";
import { Curves, keepOutOfFocus, loadPanels } from "./curves.js";
import { readBlock } from "./data.js";
import { listKeys, listenToKeys } from "./keys.js";
import { empty, include, Scene } from "./scene.js";
import { short, svg } from "./signs.js";
import { Stage } from "./stage.js";
import { tellState } from "./state_text.js";
import { Timeline } from "./timeline.js";
import { fitFrame, keepPrintLight } from "./surroundings.js";

const MAX_REACTIONS = 5; // joints up to which reactions and names are shown from the start
const COLUMNS = [1, 1, 2, 3, 2, 3, 3]; // of the grid of so many runs

class Player {
  constructor(root, data) {
    this.root = root;
    this.scenes = data.runs.map((run) => new Scene(run));
    const start = Math.min(...this.scenes.map((scene) => scene.start));
    this.clock = new Clock(start, Math.max(...this.scenes.map((scene) => scene.end)));
    const few = Math.max(...this.scenes.map(({ joints }) => joints)) <= MAX_REACTIONS;
    this.shown = { force: true, torque: true, reaction: few, names: few, frames: false, traces: true };
    this.cameras = camerasOf(this.scenes);
    [this.camera] = this.cameras;
    this.timeline = new Timeline(root.querySelector(".timeline"), this.clock, data.runs);
    this.curves = null;
    this.build(data.runs);
  }

  build(runs) {
    const holder = this.root.querySelector(".stages");
    this.stages = this.scenes.map((scene, k) => {
      const figure = document.createElement("figure");
      figure.append(svg("svg", { role: "img", class: "stage" }));
      const caption = document.createElement("figcaption");
      caption.className = `run-${k % 7}`;
      const missing = scene.run.missing ? `No picture: ${scene.run.missing}` : "";
      caption.textContent = [runs.length > 1 ? scene.run.label : "", missing].filter(Boolean).join(". ");
      caption.hidden = !caption.textContent;
      figure.append(caption);
      const ended = document.createElement("p");
      ended.className = "ended";
      ended.hidden = true;
      figure.append(ended);
      holder.append(figure);
      const [choose, seek] = [(element) => this.choose(element), (t) => this.clock.stopAt(t)];
      return new Stage(figure, scene, this.cameras[k], this.shown, choose, seek);
    });
    const [left, bottom, right, top] = this.camera.box;
    const aspect = Math.min(Math.max((right - left) / (top - bottom), 0.7), 2);
    holder.style.setProperty("--aspect", aspect);
    holder.style.setProperty("--columns", COLUMNS[this.stages.length]);
    for (const { svg: picture, camera } of this.stages) {
      const resize = () => camera.resize(picture.clientWidth, picture.clientHeight);
      new ResizeObserver(resize).observe(picture);
      resize();
    }
    this.shareScales();
    this.noteTurns();
    this.offerElements();
    this.clock.onTick((t) => this.draw(t));
    for (const [name, value] of Object.entries(this.shown)) this.flip(name, value);
    const actions = makeActions(this);
    connectControls(this.root, this, actions);
    listenToKeys(actions);
    listKeys(document.querySelector("#help table"));
    this.tellAll = tellState(document.querySelector("#state"), this.clock, this.timeline, this.scenes);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.curves?.paint());
    this.clock.notify();
  }

  /** Arrows of all runs have one scale, so that forces can be compared. */
  shareScales() {
    const all = this.stages.map(({ arrows }) => arrows.largest);
    const largest = Object.fromEntries(["N", "N m"].map((unit) => [unit, Math.max(...all.map((one) => one[unit]))]));
    for (const { arrows } of this.stages) arrows.largest = largest;
  }

  /** Says where a run turns too fast for the samples that it has. */
  noteTurns() {
    const note = this.root.querySelector(".note");
    const coarse = this.scenes.filter((scene) => scene.isCoarse);
    note.hidden = !coarse.length;
    note.textContent = coarse.map(({ run, times, largestTurn }) =>
      `${run.label ? `${run.label}: ` : ""}drawn at ${times.length} instants; between them the machine turns by up to ` +
      `${short(largestTurn)} rad. Animate a part of the run, result.at(…), to see more.`,
    ).join(" ");
  }

  /** A list of what can be chosen by the keyboard: joints, forces and bodies. */
  offerElements() {
    const names = this.scenes.flatMap(({ kinds, bodies }) => [
      ...Object.keys(kinds),
      ...bodies.filter(({ fixed }) => !fixed).map(({ name }) => name),
    ]);
    this.list = this.root.querySelector("#element");
    for (const name of new Set(names)) this.list.append(new Option(name, name));
    this.list.addEventListener("change", () => this.choose(this.list.value, true));
  }

  /** Chooses the element `places` further in the list. */
  chooseNext(places) {
    const count = this.list.options.length;
    this.choose(this.list.options[(this.list.selectedIndex + places + count) % count].value, true);
  }

  draw(t) {
    for (const stage of this.stages) stage.draw(t, this.clock);
  }

  /** Shows what was clicked on: its curves, and its arrow. */
  choose(element, stays = false) {
    const chosen = !stays && this.stages[0].chosen === element ? "" : element;
    for (const stage of this.stages) stage.choose(chosen);
    this.list.value = chosen;
    if (chosen) this.curves?.showElement(chosen);
  }

  flip(name, value) {
    this.shown[name] = value;
    const box = this.root.querySelector(`[data-layer="${name}"]`);
    box.checked = value;
    this.root.querySelector(".stages").classList.toggle(`without-${name}`, !value);
    for (const stage of this.stages) stage.drawArrows(true);
  }

  loop() {
    this.clock.loop = !this.clock.loop;
    this.root.querySelector('[data-action="loop"]').setAttribute("aria-pressed", String(this.clock.loop));
  }

  changeTheme() {
    const { dataset } = document.documentElement;
    const dark = dataset.theme ? dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    dataset.theme = dark ? "light" : "dark";
    this.curves?.paint();
  }

  async loadCurves() {
    const sections = [...this.root.querySelectorAll(".panel")];
    if (!sections.length) return;
    const [library, panels] = ["library", "panels"].map((id) => document.getElementById(id).textContent);
    this.curves = new Curves(sections, await loadPanels(library, panels), this.scenes, this.clock);
    keepOutOfFocus(this.root.querySelector(".curves"));
  }
}

/** A camera for each run, which all move together; runs of one machine have the same scale. */
function camerasOf(scenes) {
  const views = scenes.map((scene) => scene.view);
  const cameras = scenes.map(({ run: { title } }, k) => {
    const boxes = ["machine", "whole"].map((name) => {
      const box = empty();
      scenes.forEach(({ run }, other) => run.title === title && include(box, views[other][name]));
      return box.every(Number.isFinite) ? box : [-1, -1, 1, 1];
    });
    return new Camera(...boxes, views[k].follows ? scenes[k].middle : null);
  });
  for (const camera of cameras) camera.linked = cameras;
  return cameras;
}

async function main() {
  performance.mark("begin");
  const root = document.querySelector(".player");
  const data = await readBlock(document.getElementById("data").textContent);
  globalThis.player = new Player(root, data);
  fitFrame();
  keepPrintLight(() => globalThis.player.curves?.paint());
  root.dataset.ready = "machine";
  performance.mark("interactive");
  await globalThis.player.loadCurves();
  root.dataset.ready = "all";
  performance.mark("curves");
}

main();
