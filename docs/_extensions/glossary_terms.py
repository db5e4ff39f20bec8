"""The tables of the glossary as terms of Sphinx, which other pages and the search can refer to."""

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

PAGE = "reference/glossary"
TABLE = re.compile(r"^\| term \|.*\n\|[-|]+\|\n((?:\|.*\n?)+)", re.MULTILINE)


def terms(table: str) -> str:
    """The rows of a table, term | symbol | meaning | source | module, as a glossary."""
    entries = []
    for line in table.splitlines():
        row = [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1]]
        term, symbol, meaning, source, module = (cell.replace(r"\|", "|") for cell in row)
        facts = [part for part in (symbol, source if source != "—" else "", module) if part]
        entries.append(f"{term}\n  {meaning}\n\n  {' · '.join(facts)}\n")
    return "```{glossary}\n" + "\n".join(entries) + "```\n"


def read_source(_: "Sphinx", docname: str, source: list[str]) -> None:
    """Rewrite the glossary."""
    if docname == PAGE:
        source[0] = TABLE.sub(lambda match: terms(match[1]), source[0])


def setup(app: "Sphinx") -> dict[str, bool]:
    """Connect to the reading of pages."""
    app.connect("source-read", read_source)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
