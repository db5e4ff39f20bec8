"""A notebook shows at least one picture of its own; a page without one makes the build warn."""

from typing import TYPE_CHECKING

from docutils import nodes
from sphinx.util import logging

if TYPE_CHECKING:
    from sphinx.application import Sphinx

NOTEBOOKS = "notebooks/"
OUTPUT = "/jupyter_execute/"  # where MyST-NB keeps the pictures that cells show


def shows_a_picture(page: nodes.document) -> bool:
    """Whether a cell of a page shows a picture."""
    return any(OUTPUT in image.get("uri", "") for image in page.findall(nodes.image))


def check(app: "Sphinx", page: nodes.document) -> None:
    """Warn of a notebook that shows none."""
    name = app.env.docname
    if name.startswith(NOTEBOOKS) and not shows_a_picture(page):
        logging.getLogger(__name__).warning("no cell shows a picture", location=name)


def setup(app: "Sphinx") -> dict[str, bool]:
    """Look at each page that is read."""
    app.connect("doctree-read", check)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
