"""A loop in space whose rows repeat each other: by every method, beside an independent solution."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.check import shared_rows
from codegen.errors import AssemblyError, ModelError
from codegen.lower.kernels.independent_rows import SharedRows
from models.space.bricard import bricard
from runtime import load
from runtime.core.outcomes import Outcome
from tests.space.machines import Z


def tracked() -> Model:
    """Bricard's linkage with the path of a pin."""
    model = bricard()
    model.track("pin", model.bodies["b2"].at(0, -0.5, 0))
    model.scene("followed", effects=["gravity", "pin"])
    return model


@pytest.mark.parametrize("method", ["dop853", "radau5", "bdf"])
def test_bricards_linkage_moves_as_its_reference_does(
    method: str, root: Path, workshop: Path
) -> None:
    reference = np.genfromtxt(root / "tests/data/bricard.csv", delimiter=",", names=True)
    machine = load(tracked(), "followed", folder=workshop)
    run = machine.simulate(10.0, reference["t"], rtol=1e-9, method=method, progress=False)
    assert run.outcome is Outcome.OK
    assert "Redundant: J6.g; the reactions of J1" in run.message
    for axis in "xyz":
        assert_allclose(run.point("pin", axis), reference[f"P3{axis}"], rtol=0, atol=1e-9)
    assert all(np.isfinite(run.reaction(f"J{k}", "fx")).all() for k in range(1, 7))


def four_bar() -> Any:
    """A four-bar of parallel axes, of whose last hinge three rows follow; its hinges count."""
    model: Any = Model("counting_four_bar", space=True, gravity=(0, -9.81, 0))
    pins = [(0, 0, 0), (0, 1, 0), (2, 1.2, 0), (2, 0, 0)]
    middles = (np.mean(pins[k : k + 2], axis=0).tolist() for k in range(3))
    bars = [model.body(f"b{k}", 1.0, (0.1, 0.1, 0.1), at=at) for k, at in enumerate(middles)]
    links = (model.ground, *bars, model.ground)
    hinges = [
        model.revolute(f"J{k}", *links[k : k + 2], at=at, axis=Z) for k, at in enumerate(pins)
    ]
    model.rotation_driver("drive", hinges[0], 3 * t)
    angles = [hinge.angle for hinge in hinges]
    for name, words in {"few": ["default"], "all": ["all"]}.items():
        model.scene(f"led_{name}", ["gravity"], ["drive"], outputs=[*words, *angles])
        model.scene(f"free_{name}", ["gravity"], outputs=[*words, angles[0]])
    model.scene("free_energy", ["gravity"], outputs=["energy", angles[0]])
    model.scene("free_doubled", ["gravity"], outputs={"doubled": 2 * angles[0]})
    return model


@pytest.mark.parametrize("few", ["led_few", "free_few", "free_energy", "free_doubled"])
def test_outputs_afterwards_where_hinges_count(few: str, workshop: Path) -> None:
    model, runs = four_bar(), []
    for scene in (few, few.partition("_")[0] + "_all"):
        machine = load(model, scene, folder=workshop)
        if scene.startswith("led"):
            runs.append(machine.inverse_dynamics(0.3, 4, progress=False))
        else:
            start = {"J0.rate": 2.0}
            runs.append(machine.simulate(0.3, 4, start=start, rtol=1e-10, progress=False))
    late, named = runs
    assert "Redundant: J3.z, J3.f, J3.g;" in late.message
    power = named.power("gravity")
    assert_allclose(late.power("gravity"), power, rtol=1e-9, atol=1e-12)
    assert power[-1] > 30.0
    wanted = named.wrench("J2", "b2")
    assert_allclose(late.wrench("J2", "b2"), wanted, rtol=0.0, atol=1e-7 * np.abs(wanted).max())


SIDES, TWISTS = (1.0, np.sqrt(2.0)), (np.pi / 6, np.pi / 4)  # m; with sin α / a = sin β / b


def opposite(angle: float) -> float:
    """The angle at the second hinge of Bennett's linkage, for that at the first."""
    ratio = np.sin(sum(TWISTS) / 2) / np.sin((TWISTS[1] - TWISTS[0]) / 2)
    return float(2 * np.arctan2(ratio * np.cos(angle / 2), np.sin(angle / 2)))


def bennett(angle: float, digits: int = 16) -> Any:
    """Four hinges whose axes are skew, by the frames of Denavit and Hartenberg, rounded."""
    frame, frames = np.eye(4), [np.eye(4)]
    turns = (angle, opposite(angle), -angle)
    for turn, side, twist in zip(turns, (*SIDES, SIDES[0]), (*TWISTS, TWISTS[0]), strict=True):
        c, s, e, f = np.cos(turn), np.sin(turn), np.cos(twist), np.sin(twist)
        frame = frame @ [
            [c, -s * e, s * f, side * c], [s, c * e, -c * f, side * s], [0, f, e, 0], [0, 0, 0, 1],
        ]  # fmt: skip
        frames.append(frame)
    model: Any = Model("bennett", space=True, gravity=(0, 0, -9.81))
    chain: list[Any] = [model.ground]
    for k, (one, other) in enumerate(pairwise(frames), 1):
        chain.append(model.body(f"b{k}", 1.0, (0.1, 0.1, 0.1), at=(one[:3, 3] + other[:3, 3]) / 2))
    chain.append(model.ground)
    for k, of in enumerate(frames):
        at, axis = np.round(of[:3, [3, 2]], digits).T
        model.revolute(f"J{k + 1}", chain[k], chain[k + 1], at=at, axis=axis)
    model.rotation_driver("drive", model.joints["J1"], 2 * np.pi * t)
    model.scene("turn", [], ["drive"], outputs=["default", model.joints["J4"].angle])
    return model


@pytest.mark.parametrize("degrees", [30, 60, 100])
def test_rows_that_are_chosen_hold_for_a_whole_turn(degrees: float, workshop: Path) -> None:
    """Of rows that are good for 1 rad about the drawing some are dependent after half a turn."""
    start = np.radians(degrees)
    run = load(bennett(start), folder=workshop).kinematics(1.0, 101, progress=False)
    assert run.outcome is Outcome.OK
    assert run.stats["singular_crossings"] == 0
    turned = [opposite(start) - opposite(start + 2 * np.pi * time) for time in run.t]
    assert_allclose(np.exp(1j * run["J4.angle"]), np.exp(1j * np.array(turned)), atol=1e-9)


def test_a_loop_that_rounded_numbers_lock_is_told_so(workshop: Path) -> None:
    with pytest.raises(ModelError) as refusal:
        load(bennett(1.0, 4), folder=workshop)
    said = str(refusal.value)
    assert "The joints hold a motion by a singular value of only 8e-06, and would leave it" in said
    assert "compute these rather than round them (ten digits are enough), or use" in said
    assert "Remove or relax" not in said
    with pytest.warns(UserWarning, match="no velocities"):
        machine = load(bennett(1.0, 9), folder=workshop)
    with pytest.raises(AssemblyError, match="elsewhere, or give more digits of axes and"):
        machine.kinematics(1.0, 11, progress=False)
    run = load(bennett(1.0, 10), folder=workshop).kinematics(1.0, 101, progress=False)
    assert run.outcome is Outcome.OK


def test_a_driver_far_from_the_drawing_leads_its_loop_on_from_there(workshop: Path) -> None:
    machine = load(four_bar(), "led_few", folder=workshop)
    run = machine.kinematics([0.0, 0.8, 1.6, 2.0], progress=False)
    for k, time in enumerate(run.t):
        assert_allclose(machine.assemble(t=time).q, run.samples.q[k], rtol=0, atol=1e-9)


LINK, LOAD, PART, OFFSET = 0.3, 8.0, 0.5, 0.12  # m, kg, kg of a link, m to the lower hinges


def sarrus() -> Any:
    """Sarrus's linkage: two chains of hinges at right angles lead a plate up and down."""
    model: Any = Model("sarrus", space=True, gravity=(0, 0, -9.81))
    up, moments = np.array(Z, float), (1e-5, PART * LINK**2 / 12, PART * LINK**2 / 12)
    height, angle = 0.5, np.arcsin(0.5 / 2 / LINK)
    plate = model.body("plate", LOAD, (0.05, 0.05, 0.08), at=(0, 0, height))
    for name, out in (("x", np.array([1.0, 0, 0])), ("y", np.array([0, 1.0, 0]))):
        axis, low = np.cross(up, out), OFFSET * out
        elbow = low + LINK * (np.cos(angle) * out + np.sin(angle) * up)
        places = low, elbow, low + height * up
        links = [
            model.body(f"{part}_{name}", PART, moments, at=(a + b) / 2, axes=(b - a, axis))
            for part, (a, b) in zip(("low", "up"), pairwise(places), strict=True)
        ]
        chain = (model.ground, *links, plate)
        for word, at, (i, j) in zip(("base", "elbow", "top"), places, pairwise(chain), strict=True):
            model.revolute(f"{word}_{name}", i, j, at=at, axis=axis)
    model.scene("fall", ["gravity"])
    return model


def test_chains_that_fold_and_stretch_at_once_keep_their_energy(workshop: Path) -> None:
    """The redundant direction turns by 90° between both, in the axes of the last link."""

    def inertia(angle: float) -> float:
        """Of both chains and the plate, in the angle of a link."""
        sine, cosine = np.sin(angle) / 2, np.cos(angle)
        links = 2 * PART * (LINK**2 / 6 + LINK**2 * (0.25 + sine**2 + (1.5 * cosine) ** 2))
        return float(links + LOAD * (2 * LINK * cosine) ** 2)

    machine = load(sarrus(), folder=workshop)
    run = machine.simulate(1.2, 601, rtol=1e-10, progress=False)
    assert run.outcome is Outcome.OK
    assert [round(row.time, 3) for row in run.singular] == [0.316, 0.471, 0.626]
    assert np.ptp(run.energy("total")) < 1e-3
    # speed from the energy, and heights from it by the rate at which they change
    z, speed = run["plate.z"], run["plate.vz"]
    cosine = np.sqrt(1.0 - (z / 2 / LINK) ** 2)
    away = cosine > 0.05
    rate = speed[away] / (2 * LINK * cosine[away])
    kinetic = 0.5 * np.vectorize(inertia)(np.arcsin(z[away] / 2 / LINK)) * rate**2
    assert_allclose(kinetic, (LOAD + 2 * PART) * 9.81 * (0.5 - z[away]), rtol=0, atol=1e-3)


def test_a_step_across_a_singular_position_errs_by_little_or_is_not_taken(
    workshop: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows of which one is dropped that says most where the chains are stretched."""

    def last_dropped(rows: Any, redundant: Any, *_: Any) -> SharedRows:
        return SharedRows(rows, redundant, tuple(row for row in rows if row not in redundant), ())

    monkeypatch.setattr(shared_rows, "_best", last_dropped)
    monkeypatch.setattr(shared_rows, "_loses_direction", lambda *_: False)
    machine = load(sarrus(), folder=workshop / "poor")
    for rtol in (1e-6, 1e-8, 1e-10):
        run = machine.simulate(1.2, 601, rtol=rtol, progress=False)
        assert run.stats["crossing_error"] * rtol < 1e-3
