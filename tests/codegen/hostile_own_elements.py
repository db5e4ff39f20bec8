"""Own elements of a hostile author: each has one method whose answer means nothing."""

from collections.abc import Callable
from typing import Any

import sympy

from codegen import ConjugateReaction, Constraint, Effect, JointReaction, Statement
from codegen.declare.element import FrictionLaw, J
from codegen.declare.element_conditions import Condition
from codegen.declare.symbols import coordinate
from tests.codegen.test_boundary import Machine

NONE: dict[str, Any] = {"reaction": None}
ALPHA = coordinate("mine", "alpha")
NAN, ONE = sympy.nan, sympy.S.One
STRANGER = sympy.Symbol("stranger", real=True)


class Effort(Effect):
    """A force whose answers a case chooses."""

    kind = "effort"

    def __init__(self, machine: Machine, **answers: Any) -> None:
        self.name, self.machine = "mine", machine
        for word, answer in answers.items():
            setattr(self, word, answer if callable(answer) else lambda *_, answer=answer: answer)

    @property
    def bodies(self) -> Any:
        return (self.machine.a,)

    def forces(self, bodies: Any) -> Any:
        return {self.machine.a.x: ONE}


class Guide(Constraint):
    """A joint whose answers a case chooses."""

    kind = "guide"

    def __init__(self, machine: Machine, statement: Any = None, **answers: Any) -> None:
        self.name, self.machine, self.changes = "mine", machine, statement or {}
        for word, answer in answers.items():
            setattr(self, word, answer if callable(answer) else lambda *_, answer=answer: answer)

    @property
    def bodies(self) -> Any:
        return (self.machine.b,)

    @property
    def alpha(self) -> Any:
        return coordinate("mine", "alpha")

    def statement(self) -> Any:
        words: dict[str, Any] = {
            "phi": (self.machine.b.x - 1,),
            "rows": ("along",),
            "reaction": ConjugateReaction((("fx", "N"),)),
            "bindings": {},
            "own": (),
        }
        return Statement(**(words | self.changes))


def fails(*_: Any) -> Any:
    raise KeyError("of the\nauthor's own")


def recurses(*arguments: Any) -> Any:
    return recurses(*arguments)


def stops(*_: Any) -> Any:
    raise StopIteration


def property_that(action: Callable[..., Any], base: type, word: str) -> Callable[[Machine], Any]:
    """An element whose property `word` acts."""
    return type("Mine", (base,), {word: property(action)})


class Hostile(float):
    """A number that says another thing of itself."""

    def __repr__(self) -> str:
        return "__import__('os')"

    __str__ = __format__ = __repr__  # type: ignore[assignment]


def deep(x: sympy.Expr, count: int = 400) -> sympy.Expr:
    for _ in range(count):
        x = sympy.sin(x, evaluate=False)
    return x


def bounded(sentence: Any, numbers: Any, **bounds: Any) -> Condition:
    return Condition(sentence, numbers, **bounds)


def joint(**changes: Any) -> Callable[[Machine], Any]:
    return lambda m: Guide(m, changes)


def with_place(m: Machine, **changes: Any) -> Any:
    """A joint that brings a coordinate of its own."""
    place = coordinate("mine", "alpha")
    words = {
        "phi": (m.b.x - sympy.cos(place), m.b.y - place),
        "rows": ("across", "along"),
        "reaction": None,
        "own": (("along", place),),
    }
    return Guide(m, words | changes)


def pushed(m: Machine, direction: list[Any]) -> Any:
    """A joint with a reaction along a direction."""
    bindings = J.bind(m.b.at(0, 0))
    return Guide(m, {"reaction": JointReaction(sympy.Matrix(direction)), "bindings": bindings})


def located(m: Machine, near: Any) -> Any:
    guide = with_place(m)
    guide.near = near
    return guide


def friction(m: Machine, **changes: Any) -> Any:
    words = {
        "joint": "pin", "strength": ONE, "creep": ONE, "along": m.a.phi,
        "contacts": (((("fx", ONE),),),), "unit": "N m",
    }  # fmt: skip
    return Effort(m, friction=FrictionLaw(**(words | changes)), forces={})  # type: ignore[arg-type]


def with_values(element: Any, **values: Any) -> Any:
    for word, value in values.items():
        setattr(element, word, value)
    return element
