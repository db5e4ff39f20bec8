"""Docstrings, in numpy's form, as Markdown."""

import re
from inspect import cleandoc

UNDERLINE = re.compile(r"-{3,}\s*")
LISTS = ("Attributes", "Parameters", "Raises", "Returns")


def markdown(docstring: str | None) -> str:
    """The text, with each section's heading in bold and its entries as a list."""
    lines = cleandoc(docstring or "").splitlines()
    shown: list[str] = []
    listing = False
    for k, line in enumerate(lines):
        if UNDERLINE.fullmatch(line):
            listing = lines[k - 1] in LISTS
        elif k + 1 < len(lines) and UNDERLINE.fullmatch(lines[k + 1]):
            shown += [f"**{line}**", ""]
        elif listing and line and not line.startswith(" "):
            names = ", ".join(f"`{name.strip()}`" for name in line.split(","))
            shown.append(f"- {names}:")
        elif listing and line:
            shown.append(f"  {line.strip()}")
        else:
            shown.append(line)
    return "\n".join(shown).strip()
