"""Write docs/development/modules.md, every module with the first sentence of its docstring.

Usage: ``python docs/make_modules.py [--check]``. With ``--check`` nothing is written; the exit
status is 1 where the page is stale.
"""

import ast
import sys
from itertools import groupby
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "development" / "modules.md"

ROOMS = ("linkwright", "codegen", "runtime")

HEAD = """# Modules

Every module of the compiler and the runtime, with the first sentence of its docstring.
`docs/make_modules.py` makes the page from the source, and `make check` compares them.
[architecture.md](../architecture.md) has the rooms and the order in which they depend on each
other.
"""


def summary(path: Path) -> str:
    """The first sentence of a module's docstring, on one line."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    first = " ".join(text.split("\n\n")[0].split())
    return first.replace("|", r"\|")


def page() -> str:
    """The text of docs/development/modules.md."""
    parts = [HEAD]
    files = [path for room in ROOMS for path in (ROOT / room).rglob("*.py")]
    files.sort(key=lambda path: (path.parent.parts, path.name))
    for room, modules in groupby(files, key=lambda path: path.parent):
        listed = [(path, summary(path)) for path in modules]
        about = next((said for path, said in listed if path.name == "__init__.py"), "")
        parts.append(f"\n## `{room.relative_to(ROOT).as_posix()}`\n\n")
        parts.append(f"{about}\n\n" if about else "")
        rows = [f"| `{path.name}` | {said} |\n" for path, said in listed if path.stem != "__init__"]
        parts.append("| module | content |\n|---|---|\n" + "".join(rows) if rows else "")
    return "".join(parts).rstrip() + "\n"


def main(arguments: list[str]) -> int:
    """Write the page, or compare it."""
    text = page()
    if "--check" not in arguments:
        PAGE.write_text(text, encoding="utf-8")
        return 0
    if PAGE.exists() and PAGE.read_text(encoding="utf-8") == text:
        return 0
    print(
        "docs/development/modules.md is stale; run `python docs/make_modules.py`", file=sys.stderr
    )
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
