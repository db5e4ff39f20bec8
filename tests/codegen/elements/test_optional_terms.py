"""Elements of a user's own that use the words of optional answers in their own way."""

from collections.abc import Iterator
from pathlib import Path

import pytest
import sympy

from codegen import Body, Model, Statement, build, element
from codegen.declare.element import Constraint, Effect, FrictionLaw
from codegen.elements import registry
from codegen.elements.forces.springs import Spring
from codegen.elements.registry import kinds_of_elements
from codegen.explain.ledger import Inventory
from codegen.reading.scene_selection import valid_scenes


@pytest.fixture(autouse=True)
def own_kinds(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Forget the kinds that a test registers."""
    kinds_of_elements()
    monkeypatch.setattr(registry, "_KINDS", dict(registry._KINDS))
    return


def pair() -> tuple[Model, Body, Body]:
    model = Model("pair")
    first = model.body("first", mass=2.0, inertia=0.7)
    return model, first, model.body("second", mass=3.0, inertia=1.1)


def reasons(model: Model) -> dict[str, str]:
    (scene,) = valid_scenes(model, None)
    return {part.name: part.why for part in Inventory(model, scene).parts()}


def test_driver_with_a_field_called_friction() -> None:
    @element(driver=True)
    class Belt(Constraint):
        """Turns a body, and slips by its friction."""

        kind = "slipping belt"
        name: str
        body: Body
        friction: float

        def statement(self) -> Statement:
            return Statement((self.body.phi - sympy.Float(self.friction),), ("angle",), None)

    model, first, _ = pair()
    model.add(Belt("belt", first, 0.3))
    model.scene("free", drivers=())
    assert reasons(model)["belt"] == "the scene does not name it"


def test_effect_whose_friction_law_is_none() -> None:
    @element
    class Drag(Effect):
        """Drag, without a reaction to follow."""

        kind = "drag"
        name: str
        body: Body

        def friction(self) -> FrictionLaw | None:
            return None

        def forces(self, bodies: tuple[Body, ...]) -> dict[sympy.Symbol, sympy.Expr]:
            return {self.body.x: -self.body.vx}

    model, first, _ = pair()
    model.add(Drag("drag", first))
    model.scene("dragged", effects=("drag",))
    assert reasons(model)["drag"] == "named by the scene"
    left_out, body, _ = pair()
    left_out.add(Drag("drag", body))
    left_out.scene("free", effects=())
    assert reasons(left_out)["drag"] == "the scene does not name it"


def test_class_that_sets_an_optional_answer_to_none(tmp_path: Path) -> None:
    @element
    class Plain(Spring):
        """A spring that neither rubs nor sticks."""

        kind = "plain spring"
        friction = None
        hold = None

    model, first, second = pair()
    numbers = (sympy.Integer(n) for n in (50, 1, 0, 0))
    model.add(Plain("plain", first.at(1, 0), second.at(0, 0), *numbers))
    model.scene("sprung", effects=("plain",))
    build(model, out=tmp_path, compile=False)
    assert reasons(model)["plain"] == "named by the scene"


def test_a_body_counts_whatever_its_field_is_called() -> None:
    @element
    class Ballast(Effect):
        """A weight in place of a body."""

        kind = "ballast"
        name: str
        instead_of: Body

        def forces(self, bodies: tuple[Body, ...]) -> dict[sympy.Symbol, sympy.Expr]:
            return {self.instead_of.y: sympy.Float(-9.81)}

    _, first, _ = pair()
    assert Ballast("ballast", first).bodies == (first,)
