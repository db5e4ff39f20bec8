"""What a colleague gets wrong is said in full: what, where, the numbers, and what to do; at once.

Cases stand in a table: declarations, also of elements of one's own whose methods return nonsense.
"""

import math
import re
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from pint import get_application_registry

import codegen
from codegen import Body, Constraint, Effect, LinkwrightError, Model, ModelError, Scene, Statement
from codegen.declare import element as el
from codegen.declare.element_fields import Condition
from codegen.declare.symbols import SPEED, coordinate
from codegen.driver import build, valid_scenes
from tests.codegen.test_boundary import MARK, Machine, refusal

ALPHA = coordinate("mine", "alpha")


def read_table() -> dict[str, list[str]]:
    """Cases of the table, each with the sentences that are said of it, indented, in its order."""
    text = Path(__file__).with_name("mistakes.txt").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    cases: dict[str, list[str]] = {}
    declaration: list[str] = []
    for is_sentence, block in groupby(lines, lambda line: line.startswith("    ")):
        if is_sentence:
            case = "\n".join(declaration)
            assert case not in cases, f"{case!r} stands twice"
            cases[case] = [sentence.strip() for sentence in block]
        else:
            declaration = [*block]
    return cases


CASES = read_table()


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
    words = (*stated, "bindings", "own")
    stated |= {word: given.pop(word) for word in words if word in given}
    if "statement" not in given:
        given["statement"] = Statement(**stated)
    return own(Constraint, machine, **given)


def body(machine: dict[str, Any], **answers: Any) -> Any:
    """A body of one's own, with properties that a case gives."""
    parts: dict[str, Any] = {
        word: answer if word == "torque" else property(lambda self, answer=answer: answer)
        for word, answer in answers.items()
    }
    values = {"name": "mine", "model": machine["m"].token, "outlines": ()}
    values |= {word: sympy.S.One for word in ("mass", "inertia") if word not in parts}
    made = {"__init__": lambda self: vars(self).update(values), **parts}
    return type("Mine", (Body,), made)()


def machine_and_words() -> dict[str, Any]:
    """What cases are written with: a small machine, what models import, elements of one's own."""
    model = Model("m", gravity=(0, -9.81))
    a, b = (model.body(name, 1.0, 2.0) for name in "ab")
    known: dict[str, Any] = {
        **{name: getattr(sympy, name) for name in sympy.__all__},
        **{name: getattr(codegen, name) for name in codegen.__all__},
        **{name: getattr(el, name) for name in ("FrictionLaw", "OneWay", "Rigid", "Sticking")},
        "m": model,
        "a": a,
        "b": b,
        "p": model.particle("p", 1.0),
        "math": math,
        "np": np,
        "pin": model.revolute("pin", model.ground.at(0, 0), a.at(1, 0)),
        "k": model.parameter("k", 5.0, unit="N/m"),
        "other": Model("other").body("a", 1.0, 1.0),
        "S": sympy.Symbol("unknown", real=True),
        "nan": math.nan,
        "inf": math.inf,
        "Q": get_application_registry().Quantity,
        "Condition": Condition,
        "SPEED": SPEED,
        "One": sympy.S.One,
        "fails": fails,
        "recurses": recurses,
    }
    for make in (effect, joint, body):
        known[make.__name__] = lambda make=make, **answers: model.add(make(known, **answers))
    return known


def declare(case: str, known: dict[str, Any]) -> Any:
    """Run a case; what it is, where it is an expression."""
    try:
        expression = compile(case, "case", "eval")
    except SyntaxError:
        return exec(case, known)
    return eval(expression, known)


@pytest.mark.parametrize("case", CASES)
def test_a_mistake_is_told(case: str) -> None:
    known = machine_and_words()
    with pytest.raises(LinkwrightError) as caught:  # noqa: PT012 (either of them)
        made = declare(case, known)
        valid_scenes(known["m"], made if isinstance(made, Scene) else None)
    told = [re.sub("0x[0-9a-f]+", "0x...", problem) for problem in caught.value.problems]
    assert told == CASES[case]


PINNED = """
m.revolute('B', m.ground.at(0.3, 0.4), b)
m.revolute('A', m.ground.at(0, 0), a)
"""
ARM = """
arm = m.body('arm', mass=1, inertia=1)
m.revolute('A', arm.at(0, 0), a.at(0, 0.1))
m.revolute('B', b, arm.at(2, 0))
"""
COAXIAL = """
arm = m.body('arm', mass=1, inertia=1)
m.revolute('S', m.ground.at(0, 0), a)
m.revolute('A', m.ground.at(0, 0), arm)
m.revolute('B', b, arm.at(2, 0))
"""


@pytest.mark.parametrize(
    "case",
    [
        *(
            f"{PINNED}m.gear('G', a, b, {radii})"
            for radii in ("0.2, 0.3", "0.1 + 0.1, 0.29999999", "k / 25, 0.5 - k / 25", "-0.7, 0.2")
        ),
        f"{ARM}m.belt('D', a, b, 1, 2, carrier=arm)",
        f"{COAXIAL}m.belt('D', a, b, 1, 2, carrier=arm)",
        "m.belt('B', a, b, 1, 2, carrier=m.ground)",
        f"{ARM}m.weld('W', arm.at(0, 5), m.ground.at(0, 5))\nm.belt('D', a, b, 1, 2)",
    ],
)
def test_wheels_that_fit_their_bearings(case: str) -> None:
    known = machine_and_words()
    declare(case, known)
    valid_scenes(known["m"], None)


@pytest.mark.parametrize(
    "case", ['coordinate("a", "w")', 'coordinate(a, "phi")', 'ConjugateReaction.along("w")']
)
def test_a_coordinate_that_there_is_not(case: str) -> None:
    """The list ends with the coordinates that elements of one's own have declared."""
    with pytest.raises(LinkwrightError, match="one of x, y, phi, alpha, beta, integral"):
        declare(case, machine_and_words())


@pytest.mark.parametrize("symbol", ["k", "a.x", "a.vx"])
def test_a_symbol_takes_no_value(symbol: str) -> None:
    with pytest.raises(AttributeError):
        declare(symbol, machine_and_words()).value = 3.0


def test_a_model_of_an_own_class_has_its_own_words() -> None:
    class Crane(Model):
        """A model with a number of its own."""

    crane = Crane("crane")
    crane.reach = 3.0  # type: ignore[attr-defined]
    assert crane.reach == 3.0
    with pytest.raises(LinkwrightError, match="'force' cannot be set"):
        crane.force = 3.0  # type: ignore[method-assign, assignment]


def test_each_method_is_called_once_in_a_build(tmp_path: Path) -> None:
    machine, calls = machine_and_words(), []

    def potential(_: Any, bodies: Any) -> Any:
        calls.append(bodies)
        return machine["a"].x ** (2 * len(calls))

    machine["m"].add(effect(machine, potential=potential))
    build(machine["m"], out=tmp_path, compile=False)
    first = calls.copy()
    build(machine["m"], out=tmp_path, compile=False)
    assert (len(first), len(calls)) == (1, 2)


def test_an_own_joint_with_conditions_and_a_place_builds(tmp_path: Path) -> None:
    machine = machine_and_words()
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
    machine = machine_and_words()
    force = {True: {machine["a"].x: sympy.S.One}, False: {machine["a"].x: machine["S"]}}
    machine["m"].add(effect(machine, forces=lambda self, bodies: force[len(bodies) == 3]))
    machine["m"].scene("all", ["mine"])
    machine["m"].scene("two", ["mine"], without=["b"])
    with pytest.raises(ModelError, match="'mine': unknown symbol 'unknown'"):
        build(machine["m"], out=tmp_path, compile=False)


def test_it_is_told_once_for_all_scenes(tmp_path: Path) -> None:
    machine = machine_and_words()
    force = {True: {machine["a"].x: sympy.S.One}, False: {machine["a"].x: machine["S"]}}
    known = machine["m"]
    known.add(effect(machine, forces=lambda self, bodies: force[len(bodies) == 3]))
    known.scene("less", ["mine"], without=["b"])
    known.scene("least", ["mine"], without=["b", "p"])
    with pytest.raises(ModelError) as caught:
        build(known, out=tmp_path, compile=False)
    (told,) = caught.value.problems
    assert told.startswith("own 'mine': unknown symbol 'unknown'")


@pytest.mark.parametrize(
    "case",
    [
        *(
            f"joint(reaction=JointReaction((1, 0), sign={sign}), bindings=J.bind(a.at(0, 0)))"
            for sign in ("1", "-1.0", "Integer(1)", "np.int64(-1)")
        ),
        "body(torque=lambda self, value: {a.phi: value})",
    ],
)
def test_an_answer_of_ones_own_that_is_fine(case: str) -> None:
    known = machine_and_words()
    declare(case, known)
    valid_scenes(known["m"], None)


def test_elements_that_compare_by_their_fields(tmp_path: Path) -> None:
    """As plain dataclasses do, which no set or dictionary takes."""

    @dataclass
    class Push(Effect):
        name: str
        body: Body
        kind = "push"

        def forces(self, bodies: Any) -> Any:
            return {self.body.x: sympy.S.One}

    @dataclass
    class Pin(Constraint):
        name: str
        body: Body
        kind = "hold"

        def statement(self) -> Statement:
            return Statement((self.body.x,), ("x",), None)

    known = machine_and_words()
    known["m"].add(Push("push", known["b"]))
    known["m"].add(Pin("hold", known["p"]))
    build(known["m"], out=tmp_path, compile=False)


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

    def declare_it(machine: Machine) -> None:
        machine.model.add(Loaded("mine", one, one, machine.model.token))

    assert "'mine'" in refusal(declare_it)
    assert not (tmp_path / MARK).exists()
