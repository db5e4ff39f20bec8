"""Links of the built site, checked at the end of each build: pages, files, pictures and anchors.

Sphinx checks the references that it resolves itself. This looks at the result: every relative
`href` and `src` of every page, those of the theme, of cells and of the gallery among them.
"""

import os
from html.parser import HTMLParser
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote, urlsplit

if TYPE_CHECKING:
    from sphinx.application import Sphinx

TARGETS = {"href", "src", "poster", "data"}
ANCHORS = {"id", "name"}


class Page(HTMLParser):
    """The links of a page, and the anchors that others may link to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note the links and anchors of one element."""
        for name, value in attrs:
            if value and name in TARGETS:
                self.links.append(value)
            elif value and name in ANCHORS:
                self.anchors.add(value)


def broken_links(site: Path) -> list[str]:
    """A sentence for each link of the pages of a folder that leads nowhere.

    Links with a scheme or a host, such as `https:` and `data:`, are left alone, and so are the
    templates that a theme puts into `_static`.
    """
    files = [path for path in sorted(site.rglob("*.html")) if path.parent != site / "_static"]
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in files}
    problems = []
    for path, page in pages.items():
        for link in sorted(set(page.links)):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            place = Path(os.path.normpath(path.parent / unquote(parts.path)))
            target = path if not parts.path else place / "index.html" if place.is_dir() else place
            anchor = unquote(parts.fragment)
            if not target.is_file():
                problems.append(f"{path.relative_to(site)} links to {link}: there is no such file")
            elif anchor and target in pages and anchor not in pages[target].anchors:
                problems.append(
                    f"{path.relative_to(site)} links to {link}: there is no such anchor"
                )
    return problems


def check(app: "Sphinx", error: Exception | None) -> None:
    """Warn of each broken link; `make docs` takes warnings for errors."""
    from sphinx.util import logging

    if error is None and app.builder.name == "html":
        for sentence in broken_links(Path(app.outdir)):
            logging.getLogger(__name__).warning("%s", sentence)


def setup(app: "Sphinx") -> dict[str, bool]:
    """Connect to the end of the build, behind what copies files into it."""
    app.connect("build-finished", check, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
