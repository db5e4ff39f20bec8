"""Messages name one command, `linkwright`."""

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
FORMS = "python -m codegen", "python -m runtime"
ALLOWED = {
    "codegen/__main__.py": "the program's own name, as it was called",
    "runtime/__main__.py": "the same",
    "codegen/emit/runge_kutta.py": "the header of a generated file",
    "codegen/generated_files/provenance.py": "the same",
    "codegen/explain/element_times.py": "the same",
    "codegen/files/generated_modules.py": "finds it in a header",
    "codegen/reference/pages.py": "the last line of a generated page",
}


def texts(path: Path) -> Iterator[str]:
    """All texts of a module that are no docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    bare = {node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in bare:
            yield node.value


def test_messages_name_the_command() -> None:
    packages = (ROOT / name for name in ("codegen", "runtime", "linkwright"))
    found = {
        path.relative_to(ROOT).as_posix()
        for package in packages
        for path in package.rglob("*.py")
        if any(form in text for text in texts(path) for form in FORMS)
    }
    assert found == {*ALLOWED}
