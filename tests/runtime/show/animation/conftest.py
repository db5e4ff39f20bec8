"""A browser, and pages of machines in motion in it."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from runtime import Result, load

WIDE, PHONE = {"width": 1400, "height": 900}, {"width": 390, "height": 844}
Open = Callable[..., Any]


@pytest.fixture(scope="session")
def compressor() -> Result:
    return load("slider_crank", "compressor").simulate(2.0)


@pytest.fixture(scope="session", name="browser")
def _browser() -> Iterator[Any]:
    """Headless Chromium, without Playwright's own downloads."""
    found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)
    if found is None:
        pytest.skip("no Chromium is installed; on Debian: apt-get install chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def compressor_page(compressor: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("pages") / "compressor.html"
    compressor.animate(file=path)
    return path


@pytest.fixture
def show(browser: Any) -> Iterator[Open]:
    """Opens a page: it must ask for nothing else, and report no error and no warning."""
    contexts, wrong, asked = [], [], []

    def opened(path: Path, size: dict[str, int] = WIDE, **options: Any) -> Any:
        context = browser.new_context(viewport=size, **options)
        contexts.append(context)
        page = context.new_page()
        page.on("request", lambda request: asked.append(request.url))
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("console", lambda m: m.type in ("error", "warning") and wrong.append(m.text))
        page.goto(path.as_uri())
        page.wait_for_selector(".player[data-ready=all]")
        return page

    yield opened
    for context in contexts:
        context.close()
    assert not wrong
    assert all(url.startswith(("file:", "data:", "blob:")) for url in asked)
    assert sum(url.startswith("file:") for url in asked) == len(contexts)
