"""Links of pages to files of the repository that are no pages of the site.

Pages are read in the repository as well as on the site. A link that leaves the folder of the pages
becomes a download of the file, and a link to a folder, its name alone. Notebooks are pages.
"""

import json
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

LINK = re.compile(r"(?<!!)\[([^\]]+)\]\((?![a-z]+:|#)([^)#\s]+)(#[^)\s]*)?\)")
FENCE = re.compile(r"(^(`{3,}|:{3,}).*?^\2`*\s*$)", re.MULTILINE | re.DOTALL)
NOTEBOOKS = "notebooks"
BOOK = "gallery/book.md"  # on the site, the gallery has its numbers on the pages of the machines


def rewritten(text: str, page: Path, docs: Path, folder: Path | None = None) -> str:
    """The text of a page with its links out of `docs` turned into what the site can show.

    `folder` is where the site has the page, if not where `page` lies.
    """

    def link(match: re.Match[str]) -> str:
        label, path, anchor = match.groups()
        target = Path(os.path.normpath(page.parent / path))
        place = folder or page.parent
        if target == docs / BOOK:
            return f"[{label}]({os.path.relpath(target.with_name('index.md'), place)})"
        if target.is_relative_to(docs) and not target.is_dir():
            return f"[{label}]({os.path.relpath(target, place)}{anchor or ''})"
        if target.suffix == ".ipynb":
            target = docs / NOTEBOOKS / target.name
            return f"[{label}]({os.path.relpath(target, place)})"
        if target.is_file():
            return f"{{download}}`{label.strip('`')} <{os.path.relpath(target, place)}>`"
        return label

    parts = FENCE.split(text)
    # `split` gives text, fence, its mark, text, …
    return "".join(
        LINK.sub(link, part) if k % 3 == 0 else part for k, part in enumerate(parts) if k % 3 != 2
    )


def read_source(app: "Sphinx", docname: str, source: list[str]) -> None:
    """Rewrite the links of a page; give the generated index of the elements its table of pages."""
    page = Path(app.env.doc2path(docname))
    if page.suffix == ".md":
        source[0] = rewritten(source[0], page, Path(app.srcdir))
    if docname == "elements/index":
        source[0] += "\n```{toctree}\n:hidden:\n:glob:\n\n*\n```\n"


def notebook_of_the_site(path: Path, docs: Path) -> str:
    """A notebook of the repository, with the links in its texts as the site has them."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    for cell in notebook["cells"]:
        if cell["cell_type"] == "markdown":
            text = rewritten("".join(cell["source"]), path, docs, docs / NOTEBOOKS)
            cell["source"] = text.splitlines(keepends=True)
    return json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"


def copy_notebooks(app: "Sphinx") -> None:
    """Copy the notebooks of the repository, which stand beside `docs`, where they have changed."""
    docs = Path(app.srcdir)
    (docs / NOTEBOOKS).mkdir(exist_ok=True)
    there = {path.name: path for path in (docs.parent / NOTEBOOKS).glob("*.ipynb")}
    for path in (docs / NOTEBOOKS).glob("*.ipynb"):
        if path.name not in there:
            path.unlink()
    for name, path in there.items():
        copy, text = docs / NOTEBOOKS / name, notebook_of_the_site(path, docs)
        if not copy.exists() or copy.read_text(encoding="utf-8") != text:
            copy.write_text(text, encoding="utf-8")


def setup(app: "Sphinx") -> dict[str, bool]:
    """Connect to the reading of pages."""
    app.connect("builder-inited", copy_notebooks, priority=2)
    app.connect("source-read", read_source)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
