"""What a colleague gets wrong is said in full: what, where, the numbers, and what to do."""

import math
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from pint import get_application_registry

import codegen
from codegen import LinkwrightError, Model, Scene
from codegen.driver import valid_scenes


def read_table(name: str) -> dict[str, list[str]]:
    """Cases of a table, each with the sentences that are said of it, indented, in its order."""
    text = Path(__file__).with_name(name).read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    cases: dict[str, list[str]] = {}
    declaration: list[str] = []
    for is_sentence, block in groupby(lines, lambda line: line.startswith("    ")):
        if is_sentence:
            cases["\n".join(declaration)] = [sentence.strip() for sentence in block]
        else:
            declaration = [*block]
    return cases


CASES = read_table("ordinary_mistakes.txt")
NAMES: dict[str, Any] = {name: getattr(codegen, name) for name in codegen.__all__}
NAMES |= {name: getattr(sympy, name) for name in sympy.__all__}
"""What models import."""


def words() -> dict[str, Any]:
    """What the cases of the table are written with: a small machine, and what models import."""
    model = Model("m", gravity=(0, -9.81))
    a, b = (model.body(name, 1.0, 2.0) for name in "ab")
    return {
        **{name: getattr(sympy, name) for name in sympy.__all__},
        **{name: getattr(codegen, name) for name in codegen.__all__},
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
    }


@pytest.mark.parametrize("case", CASES)
def test_an_ordinary_mistake_is_told(case: str) -> None:
    known = words()
    with pytest.raises(LinkwrightError) as caught:  # noqa: PT012 (either of them)
        made = eval(case, known)
        valid_scenes(known["m"], made if isinstance(made, Scene) else None)
    assert [*caught.value.problems] == CASES[case]


@pytest.mark.parametrize(
    "case", ['coordinate("a", "z")', 'coordinate(a, "phi")', 'ConjugateReaction.along("z")']
)
def test_a_coordinate_that_there_is_not(case: str) -> None:
    """The list ends with the coordinates that elements of one's own have declared."""
    with pytest.raises(LinkwrightError, match="one of x, y, phi, alpha, beta, integral"):
        eval(case, words())


@pytest.mark.parametrize("symbol", ["k", "a.x", "a.vx"])
def test_a_symbol_takes_no_value(symbol: str) -> None:
    with pytest.raises(AttributeError):
        eval(symbol, words()).value = 3.0


def test_a_model_of_an_own_class_has_its_own_words() -> None:
    class Crane(Model):
        """A model with a number of its own."""

    crane = Crane("crane")
    crane.reach = 3.0  # type: ignore[attr-defined]
    assert crane.reach == 3.0
    with pytest.raises(LinkwrightError, match="'force' cannot be set"):
        crane.force = 3.0  # type: ignore[method-assign, assignment]
