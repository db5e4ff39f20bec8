"""Sphinx builds the site from this folder: `make docs`, into docs/_build/html."""

import hashlib
import os
import shutil
import sys
from importlib.metadata import version as version_of
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.environment import BuildEnvironment

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
BUILD = DOCS / "_build"
BLOCKS = 6  # about as many as Sphinx divides the pages into
sys.path.insert(0, str(DOCS / "_extensions"))
# Notebooks show figures by the backend of IPython, which one from outside would replace.
os.environ.pop("MPLBACKEND", None)

project = "Linkwright"
author = "The Linkwright authors"
copyright = "2026, The Linkwright authors"  # noqa: A001 (Sphinx reads this name)
version = release = version_of("linkwright")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "built_links",
    "docstrings",
    "element_pictures",
    "glossary_terms",
    "moving_pictures",
    "notebook_pictures",
    "repository_links",
]
root_doc = "index"
exclude_patterns = [
    "_build",
    "gallery/book.md",  # its numbers and figures stand on the pages of the machines
    "gallery/machines",
    "gallery/pages/index.rst",  # gallery/index.md shows the machines by group
    *(f"gallery/pages/**.{ending}" for ending in ("ipynb", "json", "py", "zip")),
]
nitpicky = True
default_role = "code"


PROGRAMS = (".py", ".js", ".css", ".html")  # endings of what makes numbers, figures and players


def is_companion(path: Path) -> bool:
    """Whether a file is a companion of a generated module: it follows from that module.

    The pages build some of them, so that a digest with them would differ after the first build.
    """
    return path.parent == ROOT / "generated" and len(path.stem.split("__")) > len(
        ("model", "scene")
    )


def digest_of_the_source() -> str:
    """A hash of all that the numbers of the site depend on but the pages themselves."""
    digest = hashlib.sha256()
    folders = ("codegen", "docs/_extensions", "generated", "linkwright", "models", "runtime")
    found = (path for folder in folders for path in (ROOT / folder).rglob("*"))
    of_programs = (p for p in found if p.suffix in PROGRAMS and not is_companion(p))
    for path in (ROOT / "constraints.txt", *sorted(of_programs)):
        if ".numba" not in path.name:
            digest.update(str(path.relative_to(ROOT)).encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


# Cells and machines of the gallery run anew where the page or the program has changed.
source_digest = digest_of_the_source()

# Pages: Markdown with cells that run.
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "attrs_inline"]
myst_heading_anchors = 3
nb_execution_mode = "cache"
nb_execution_cache_path = str(BUILD / "cells" / source_digest)
nb_execution_raise_on_error = True
nb_execution_in_temp = True
nb_execution_timeout = 600
nb_execution_show_tb = True
nb_merge_streams = True
nb_render_markdown_format = "gfm"
nb_output_stderr = "remove"  # the note that a kernel is compiled

# Docstrings are numpydoc; types that other libraries document are no links without a network.
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_class_signature = "mixed"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
nitpick_ignore_regex = [("py:class", r"(codegen|numpy|runtime|sympy|xarray)\..*")]

# Machines: one script each, run in the process of the build.
sphinx_gallery_conf = {
    "examples_dirs": ["gallery/machines"],
    "gallery_dirs": ["gallery/pages"],
    "filename_pattern": r"/plot_",
    "abort_on_example_error": False,
    "capture_repr": ("_repr_html_",),
    "ignore_repr_types": r"Figure|list",
    "parallel": True,  # as many at once as readers of pages
    "image_scrapers": ("gallery_parts.scrape",),
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "remove_config_comments": True,
    "reset_modules": (),
    "within_subsection_order": "FileNameSortKey",
}

html_theme = "pydata_sphinx_theme"
html_title = "Linkwright"
html_static_path = ["_static", "gallery/pages/moving"]  # the second is the gallery's work
(DOCS / "gallery" / "pages" / "moving").mkdir(parents=True, exist_ok=True)
html_logo = "_static/logo.svg"
html_favicon = "_static/logo.svg"
html_context = {"default_mode": "auto"}
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {
    "logo": {"text": "Linkwright"},
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "header_links_before_dropdown": 7,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}
# Equations are set by the MathJax of the environment, so that the site needs no network.
mathjax_path = "mathjax/tex-mml-chtml.js"


def forget_what_another_source_gave(app: "Sphinx") -> None:
    """Remove the cells and the machines that were run with another state of the program."""
    for cells in (BUILD / "cells").glob("*"):
        if cells.name != source_digest:
            shutil.rmtree(cells)
    stamp = DOCS / "gallery" / "pages" / ".source"
    if stamp.exists() and stamp.read_text(encoding="utf-8") != source_digest:
        shutil.rmtree(stamp.parent)
    stamp.parent.mkdir(parents=True, exist_ok=True)
    stamp.write_text(source_digest, encoding="utf-8")


def make_the_store_of_cells(app: "Sphinx") -> None:
    """Make the database of run cells before the readers fork: two that make it at once collide."""
    from jupyter_cache import get_cache

    get_cache(nb_execution_cache_path).list_cache_records()


def spread_pages(app: "Sphinx", env: "BuildEnvironment", pages: list[str]) -> None:
    """Spread the pages with cells, which are neighbours by name, over the blocks of readers."""
    pages[:] = [page for first in range(BLOCKS) for page in pages[first::BLOCKS]]


def copy_mathjax(app: "Sphinx", error: Exception | None) -> None:
    """Put MathJax and its fonts beside the other static files."""
    if error is None and app.builder.format == "html":
        target = Path(app.outdir) / "_static" / "mathjax"
        source = Path(str(files("mathjax"))) / "static" / "mathjax" / "es5"
        for part in ("tex-mml-chtml.js", "output/chtml/fonts/woff-v2"):
            if not (target / part).exists():
                (target / part).parent.mkdir(parents=True, exist_ok=True)
                copy = shutil.copytree if (source / part).is_dir() else shutil.copy
                copy(source / part, target / part)


def setup(app: "Sphinx") -> None:
    """Tie the pages to the source."""
    app.add_config_value("source_digest", "", "env", types=[str])
    app.connect("builder-inited", forget_what_another_source_gave, priority=1)
    app.connect("builder-inited", make_the_store_of_cells, priority=2)
    app.connect("env-before-read-docs", spread_pages)
    app.connect("build-finished", copy_mathjax)
