// The player: reads the data, builds stages, time line, controls and curves.

import { Camera } from "./camera.js";
import { Clock } from "./clock.js";
import { connectControls, makeActions } from "./controls.js";
import { Curves, loadPanels } from "./curves.js";
import { readBlock } from "./data.js";
import { listKeys, listenToKeys } from "./keys.js";
import { Scene } from "./scene.js";
import { svg } from "./signs.js";
import { Stage } from "./stage.js";
import { tellState } from "./state_text.js";
import { Timeline } from "./timeline.js";

const FEW = 5; // joints up to which reactions are shown from the start

class Player {
  constructor(root, data) {
    this.root = root;
    this.scenes = data.runs.map((run) => new Scene(run, data.arrays));
    const start = Math.min(...this.scenes.map((scene) => scene.start));
    this.clock = new Clock(start, Math.max(...this.scenes.map((scene) => scene.end)));
    const joints = this.scenes[0].symbols.filter(({ shape }) => shape.kind === "reaction").length;
    const few = joints <= FEW;
    this.shown = { force: true, torque: true, reaction: few, names: few, frames: false, traces: true };
    this.camera = new Camera(...[true, false].map((near) => around(this.scenes.map((scene) => scene.extent(near)))));
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
      holder.append(figure);
      return new Stage(figure, scene, this.camera, this.shown, (element) => this.choose(element));
    });
    const [left, bottom, right, top] = this.camera.box;
    const aspect = Math.min(Math.max((right - left) / (top - bottom), 0.7), 2);
    holder.style.setProperty("--aspect", aspect);
    const seen = this.stages[0].svg;
    const resize = () => this.camera.resize(seen.clientWidth, seen.clientHeight);
    new ResizeObserver(resize).observe(seen);
    resize();
    this.clock.onTick((t) => this.draw(t));
    for (const [name, value] of Object.entries(this.shown)) this.flip(name, value);
    const actions = makeActions(this);
    connectControls(this.root, this, actions);
    listenToKeys(actions);
    listKeys(document.querySelector("#help table"));
    tellState(document.querySelector("#state"), this.clock, this.timeline, this.scenes);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.curves?.paint());
    this.clock.tell();
  }

  draw(t) {
    for (const stage of this.stages) stage.draw(t, this.clock.speed);
  }

  /** Shows what was clicked on: its curves, and its arrow. */
  choose(element) {
    const same = this.stages[0].chosen === element;
    for (const stage of this.stages) stage.choose(same ? "" : element);
    if (!same) this.curves?.showElement(element);
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
  }
}

/** The box round several. */
function around(boxes) {
  const side = (k, choose) => choose(...boxes.map((one) => one[k]));
  return [side(0, Math.min), side(1, Math.min), side(2, Math.max), side(3, Math.max)];
}

async function main() {
  performance.mark("begin");
  const root = document.querySelector(".player");
  const data = await readBlock(document.getElementById("data").textContent);
  globalThis.player = new Player(root, data);
  root.dataset.ready = "machine";
  performance.mark("interactive");
  await globalThis.player.loadCurves();
  root.dataset.ready = "all";
  performance.mark("curves");
}

main();
