"""Which modules are compiled ahead of the first run, and in which order."""

from graphlib import TopologicalSorter
from pathlib import Path

import pytest
from typer.testing import CliRunner

from codegen.errors import InputError
from linkwright.cli.application import app
from runtime.integrate.method import EXPLICIT, LEADING, METHODS, REGISTER
from runtime.precompile import import_graph, precompile

RUNTIME = Path(__file__).parents[2] / "runtime"


def test_all_compiled_modules_are_compiled_after_what_they_import():
    graph = import_graph(METHODS)
    compiled = {
        ".".join(path.relative_to(RUNTIME.parent).with_suffix("").parts)
        for path in RUNTIME.rglob("*.py")
        if "from runtime.core.jit import" in path.read_text()
    }
    assert compiled - graph.keys() == {"runtime.precompile"}
    assert {method.module for method in REGISTER.values()} <= graph.keys()
    assert "runtime.core.jit" in graph["runtime.integrate.loop"]
    order = list(TopologicalSorter(graph).static_order())
    assert order.index("runtime.integrate.step") < order.index("runtime.integrate.loop")


def test_explicit_methods_compile_nothing_of_implicit_ones():
    graph = import_graph(EXPLICIT)
    assert not [module for module in graph if ".implicit." in module]
    assert REGISTER["bdf"].module not in graph
    assert REGISTER[EXPLICIT[0]].module in graph
    assert REGISTER[EXPLICIT[1]].module not in import_graph(EXPLICIT[:1])


def test_a_method_that_another_loads_is_compiled_before_it():
    auto, leading = REGISTER["auto"].module, REGISTER[LEADING].module
    graph = import_graph(("auto",))
    assert leading in graph[auto]
    assert "runtime.core.jit" in graph[leading]


def test_unknown_method_is_refused_by_name():
    with pytest.raises(InputError, match="no such method: dop85; there are dop853, dopri5"):
        precompile("dop853", "dop85")


def test_a_line_tells_of_each_room_that_is_compiled():
    done = CliRunner().invoke(app, ["precompile", "dop853"])
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    assert "compiled runtime.integrate" in lines
    assert len(lines) == len({*lines}) > 4
