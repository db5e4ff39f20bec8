"""Each term of the glossary stands there once, and the module that it names is there."""

from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
HEADER = ["term", "symbol", "meaning", "source", "module"]


def rows() -> list[list[str]]:
    """The cells of every row of the glossary's tables, headers included."""
    lines = (ROOT / "docs" / "reference" / "glossary.md").read_text(encoding="utf-8").splitlines()
    table = [line.replace(r"\|", "∣") for line in lines if line.startswith("|")]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in table]
    return [row for row in cells if set("".join(row)) != {"-"}]


def test_every_row_has_a_meaning_a_source_and_a_module() -> None:
    incomplete = [row for row in rows() if len(row) != 5 or not (row[0] and row[2] and row[3])]
    assert not incomplete


def test_every_term_stands_there_once() -> None:
    terms = Counter(row[0] for row in rows() if row != HEADER)
    assert not [term for term, count in terms.items() if count > 1]


def test_modules_exist() -> None:
    modules = [row[4].strip("`") for row in rows() if row != HEADER]
    assert not [module for module in modules if not (ROOT / module).is_file()]
