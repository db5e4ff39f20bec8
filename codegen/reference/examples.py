"""A small sound model for each kind of the library: the element between two free bodies.

The reference pages show these declarations, their equations and their costs, and the tests hold
every kind to the same laws with them. The lines stand in the element's class, as `example`, exactly
as a page shows them; they may use the bodies and points of `Pair`. The last call is of the method
of `Model` that declares the kind; where several do, `declared_by` of the class names them.
"""

import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass

import sympy

from codegen.declare.element import Constraint, Effect
from codegen.declare.symbols import alpha, t
from codegen.elements.registry import kinds_of_elements
from codegen.errors import ModelError
from codegen.model import Model
from codegen.readers.names import nearest
from codegen.readers.values import shown


class Pair(Model):
    """Two free bodies `i` and `j` with a point each, `P` on i and `Q` on j, named by parameters."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.i = self.body("i", mass=2.0, inertia=0.5)
        self.j = self.body("j", mass=3.0, inertia=0.7)
        places = {"i_sx": 0.3, "i_sy": -0.2, "j_sx": -0.5, "j_sy": 0.4}
        s = [self.parameter(place, value, unit="m") for place, value in places.items()]
        self.P, self.Q = self.i.at(*s[:2]), self.j.at(*s[2:])


@dataclass(frozen=True)
class Example:
    """An element in a model."""

    model: Model
    element: Constraint | Effect  # the one element that is looked at
    methods: tuple[str, ...] = ()  # methods of `Model` that declare the kind; none for one's own
    source: str = ""  # the lines that declare it; empty where they are in a file of their own


def example_of(kind: str, model: Model | None = None) -> Example:
    """The library's example of a kind, or the first in `model`; ModelError if there is none."""
    registered = kinds_of_elements()
    if kind not in registered:
        raise ModelError(f"there is no element {shown(kind)}; {nearest(kind, registered)}")
    if model is not None:
        for element in _elements(model):
            if element.kind == kind:
                return Example(model, element)
    cls = registered[kind].element
    if registered[kind].is_user_defined:
        raise ModelError(
            f"element '{kind}' is one of your own, of {cls.__module__}; name a model file that "
            "declares one: linkwright elements --model FILE."
        )
    source = textwrap.dedent(getattr(cls, "example", "")).strip()
    if not source:
        raise ModelError(
            f"the library's element '{kind}' has no example; add one to {cls.__qualname__} of "
            f"{cls.__module__}."
        )
    pair = Pair("example")
    names = {"model": pair, "alpha": alpha, "t": t, "i": pair.i, "j": pair.j}
    names |= {"P": pair.P, "Q": pair.Q, "sin": sympy.sin, "cos": sympy.cos, "pi": sympy.pi}
    exec(source, names)
    (element,) = (e for e in _elements(pair) if e.kind == kind)
    *_, method = re.findall(r"model\.(\w+)", source)
    return Example(pair, element, getattr(cls, "declared_by", (method,)), source)


def _elements(model: Model) -> Iterator[Constraint | Effect]:
    yield from model.joints.values()
    yield from model.drivers.values()
    yield from model.effects.values()
