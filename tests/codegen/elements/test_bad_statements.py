"""Faults in the statement of a user's own joint, each told in a sentence."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import sympy

from codegen import (
    Constraint,
    I,
    J,
    JointReaction,
    Model,
    ModelError,
    Point,
    Statement,
    build,
    element,
    given,
)
from codegen.elements import registry
from codegen.elements.registry import kinds_of_elements

COEFFICIENT = given("coefficient")
X, Y = I.A.T * (J.point - I.r) - I.s
PARABOLA = (Y - COEFFICIENT * X**2,)
X_AXIS = I.A * sympy.Matrix([1, 0])


@pytest.fixture(autouse=True)
def _own_kinds(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    kinds_of_elements()
    monkeypatch.setattr(registry, "_KINDS", dict(registry._KINDS))
    return


def slotted(phi: Any = PARABOLA, reaction: Any = X_AXIS, number: Any = 0.5) -> Model:
    """A model of two bodies with the joint ``my slot 's'`` between them."""

    @element
    class Slot(Constraint):
        """y - c x² = 0: a point of j on a parabola of i."""

        kind = "my slot"
        name: str
        i: Point
        j: Point

        def statement(self) -> Statement:
            bindings = I.bind(self.i) | J.bind(self.j) | {COEFFICIENT: number}
            return Statement(phi, ("across",), JointReaction(reaction), bindings)

    model = Model("slotted")
    first, second = (model.body(name, mass=1.0, inertia=1.0) for name in ("first", "second"))
    model.add(Slot("s", first.at(0.1, 0.2), second.at(0, 0)))
    model.scene("alone")
    return model


FAULTS: list[tuple[dict[str, Any], str]] = [
    ({"reaction": [3, 0]}, r"my slot 's': the direction of its reaction is \(3, 0\)"),
    ({"reaction": [1, 0, 0]}, r"my slot 's': the direction of its reaction is \(1, 0, 0\)"),
    ({"number": given("c")}, "my slot 's': the placeholder 'c' is not bound; add it to bindings."),
]


@pytest.mark.parametrize(("fault", "message"), FAULTS)
def test_a_fault_is_told(fault: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=message) as caught:
        build(slotted(**fault), out=tmp_path, compile=False)
    assert len(caught.value.problems) == 1


@pytest.mark.parametrize(
    "sound", [{}, {"number": 1}, {"reaction": [0.6, 0.8]}, {"phi": [*PARABOLA]}]
)
def test_plain_numbers_and_lists_build(sound: dict[str, Any], tmp_path: Path) -> None:
    build(slotted(**sound), out=tmp_path, compile=False)
