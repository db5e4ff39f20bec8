"""Words that the search finds: the terms of the glossary, and those that stand for an element.

The tables of the glossary become terms of Sphinx, which other pages can refer to. The words in the
first column of the tables of `reference/words` become entries of the index, which the search puts
first when somebody types them.
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

PAGE = "reference/glossary"
WORDS = "reference/words"
SECTION = re.compile(r"^## .*\n\n(?:\|.*\n)+", re.MULTILINE)
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


def words_of_rows(text: str) -> Iterator[tuple[list[str], list[str]]]:
    """The words of each row of the page of words, and the elements to which they lead."""
    for row in text.splitlines():
        first, _, rest = row.removeprefix("| ").partition(" | ")
        if row.startswith("| ") and first != "word":
            yield first.split(", "), re.findall(r"\(\.\./(elements/[\w-]+)\.md\)", rest)


def indexed(words: Iterable[str]) -> str:
    """Words as entries of the index, to be found first."""
    return f"```{{index}} {', '.join(f'! {word}' for word in dict.fromkeys(words))}\n```\n"


def read_source(app: "Sphinx", docname: str, source: list[str]) -> None:
    """Rewrite the glossary, and have the index lead to the words and to the elements."""
    if docname == PAGE:
        source[0] = TABLE.sub(lambda match: terms(match[1]), source[0])
    elif docname == WORDS:
        words = {section: [w for some, _ in words_of_rows(section) for w in some]
                 for section in SECTION.findall(source[0])}  # fmt: skip
        source[0] = SECTION.sub(lambda match: f"{indexed(words[match[0]])}\n{match[0]}", source[0])
    elif docname.startswith("elements/"):
        text = (Path(app.srcdir) / f"{WORDS}.md").read_text(encoding="utf-8")
        own = [w for some, elements in words_of_rows(text) if docname in elements for w in some]
        title, _, rest = source[0].partition("\n\n")
        source[0] = f"{title}\n\n{indexed(own)}\n{rest}" if own else source[0]


def setup(app: "Sphinx") -> dict[str, bool]:
    """Connect to the reading of pages."""
    app.connect("source-read", read_source)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
