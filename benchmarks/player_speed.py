"""``python -m benchmarks.player_speed``: sizes of pages, how soon they answer, frames a second.

A page of the compressor, 10 s and 20 s of motion, and one of a chain of twenty masses on springs,
opened from disk in headless Chromium. A page answers when all its controls and curves are there;
frames are those between which the browser asks for a new one while the machine moves.
"""

import shutil
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from statistics import mean, median
from typing import Annotated, Any

import typer

from runtime import load

VIEW: Any = {"width": 1400, "height": 900}
FRAMES = """seconds => new Promise(done => {
  const instants = [];
  player.clock.loop = true;
  player.clock.play();
  const frame = now => {
    instants.push(now);
    if (now - instants[0] < 1000 * seconds) requestAnimationFrame(frame); else done(instants);
  };
  requestAnimationFrame(frame);
})"""


def pages(folder: Path) -> dict[str, Path]:
    """Name → page."""
    compressor = load("slider_crank", "compressor")
    runs = {
        "compressor, 10 s": compressor.simulate(10.0, 601),
        "compressor, 20 s": compressor.simulate(20.0, 1201),
        "twenty masses, 10 s": load("hard/spring_chain", "struck").simulate(10.0, 601),
    }
    found = {}
    for name, result in runs.items():
        found[name] = folder / f"{name.replace(' ', '_').replace(',', '')}.html"
        result.animate(file=found[name])
    return found


def intervals(page: Any, seconds: float) -> list[float]:
    """Times between frames while the machine moves, ms."""
    instants = page.evaluate(FRAMES, seconds)
    return [b - a for a, b in pairwise(instants)]


def main(
    seconds: Annotated[float, typer.Option(help="How long each machine moves.")] = 10.0,
    rounds: Annotated[int, typer.Option(help="Turns, of which the least times count.")] = 3,
) -> None:
    """Measure pages in a browser."""
    from playwright.sync_api import sync_playwright

    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))))
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=browser, args=["--no-sandbox"])
        print("| page | bytes | s until it answers | frames a second | median, ms | over 25 ms |")
        print("| :-- | --: | --: | --: | --: | --: |")
        for name, path in pages(Path(folder)).items():
            ready, spans = [], list[list[float]]()
            for _ in range(rounds):
                page = opened.new_page(viewport=VIEW)
                began = time.perf_counter()
                page.goto(path.as_uri())
                page.wait_for_selector(".player[data-ready=all]")
                ready.append(time.perf_counter() - began)
                spans.append(intervals(page, seconds))
                page.close()
            best = min(spans, key=mean)
            late = sum(span > 25.0 for span in best)
            print(f"| {name} | {path.stat().st_size} | {min(ready):.2f} | {1e3 / mean(best):.1f} "
                  f"| {median(best):.1f} | {late} of {len(best)} |")  # fmt: skip
        opened.close()


if __name__ == "__main__":
    typer.run(main)
