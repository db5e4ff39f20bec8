"""``python -m models``: the library's machines, a line each."""

import ast
from pathlib import Path

from rich.console import Console


def machines() -> dict[str, str]:
    """Name of every machine → the first line of its file's docstring."""
    found, folder = {}, Path(__file__).parent
    for path in (*sorted(folder.glob("[!_]*.py")), *sorted(folder.glob("space/[!_]*.py"))):
        text = ast.get_docstring(ast.parse(path.read_bytes())) or ""
        found[path.relative_to(folder).with_suffix("").as_posix()] = text.partition("\n")[0]
    return found


if __name__ == "__main__":
    console = Console(highlight=False, soft_wrap=True)
    for name, line in machines().items():
        console.print(f"[bold]{name}[/]  {line}")
