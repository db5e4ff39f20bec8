"""No reader of data executes it: who unpickles, evaluates or loads what may do so, by name."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent.parent
EXECUTES = {
    *("eval", "exec", "compile", "__import__", "execfile"),
    *("pickle.load", "pickle.loads", "pickle.Unpickler", "marshal.load", "marshal.loads"),
    *("shelve.open", "joblib.load", "cloudpickle.load", "cloudpickle.loads", "dill.load"),
    *("pandas.read_pickle", "pd.read_pickle", "yaml.load", "yaml.load_all", "yaml.unsafe_load"),
    *("yaml.full_load", "numpy.load", "np.load", "runpy.run_path", "os.system"),
}
PERMITTED = {
    "codegen/files/generated_modules.py": {"compile", "exec"},  # generated modules
    "codegen/machine_code/kernels.py": {"eval"},  # a kernel's signature, of a generated module
    "codegen/reference/pages.py": {"exec"},  # the examples of elements, from their classes
    "runtime/mechanism/mechanism.py": {"pickle.loads"},  # within a pickle, of its model
    "runtime/results/saved_result.py": {"np.load"},  # with allow_pickle=False
    # of processes that the sweep has started, of the sweep itself, and of the scheduler
    "runtime/sweeps/execution.py": {"pickle.load", "pickle.loads"},
}
"""Calls that are there, and what they read."""


def dotted(node: ast.expr) -> str:
    """``a.b`` of a name or attribute, else empty."""
    if isinstance(node, ast.Attribute):
        return f"{dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def calls(tree: ast.AST) -> Iterator[ast.Call]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.Call))


@pytest.mark.parametrize("package", ["codegen", "linkwright", "runtime"])
def test_what_executes_data_is_named_here(package: str) -> None:
    found = dict[str, set[str]]()
    for path in sorted((ROOT / package).rglob("*.py")):
        if not {"templates", "generated"} & {*path.relative_to(ROOT).parts}:
            names = {dotted(call.func) for call in calls(ast.parse(path.read_bytes()))}
            if names & EXECUTES:
                found[path.relative_to(ROOT).as_posix()] = names & EXECUTES
    permitted = {k: v for k, v in PERMITTED.items() if k.startswith(f"{package}/")}
    present = {k: v for k, v in permitted.items() if (ROOT / k).is_file()}
    assert found == present


def test_arrays_are_loaded_without_pickles() -> None:
    tree = ast.parse((ROOT / "runtime/results/saved_result.py").read_bytes())
    (load,) = (call for call in calls(tree) if dotted(call.func) == "np.load")
    words = {word.arg: ast.unparse(word.value) for word in load.keywords}
    assert words == {"allow_pickle": "False"}


def test_yaml_is_composed_and_not_constructed() -> None:
    text = (ROOT / "runtime/cases/document.py").read_text(encoding="utf-8")
    used = {dotted(c.func) for c in calls(ast.parse(text)) if dotted(c.func).startswith("yaml.")}
    assert used == {"yaml.compose"}
