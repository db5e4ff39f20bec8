"""What all elements return: bodies, problems, conditions on their numbers."""

import math
import re
from string import Formatter
from typing import Any

from codegen.declare.body import Body
from codegen.declare.element import label
from codegen.declare.element_conditions import Condition
from codegen.declare.return_values.calls import (
    call_method,
    call_optional_method,
    expression,
    has_attribute,
    read_property,
    refusal,
)
from codegen.errors import ModelError
from codegen.plain_values import KindError, one_line, plain_float, shown

_FORMAT = re.compile(r"(\.\d{1,2})?[efg]?")


def bodies_of(element: Any) -> tuple[Body, ...]:
    """The bodies that an element takes hold of."""
    value = read_property(element, "bodies")
    if not isinstance(value, tuple | list) or not all(isinstance(b, Body) for b in value):
        raise refusal(element, "bodies", value, "a tuple of bodies")
    return tuple(value)


def replaced_body(element: Any) -> Body | None:
    """The body instead of which a link stands, for elements that have one."""
    body = read_property(element, "instead_of") if has_attribute(element, "instead_of") else None
    if body is not None and not isinstance(body, Body):
        raise refusal(element, "instead_of", body, "a body or None")
    return body


def problems_of(element: Any) -> list[str]:
    """The problems that an element finds itself."""
    value = call_method(element, "problems")
    if not isinstance(value, tuple | list) or not all(isinstance(p, str) for p in value):
        raise refusal(element, "problems()", value, "a list of sentences")
    where = label(element)
    lines = (one_line(p, 1000) for p in value)
    return [line if where in line else f"{where}: {line}" for line in lines]


def conditions_of(element: Any) -> tuple[Condition, ...]:
    """What an element asks of its numbers; a modeller's own need not ask anything."""
    value = call_optional_method(element, "conditions", ())
    if not isinstance(value, tuple | list) or not all(isinstance(c, Condition) for c in value):
        raise refusal(element, "conditions()", value, "a tuple of Condition")
    return tuple(_condition(element, condition) for condition in value)


def _condition(element: Any, condition: Condition) -> Condition:
    """A condition of which each part is of its kind, and the sentence shows its numbers."""
    where = f"{label(element)}: in its conditions() "
    sentence, numbers, low, open_, high = (vars(condition)[word] for word in _PARTS)
    if not isinstance(numbers, tuple | list) or not numbers:
        raise ModelError(f"{where}numbers is {shown(numbers)}; give a tuple, of one (value,).")
    numbers = tuple(expression(element, "conditions() among numbers", n) for n in numbers)
    if not isinstance(open_, bool) or not (_is_bound(low) and _is_bound(high)):
        bounds = ", ".join(map(shown, (low, open_, high)))
        raise ModelError(f"{where}low, open and high are {bounds}; give numbers, and a bool.")
    if not isinstance(sentence, str) or not _shows(sentence, len(numbers)):
        raise ModelError(
            f"{where}the sentence {shown(sentence)} does not fit its {len(numbers)} numbers; "
            "write them as {:g} or {0:.3g}, and braces twice."
        )
    low, high = (None if bound is None else plain_float(bound) for bound in (low, high))
    return Condition(str.__str__(sentence), numbers, low, open_, high)


_PARTS = ("sentence", "numbers", "low", "open", "high")


def _is_bound(bound: Any) -> bool:
    try:
        return bound is None or math.isfinite(plain_float(bound))
    except KindError:
        return False


def _shows(sentence: str, count: int) -> bool:
    """Whether a sentence has numbers alone in its braces, as many as there are at most."""
    try:
        fields = [f for f in Formatter().parse(str.__str__(sentence)) if f[1] is not None]
    except ValueError:
        return False
    plain = all(
        re.fullmatch(r"\d{0,2}", str(field)) and not conversion and _FORMAT.fullmatch(str(form))
        for _, field, form, conversion in fields
    )
    try:
        return plain and bool(sentence.format(*(0.5,) * count)) and sentence.isprintable()
    except (IndexError, ValueError):
        return False
