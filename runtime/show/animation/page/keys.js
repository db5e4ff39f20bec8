// The keyboard: each key, what it is for, and the name of its action.

export const KEYS = [
  [[" ", "k"], "space", "play or pause", "play"],
  [["ArrowRight"], "→", "a frame forward (with shift ten)", "forward"],
  [["ArrowLeft"], "←", "a frame back (with shift ten)", "back"],
  [["Home"], "home", "to the start", "start"],
  [["End"], "end", "to the end", "end"],
  [["e"], "e", "to the next event", "nextEvent"],
  [["E"], "shift e", "to the event before", "previousEvent"],
  [[">", "."], "> or .", "faster", "faster"],
  [["<", ","], "< or ,", "slower", "slower"],
  [["l"], "l", "play once, or again and again", "loop"],
  [["+", "="], "+", "zoom in", "zoomIn"],
  [["-"], "−", "zoom out", "zoomOut"],
  [["0"], "0", "the whole flight, or the machine", "fit"],
  [["w"], "w", "view up", "panUp"],
  [["a"], "a", "view to the left", "panLeft"],
  [["s"], "s", "view down", "panDown"],
  [["d"], "d", "view to the right", "panRight"],
  [["f"], "f", "applied forces", "force"],
  [["r"], "r", "reactions", "reaction"],
  [["q"], "q", "torques", "torque"],
  [["m"], "m", "centres of mass and frames", "frames"],
  [["n"], "n", "names of joints", "names"],
  [["p"], "p", "paths of points", "traces"],
  [["j"], "j", "next joint, force or body", "nextElement"],
  [["J"], "shift j", "the one before", "previousElement"],
  [["i"], "i", "tell the state of all bodies", "tellAll"],
  [["t"], "t", "light or dark", "theme"],
  [["?", "h"], "?", "this list", "help"],
];

const OWN = { CHECKBOX: [" "], INPUT: ["ArrowLeft", "ArrowRight", "Home", "End"], SELECT: null, BUTTON: [" "], SUMMARY: [" "] };

/** Calls actions by keys, unless the element that has the focus uses the key itself. */
export function listenToKeys(actions) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const own = OWN[event.target.type === "checkbox" ? "CHECKBOX" : event.target.tagName];
    const slider = event.target.matches?.("#time");
    if (own === null || (own?.includes(event.key) && !slider) || document.querySelector("dialog[open]")) return;
    const found = KEYS.find(([keys]) => keys.includes(event.key));
    if (!found) return;
    event.preventDefault();
    actions[found[3]](event.shiftKey ? 10 : 1);
  });
}

/** Fills the list of keys. */
export function listKeys(table) {
  for (const [, sign, meaning] of KEYS) {
    const row = table.insertRow();
    const key = document.createElement("kbd");
    key.textContent = sign;
    row.insertCell().append(key);
    row.insertCell().textContent = meaning;
  }
}
