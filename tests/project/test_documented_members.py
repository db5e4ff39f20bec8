"""Pages name members of the package, and outcomes of runs, that exist."""

import importlib
import re
from pathlib import Path

import linkwright

MEMBER = re.compile(r"\b(?:(?:lw|linkwright)\.|(?=Outcome\.))([A-Za-z]\w*(?:\.[A-Za-z]\w*)*)")
PLACEHOLDER = "NAME"


def has(path: str) -> bool:
    """Whether `linkwright` has a member of this dotted path."""
    found = linkwright
    for name in path.split("."):
        if not hasattr(found, name):
            try:
                importlib.import_module(f"{found.__name__}.{name}")
            except (ImportError, AttributeError):
                return False
        found = getattr(found, name)
    return True


def test_a_member_that_does_not_exist_is_found() -> None:
    text = "lw.Outcome.OK, linkwright.cli.application, Outcome.CONDITION, lw.loud(model)"
    missing = [path for path in MEMBER.findall(text) if not has(path)]
    assert missing == ["Outcome.CONDITION", "loud"]


def test_members_in_pages_exist(root: Path) -> None:
    pages = [root / "README.md", *(root / "docs").rglob("*.md"), *(root / "docs").rglob("*.py")]
    missing = {
        f"{page.relative_to(root)}: {path}"
        for page in pages
        if "_build" not in page.parts
        for path in MEMBER.findall(page.read_text(encoding="utf-8"))
        if path != PLACEHOLDER and not has(path)
    }
    assert not missing
