// Buttons and actions of a page in space: those of the plane, and views along the axes.

import { connectControls as connectAll, makeActions as makePlaneActions } from "../controls.js";

const STEP = 30; // px of a drag by which a key turns the view
const VIEWS = [["alongX", "x", "x"], ["alongY", "y", "y"], ["alongZ", "z", "z"], ["usual", "◳", "v"]];

/** The actions of the player by name. */
export function makeActions(player) {
  const { camera } = player;
  const along = ["X", "Y", "Z"].flatMap((letter, axis) => [
    [`along${letter}`, () => camera.lookAlong(axis)],
    [`behind${letter}`, () => camera.lookAlong(axis, -1)],
  ]);
  return {
    ...makePlaneActions(player),
    ...Object.fromEntries(along),
    usual: () => camera.lookAlong(),
    turnLeft: () => camera.turn(-STEP, 0),
    turnRight: () => camera.turn(STEP, 0),
    turnUp: () => camera.turn(0, STEP),
    turnDown: () => camera.turn(0, -STEP),
  };
}

/** Adds the buttons of the views, and connects all. */
export function connectControls(root, player, actions) {
  const fit = root.querySelector('[data-action="fit"]');
  for (const [action, sign, key] of VIEWS.toReversed()) {
    const button = document.createElement("button");
    const words = action === "usual" ? "The usual view" : `View along ${sign}`;
    Object.assign(button, { type: "button", textContent: sign, title: `${words} (${key})`, ariaLabel: words });
    button.dataset.action = action;
    fit.after(button);
  }
  connectAll(root, player, actions);
}
