"""One package imports what numba does not document, and its table lists all of that."""

import ast
import importlib
import re
from pathlib import Path

import pytest

PACKAGE = "codegen/machine_code"


@pytest.fixture
def table(root: Path) -> list[list[str]]:
    """The cells of each row: names, what for, what it gains, what happens without."""
    page = (root / "docs/development/undocumented-names.md").read_text()
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| ")]
    return rows[2:]


def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
            found |= {x.value for x in node.args if isinstance(x, ast.Constant)}
    return {name for name in found if name.startswith(("numba.core", "numba.np", "llvmlite"))}


def test_no_other_package_imports_them(root: Path) -> None:
    files = [
        p for room in ("codegen", "runtime", "linkwright") for p in (root / room).rglob("*.py")
    ]
    others = [p for p in files if not p.is_relative_to(root / PACKAGE)]
    assert len(others) > 300
    assert {str(p): found for p in others if (found := imports(p))} == {}


def test_every_import_stands_in_the_table(root: Path, table: list[list[str]]) -> None:
    listed = " ".join(row[0] for row in table)
    for path in (root / PACKAGE).glob("*.py"):
        names = {name for name in imports(path) if not name.startswith("llvmlite")}
        assert not names or path.name == "undocumented_names.py", path
        for name in names:
            module, _, last = name.rpartition(".")
            assert module in listed, name
            assert re.search(rf"\b{last}\b", listed), name


def test_numba_has_every_module_of_the_table(table: list[list[str]]) -> None:
    modules = re.findall(r"numba\.core(?:\.[a-z_]+)+", " ".join(row[0] for row in table))
    assert modules
    for name in modules:
        parent, _, last = name.rpartition(".")
        try:
            importlib.import_module(name)
        except ModuleNotFoundError:
            assert hasattr(importlib.import_module(parent), last)
    assert all(len(row) == 4 and all(row) for row in table)
