"""Kernels are called from Python by their addresses, from compiled code by name and as values."""

import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numba
import numpy as np
import pytest
from numba import types

from codegen.files.generated_modules import import_generated
from runtime.core.arrays import f8, vector

TEXT = """import numba

OPTIONS = {"cache": True, "error_model": "numpy"}


@numba.njit(**OPTIONS)
def square(x):
    return x * x


@numba.njit("f8(f8[::1], f8)", **OPTIONS)
def number(p, t):
    return square(p[0]) / t


@numba.njit("i8(f8[::1], f8)", **OPTIONS)
def integer(p, t):
    return 1 if p[0] > t else 0


@numba.njit("void(f8, f8[::1], i8[::1])", **OPTIONS)
def nothing(t, p, modes):
    p[modes[0]] = t


@numba.njit("Tuple((f8, f8))(f8)", **OPTIONS)
def pair(x):
    return x, x
"""


@pytest.fixture
def module(tmp_path: Path) -> ModuleType:
    path = tmp_path / "kernels.py"
    path.write_text(TEXT)
    return import_generated(path)


def test_python_calls_them(tmp_path: Path, module: ModuleType) -> None:
    p, modes = np.array([3.0, 0.0]), np.array([1])
    assert module.number(p, 2) == module.number(p, np.int32(2)) == 4.5
    assert module.number(p, 0.0) == np.inf
    assert module.integer(p, 2.0) == 1
    assert module.nothing(7.0, p, modes) is None
    assert p.tolist() == [3.0, 7.0]
    path = tmp_path / "others.py"
    path.write_text(TEXT.replace("x * x", "x + 1.0"))
    other = import_generated(path)
    assert (module.number(p, 1.0), other.number(p, 1.0), module.number(p, 1.0)) == (9.0, 4.0, 9.0)


@pytest.mark.parametrize(
    ("arguments", "given"),
    [
        ((np.ma.zeros(2), 1.0), "float64, float64"),
        ((np.zeros(4)[::2], 1.0), "array(float64, 1d, A), float64"),
        ((np.zeros(2, np.int64), 1.0), "array(int64, 1d, C), float64"),
        ((np.ones(2, ">f8"), 1.0), ">f8, float64"),
        ((np.broadcast_to(0.0, 1), 1.0), "readonly array(float64, 1d, C), float64"),
        ((np.zeros((2, 2)), 1.0), "array(float64, 2d, C), float64"),
        ((np.zeros(2),), "array(float64, 1d, C)"),
        ((np.zeros(2), 1.0, 1.0), "array(float64, 1d, C), float64, float64"),
        ((1.0, np.zeros(2)), "float64, array(float64, 1d, C)"),
        ((np.zeros(2), "1"), "array(float64, 1d, C), unicode_type"),
        ((), "nothing"),
    ],
    ids=str,
)
def test_other_arguments_are_refused(
    module: ModuleType, arguments: tuple[object, ...], given: str
) -> None:
    """What is no array of that kind would be read as one."""
    with pytest.raises(TypeError) as caught:
        module.number(*arguments)
    wanted = "number(p: array(float64, 1d, C), t: float64) is called with"
    assert str(caught.value) == f"{wanted} ({given})."
    assert module.number(np.ones(2), 1) == 1.0


def test_what_python_does_not_call_says_so(module: ModuleType) -> None:
    with pytest.raises(TypeError, match=r"pair returns .*; Python calls kernels that return"):
        module.pair(0.0)
    with pytest.raises(TypeError, match="square has no one signature"):
        module.square(2.0)


def test_compiled_code_calls_them_by_name_and_as_values(module: ModuleType) -> None:
    number, p = module.number, np.array([3.0, 1.0])
    by_name = numba.njit(lambda p: number(p, 1.0))
    assert by_name(p) == 9.0
    kind = types.FunctionType(f8(vector, f8))
    as_value = numba.njit(f8(kind, vector))(lambda kernel, p: kernel(p, 1.0))
    assert as_value(number, p) == 9.0
    integer, nothing = module.integer, module.nothing
    modes = np.array([1])
    others = numba.njit(lambda p, modes: (nothing(7.0, p, modes), integer(p, 2.0)))
    assert others(p, modes) == (None, 1)
    assert p.tolist() == [3.0, 7.0]


FOREIGN = """import sys
from pathlib import Path

import numba
import numpy as np

from codegen.files.generated_modules import import_generated

number = import_generated(Path(sys.argv[1])).number


@numba.njit("f8(f8[::1])", cache=True)
def twice(p):
    return 2.0 * number(p, 1.0)


print(twice(np.array([3.0])))
"""


def test_no_cache_of_a_users_keeps_an_old_kernel(tmp_path: Path, root: Path) -> None:
    """Numba keeps no function that holds an address, and says so."""
    path, program, answers = tmp_path / "kernels.py", tmp_path / "program.py", []
    program.write_text(FOREIGN)
    for text in (TEXT, TEXT.replace("x * x", "x + 1.0")):
        path.write_text(text)
        done = subprocess.run(
            [sys.executable, program, path], env={**os.environ, "PYTHONPATH": str(root)},
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        assert "Cannot cache compiled function" in done.stderr
        answers.append(float(done.stdout))
    assert answers == [18.0, 8.0]


def test_a_module_without_options_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "plain.py"
    path.write_text('import numba\n\n\n@numba.njit("f8(f8)")\ndef twice(x):\n    return 2.0 * x\n')
    assert import_generated(path).twice(x=2.0) == 4.0
