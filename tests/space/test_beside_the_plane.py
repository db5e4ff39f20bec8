"""Planar machines declared again in space: the same motion, events and reactions.

Open chains are not redundant in space; the motion in the plane is one of theirs.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model, t
from runtime import load
from runtime.results.result import Result
from tests.space.machines import Z

MASSES, MOMENTS = (2.0, 1.5), (0.3, 0.2)
EFFECTS = ["gravity", "s", "push", "twist"]
TIGHT: dict[str, Any] = {"rtol": 1e-12, "progress": False}


def in_plane() -> Model:
    model = Model("pair_in_plane", gravity=(0, -9.81))
    a, b = (model.body(n, m, j) for n, m, j in zip("ab", MASSES, MOMENTS, strict=True))
    model.revolute("A", model.ground.at(0, 0), a.at(-0.5, 0))
    model.revolute("B", a.at(0.5, 0), b.at(-0.4, 0.1))
    end = b.at(0.3, 0)
    model.spring("s", model.ground.at(1, 0.5), end, stiffness=40.0, free_length=0.4, damping=2)
    model.force("push", b.at(0.2, -0.1), 3.0, 1.0, frame="body")
    model.torque("twist", a, held(a.y, a.omega))
    start = {"a.phi": 0.5, "b.phi": -0.3, "a.omega": 1.0, "b.omega": -0.5}
    until = {"low": b.y < -0.8}
    model.scene("fall", effects=EFFECTS, start=start, until=until)
    return model


def in_space() -> Model:
    model: Any = Model("pair_in_space", space=True, gravity=(0, -9.81, 0))
    a, b = (
        model.body(n, m, (0.4 * j, 0.8 * j, j), axes=(0, 0, turn))
        for n, m, j, turn in zip("ab", MASSES, MOMENTS, (0.5, -0.3), strict=True)
    )
    along = model.ground.along(*Z), a.along(*Z)
    model.revolute("A", model.ground.at(0, 0, 0), a.at(-0.5, 0, 0), axis=along)
    both = a.along(*Z), b.along(*Z)
    model.revolute("B", a.at(0.5, 0, 0), b.at(-0.4, 0.1, 0), axis=both)
    end, post = b.at(0.3, 0, 0), model.ground.at(1, 0.5, 0)
    model.spring("s", post, end, stiffness=40.0, free_length=0.4, damping=2)
    model.force("push", b.at(0.2, -0.1, 0), (3.0, 1.0, 0.0), frame="body")
    model.torque("twist", a, (0, 0, held(a.y, a.omega_z)))
    half = {"a": 0.25, "b": -0.15}
    start = {f"{n}.e0": np.cos(x) for n, x in half.items()}
    start |= {f"{n}.e3": np.sin(x) for n, x in half.items()}
    start |= {"a.omega_z": 1.0, "b.omega_z": -0.5}
    model.scene("fall", effects=EFFECTS, start=start, until={"low": b.y < -0.8})
    return model


def held(height: Any, spin: Any) -> Any:
    """A torque that depends on time and speed, and stops below a height."""
    return sympy.Piecewise((0.7 + 0.2 * sympy.sin(3 * t) - 0.1 * spin, height > -0.4), (0, True))


@pytest.fixture(scope="module")
def pair(workshop: Path) -> tuple[Any, Any]:
    return load(in_plane(), folder=workshop), load(in_space(), folder=workshop)


def angle(result: Result, body: str) -> np.ndarray:
    half = np.arctan2(result.q(f"{body}.e3"), result.q(f"{body}.e0"))
    return np.asarray(2 * np.unwrap(half))


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_motion_events_and_reactions_are_those_of_the_plane(
    pair: tuple[Any, Any], method: str
) -> None:
    rtol = 1e-12 if method == "dop853" else 1e-10
    plane, space = (m.simulate(4.0, 81, rtol=rtol, method=method, progress=False) for m in pair)
    assert plane.message.split(" in ")[0] == space.message.split(" in ")[0]
    assert [e.name for e in plane.events] == [e.name for e in space.events]
    instants = [[e.time for e in result.events] for result in (plane, space)]
    assert_allclose(instants[1], instants[0], rtol=0.0, atol=1e-8)
    assert len(instants[0]) == 2  # the torque stops, and the run ends
    for body in "ab":
        assert_allclose(angle(space, body), plane.q(f"{body}.phi"), rtol=0.0, atol=1e-8)
        assert_allclose(space.v(f"{body}.omega_z"), plane.v(f"{body}.omega"), rtol=0.0, atol=1e-8)
        for c in "xy":
            assert_allclose(space.q(f"{body}.{c}"), plane.q(f"{body}.{c}"), rtol=0.0, atol=1e-8)
        assert_allclose(space.q(f"{body}.z"), 0.0, rtol=0.0, atol=1e-12)
    for c in "xy":  # joint A has the axes of the ground in both
        found, known = (result.reaction("A", f"f{c}") for result in (space, plane))
        assert_allclose(found, known, rtol=0.0, atol=1e-6)
    assert_allclose(space.reaction("A", "tz"), 0.0, rtol=0.0, atol=1e-9)
    assert_allclose(space.energy(), plane.energy(), rtol=0.0, atol=1e-6)
