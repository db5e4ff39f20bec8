"""What methods of own elements return is checked by its kind, and refused by name."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sympy

from codegen import Body, Constraint, Effect, ModelError, Statement, build
from codegen.declare.element_conditions import Condition
from tests.codegen.hostile_own_effects import EFFECTS
from tests.codegen.hostile_own_elements import ALPHA, with_place
from tests.codegen.hostile_own_joints import JOINTS
from tests.codegen.test_boundary import MARK, Machine, refusal


class Belt(Effect):
    """A force whose answers a test chooses."""

    kind = "belt"

    def __init__(self, machine: Machine, **answers: Any) -> None:
        self.name, self.machine = "mine", machine
        for word, answer in answers.items():
            setattr(self, word, answer)

    @property
    def bodies(self) -> Any:
        return (self.machine.a,)

    def forces(self, bodies: Any) -> Any:
        return {self.machine.a.x: sympy.S.One}


class Bar(Constraint):
    """A joint whose statement a test chooses."""

    kind = "bar"

    def __init__(self, machine: Machine, statement: Any) -> None:
        self.name, self.machine, self.chosen = "mine", machine, statement

    @property
    def bodies(self) -> Any:
        return (self.machine.a,)

    def statement(self) -> Any:
        return self.chosen(self.machine.a.x)


def fails(*_: Any) -> Any:
    raise KeyError("theirs")


ANSWERS: dict[str, tuple[Callable[[Machine], Any], str]] = {
    "problems that fail": (
        lambda m: Belt(m, problems=fails),
        r"its problems\(\) fails with KeyError",
    ),
    "problems that are a number": (
        lambda m: Belt(m, problems=lambda: 7),
        r"its problems\(\) returns 7",
    ),
    "forces that are None": (
        lambda m: Belt(m, forces=lambda b: None),
        r"its forces\(\) returns None",
    ),
    "forces by name": (lambda m: Belt(m, forces=lambda b: {"a.x": 1}), r"its forces\(\) returns"),
    "a force that is text": (
        lambda m: Belt(m, forces=lambda b: {m.a.x: "1"}),
        r"forces\(\) returns '1'",
    ),
    "a potential that fails": (lambda m: Belt(m, potential=fails), r"its potential\(\) fails"),
    "a potential of a velocity": (
        lambda m: Belt(m, potential=lambda b: m.a.vx),
        "the velocity a_vx",
    ),
    "pulls of three": (lambda m: Belt(m, pulls=lambda b: ((1, 2, 3),)), r"its pulls\(\) returns"),
    "a hold of another kind": (lambda m: Belt(m, hold=lambda b: 7), r"its hold\(\) returns 7"),
    "a statement that is None": (
        lambda m: Bar(m, lambda x: None),
        r"its statement\(\) returns None",
    ),
    "a statement that fails": (lambda m: Bar(m, fails), r"its statement\(\) fails with KeyError"),
    "equations that are text": (
        lambda m: Bar(m, lambda x: Statement(("x",), ("x",), None)),
        "among phi returns 'x'",
    ),
    "bindings that are none": (
        lambda m: Bar(m, lambda x: Statement((x,), ("x",), None, 7)),
        "bindings is 7",
    ),
    "a reaction that is none": (
        lambda m: Bar(m, lambda x: Statement((x,), ("x",), "fx")),
        "its reaction returns 'fx'",
    ),
}


@pytest.mark.parametrize("case", ANSWERS)
def test_answers_of_another_kind_are_refused_by_name(case: str) -> None:
    make, pattern = ANSWERS[case]
    told = refusal(lambda m: m.model.add(make(m)))
    assert "'mine'" in told
    assert re.search(pattern, told), told


def test_a_statement_says_what_is_wrong_where_it_is_made() -> None:
    with pytest.raises(ModelError, match="bindings is 7"):
        Statement((sympy.Symbol("x"),), ("x",), None, 7)  # type: ignore[arg-type]


HOSTILE = {**EFFECTS, **JOINTS}


@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_elements_are_refused_by_name(case: str, tmp_path: Path) -> None:
    make, pattern = HOSTILE[case]
    machine = Machine()
    with pytest.raises(ModelError) as caught:  # noqa: PT012 (either of them)
        machine.model.add(make(machine))
        build(machine.model, out=tmp_path, compile=False)
    for problem in caught.value.problems:
        assert "'mine'" in problem
        assert problem.isprintable()
    assert len(caught.value.problems) <= 2
    assert re.search(pattern, str(caught.value)), str(caught.value)


def test_each_method_is_called_once_in_a_build(tmp_path: Path) -> None:
    machine, calls = Machine(), []

    def potential(bodies: Any) -> Any:
        calls.append(bodies)
        return machine.a.x ** (2 * len(calls))

    machine.model.add(Belt(machine, potential=potential))
    build(machine.model, out=tmp_path, compile=False)
    first = calls.copy()
    build(machine.model, out=tmp_path, compile=False)
    assert (len(first), len(calls)) == (1, 2)


def test_an_own_joint_with_conditions_and_a_place_builds(tmp_path: Path) -> None:
    machine = Machine()
    r = machine.model.parameter("r", 0.5)
    guide = with_place(machine)
    guide.near = lambda numbers: {ALPHA: 2.0 * numbers[r]}
    guide.conditions = lambda: [Condition("the radius is {0:g}; give {1:.2g}.", (r, sympy.S.One))]
    guide.profiles = lambda: ((machine.b.circle(r), True),)
    machine.model.add(guide)
    build(machine.model, out=tmp_path, compile=False)
    assert machine.model.scene("s").guess == (("mine.alpha", 1.0),)
    machine.model.scene("less", parameters={"r": -1.0})
    with pytest.raises(ModelError, match=r"'less': guide 'mine': the radius is -1; give 1\."):
        build(machine.model, out=tmp_path, compile=False)


def test_what_an_effect_returns_for_a_scene_is_checked_for_that_scene(tmp_path: Path) -> None:
    machine = Machine()
    stranger = sympy.Symbol("stranger", real=True)
    force = {True: {machine.a.x: sympy.S.One}, False: {machine.a.x: stranger}}
    machine.model.add(Belt(machine, forces=lambda bodies: force[len(bodies) == 3]))
    machine.model.scene("all", ["mine"])
    machine.model.scene("two", ["mine"], without=["b"])
    with pytest.raises(ModelError, match="'mine': unknown symbol 'stranger'"):
        build(machine.model, out=tmp_path, compile=False)


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
    told = refusal(lambda m: m.model.add(Loaded("mine", one, one, m.model.token)))
    assert "'mine'" in told
    assert not (tmp_path / MARK).exists()


@pytest.mark.parametrize("word", ["angular_velocity", "position", "equations", "inertia_force"])
def test_a_body_answers_symbols_of_its_model_alone(word: str) -> None:
    unknown = sympy.Symbol("unknown")
    answers = {"position": (unknown, 1), "equations": (("x", unknown),)}
    answers["inertia_force"] = {Machine().a.x: unknown}
    made = type("Mine", (Body,), {word: property(lambda self: answers.get(word, unknown))})
    one = sympy.S.One
    told = refusal(lambda m: m.model.add(made("mine", one, one, m.model.token)))
    assert f"body 'mine': its {word} has the symbol 'unknown', which is none of the model" in told
