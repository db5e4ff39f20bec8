// The keyboard of a page in space: the keys of the plane, and those that turn the view.

import { KEYS, listenToKeys, listKeys as listAll } from "../keys.js";

export { listenToKeys };

KEYS.push(
  ...["X", "Y", "Z"].flatMap((axis) => [
    [[axis.toLowerCase()], axis.toLowerCase(), `view along the ${axis.toLowerCase()} axis`, `along${axis}`],
    [[axis], `shift ${axis.toLowerCase()}`, "the same from behind", `behind${axis}`],
  ]),
  [["v"], "v", "the usual view", "usual"],
  ...[["4", "left", "Left"], ["6", "right", "Right"], ["8", "up", "Up"], ["2", "down", "Down"]].map(
    ([key, way, name]) => [[key], key, `turn the view ${way}`, `turn${name}`]),
);

/** Fills the list of keys. */
export function listKeys(table) {
  listAll(table);
  document.querySelector("#help > p").textContent =
    "Drag turns the view; with shift or the right button it moves. The wheel or two fingers zoom, a double click shows " +
    "the whole flight, or the machine; in a notebook the wheel zooms after a click, or with ctrl. The arrow of a torque " +
    "has two heads. An arrow with strokes across is cut: its force is larger. A click on a joint, a force or a body " +
    "shows its curves; a click on a curve goes to that instant.";
}
