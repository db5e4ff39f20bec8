"""What the runtime adds to numba's compiling and caching."""

import ast
import re
from pathlib import Path
from threading import Barrier, Thread
from typing import Any

import numpy as np
import pytest
from filelock import FileLock
from numba import types

import runtime.core.jit
from runtime.core import workspace_rows
from runtime.core.function_table_layout import TableLayout
from runtime.core.jit import ADDRESSES, addressed, addresses, at, compiled, inner

F8 = types.float64
BINARY = types.FunctionType(F8(F8, F8))


@compiled(F8(F8, F8))
def plus(a: float, b: float) -> float:
    return a + b


@compiled(F8(F8, F8))
def times(a: float, b: float) -> float:
    return a * b


@addressed(F8(F8, F8))
def less(a: float, b: float) -> float:
    return a - b


first_of = at(BINARY, 0)
second_of = at(BINARY, 1)


@compiled(F8(ADDRESSES, F8, F8))
def both(table: np.ndarray, a: float, b: float) -> float:
    return first_of(table)(a, b) * 100.0 + second_of(table)(a, b)


def test_functions_are_found_by_their_addresses() -> None:
    assert both(addresses((plus, times)), 3.0, 4.0) == 712.0
    assert both(addresses((times, plus)), 3.0, 4.0) == 1207.0


def test_what_has_an_address_alone_is_called_by_compiled_code_alone() -> None:
    assert both(addresses((less, less)), 7.0, 4.0) == 303.0
    with pytest.raises(TypeError, match=r"less is called by compiled code alone"):
        less(7.0, 4.0)


def test_a_function_waits_for_the_process_that_compiles_it() -> None:
    def half(a: float) -> float:
        return 0.5 * a

    function: Any = inner(half)
    thread = Thread(target=function.compile, args=((F8,),))
    with FileLock(f"{function._cache._cache_file._index_path}.lock"):
        thread.start()
        thread.join(0.3)
        assert thread.is_alive()
        assert not function.overloads
    thread.join()
    assert list(function.overloads) == [(F8,)]


def test_a_new_table_compiles_nothing() -> None:
    both(addresses((times, times)), 1.0, 1.0)
    before = len(both.signatures)
    both(addresses((plus, plus)), 1.0, 1.0)
    assert len(both.signatures) == before == 1


def _negative(a: float) -> float:
    return -a


def test_a_function_is_compiled_when_it_is_first_called() -> None:
    function: Any = compiled(F8(F8))(_negative)
    assert not function.overloads
    assert function(3) == -3.0  # a whole number as well
    assert list(function.overloads) == [(F8,)]
    with pytest.raises(TypeError, match="No matching definition"):
        function("three")


def test_a_function_is_compiled_when_compiled_code_calls_it_or_needs_its_address() -> None:
    called, needed = (compiled(F8(F8))(_negative) for _ in range(2))

    def twice(a: float) -> float:
        return called(called(a)) + 1.0

    assert compiled(F8(F8))(twice)(2.0) == 3.0
    assert len(called.signatures) == 1  # type: ignore[attr-defined]
    assert not needed.overloads  # type: ignore[attr-defined]
    assert addresses([needed])[0] != 0
    assert len(needed.signatures) == 1  # type: ignore[attr-defined]


def test_threads_that_call_a_function_at_once_compile_it_once() -> None:
    function: Any = compiled(F8(F8))(_negative)
    answers: list[float] = []
    start = Barrier(8)

    def call() -> None:
        start.wait()
        answers.append(function(1.0))

    threads = [Thread(target=call) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == [-1.0] * 8
    assert len(function.overloads) == 1


def test_every_file_with_compiled_code_counts_in_the_stamp() -> None:
    root = Path(runtime.core.jit.__file__).parent
    for path in root.rglob("*.py"):
        text = path.read_text()
        if re.search(
            r"^@(compiled|unlocked|addressed|allocating|inner|inlined|fetched|njit)|numba\.njit\(",
            text,
            re.MULTILINE,
        ):
            assert "runtime.core.jit" in text, path


def test_constants_by_keyword_compile_once() -> None:
    def scaled(a: float, factor: int) -> float:
        return a * factor

    function: Any = inner(scaled)

    def twice(a: float) -> float:
        return float(function(a, factor=2) + function(a, factor=3))

    assert compiled(F8(F8))(twice)(1.0) == 5.0
    assert len(function.overloads) == 1


@pytest.mark.parametrize("name", ["modes", "q0", "size", "constraints"])
def test_a_name_of_a_table_is_given_once(name: str) -> None:
    """Taken are arrays and rows of the run's table, attributes of all arrays, and kernels."""
    assert workspace_rows.Y0 == 0  # declares its rows
    with pytest.raises(ValueError, match=name):
        TableLayout(attributes=True).floats(name, 1)


def test_a_slot_of_a_table_has_one_name() -> None:
    layout = TableLayout()
    layout.number("count")
    with pytest.raises(ValueError, match="'count' is taken"):
        layout.floats("count", 1)


DECORATORS = re.compile(
    "^(compiled|allocating|unlocked|addressed|inner|inner_allocating|closure|inlined|fetched)\\b"
)


def imported_names(tree: ast.Module, folder: Path) -> dict[str, Path]:
    """What a module has of others of the runtime, name → file."""
    found = {}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("runtime."):
            place = folder.joinpath(*str(node.module).split("."))
            for alias in node.names:
                inside = place / f"{alias.name}.py"
                home = inside if inside.is_file() else place.with_suffix(".py")
                found[alias.asname or alias.name] = home
    return found


def test_an_edit_of_a_constant_is_an_edit_of_the_code_that_has_it() -> None:
    """Compiled code holds the constants that it uses: their files name its folder, too."""
    files, outside, seen = runtime.core.jit.sources(), [], 0
    for path, text in files.items():
        tree = ast.parse(text)
        names = imported_names(tree, runtime.core.jit.LIBRARY)
        for function in ast.walk(tree):
            if isinstance(function, ast.FunctionDef) and DECORATORS.search(
                " ".join(map(ast.unparse, function.decorator_list))
            ):
                used = {x.id for line in function.body for x in ast.walk(line)
                        if isinstance(x, ast.Name)}  # fmt: skip
                homes = {names[name] for name in used & names.keys()}
                seen += len(homes)
                outside += [(path.name, function.name, h.name) for h in homes - files.keys()]
    assert seen > 500
    assert outside == []
