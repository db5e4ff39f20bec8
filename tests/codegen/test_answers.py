"""What elements of a modeller's own answer is read by its kind, and refused by name."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sympy

from codegen import Body, Constraint, Effect, ModelError, Statement
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
        r"its problems\(\) answers 7",
    ),
    "forces that are None": (
        lambda m: Belt(m, forces=lambda b: None),
        r"its forces\(\) answers None",
    ),
    "forces by name": (lambda m: Belt(m, forces=lambda b: {"a.x": 1}), r"its forces\(\) answers"),
    "a force that is text": (
        lambda m: Belt(m, forces=lambda b: {m.a.x: "1"}),
        r"forces\(\) answers '1'",
    ),
    "a potential that fails": (lambda m: Belt(m, potential=fails), r"its potential\(\) fails"),
    "a potential of a velocity": (
        lambda m: Belt(m, potential=lambda b: m.a.vx),
        "the velocity a_vx",
    ),
    "pulls of three": (lambda m: Belt(m, pulls=lambda b: ((1, 2, 3),)), r"its pulls\(\) answers"),
    "a hold of another kind": (lambda m: Belt(m, hold=lambda b: 7), r"its hold\(\) answers 7"),
    "a statement that is None": (
        lambda m: Bar(m, lambda x: None),
        r"its statement\(\) answers None",
    ),
    "a statement that fails": (lambda m: Bar(m, fails), r"its statement\(\) fails with KeyError"),
    "equations that are text": (
        lambda m: Bar(m, lambda x: Statement(("x",), ("x",), None)),
        "among phi answers 'x'",
    ),
    "bindings that are none": (
        lambda m: Bar(m, lambda x: Statement((x,), ("x",), None, 7)),
        "bindings is 7",
    ),
    "a reaction that is none": (
        lambda m: Bar(m, lambda x: Statement((x,), ("x",), "fx")),
        "its reaction answers 'fx'",
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
