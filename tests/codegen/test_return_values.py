"""What methods of own elements return is checked by its kind, and refused by name."""

from pathlib import Path
from typing import Any

import pytest
import sympy

from codegen import Body, Constraint, Effect, LinkwrightError, ModelError, Statement, build
from codegen.declare import element as el
from codegen.declare.element_conditions import Condition
from codegen.declare.symbols import SPEED, coordinate
from codegen.driver import valid_scenes
from tests.codegen.test_boundary import MARK, Machine, refusal
from tests.codegen.test_ordinary_mistakes import read_table, words

CASES = read_table("wrong_returns.txt")
ALPHA = coordinate("mine", "alpha")


def fails(*_: Any) -> Any:
    raise KeyError("theirs")


def recurses(*arguments: Any) -> Any:
    return recurses(*arguments)


def own(base: type[Any], machine: Any, **answers: Any) -> Any:
    """An element of one's own: what a case gives, its methods return, its properties are."""
    parts: dict[str, Any] = {"bodies": (machine["a"],), "kind": "own", "name": "mine"}
    for word, answer in answers.items():
        if word in ("bodies", "kind", "name", "instead_of"):
            parts[word] = answer
        else:
            parts[word] = answer if callable(answer) else lambda *_, answer=answer: answer
    return type("Mine", (base,), {"__init__": lambda self: None, **parts})()


def effect(machine: dict[str, Any], **answers: Any) -> Any:
    """An effect that pushes at a body, but for what a case gives."""
    return own(Effect, machine, **({"forces": {machine["a"].x: sympy.S.One}} | answers))


def joint(machine: dict[str, Any], **given: Any) -> Any:
    """A joint of one equation, but for what a case gives."""
    stated: dict[str, Any] = {"phi": (machine["a"].x,), "rows": ("x",), "reaction": None}
    stated |= {word: given.pop(word) for word in ("bindings", "own") if word in given}
    stated |= {word: given.pop(word) for word in ("phi", "rows", "reaction") if word in given}
    if "statement" not in given:
        given["statement"] = Statement(**stated)
    return own(Constraint, machine, **given)


def body(machine: dict[str, Any], **answers: Any) -> Any:
    """A body of one's own, with properties that a case gives."""
    parts = {word: property(lambda self, answer=answer: answer) for word, answer in answers.items()}
    values = {"name": "mine", "model": machine["m"].token, "outlines": ()}
    values |= {word: sympy.S.One for word in ("mass", "inertia") if word not in parts}
    made = {"__init__": lambda self: vars(self).update(values), **parts}
    return type("Mine", (Body,), made)()


@pytest.mark.parametrize("case", CASES)
def test_what_an_own_element_returns_is_told(case: str) -> None:
    known = words()
    machine = known["m"]
    known |= {name: getattr(el, name) for name in ("FrictionLaw", "OneWay", "Rigid", "Sticking")}
    known |= {"Condition": Condition, "SPEED": SPEED, "One": sympy.S.One, "unknown": known["S"]}
    known |= {"fails": fails, "recurses": recurses}
    for make in (effect, joint, body):
        known[make.__name__] = lambda make=make, **answers: make(known, **answers)
    with pytest.raises(LinkwrightError) as caught:  # noqa: PT012 (either of them)
        machine.add(eval(case, known))
        valid_scenes(machine, None)
    assert [*caught.value.problems] == CASES[case]


def test_each_method_is_called_once_in_a_build(tmp_path: Path) -> None:
    machine, calls = words(), []

    def potential(bodies: Any) -> Any:
        calls.append(bodies)
        return machine["a"].x ** (2 * len(calls))

    machine["m"].add(effect(machine, potential=lambda self, bodies: potential(bodies)))
    build(machine["m"], out=tmp_path, compile=False)
    first = calls.copy()
    build(machine["m"], out=tmp_path, compile=False)
    assert (len(first), len(calls)) == (1, 2)


def test_an_own_joint_with_conditions_and_a_place_builds(tmp_path: Path) -> None:
    machine = words()
    model, b = machine["m"], machine["b"]
    r = model.parameter("r", 0.5)
    guide = joint(
        machine, phi=(b.x - sympy.cos(ALPHA), b.y - ALPHA), rows=("across", "along"),
        own=(("along", ALPHA),), bodies=(b,), near=lambda self, numbers: {ALPHA: 2.0 * numbers[r]},
        conditions=(Condition("the radius is {0:g}; give {1:.2g}.", (r, sympy.S.One)),),
        profiles=((b.circle(r), True),),
    )  # fmt: skip
    model.add(guide)
    build(model, out=tmp_path, compile=False)
    assert model.scene("s").guess == (("mine.alpha", 1.0),)
    model.scene("less", parameters={"r": -1.0})
    with pytest.raises(ModelError, match=r"'less': own 'mine': the radius is -1; give 1\."):
        build(model, out=tmp_path, compile=False)


def test_what_an_effect_returns_for_a_scene_is_checked_for_that_scene(tmp_path: Path) -> None:
    machine = words()
    a, stranger = machine["a"], machine["S"]
    force = {True: {a.x: sympy.S.One}, False: {a.x: stranger}}
    machine["m"].add(effect(machine, forces=lambda self, bodies: force[len(bodies) == 3]))
    machine["m"].scene("all", ["mine"])
    machine["m"].scene("two", ["mine"], without=["b"])
    with pytest.raises(ModelError, match="'mine': unknown symbol 'unknown'"):
        build(machine["m"], out=tmp_path, compile=False)


class Loaded(Body):
    """A body whose angle is text in a tuple."""

    @property
    def angle(self) -> Any:
        return (f"__import__('pathlib').Path({MARK!r}).touch()",)


def test_text_among_the_answers_of_a_body_is_never_evaluated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    one = sympy.S.One

    def declare(machine: Machine) -> None:
        machine.model.add(Loaded("mine", one, one, machine.model.token))

    assert "'mine'" in refusal(declare)
    assert not (tmp_path / MARK).exists()
