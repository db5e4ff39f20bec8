"""Planar machines declared again in space, in a plane at some angle and place.

Each loop of the plane has three rows too many there, which are named; the forces in the plane and
the torque about its normal are not touched by them, and are those of the plane.
"""

from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from codegen import Model
from codegen.declare.scene import Scene
from codegen.elements.joints.wheels import Gear
from codegen.errors import ModelError
from codegen.model.space_model import REFUSED
from models.hard import andrews, double_pendulum
from models.hard.n_four_bar import n_four_bar
from runtime.core.outcomes import Outcome
from tests.space.from_plane import Translation, UntranslatableError, turned
from tests.space.plane_comparison import Pair

TURN, ORIGIN = Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix(), (0.3, -0.2, 0.5)
SAME = 1e-8  # of the machine's size, of entries of rotation matrices, and of the largest reaction
NOTHING = 1e-12  # N, the rounding of reactions where nothing bears on a joint
ENDS = {  # s
    "coil_spring": 1.0, "engine": 0.15, "film_follower": 1.0, "four_bar": 1.0, "gear_slider": 0.5,
    "quarter_car": 0.6, "quick_return": 1.0, "rack_and_pinion": 0.4, "robot_arm": 0.3,
    "scotch_yoke": 0.5, "slider_crank": 1.0, "trebuchet": 10.0, "valve_lifter": 0.02,
    "watt_six_bar": 0.5, "web_cutter": 1.0,
}  # fmt: skip
"""Machine of the library → the end of its runs; no run of the trebuchet lasts so long."""
LACKING = {"scotch_yoke": {"slot_rub": "friction", "guide_rub": "friction"}}
"""Machine → its elements that space does not have, and what kind they are; runs go without them."""
CONTROLLERS = {
    "own": {
        f"own_{joint}": lambda sample, k=k: 20.0 * np.cos((3.0 + k) * sample.t)
        for k, joint in enumerate(("shoulder", "elbow", "wrist"))
    }
}


def machine(name: str) -> Model:
    model: Model = import_module(f"models.{name}").model
    return model


def part_of(one: Scene, other: Scene) -> bool:
    """Whether a scene has all that another one has, and more."""
    same = (one.bodies, one.drivers, one.inactive_joints) == (
        other.bodies, other.drivers, other.inactive_joints,
    )  # fmt: skip
    has_forces = other.analysis == "dynamics" and {*one.effects} <= {*other.effects}
    return same and has_forces and (one.analysis == "kinematics" or one.effects != other.effects)


def scenes(name: str) -> Iterator[Any]:
    """The scenes that are run: those that are part of no other."""
    found = [scene for scene in machine(name).scenes.values() if not scene.follows]
    for scene in found:
        if not any(part_of(scene, other) for other in found if other is not scene):
            yield pytest.param(name, scene, id=f"{name}-{scene.name}")


def check_structure(both: Pair) -> None:
    """The redundant rows are named, three a loop; so are the joints in loops."""
    start, plane, to = both.space_start, both.plane_start, both.translation
    assert len(plane.redundant) == 0
    assert len(start.redundant) == 3 * to.loops
    assert {row.element for row in start.redundant} <= to.in_loops
    assert {*start.not_unique} == to.in_loops
    assert start.degrees_of_freedom == plane.degrees_of_freedom + to.spins


def check_runs(both: Pair) -> None:
    assert both.known.outcome is both.found.outcome is Outcome.OK
    assert both.known.ended_by == both.found.ended_by
    apart = both.motion_apart()
    assert apart["place"] < SAME * both.size
    assert apart["A"] < SAME
    times = [
        [event.time for event in run.events if event.element not in both.until]
        for run in (both.known, both.found)
    ]  # the ball of the trebuchet, which begins at y = 0, leaves it at an instant of rounding
    assert_allclose(*times, rtol=0.0, atol=SAME)
    if both.plane.description.analysis == "kinematics":
        return
    assert ("are not unique" in both.found.message) == bool(both.translation.loops)
    worst, largest, across = both.reactions_apart()
    assert max(worst, across) < SAME * largest + NOTHING
    for known, found in both.multipliers():
        size = float(np.nanmax(np.abs(known)))
        assert_allclose(found, known, rtol=0.0, atol=SAME * size + NOTHING)


@pytest.mark.parametrize(("name", "scene"), [one for name in ENDS for one in scenes(name)])
def test_a_machine_of_the_library_moves_in_space_as_in_its_plane(
    name: str, scene: Scene, workshop: Path
) -> None:
    acting = scene.without(*LACKING[name]) if name in LACKING else scene
    both, end = Pair(machine(name), acting, TURN, ORIGIN, workshop), ENDS[name]
    check_structure(both)
    if "equilibrium" in scene.name:
        both.rest()
    else:
        words = {"controllers": CONTROLLERS[scene.name]} if scene.name in CONTROLLERS else {}
        both.run(end, np.linspace(0.0, end, 51), rtol=1e-12, atol=1e-13, space={}, **words)
    check_runs(both)


class WithGears(Translation):
    """Gears between the angles of joints, which leave out what the teeth press on the bearings."""

    def _joint(self, joint: Any) -> None:
        if not isinstance(joint, Gear):
            super()._joint(joint)
            return
        i, j, sign = {"mesh": ("A", "B", -1.0), "ring": ("O", "axle", 1.0)}[joint.name]
        ratio = sign * self.number(joint.radius_i / joint.radius_j)
        self.model.gear(joint.name, self.model.joints[i], self.model.joints[j], ratio)


@pytest.mark.parametrize("scene", ["train_running", "planetary_inverse_dynamics"])
def test_gears_between_angles_of_joints_move_as_gears_of_the_plane(
    scene: str, workshop: Path
) -> None:
    model = machine("gear_slider")
    given = model.scenes[scene].without("gravity")
    both = Pair(model, given, TURN, ORIGIN, workshop, WithGears)
    both.run(0.5, np.linspace(0.0, 0.5, 51), rtol=1e-12, atol=1e-13, space={})
    apart = both.motion_apart()
    assert apart["place"] < SAME * both.size
    assert apart["A"] < SAME
    for name in given.drivers:
        known, found = (run.reaction(name, "torque") for run in (both.known, both.found))
        assert_allclose(found, known, rtol=0.0, atol=SAME * np.abs(known).max())


def test_each_machine_of_the_library_is_declared_in_space(root: Path) -> None:
    assert {path.stem for path in (root / "models").glob("[!_]*.py")} == {*ENDS}


def rubs_in_slots() -> bool:
    """Whether space has friction in slots, as the scotch yoke needs it."""
    declared: Any = Model("slot", space=True)
    body = declared.body("b", 1.0, (1, 1, 1))
    words = {"at": (0, 0, 0), "axis": (1, 0, 0), "hinge": (0, 0, 1)}
    slot = declared.revolute_translational("slot", declared.ground, body, **words)
    declared.friction("rub", slot, 0.1)
    declared.scene("s", ["rub"])
    try:
        declared.equations()
    except ModelError as error:
        return "is no joint that rubs" not in str(error)
    return True


@pytest.mark.parametrize("name", LACKING)
def test_what_a_machine_lacks_in_space_is_refused_there(name: str) -> None:
    model = machine(name)
    scene = next(iter(model.scenes.values()))
    q = {f"{body}.{c}": 0.0 for body in model.bodies for c in ("x", "y", "phi")}
    for element, kind in LACKING[name].items():
        assert element in scene.effects
        told = f"space has {kind} now: run {name} with {element}"
        assert kind in REFUSED or not rubs_in_slots(), told
        with pytest.raises(UntranslatableError, match=f"{element} is a .*{kind}"):
            Translation(model, scene.without(*{*LACKING[name]} - {element}), q, TURN)


@cache
def pair(name: str, workshop: Path) -> Pair:
    declared, scene, _ = HARD[name]
    model = declared()
    return Pair(model, model.scenes[scene], TURN, ORIGIN, workshop)


HARD = {  # model, scene, and end in s
    "compressor": (lambda: machine("slider_crank"), "compressor", 1.0),
    "andrews": (lambda: andrews.model, "released", 0.02),
    "ten_four_bars": (lambda: n_four_bar(10), "fall", 2.0),
}


@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("compressor", "radau5"),
        *(pytest.param(name, method, marks=pytest.mark.slow)
          for name in ("andrews", "ten_four_bars") for method in ("dop853", "radau5")),
    ],
)  # fmt: skip
def test_a_hard_machine_moves_in_space_as_in_its_plane(
    name: str, method: str, workshop: Path
) -> None:
    both, end = pair(name, workshop), HARD[name][2]
    check_structure(both)
    rtol = 1e-12 if method == "dop853" else 1e-10
    space = {"method": method, "rtol": rtol, "atol": 0.1 * rtol}
    both.run(end, np.linspace(0.0, end, 51), rtol=1e-12, atol=1e-13, space=space)
    check_runs(both)


def test_the_compressor_in_space_is_that_of_the_reference(root: Path, workshop: Path) -> None:
    rows = np.genfromtxt(root / "tests/data/compressor_J450.csv", delimiter=",", names=True)
    both = pair("compressor", workshop)
    run = both.space.simulate(
        rows["t"][-1], rows["t"], start=both.space_start, rtol=1e-12, progress=False
    )
    place = (np.column_stack([run.q(f"slider.{c}") for c in "xyz"]) - ORIGIN) @ TURN
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


def test_the_cosine_of_a_difference_of_angles_is_the_product_of_two_axes() -> None:
    plane = double_pendulum.model
    q = {f"{b}.{c}": 0.3 for b in plane.bodies for c in ("x", "y", "phi")}
    to = Translation(plane, plane.scenes["thrown"], q, TURN)
    (first, second), angles = [to.bodies[name] for name in plane.bodies][:2], (0.3, 1.1)
    flat = [plane.bodies[body.name].phi for body in (first, second)]
    found = to.value(sympy.cos(flat[0] - flat[1]))
    poses = [TURN @ turned(x) for x in angles]
    values = {
        e: x for body, A in zip((first, second), poses, strict=True)
        for e, x in zip(body.p, np.roll(Rotation.from_matrix(A).as_quat(), 1), strict=True)
    }  # fmt: skip
    assert float(found.subs(values)) == pytest.approx(np.cos(0.8), abs=1e-14)
