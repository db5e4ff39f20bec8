"""Digest of functions: everything that decides their values, and nothing else."""

import functools
import math
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
import pytest

from runtime.sweeps.request import ContentError, value_digest

LEVEL = 1.0


def scaled(result: Any, *, by: float = 1.0) -> float:
    return by * result


def above(level: Any) -> Callable[[Any], Any]:
    return lambda result: result > level


def global_level(result: Any) -> float:
    return result + LEVEL + helper(result)


def helper(result: Any) -> float:
    return math.sqrt(result)


@dataclass
class Threshold:
    level: float

    def exceeded(self, result: Any) -> bool:
        return bool(result > self.level)

    def __call__(self, result: Any) -> bool:
        return self.exceeded(result)


def with_globals(**changes: Any) -> FunctionType:
    return FunctionType(global_level.__code__, {**globals(), **changes})


def with_keyword_default(value: float) -> FunctionType:
    made = FunctionType(scaled.__code__, globals())
    made.__kwdefaults__ = {"by": value}
    return made


def with_field(value: Any) -> Any:
    """An object of a class of a notebook's cell, whose text nobody can read."""
    return type("Gain", (), {"__module__": "__main__", "__slots__": ("level",), "k": value})()


CYCLE: list[Any] = [1.0]
CYCLE.append(CYCLE)
LONG = np.zeros(5000)


@pytest.mark.parametrize(
    ("make", "first", "second"),
    [
        (lambda x: functools.partial(scaled, by=x), 1.0, 2.0),
        (lambda x: Threshold(x).exceeded, 1.0, 2.0),
        (Threshold, 1.0, 2.0),
        (with_keyword_default, 1.0, 2.0),
        (lambda x: with_globals(LEVEL=x), 1.0, 2.0),
        (lambda x: with_globals(helper=x), math.sin, math.cos),
        (lambda x: with_globals(helper=above(x)), 1.0, 2.0),
        (above, np.r_[LONG, 1.0, LONG], np.r_[LONG, 2.0, LONG]),
        (above, Threshold(1.0), Threshold(2.0)),
        (above, {"a": {1, 2}}, {"a": {1, 3}}),
        (above, "1", b"1"),
        (above, 0.0, -0.0),
        (above, np.max, np.min),
        (above, [1].count, [2].count),
        (above, CYCLE, [1.0, [1.0]]),
        (with_field, 5.0, 6.0),
        (with_field, LONG, LONG + 1.0),
        *((lambda x, kind=kind: with_field(kind(x)), helper, global_level) for kind in (
            staticmethod, classmethod, property, functools.cached_property,
        )),
        (lambda x: with_field(staticmethod(with_globals(LEVEL=x))), 1.0, 2.0),
    ],
)  # fmt: skip
def test_what_decides_a_value_is_in_the_digest(
    make: Callable[[Any], Any], first: Any, second: Any
) -> None:
    assert value_digest(make(first)) == value_digest(make(first))
    assert value_digest(make(first)) != value_digest(make(second))


def test_a_global_that_is_not_read_is_not_in_the_digest() -> None:
    assert value_digest(with_globals(OTHER=1)) == value_digest(with_globals(OTHER=2))


def test_equal_objects_have_one_digest_whether_shared_or_not() -> None:
    part = (1.0, "a", Threshold(2.0))
    assert value_digest([part, part]) == value_digest([part, (1.0, "a", Threshold(2.0))])


def test_what_has_no_content_is_named(tmp_path: Path) -> None:
    with (tmp_path / "f").open("w") as file, pytest.raises(ContentError, match="TextIOWrapper"):
        value_digest(above(file))
    deep: list[Any] = []
    for _ in range(10**5):
        deep = [deep]
    with pytest.raises(ContentError, match="too deep"):
        value_digest(deep)


def test_every_process_finds_the_same_digest() -> None:
    program = (
        "from runtime.sweeps.request import value_digest as d\n"
        "def f(r, words={'x', 'y', 'z'}): return r in {'a', 'b', 'c', 'd'} or r in words\n"
        "print(d(f))"
    )
    found = {
        subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, check=True,
            env={"PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }  # fmt: skip
    assert len(found) == 1
