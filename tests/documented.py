"""The cells of a page of the documentation, run as they stand there."""

import ast
import re
from pathlib import Path
from typing import Any

import pytest

CELL = re.compile(r"```\{code-cell\} (?:ipython3|python)\n(.*?)```", re.DOTALL)


def cells(page: Path) -> list[str]:
    """The texts of the cells of a page."""
    found = CELL.findall(page.read_text(encoding="utf-8"))
    assert found, f"{page} has no cells"
    return found


def run_cells(page: Path, folder: Path) -> dict[str, Any]:
    """Everything that the code of a page defines, run in `folder`; `shown`: what it shows.

    A cell shows the value of its last line, if that is an expression.
    """
    texts = cells(page)
    if any(re.search(r"\.(plot|draw)\(", text) for text in texts):
        pytest.importorskip("matplotlib.pyplot")
    shown: list[Any] = []
    names: dict[str, Any] = {"__name__": f"documented_{page.stem.replace('-', '_')}"}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for text in texts:
            body = ast.parse(text).body
            last = body.pop() if isinstance(body[-1], ast.Expr) else None
            exec(compile(ast.Module(body, []), str(page), "exec"), names)
            if last is not None:
                shown.append(eval(compile(ast.Expression(last.value), str(page), "eval"), names))
                close_figures()
    return names | {"shown": shown}


def close_figures() -> None:
    """Drop the figures of pyplot, where it is there."""
    try:
        from matplotlib import pyplot
    except ImportError:
        return
    pyplot.close("all")
