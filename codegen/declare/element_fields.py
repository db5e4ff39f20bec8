"""Fields of an element that hold its numbers: how a declaration reads each, and what it must be.

A field says its unit, and what is asked of its value, once. `Model` reads the argument of the same
name by it; the build and each run judge the value by the condition that follows from it.
"""

from collections.abc import Callable, Iterator
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from typing import Any, Literal, TypeVar, dataclass_transform

import sympy

from codegen.declare.element_conditions import Condition, sign_conditions
from codegen.declare.symbols import SignRule

Axis = tuple[sympy.Expr, sympy.Expr]
"""A direction in the frame of a body, of any length but 0."""
Units = str | tuple[str, ...]
Class = TypeVar("Class", bound=type[Any])


@dataclass(frozen=True)
class Quantity:
    """How the value of a field is read, and what is asked of it; see `quantity`."""

    unit: Units | Callable[[Any], Units]
    needs: SignRule | Literal["direction"]
    binds: SignRule
    word: str
    advice: str
    function_of: Callable[[Any], tuple[sympy.Expr, ...]] | None
    is_law: bool

    def unit_of(self, element: Any) -> Units:
        """Its unit, or one a component, where it follows from the fields before it."""
        return self.unit(element) if callable(self.unit) else self.unit


def quantity(
    unit: Units | Callable[[Any], Units] = "", needs: SignRule | Literal["direction"] = "",
    binds: SignRule = "", *, default: Any = MISSING, word: str = "", advice: str = "",
    gated: bool = False, function_of: Callable[[Any], tuple[sympy.Expr, ...]] | None = None,
    is_law: bool = False,
) -> Any:  # fmt: skip
    """A field for a number, quantity or expression, or for several.

    Parameters
    ----------
    unit
        In SI, one a component; or a function that returns it for the fields before this one.
    needs
        What the build asks of the value, and each run of the parameters in it.
    binds
        The rule that a parameter which stands alone obeys from then on.
    word, advice
        What messages call it, by default its name; and what they say besides where it is wrong.
    gated
        Whether it acts only while the condition ``when`` of the declaration holds.
    function_of
        Expressions, from the fields before this one, of which a function may return the value.
    is_law
        Whether nothing but such a function will do.
    """
    read = Quantity(unit, needs, binds, word, advice, function_of, is_law)
    return field(default=default, metadata={"quantity": read, "gated": gated})


def direction() -> Any:
    """A field for an `Axis`."""
    return quantity(("m", "m"), "direction")


def ground_unless_given() -> Any:
    """A field for a body, which is the ground where the declaration gives none."""
    return field(metadata={"ground": True})


@dataclass_transform(
    eq_default=False, frozen_default=True,
    field_specifiers=(quantity, direction, ground_unless_given),
)  # fmt: skip
def shared_fields(cls: Class) -> Class:
    """A class whose fields elements inherit; a class decorator."""
    return dataclass(frozen=True, eq=False, init=False)(cls)  # type: ignore[return-value]


def field_conditions(element: Any) -> Iterator[Condition]:
    """What the fields of an element ask of their values, in their order."""
    for one in fields(element) if is_dataclass(element) else ():
        read, value = one.metadata.get("quantity"), getattr(element, one.name)
        if read is None or not read.needs or value is None:
            continue
        if read.needs == "direction":
            ux, uy = value
            text = "the axis ({1:g}, {2:g}) has no direction; give one."
            yield Condition(text, (ux**2 + uy**2, ux, uy), open=True)
            continue
        row = (read.word or one.name.replace("_", " "), value, str(read.unit_of(element)))
        yield from sign_conditions(row, positive=read.needs == "positive", advice=read.advice)
