// Where texts beside points stand: free of each other, and of the lines of bodies where they can.

import { svg } from "./signs.js";

const FONT = "13px system-ui, sans-serif"; // the larger one of the style sheet
const LINE = 15; // px, height of a line
const EDGE = 4; // px, room to the edge of the picture
const BESIDE = 0.9; // of the size of a pin, between a joint and its name, in both directions

const pen = document.createElement("canvas").getContext("2d");
pen.font = FONT;

/** The texts of a picture at one instant; each is placed after those before it. */
export class Labels {
  constructor(camera, obstacles) {
    Object.assign(this, { camera, obstacles, boxes: [] });
  }

  /**
   * Places a text at the candidate {x, y, end} that crosses fewest lines, or hides it where all
   * would cover another text and it is not `wanted`; `entry` keeps the choice, which holds while
   * `anew` is false.
   */
  place(entry, candidates, anew, wanted = false) {
    const { text } = entry;
    if (anew || entry.choice === undefined) entry.choice = this.choose(text.textContent, candidates);
    const chosen = candidates[entry.choice] ?? (wanted ? candidates[0] : undefined);
    text.toggleAttribute("hidden", !chosen);
    if (!chosen) return;
    const box = this.box(text.textContent, chosen);
    this.boxes.push(box);
    text.setAttribute("x", chosen.end ? box.right : box.left);
    text.setAttribute("y", box.bottom - 4);
    text.setAttribute("text-anchor", chosen.end ? "end" : "start");
  }

  /** The number of the best candidate; -1: none is free. */
  choose(words, candidates) {
    let [best, fewest] = [-1, Infinity];
    for (const [k, candidate] of candidates.entries()) {
      const box = this.box(words, candidate);
      if (this.boxes.some((other) => overlap(box, other))) continue;
      const crossed = this.obstacles.reduce((sum, point) => sum + inside(point, box), 0);
      if (crossed < fewest) [best, fewest] = [k, crossed];
      if (crossed === 0) break;
    }
    return best;
  }

  box(words, { x, y, end }) {
    const { width } = pen.measureText(words);
    const start = end ? x - width : x;
    const left = Math.max(Math.min(start, this.camera.width - width - EDGE), EDGE);
    return { left, right: left + width, top: y + 4 - LINE, bottom: y + 4 };
  }
}

function overlap(a, b) {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

function inside({ x, y }, box) {
  return x > box.left && x < box.right && y > box.top && y < box.bottom ? 1 : 0;
}

/** The names of joints and tracked points of a scene: {node, update(camera, labels, anew)}. */
export function drawNames(scene) {
  const named = scene.names.map((one) => ({ ...one, text: svg("text", {}, one.element) }));
  const node = svg("g", { class: "names" }, ...named.map(({ text }) => text));
  const update = (camera, labels, anew) => {
    const beside = BESIDE * scene.u * camera.scale + 5;
    for (const entry of named) {
      if (!scene.acts(entry.element)) entry.text.setAttribute("hidden", "");
      else labels.place(entry, cornersOf(camera.toScreen(scene.place(entry.at)), beside), anew);
    }
  };
  return { node, update };
}

/** Places of the corners beside a point, `beside` px away in both directions. */
function cornersOf({ x, y }, beside) {
  return [
    { x: x + beside, y: y - beside },
    { x: x - beside, y: y - beside, end: true },
    { x: x + beside, y: y + beside + 10 },
    { x: x - beside, y: y + beside + 10, end: true },
  ];
}

/** Places below and above each other. */
export function columnOf(place) {
  return [0, 1, -1, 2, -2, 3].map((lines) => ({ ...place, y: place.y + lines * LINE }));
}
