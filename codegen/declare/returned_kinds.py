"""The kinds of values that methods of elements and bodies return, and the error of another kind.

A kind takes a value and returns a plain one, or raises `KindError`, whose text goes on behind
``its forces()``: a modeller's own element may return anything. An exception, and a value of another
kind, is a `ModelError` that names the element, the method and the value.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from dataclasses import replace
from functools import wraps
from typing import Any, TypeVar

import sympy

from codegen.declare.element import label
from codegen.declare.symbols import Coordinate, Time, Velocity, kinds
from codegen.errors import LinkwrightError, ModelError
from codegen.readers.calls import errors_at, failure
from codegen.readers.expressions import plain_expression
from codegen.readers.quantities import known_unit
from codegen.readers.values import KindError, shown

WORDS = re.compile(r"[A-Za-z0-9][A-Za-z0-9_ ^/.-]*")
Kind = Callable[[Any], Any]
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


def returned(
    element: Any, word: str, kind: Kind, bodies: tuple[Any, ...] | None = None,
    otherwise: Any = None,
) -> Any:  # fmt: skip
    """What the method `word` returns, of one kind, found once within `memoize_methods`.

    It is called with the bodies of a scene where it takes them. Not every element has every method:
    one without has `otherwise`. ModelError, which names the element and the method, if it fails.
    """
    known, key = _known.get(), (id(element), word, tuple(map(id, bodies or ())))
    if known is not None and key in known:
        return known[key][-1]
    with named(element, f"{word}()"):
        method = getattr(element, word, None)
        value = otherwise
        if method is not None:
            value = kind(method() if bodies is None else method(bodies))
    if known is not None:
        known[key] = element, bodies, value  # which keeps the ids theirs
    return value


def check_attribute(element: Any, word: str, kind: Kind) -> None:
    """Check an attribute of an element or body, None where there is none."""
    with named(element, word):
        kind(getattr(element, word, None))


def name_errors(element: Any) -> AbstractContextManager[None]:
    """Errors in the block that are not ours name the element."""
    return errors_at(label(element))


@contextmanager
def named(element: Any, what: str) -> Iterator[None]:
    """A block that reads what a modeller's method returns: its errors name both."""
    where = label(element)
    try:
        yield
    except KindError as misfit:
        text, *fields = misfit.args  # of a record, the one that is wrong
        raise ModelError(f"{where}: its {' of '.join([*fields, what])} {text}") from None
    except LinkwrightError as error:
        raise ModelError(p if where in p else f"{where}: {p}" for p in error.problems) from error
    except Exception as error:
        raise ModelError(f"{where}: its {what} fails with {failure(error)}.") from error


def refusal(value: object, needed: str) -> KindError:
    """The misfit of a value that is returned, and what to return in its place."""
    return KindError(f"returns {shown(value)}; return {needed}.")


def expression(value: Any) -> sympy.Expr:
    """A number or expression."""
    try:
        return plain_expression(value)
    except KindError:
        raise refusal(value, "an expression") from None


def position_scalar(value: Any) -> sympy.Expr:
    """A scalar that depends on positions, and on no velocity."""
    scalar = expression(value)
    if speeds := kinds(scalar, Velocity):
        raise KindError(
            f"is {scalar}, with the velocity {speeds[0]}; write it in coordinates, parameters "
            "and t."
        )
    if not kinds(scalar, Coordinate, Time):
        raise KindError(f"is {shown(scalar)}, which nothing moves.")
    return scalar


def words(text: Any) -> str:
    """A few ASCII words, fit for the generated text."""
    if not isinstance(text, str) or not WORDS.fullmatch(text):
        raise refusal(text, "ASCII words where a name stands")
    return text


def unit(text: Any) -> str:
    """A unit as a parameter may have it, or ASCII words; empty for a pure number."""
    if isinstance(text, str) and text.isprintable() and (WORDS.fullmatch(text) or known_unit(text)):
        return text
    raise refusal(text, "a unit, such as 'N m', where one stands")


def one_of(*classes: type[Any], needed: str) -> Kind:
    """An object of one of the classes."""

    def read_object(value: Any) -> Any:
        if not isinstance(value, classes):
            raise refusal(value, needed)
        return value

    return read_object


def choice(*values: Any) -> Kind:
    """One of a few values."""

    def read_choice(value: Any) -> Any:
        if value not in values:
            raise refusal(value, f"one of {', '.join(map(str, values))}")
        return value

    return read_choice


def several(kind: Kind, needed: str, least: int = 0) -> Kind:
    """A tuple or list of what `kind` reads, as a tuple."""

    def read_list(value: Any) -> tuple[Any, ...]:
        if not isinstance(value, tuple | list) or len(value) < least:
            raise refusal(value, needed)
        return tuple(map(kind, value))

    return read_list


def rows(needed: str, *cells: Kind, unique: Callable[[Any], str] | None = None) -> Kind:
    """A tuple or list of rows, each with these cells; `unique` gives the name of a row."""

    def read_rows(value: Any) -> tuple[tuple[Any, ...], ...]:
        if not isinstance(value, tuple | list) or not all(
            isinstance(row, tuple | list) and len(row) == len(cells) for row in value
        ):
            raise refusal(value, needed)
        found = tuple(
            tuple(cell(entry) for cell, entry in zip(cells, row, strict=True)) for row in value
        )
        names = [unique(row) for row in found] if unique else []
        if twice := next((n for k, n in enumerate(names) if n in names[:k]), None):
            raise KindError(f"has '{twice}' twice; give each a name.")
        return found

    return read_rows


def record(*classes: type[Any], needed: str, **fields: Kind) -> Kind:
    """A dataclass of one of the classes, with those of the fields that it has read by kind."""

    def read_record(value: Any) -> Any:
        if not isinstance(value, classes):
            raise refusal(value, needed)
        changes = {}
        for word, kind in fields.items():
            if hasattr(value, word):
                try:
                    changes[word] = kind(getattr(value, word))
                except KindError as misfit:
                    raise KindError(*misfit.args, word) from None
        return replace(value, **changes)

    return read_record


def by_coordinate(value: Any) -> dict[Coordinate, sympy.Expr]:
    """Coordinate → expression."""
    if not isinstance(value, Mapping) or not all(isinstance(q, Coordinate) for q in value):
        raise refusal(value, "a dictionary, coordinate: expression")
    return {q: expression(force) for q, force in value.items()}
