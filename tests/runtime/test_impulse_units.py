"""Impulses of joints that engage: a unit for each component, and zeros without a sign."""

import math
from pathlib import Path

import pytest

from codegen import Model
from runtime import load
from runtime.results.run_records import Reconnection


def _caught(kind: str, folder: Path) -> Reconnection:
    model = Model(f"caught_{kind}")
    bob = model.body("bob", mass=2.0, inertia=0.5)
    if kind == "angle":
        joint = model.constraint("stay", bob.phi - 1.0)
    elif kind == "place":
        joint = model.constraint("stay", bob.x - 1.0, bob.y)
    elif kind == "mixed":
        joint = model.constraint("stay", bob.x - 0.5 * bob.phi - 0.5)
    else:
        joint = model.weld("stay", model.ground.at(1, 0), bob.at(0, 0), angle=1.0)
    model.engage(joint, when=bob.phi > 1.0)
    start = {bob.x: 0.0, bob.y: 0.0, bob.phi: 0.0, bob.vx: 1.0, bob.omega: 1.0}
    model.scene("meet", start=start)
    (change,) = load(model, folder=folder).simulate(1.5).reconnections
    return change


@pytest.mark.parametrize(
    ("kind", "units", "words"),
    [
        ("angle", {"force": "N m s"}, "(force -0.5 N m s), which took 0.25 J."),
        ("place", {"force0": "N s", "force1": "N s"}, "(force0 -2 N s, force1 0 N s), which took"),
        ("mixed", {"force": ""}, "(force -"),
        (
            "joint",
            {"fx": "N s", "fy": "N s", "torque": "N m s"},
            "(fx -2 N s, fy 0 N s, torque -0.5 N m s), which took 1.25 J.",
        ),
    ],
)
def test_each_component_of_an_impulse_has_its_unit(
    kind: str, units: dict[str, str], words: str, tmp_path: Path
) -> None:
    change = _caught(kind, tmp_path)
    assert change.units == units
    assert words in str(change)
    assert [x for x in change.impulse.values() if x == 0.0 and math.copysign(1.0, x) < 0.0] == []
