"""What the documents point to is there."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent.parent
WRITTEN = ("_build", "notebooks", "pages")  # folders of docs that a build of the site writes
PAGES = [
    page
    for folder in ("", "docs", "benchmarks", "tests/data")
    for page in sorted((ROOT / folder).glob("**/*.md" if folder else "*.md"))
    if not set(WRITTEN) & set(page.relative_to(ROOT).parts)
]
LINK = re.compile(r"\]\((?!https?:)([^)#]+)(#[^)]*)?\)")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    broken = [m[1] for m in LINK.finditer(text) if not (page.parent / m[1]).exists()]
    assert not broken


@pytest.mark.parametrize("notebook", sorted(ROOT.glob("notebooks/*.ipynb")), ids=lambda n: n.name)
def test_links_of_notebooks_lead_somewhere(notebook: Path) -> None:
    text = notebook.read_text(encoding="utf-8")
    broken = [m[1] for m in LINK.finditer(text) if not (notebook.parent / m[1]).exists()]
    assert not broken


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_files_that_are_named_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    named = re.findall(
        r"`((?:benchmarks|codegen|docs|linkwright|models|runtime|tests)/[\w/.]+)`", text
    )
    assert not [path for path in named if not (ROOT / path).exists()]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_anchors_are_headings(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    lost = []
    for m in re.finditer(r"\]\((?!https?:)([^)#]*)#([^)]+)\)", text):
        target = page.parent / m[1] if m[1] else page
        if target.suffix == ".md":
            lines = target.read_text(encoding="utf-8").splitlines()
            headings = [line.lstrip("# ") for line in lines if line.startswith("#")]
            anchors = {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings}
            lost += [] if m[2] in anchors else [m[0]]
    assert not lost


def test_every_page_of_the_site_is_in_a_table_of_pages() -> None:
    """Sphinx says so as well; here it is said before the site is built."""
    docs = ROOT / "docs"
    # The tables of the book stand on the pages of the machines, with numbers of the same build.
    listed = {docs / "index.md", docs / "gallery" / "book.md"}
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for tree in re.findall(r"```\{toctree\}\n(.*?)```", text, re.DOTALL):
            entries = [
                line.strip() for line in tree.splitlines() if line.strip()[:1] not in {"", ":"}
            ]
            named = [re.sub(r".*<(.*)>", r"\1", entry) for entry in entries]
            listed |= {path for name in named for path in page.parent.glob(f"{name}.md")}
            listed |= {(page.parent / f"{name}.md").resolve() for name in named if "*" not in name}
    pages = {page for page in PAGES if page.is_relative_to(docs) and page.parent.name != "elements"}
    assert not pages - listed
