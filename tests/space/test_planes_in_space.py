"""Planar machines of the library declared again in space, in a plane at some angle.

Each loop of the plane has three rows too many there, which are named; the forces in the plane and
the torque about its normal are not touched by them, and are those of the plane.
"""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from codegen import Model
from models import slider_crank, watt_six_bar
from models.hard import andrews, double_pendulum
from models.hard.n_four_bar import n_four_bar
from runtime.core.outcomes import Outcome
from tests.space.from_plane import Translation, UntranslatableError, turned
from tests.space.plane_comparison import Pair

TURN = Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix()
SAME = 1e-8  # m, and of entries of rotation matrices
MACHINES: dict[str, tuple[Any, str, int]] = {  # model, scene and loops
    "compressor": (lambda: slider_crank.model, "compressor", 1),
    "watt": (lambda: watt_six_bar.model, "constant_torque", 2),
    "andrews": (lambda: andrews.model, "released", 3),
    "ten_four_bars": (lambda: n_four_bar(10), "fall", 10),
}
RUNS = [  # machine, and end in s
    ("compressor", 1.0),
    pytest.param("watt", 0.5, marks=pytest.mark.slow),
    pytest.param("andrews", 0.02, marks=pytest.mark.slow),
    pytest.param("ten_four_bars", 2.0, marks=pytest.mark.slow),
]


@cache
def pair(name: str, workshop: Path) -> Pair:
    declared, scene, _ = MACHINES[name]
    return Pair(declared(), scene, TURN, workshop)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
@pytest.mark.parametrize(("name", "end"), RUNS)
def test_a_planar_machine_moves_in_space_as_in_its_plane(
    name: str, end: float, method: str, workshop: Path
) -> None:
    both, loops = pair(name, workshop), MACHINES[name][2]
    start = both.space_start
    assert len(start.redundant) == 3 * loops
    assert {*start.not_unique} == {joint.name for joint in both.joints}
    assert start.degrees_of_freedom == both.plane_start.degrees_of_freedom == 1
    rtol = 1e-12 if method == "dop853" else 1e-10
    space = {"method": method, "rtol": rtol, "atol": 0.1 * rtol}
    both.run(end, np.linspace(0.0, end, 51), rtol=1e-12, atol=1e-13, space=space)
    assert both.known.outcome is both.found.outcome is Outcome.OK
    assert "are not unique" in both.found.message
    assert max(both.motion_apart()[word] for word in ("place", "A")) < SAME
    apart, largest = both.reactions_apart()
    assert largest > 1.0
    assert apart < SAME * largest


def test_the_compressor_in_space_is_that_of_the_reference(root: Path, workshop: Path) -> None:
    rows = np.genfromtxt(root / "tests/data/compressor_J450.csv", delimiter=",", names=True)
    both = pair("compressor", workshop)
    run = both.space.simulate(
        rows["t"][-1], rows["t"], start=both.space_start, rtol=1e-12, progress=False
    )
    place = np.column_stack([run.q(f"slider.{c}") for c in "xyz"]) @ TURN
    assert_allclose(place[:, 0], rows["x3"], rtol=0.0, atol=1e-8)
    force = np.column_stack([run.reaction("A", f"f{c}") for c in "xyz"]) @ TURN
    known = rows["RAx_ground_on_crank"]
    assert_allclose(force[:, 0], known, rtol=0.0, atol=1e-8 * np.abs(known).max())


@pytest.mark.slow
def test_andrews_mechanism_in_space_is_that_of_the_reference(root: Path, workshop: Path) -> None:
    rows = np.loadtxt(root / "tests/data/andrews.csv", delimiter=",", skiprows=1)
    both = pair("andrews", workshop)
    run = both.space.simulate(
        rows[-1, 0], rows[:, 0], start=both.space_start, rtol=1e-12, atol=1e-13, progress=False
    )
    for k in range(7):
        axis = (TURN.T @ run.rotation(f"K{k + 1}"))[:, :2, 0]
        exact = np.column_stack([np.cos(rows[:, k + 1]), np.sin(rows[:, k + 1])])
        assert_allclose(axis, exact, rtol=0.0, atol=1e-8)


def untranslatable() -> Model:
    model = Model("coiled")
    a = model.body("a", 1.0, 1.0)
    model.revolute("A", model.ground.at(0, 0), a.at(0, 0))
    model.torsion_spring("coil", model.ground, a, stiffness=1.0)
    model.scene("run", ["coil"])
    return model


def test_what_has_no_like_in_space_is_named() -> None:
    q = {"a.x": 0.0, "a.y": 0.0, "a.phi": 0.0}
    with pytest.raises(UntranslatableError, match="coil is a torsion spring"):
        Translation(untranslatable(), "run", q, TURN)


def test_the_cosine_of_a_difference_of_angles_is_the_product_of_two_axes() -> None:
    plane = double_pendulum.model
    q = {f"{b}.{c}": 0.3 for b in plane.bodies for c in ("x", "y", "phi")}
    to = Translation(plane, "thrown", q, TURN)
    (first, second), angles = list(to.bodies.values())[:2], (0.3, 1.1)
    flat = [plane.bodies[body.name].phi for body in (first, second)]
    found = to.value(sympy.cos(flat[0] - flat[1]))
    poses = [TURN @ turned(x) for x in angles]
    values = {
        e: x for body, A in zip((first, second), poses, strict=True)
        for e, x in zip(body.p, np.roll(Rotation.from_matrix(A).as_quat(), 1), strict=True)
    }  # fmt: skip
    assert float(found.subs(values)) == pytest.approx(np.cos(0.8), abs=1e-14)
