// The numbers of a page, as in the plane; the library that draws solids is unpacked before them.

import { inflated, readBlock as readNumbers } from "../data.js";

export { inflated };

/** The header with its arrays, once three.js is there. */
export async function readBlock(text) {
  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await inflated(document.getElementById("three").textContent));
  document.head.append(script);
  return readNumbers(text);
}
