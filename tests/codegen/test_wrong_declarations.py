"""What is wrong with a declaration is said by name, all of it at once."""

import re

import pytest
from pint import get_application_registry

from codegen import LinkwrightError, Model
from codegen.driver import valid_scenes
from tests.codegen.test_ordinary_mistakes import NAMES, read_table

CASES = read_table("wrong_declarations.txt")
PINNED = """
model.revolute('A', model.ground.at(0, 0), a)
model.revolute('B', model.ground.at(0.3, 0.4), b)
"""
ARM = """
arm = model.body('arm', mass=1, inertia=1)
model.revolute('A', arm.at(0, 0), a.at(0, 0.1))
model.revolute('B', b, arm.at(2, 0))
"""
COAXIAL = """
arm = model.body('arm', mass=1, inertia=1)
model.revolute('S', model.ground.at(0, 0), a)
model.revolute('A', model.ground.at(0, 0), arm)
model.revolute('B', b, arm.at(2, 0))
"""


def declared(text: str) -> Model:
    """Two bodies, a parameter, gravity, and what the text declares."""
    model = Model("m", gravity=(0, -9.81))
    names = {
        "model": model,
        "a": model.body("a", mass=1.0, inertia=2.0),
        "b": model.body("b", mass=3.0, inertia=4.0),
        "k": model.parameter("k", 5.0, unit="N/m"),
        "Q": get_application_registry().Quantity,
        "nan": float("nan"),
    }
    exec(text, NAMES | names)
    return model


@pytest.mark.parametrize("case", CASES)
def test_what_is_wrong_is_said(case: str) -> None:
    with pytest.raises(LinkwrightError) as caught:
        valid_scenes(declared(case), None)
    told = [re.sub("0x[0-9a-f]+", "0x...", problem) for problem in caught.value.problems]
    assert told == CASES[case]


@pytest.mark.parametrize(
    "text",
    [
        *(
            f"{PINNED}model.gear('G', a, b, {radii})"
            for radii in ("0.2, 0.3", "0.1 + 0.1, 0.29999999", "k / 25, 0.5 - k / 25", "-0.7, 0.2")
        ),
        f"{ARM}model.belt('D', a, b, 1, 2, carrier=arm)",
        f"{COAXIAL}model.belt('D', a, b, 1, 2, carrier=arm)",
        "model.belt('B', a, b, 1, 2, carrier=model.ground)",
    ],
)
def test_wheels_that_fit_their_bearings(text: str) -> None:
    valid_scenes(declared(text), None)
