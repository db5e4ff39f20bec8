// The keyboard of a page in space: the keys of the plane, and those that turn the view.

import { KEYS, listenToKeys, listKeys as listAll } from "../keys.js";

export { listenToKeys };

KEYS.push(
  [["x"], "x", "view along the x axis", "alongX"],
  [["y"], "y", "view along the y axis", "alongY"],
  [["z"], "z", "view along the z axis", "alongZ"],
  [["X"], "shift x", "view along the x axis from behind", "behindX"],
  [["Y"], "shift y", "view along the y axis from behind", "behindY"],
  [["Z"], "shift z", "view along the z axis from below", "behindZ"],
  [["v"], "v", "the usual view", "usual"],
  [["4"], "4", "turn the view to the left", "turnLeft"],
  [["6"], "6", "turn the view to the right", "turnRight"],
  [["8"], "8", "turn the view up", "turnUp"],
  [["2"], "2", "turn the view down", "turnDown"],
);

/** Fills the list of keys. */
export function listKeys(table) {
  listAll(table);
  document.querySelector("#help > p").textContent =
    "Drag turns the view; with shift, the right button or two fingers it moves. The wheel or two fingers zoom, a double " +
    "click shows the whole flight, or the machine; in a notebook the wheel zooms after a click, or with ctrl. An arrow of " +
    "a torque has two heads. An arrow with strokes across is cut: its force is larger. A click on a joint, a force or a " +
    "body shows its curves; a click on a curve goes to that instant.";
}
