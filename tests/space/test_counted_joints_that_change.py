"""Angles of joints in conditions by which joints come and go, and in scenes without some joints."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.errors import AnalysisError, ModelError
from runtime import load
from runtime.core.outcomes import Outcome

Z = (0, 0, 1)
SPEED = 30.0  # rad/s


def two_links(name: str) -> Any:
    """A link that turns about Z with 30 rad/s, with another at its end; nothing pulls."""
    model: Any = Model(f"two_links_{name}", space=True)
    one = model.body("one", 1.0, (0.1, 0.2, 0.3), at=(0.3, 0, 0))
    other = model.body("other", 1.0, (0.1, 0.2, 0.3), at=(0.6, 0, 0))
    model.revolute("A", model.ground, one, at=(0, 0, 0), axis=Z)
    model.revolute("B", one, other, at=(0.6, 0, 0), axis=Z)
    return model


def test_a_condition_counts_what_it_names(workshop: Path) -> None:
    """The hinge lets go at two turns, and the angle goes on where nothing watches it."""
    model = two_links("again")
    A, B = model.joints["A"], model.joints["B"]
    model.release(B, when=A.angle > 4 * np.pi)
    model.scene("run", start={"one.omega_z": SPEED, "other.omega_z": SPEED})
    assert model.scenes["run"].counted == model.scenes["run_without_B"].counted == ("A.angle",)
    run = load(model, "run", folder=workshop).simulate(1.0, 11, rtol=1e-10, progress=False)
    (change,) = run.reconnections
    assert change.time == pytest.approx(4 * np.pi / SPEED, rel=1e-8)
    assert_allclose(run["A.angle"], SPEED * run.t, rtol=0.0, atol=1e-6)


def test_a_joint_that_is_gone_is_neither_counted_nor_watched(workshop: Path) -> None:
    model = two_links("gone")
    A, B = model.joints["A"], model.joints["B"]
    model.release(B, when=B.angle > 0.5)
    until = {"folded": B.angle > 1.0, "turned": A.angle > 60.0}
    model.scene("run", start={"A.rate": SPEED, "B.rate": 2.0}, until=until)
    assert model.scenes["run"].counted == ("A.angle", "B.angle")
    assert model.scenes["run_without_B"].counted == ("A.angle",)
    run = load(model, "run", folder=workshop).simulate(9.0, 19, progress=False)
    assert [change.joint for change in run.reconnections] == ["B"]
    assert run.ended_by == "turned"
    assert run["A.angle"][-1] == pytest.approx(60.0, rel=1e-9)


def test_angles_that_a_gear_asks_for_go_on_without_it(workshop: Path) -> None:
    model = two_links("let_go")
    model.release(model.gear("teeth", model.joints["A"], model.joints["B"], 2), when=t > 0.3)
    model.torque("push", model.bodies["other"], (0, 0, 90.0))
    model.scene("run", ["push"], start={"one.omega_z": SPEED})
    assert model.scenes["run_without_teeth"].counted == ("A.angle", "B.angle")
    run = load(model, "run", folder=workshop).simulate(0.6, 121, rtol=1e-10, progress=False)
    assert [change.action for change in run.reconnections] == ["release"]
    turned = [
        np.unwrap(np.arctan2(A[:, 1, 0], A[:, 0, 0])) for A in map(run.rotation, ("one", "other"))
    ]
    assert_allclose(run["A.angle"], turned[0], rtol=0.0, atol=1e-10)
    assert_allclose(run["B.angle"], turned[1] - turned[0], rtol=0.0, atol=1e-10)
    ratio = run["B.angle"][1:] / run["A.angle"][1:]
    assert np.ptp(ratio[run.t[1:] < 0.3]) < 1e-12
    assert np.ptp(ratio) > 0.1


def test_a_gear_engages_by_angles_that_are_counted_from_the_start(workshop: Path) -> None:
    """Wheels at 4 and 8 rad/s mesh after 1 s; modulo whole turns these angles are open."""
    model: Any = Model("meshing", space=True)
    A, B = (
        model.revolute(name, model.ground, model.body(f"wheel{name}", 1.0, (1, 1, 1), at=(x, 0, 0)),
                       at=(x, 0, 0), axis=Z)
        for name, x in (("A", 0), ("B", 1))
    )  # fmt: skip
    model.engage(model.gear("teeth", A, B, 2), when=t > 1.0)
    model.scene("run", start={"wheelA.omega_z": 4.0, "wheelB.omega_z": 8.0})
    run = load(model, "run", folder=workshop).simulate(3.0, 31, rtol=1e-11, progress=False)
    assert run.outcome is Outcome.OK, run.message
    assert [change.action for change in run.reconnections] == ["engage"]
    for joint, speed in (("A", 4.0), ("B", 8.0)):
        assert_allclose(run[f"{joint}.angle"], speed * run.t, rtol=0.0, atol=1e-9)


def test_the_ratio_of_a_gear_is_fixed(tmp_path: Path) -> None:
    model = two_links("variable")
    model.gear("teeth", model.joints["A"], model.joints["B"], t)
    model.scene("run")
    with pytest.raises(ModelError, match=r"gear in space 'teeth': t depends on t, but points"):
        load(model, "run", folder=tmp_path)


def test_a_spring_of_a_joint_that_goes_ends_the_run(workshop: Path) -> None:
    model = two_links("sprung")
    model.release("B", when=t > 0.1)
    model.torsion_spring("coil", model.joints["B"], stiffness=1.0)
    model.scene("run", effects=["coil"])
    run = load(model, "run", folder=workshop).simulate(1.0, 3, progress=False)
    assert run.outcome is Outcome.INCONSISTENT
    assert "the joints that act then form no machine: " in run.message
    assert "effect 'coil' needs joint 'B', which takes no part" in run.message


def test_a_joint_engages_by_its_own_angle(workshop: Path) -> None:
    model = two_links("own")
    model.engage("B", when=model.joints["B"].angle > 1.0)
    model.scene("run")
    with pytest.raises(ModelError, match=r"asks for B\.angle, but joint 'B' takes no part"):
        load(model, "run", folder=workshop)


@pytest.mark.parametrize("without", [["geared"], ["geared", "B"], ["other"]])
def test_what_takes_no_part_asks_for_nothing(without: list[str]) -> None:
    model = two_links("plain")
    model.constraint("geared", model.joints["A"].angle - 2 * model.joints["B"].angle)
    assert model.scene("run").counted == ("A.angle", "B.angle")
    assert model.scene("fewer", without=without).counted == ()


def test_axes_that_close_the_opposite_way(workshop: Path) -> None:
    model: Any = Model("opposite", space=True)
    plate = model.body("plate", 1.0, (0.1, 0.1, 0.1), at=(0.3, 0, 0), axes=(0.5, 0, 0))
    ground = model.ground
    axis = (ground.along(*Z), plate.along(*Z))
    C = model.revolute("C", ground.at(0, 0, 0), plate.at(-0.3, 0, 0), axis=axis)
    model.scene("run", outputs=["default", C.angle])
    machine = load(model, "run", folder=workshop)
    with pytest.raises(AnalysisError, match=r"opposite directions .*, where C\.angle cannot be"):
        machine.simulate(0.1, 2, guess={"plate.e0": 0.1, "plate.e1": 0.995}, progress=False)
    turned = machine.simulate(0.1, 2, progress=False)
    assert turned.outcome is Outcome.OK


def test_an_equilibrium_names_the_joint_that_turned(workshop: Path) -> None:
    model: Any = Model("wound", space=True)
    rod = model.body("rod", 1.0, (0.1, 0.2, 0.2), at=(0.3, 0, 0))
    A = model.revolute("A", model.ground, rod, at=(0, 0, 0), axis=Z)
    model.torsion_spring("coil", A, stiffness=2.0, free_angle=9.0)
    model.scene("rest", effects=["coil"])
    rest = load(model, "rest", folder=workshop).equilibrium(progress=False)
    assert rest["A.angle"] == pytest.approx(9.0, rel=1e-9)
    assert "A turned by 516° from its guess" in rest.message


def test_a_distance_driver_advises_words_of_space(tmp_path: Path) -> None:
    model = two_links("driven")
    model.distance_driver("winch", model.ground.at(0, 0, 1), model.bodies["one"], t - 1)
    model.scene("run", drivers=["winch"])
    with pytest.raises(ModelError, match=r"with model\.translation_driver or model\.driver\."):
        load(model, "run", folder=tmp_path)


@pytest.mark.parametrize(("speed", "turned"), [(2.9, 2.9), (-2.9, -2.9), (4.0, 4.0 - 2 * np.pi)])
def test_a_joint_that_engages_counts_from_where_it_stands(
    speed: float, turned: float, workshop: Path
) -> None:
    """Its impulse is rounding, and so is what it takes of the energy."""
    model: Any = Model(f"caught_at_{10 * (turned + 9):.0f}", space=True)
    body = model.body("b", 1.0, (1.0, 1.2, 1.4))
    lock = model.cylindrical("lock", model.ground, body, at=(0, 0, 0), axis=Z)
    model.engage(lock, when=t > 1.0)
    start = {"b.omega_x": 0.0, "b.omega_y": 0.0, "b.omega_z": speed, "b.vz": 0.2}
    model.scene("run", start=start, outputs=["default", lock.angle, lock.slide])
    run = load(model, "run", folder=workshop).simulate(2.0, 11, rtol=1e-11, progress=False)
    assert run.outcome is Outcome.OK, run.message
    late = run.t > 1.0
    assert_allclose(run["lock.angle"][late], turned + speed * (run.t[late] - 1.0), atol=1e-8)
    assert_allclose(run["lock.slide"][late], 0.2 * run.t[late], rtol=0.0, atol=1e-9)
    assert "took" not in run.message
    assert "(fx 0 N s, fy 0 N s, fz 0 N s, tx 0 N m s" in run.message
