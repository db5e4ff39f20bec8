// The page within a frame of a notebook, and on paper.

/** In a frame the page is as high as it needs; where the frame may not be changed, it scrolls. */
export function fitFrame() {
  if (globalThis.parent === globalThis) return;
  document.documentElement.classList.add("framed");
  let frame = null;
  try {
    frame = globalThis.frameElement;
  } catch {
    return; // a frame from elsewhere
  }
  if (!frame) return;
  const fit = () => {
    frame.style.height = `${Math.ceil(document.body.getBoundingClientRect().height)}px`;
  };
  new ResizeObserver(fit).observe(document.body);
  fit();
}

/** Printing takes the light colours, also for the curves, which `paint` brings up to date. */
export function keepPrintLight(paint) {
  const { dataset } = document.documentElement;
  let before;
  addEventListener("beforeprint", () => {
    before = dataset.theme;
    dataset.theme = "light";
    paint();
  });
  addEventListener("afterprint", () => {
    if (before === undefined) delete dataset.theme;
    else dataset.theme = before;
    paint();
  });
}
