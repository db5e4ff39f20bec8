"""The tests' own compilation: a kernel that two files have in common is compiled once."""

import math
import sys
from pathlib import Path

import pytest

from codegen.files.generated_modules import import_generated, module_name
from tests.machine_code import compile_apart

ATTRIBUTES = """import math

import numba

OPTIONS = {{"cache": True}}


@numba.njit("f8(f8)", **OPTIONS)
def of_module(x):
    return math.{function}(x)


@numba.njit("f8(f8)", **OPTIONS)
def builtin(x):
    return {choice}(x, 2.0)
"""
TEXT = '''import numba

RATE = {rate}
OPTIONS = {{"cache": True}}


@numba.njit(**OPTIONS)
def rate():
    return RATE


@numba.njit("f8(f8)", **OPTIONS)
def twice(x):
    """Double x, in a file where the rate is {rate}."""
    return 2.0 * x


@numba.njit("f8(f8)", **OPTIONS)
def scaled(x):
    return rate() * x
'''


pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Linux alone forks processes")


def test_equal_kernels_are_compiled_once(tmp_path: Path) -> None:
    kept = tmp_path / "kept"
    for rate in (3.0, 4.0):
        path = tmp_path / f"rate_{rate:g}.py"
        path.write_text(text := TEXT.format(rate=rate))
        compile_apart(module_name(path, text), path, text, kept)
        module = import_generated(path)
        assert (module.twice(1.0), module.scaled(1.0)) == (2.0, rate)
        assert not {**module.twice.stats.cache_misses, **module.scaled.stats.cache_misses}
    # `twice` of both; of either file its rate, and what calls it.
    assert len(list(kept.iterdir())) == 5


def test_kernels_that_differ_in_a_builtin_or_an_attribute_are_compiled_each(tmp_path: Path) -> None:
    """The byte code of these kernels is the same: it holds the place of a name, not the name."""
    kept, answers = tmp_path / "kept", {}
    for function, choice in (("sin", "max"), ("cos", "min")):
        path = tmp_path / f"{function}_{choice}.py"
        path.write_text(text := ATTRIBUTES.format(function=function, choice=choice))
        compile_apart(module_name(path, text), path, text, kept)
        module = import_generated(path)
        answers[function] = (module.of_module(1.0), module.builtin(1.0))
    assert answers == {"sin": (math.sin(1.0), 2.0), "cos": (math.cos(1.0), 1.0)}
