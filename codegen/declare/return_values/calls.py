"""Calls of methods that a modeller may have written, and the kinds of values that they return."""

import re
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from contextvars import ContextVar
from functools import wraps
from typing import Any, TypeVar

import sympy

from codegen.declare.element import label
from codegen.declare.plain_expression import plain_expression
from codegen.declare.symbols import KINDS, Coordinate, Time, Velocity, kinds
from codegen.declare.units import known_unit
from codegen.errors import FAILURES, LinkwrightError, ModelError
from codegen.plain_values import InvalidName, genuine, plain_name, shown
from codegen.public_callables import errors_at, failure
from codegen.values_of_long_numbers import with_short_numbers

WORDS = re.compile(r"[A-Za-z0-9][A-Za-z0-9_ ^/.-]*")
Rows = tuple[tuple[Any, ...], ...]
Function = TypeVar("Function", bound=Callable[..., Any])
# What methods returned in this build: (element, word, bodies) → (element, bodies, value)
_Known = dict[tuple[int, str, tuple[int, ...]], tuple[Any, Any, Any]]
_known: ContextVar[_Known | None] = ContextVar("known", default=None)


def memoize_methods(function: Function) -> Function:
    """Within the function, each method is called once: what is checked is what is compiled."""

    @wraps(function)
    def call(*arguments: Any, **words: Any) -> Any:
        before = _known.set({})
        try:
            return function(*arguments, **words)
        finally:
            _known.reset(before)

    return call  # type: ignore[return-value]


def name_errors(element: Any) -> AbstractContextManager[None]:
    """Errors in the block that are not ours name the element."""
    return errors_at(label(element))


def call_method(element: Any, word: str, bodies: tuple[Any, ...] | None = None) -> Any:
    """What the method `word` returns, for the bodies of a scene where it takes them."""
    arguments = () if bodies is None else (bodies,)
    what = f"{word}()"

    def called() -> Any:
        return call_user_code(element, what, lambda: getattr(element, word)(*arguments))

    return once(element, what, called, bodies)


def read_property(element: Any, word: str) -> Any:
    """The value of the property `word`."""
    return once(
        element, word, lambda: call_user_code(element, word, lambda: getattr(element, word))
    )


def call_optional_method(
    element: Any, word: str, otherwise: Any, bodies: tuple[Any, ...] | None = None
) -> Any:
    """The same of a method that not every element has, or that a class sets to None."""
    return call_method(element, word, bodies) if has_attribute(element, word) else otherwise


def has_attribute(element: Any, word: str) -> bool:
    """Whether the element has something under a word; a property that fails counts."""
    try:
        return getattr(element, word, None) is not None
    except FAILURES:
        return True


def once(
    element: Any, what: str, function: Callable[[], Any], bodies: tuple[Any, ...] | None = None
) -> Any:
    """The result of a function of an element, found once within `memoize_methods`."""
    known, key = _known.get(), (id(element), what, tuple(map(id, bodies or ())))
    if known is not None and key in known:
        return known[key][-1]
    value = function()
    if known is not None:
        known[key] = element, bodies, value  # which keeps the ids theirs
    return value


def call_user_code(element: Any, what: str, function: Callable[[], Any]) -> Any:
    """What a function returns; ModelError, which names the element, where it raises."""
    try:
        return genuine(function())
    except LinkwrightError as error:
        where = label(element)
        raise ModelError(p if where in p else f"{where}: {p}" for p in error.problems) from error
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise ModelError(f"{label(element)}: its {what} fails with {failure(error)}.") from error


def refusal(element: Any, word: str, value: object, needed: str) -> ModelError:
    """The error of a value of another kind than is needed."""
    return ModelError(f"{label(element)}: its {word} returns {shown(value)}; return {needed}.")


def expression(element: Any, word: str, value: Any) -> sympy.Expr:
    """A number or expression."""
    try:
        return with_short_numbers(plain_expression(value))
    except FAILURES:
        raise refusal(element, word, value, "an expression") from None


def rows(element: Any, word: str, value: Any, size: int, needed: str) -> Rows:
    """A tuple or list of tuples of one size."""
    listed = isinstance(value, tuple | list)
    if not listed or not all(isinstance(row, tuple | list) and len(row) == size for row in value):
        raise refusal(element, word, value, needed)
    return tuple(tuple(row) for row in value)


def name(element: Any, word: str, text: Any) -> str:
    """A few ASCII words, fit for the generated text."""
    plain = plain_name(text) if isinstance(text, str) else ""
    if not WORDS.fullmatch(plain):
        raise refusal(element, word, text, "ASCII words where a name stands")
    return plain


def unit(element: Any, word: str, text: Any) -> str:
    """A unit as a parameter may have it, or ASCII words; empty for a pure number."""
    plain = plain_name(text) if isinstance(text, str) else InvalidName()
    if isinstance(plain, InvalidName) or not (WORDS.fullmatch(plain) or known_unit(plain)):
        raise refusal(element, word, text, "a unit, such as 'N m', where one stands")
    return plain


def refuse_duplicates(element: Any, word: str, names: list[str]) -> None:
    """Refuse a name that stands twice."""
    if twice := next((n for k, n in enumerate(names) if n in names[:k]), None):
        raise ModelError(f"{label(element)}: its {word} has '{twice}' twice; give each a name.")


def position_scalar(element: Any, word: str, scalar: sympy.Expr) -> sympy.Expr:
    """A scalar that depends on positions, and on no velocity."""
    if speeds := kinds(scalar, Velocity):
        raise ModelError(
            f"{label(element)}: its {word} is {scalar}, with the velocity {speeds[0]}; write it "
            "in coordinates, parameters and t."
        )
    if not kinds(scalar, Coordinate, Time):
        raise ModelError(f"{label(element)}: its {word} is {shown(scalar)}, which nothing moves.")
    return scalar


def by_coordinate(element: Any, word: str, value: Any) -> dict[Coordinate, sympy.Expr]:
    """Coordinate → expression."""
    listed = isinstance(value, Mapping)
    pairs: Any = (
        call_user_code(element, word, lambda: [*value.items()]) if listed else [(None, None)]
    )
    if not all(isinstance(q, Coordinate) and q.letter in KINDS for q, _ in pairs):
        raise refusal(element, word, value, "a dictionary, coordinate: expression")
    return {q: expression(element, word, force) for q, force in pairs}
