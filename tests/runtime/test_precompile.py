"""Which functions are compiled ahead of the first run, and in which order."""

import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from codegen.errors import InputError
from linkwright.cli.application import app
from runtime.precompile import declared_functions, precompile

RUNTIME = Path(__file__).parents[2] / "runtime"
MODULES = """
import sys
from runtime.precompile import declared_functions
for function in declared_functions(tuple(sys.argv[1:])):
    print(function.__module__)
"""


def modules(root: Path, *methods: str) -> list[str]:
    """The modules of the functions that a new process finds, in their order."""
    done = subprocess.run(
        [sys.executable, "-c", MODULES, *methods], cwd=root, capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    return done.stdout.splitlines()


def test_all_compiled_modules_are_declared_behind_what_they_import(root: Path) -> None:
    declared_functions(())
    for path in RUNTIME.rglob("*.py"):
        if "from runtime.core.jit import" in path.read_text():
            assert ".".join(path.relative_to(root).with_suffix("").parts) in sys.modules
    found = modules(root)
    assert found.index("runtime.integrate.step") < found.index("runtime.integrate.loop")
    assert "runtime.integrate.implicit.bdf" in found


def test_explicit_methods_compile_nothing_of_implicit_ones(root: Path) -> None:
    found = {*modules(root, "dop853")}
    assert not [module for module in found if ".implicit." in module]
    assert len([module for module in found if module.startswith("linkwright_generated_")]) == 1
    assert "runtime.integrate.implicit.radau5" in modules(root, "radau5")


def test_a_method_that_another_loads_is_compiled_with_it(root: Path) -> None:
    found = modules(root, "auto")
    assert any(module.startswith("linkwright_generated_") for module in found)
    assert "runtime.integrate.implicit.stiffness_switching" in found


def test_unknown_method_is_refused_by_name() -> None:
    with pytest.raises(InputError, match="no such method: dop85; there are dop853, dopri5"):
        precompile("dop853", "dop85")


def test_a_line_tells_of_each_room_that_is_compiled() -> None:
    done = CliRunner().invoke(app, ["precompile", "dop853"])
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    assert "compiled runtime.integrate" in lines
    assert len(lines) == len({*lines}) > 4
