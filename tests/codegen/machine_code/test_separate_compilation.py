"""Callers link to the machine code of long functions, which they load with their own."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from codegen.machine_code.separate_compilation import _LONG

Run = Callable[..., dict[str, Any]]

# A product of 1 to LENGTH with x, written out: `middle` calls `long_one`, and `outer` both.
MODULE = """
from numba import types
from runtime.core.jit import compiled, inner

F8 = types.float64

@inner
def long_one(x, out):
{lines}

@inner
def short_one(x):
    return 2.0 * x

@inner
def middle(x, out):
    long_one(x, out)
    return short_one(out[0])

@compiled(F8(F8, F8[::1]))
def outer(x, out):
    return middle(x, out) + short_one(x)
"""

PROGRAM = """
import json, sys, warnings
warnings.simplefilter("error")
import numpy as np
import separated
out = np.zeros({length})
answer = separated.outer(3.0, out)
functions = (separated.long_one, separated.short_one, separated.middle, separated.outer)
defined = {{
    f.__name__: [
        g.__name__ for g in functions for s in g.overloads.values()
        if any(s.fndesc.llvm_func_name == d.name and not d.is_declaration
               for d in r.library._final_module.functions)
    ] for f in functions for r in f.overloads.values()
}}
print(json.dumps({{
    "answer": answer,
    "last": out[-1],
    "defined": defined,
    "compiled": [f.__name__ for f in functions if sum(f.stats.cache_misses.values())],
    "loaded": [f.__name__ for f in functions if sum(f.stats.cache_hits.values())],
}}))
"""


# A function of the user's, in numba's own cache.
FOREIGN = """
import numba
import separated

@numba.njit("f8(f8, f8[::1])", cache=True)
def twice(x, out):
    return 2.0 * separated.outer(x, out)
"""

CALL_FOREIGN = """
import numpy as np
import foreign
print(foreign.twice(3.0, np.zeros({length})), sum(foreign.twice.stats.cache_misses.values()))
"""


def call(program: str, folder: Path, root: Path, length: int) -> str:
    """What a program prints that imports the modules of a folder."""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join((str(folder), str(root))),
        "NUMBA_CACHE_DIR": str(folder / "cache"),
    }
    done = subprocess.run(
        [sys.executable, "-c", program.format(length=length)],
        env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture
def run(tmp_path: Path, root: Path) -> Run:
    """What a new process reports that imports the module and calls `outer`."""

    def report(length: int = 2 * _LONG) -> dict[str, Any]:
        stores = "\n".join(f"    out[{k}] = {k + 1}.0 * x" for k in range(length))
        text = MODULE.format(lines=stores)
        path = tmp_path / "separated.py"
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
        answer: dict[str, Any] = json.loads(call(PROGRAM, tmp_path, root, length))
        assert answer["answer"] == 2.0 * 3.0 + 2.0 * 3.0
        assert answer["last"] == 3.0 * length
        return answer

    return report


def test_a_caller_has_no_copy_of_what_is_long(run: Run) -> None:
    defined = run()["defined"]
    assert defined["long_one"] == ["long_one"]
    assert defined["outer"] == ["outer"]
    assert "long_one" not in defined["middle"]


def test_another_process_loads_what_is_called_with_its_callers(run: Run) -> None:
    assert set(run()["compiled"]) == {"long_one", "short_one", "middle", "outer"}
    again = run()
    assert again["compiled"] == []
    assert {"outer", "long_one"} <= set(again["loaded"])
    assert "short_one" not in again["loaded"]  # its callers have it in them


def test_callers_of_what_was_compiled_anew_are_compiled_anew(run: Run, tmp_path: Path) -> None:
    run()
    for file in tmp_path.glob("cache/**/separated.long_one*"):
        file.unlink()
    again = run()
    assert {"long_one", "outer"} <= set(again["compiled"])
    assert run()["compiled"] == []


def test_what_is_short_is_copied(run: Run) -> None:
    run(length=3)
    again = run(length=3)
    assert (again["compiled"], again["loaded"]) == ([], ["outer"])


def test_a_function_of_the_user_outlives_what_it_calls(
    run: Run, tmp_path: Path, root: Path
) -> None:
    run()
    (tmp_path / "foreign.py").write_text(FOREIGN)
    calls = [call(CALL_FOREIGN, tmp_path, root, 2 * _LONG) for _ in range(2)]
    for file in tmp_path.glob("cache/**/separated.*-*"):
        file.unlink()
    calls += [call(CALL_FOREIGN, tmp_path, root, 2 * _LONG) for _ in range(2)]
    assert [text.split() for text in calls] == [["24.0", count] for count in "1010"]
