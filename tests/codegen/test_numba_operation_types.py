"""The types of operations that are kept are those that numba finds."""

import operator
from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
import pytest
from numba import njit, types
from numba.core.errors import TypingError
from numba.core.registry import cpu_target
from numba.core.types.functions import BaseFunction
from numba.extending import overload

from codegen import numba_operation_types
from codegen.numba_operation_types import remembered_operation_types

SCALARS = (types.float64, types.int64, types.boolean, types.literal(3), types.complex128)
VECTOR, TABLE = types.Array(types.float64, 1, "C"), types.Array(types.int64, 2, "C")
INDICES = (types.int64, types.literal(2), types.uint64)


@pytest.fixture
def questions(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What numba is asked while nothing is known."""
    queries = list[Any]()
    usual = numba_operation_types._usual

    def ask(operation: Any, context: Any, args: Any, kws: Any) -> Any:
        queries.append((operation.typing_key, args))
        return usual(operation, context, args, kws)

    monkeypatch.setattr(numba_operation_types, "_usual", ask)
    monkeypatch.setattr(numba_operation_types, "_known", {})
    return queries


def signature(operation: Callable[..., Any], *kinds: Any) -> str:
    context = cpu_target.typing_context
    context.refresh()
    return str(context.resolve_function_type(operation, kinds, {}))


CALLS = [
    *product((operator.add, operator.truediv, operator.lt), SCALARS, SCALARS),
    *product((operator.neg, abs), SCALARS),
    *product((operator.getitem,), (VECTOR,), INDICES),
    *product((operator.setitem,), (VECTOR,), INDICES, (types.float64, types.int64)),
    (operator.getitem, TABLE, types.int64),
    (operator.add, VECTOR, types.float64),
    (operator.lt, types.complex128, types.float64),
]


def test_types_and_errors_are_those_of_numba(questions: list[Any]) -> None:
    def found(call: tuple[Any, ...]) -> tuple[bool, str]:
        try:
            return True, signature(*call)
        except TypingError as error:
            return False, str(error)

    plain = [found(call) for call in CALLS]
    assert {typed for typed, _ in plain} == {True, False}
    assert not questions
    with remembered_operation_types():
        assert [found(call) for call in CALLS] == plain
        count = len(questions)
        assert 0 < count < len(CALLS)  # one index stands for the other
        assert [found(call) for call in CALLS] == plain
    # What is known is not asked for; an error is.
    assert len(questions) - count == sum(not typed for typed, _ in plain)


def test_a_second_function_asks_for_nothing_that_the_first_has_found(questions: list[Any]) -> None:
    def first(x: Any, out: Any) -> None:
        out[0] = x[0] * x[1] + 2.0
        out[1] = -x[2]

    def second(x: Any, out: Any) -> None:
        out[3] = -x[4] * x[7] + 3.0

    with remembered_operation_types():
        for function in (first, second):
            count = len(questions)
            njit("void(f8[::1], f8[::1])", cache=False)(function)
    assert 0 < count == len(questions)
    out = np.zeros(4)
    with remembered_operation_types():
        njit("void(f8[::1], f8[::1])", cache=False)(second)(np.arange(8.0), out)
    assert out[3] == -25.0


def test_a_function_that_numba_compiles_for_the_call_is_not_kept(questions: list[Any]) -> None:
    def twice(x: float) -> float:
        return 2 * x

    @overload(twice)
    def _twice(x):  # type: ignore[no-untyped-def]  # numba compares it with the lambda
        return lambda x: 2 * x

    with remembered_operation_types():
        counts = []
        for _ in range(2):
            assert njit(cache=False)(lambda x: twice(x) + 1.0)(3.0) == 7.0
            counts.append([key for key, _ in questions].count(twice))
    assert counts[1] == 2 * counts[0] > 0
    assert not any(operation.typing_key is twice for operation, *_ in numba_operation_types._known)


def test_numba_is_as_it_was_behind_the_block() -> None:
    before = BaseFunction.get_call_type
    with remembered_operation_types(), remembered_operation_types():
        assert BaseFunction.get_call_type is not before
    assert BaseFunction.get_call_type is before
