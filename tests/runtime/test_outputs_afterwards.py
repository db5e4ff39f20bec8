"""Outputs that a scene does not name: what a run that names them has, from the stored states."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from sympy import Piecewise, sin

from codegen import Model, t
from codegen.errors import InputError, UnknownNameError
from codegen.model.scene_requests import OF_ANALYSIS
from runtime import Result, load, load_result


def sled() -> Model:
    """A sled that sticks by friction, with an arm, a controller and a force that jumps in time."""
    model = Model("late_sled", gravity=(0, -9.81))
    block = model.body("block", mass=2.0, inertia=0.1)
    arm = model.body("arm", mass=1.0, inertia=0.05)
    guide = model.translational("guide", model.ground.at(0, 0), block.at(0, 0), axis=(1, 0))
    model.revolute("pin", block.at(0, 0), arm.at(-0.5, 0))
    model.spring("strut", model.ground.at(-1, 0), block, 40.0, free_length=0.8, damping=0.3)
    model.friction("rub", guide, 0.3)
    gain = model.sampled("gain", 0.05, -0.5 * arm.omega, unit="N m")
    model.torque("motor", on=arm, value=gain)
    model.force("kick", on=block, fx=Piecewise((6.0, t < 0.5), (-2.0, True)))
    model.track("tip", arm.at(0.5, 0))
    start = {block.x: 0.4, block.vx: 0.0, arm.phi: 0.3, arm.omega: 0.0}
    model.scene("run", ["gravity", "strut", "rub", "motor", "kick"], start=start)
    return model


def ball() -> Model:
    """A ball on a spring above two floors, and one that a force pushes from t = 0 on."""
    model = Model("late_ball", gravity=(0, -9.81))
    ball = model.body("ball", mass=1.0, inertia=0.1)
    model.contact("floor", gap=ball.y - 0.2, restitution=0.6, stiffness=2e3, damping=5.0,
                  fidelity="rigid")  # fmt: skip
    model.spring("strut", model.ground.at(0, 3), ball, 2.0, free_length=1.0, damping=0.1)
    model.force("push", on=ball, fx=Piecewise((7.0, t <= 0), (1.0 + t, True)))
    acting, start = ["gravity", "floor", "strut", "push"], {ball.y: 1.0, ball.vy: 0.0}
    model.scene("rigid", acting, start=start, fidelity={"floor": "rigid"})
    model.scene("soft", acting, start=start, fidelity={"floor": "penalty"})
    model.scene("bare", acting, start=start, fidelity={"floor": "rigid"}, outputs=[])
    return model


def cut() -> Model:
    """A pendulum on a spring that is cut loose; its friction goes with the hinge."""
    model = Model("late_cut", gravity=(0, -9.81))
    bob = model.body("bob", mass=1.0, inertia=0.1)
    hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.release(hinge, when=bob.phi > 0.5)
    model.spring("strut", model.ground.at(0, 2), bob, 3.0, free_length=1.0, damping=0.2)
    model.friction("rub", hinge, 0.2, creep=0.01, radius=0.02)
    acting = ["gravity", "strut", "rub"]
    model.scene("swing", acting, start={bob.phi: -np.pi / 2, bob.omega: 7.5})
    return model


def crank() -> Model:
    """A crank that is driven or hangs, held twice, with a spring."""
    model = Model("late_crank", gravity=(0, -9.81))
    bar = model.body("bar", mass=2.0, inertia=0.3)
    model.revolute("hinge", model.ground.at(0, 0), bar.at(-1, 0))
    model.revolute("again", model.ground.at(0, 0), bar.at(-1, 0))
    model.torsion_spring("coil", model.ground, bar, 3.0, damping=0.1)
    model.driver("hand", bar.phi, Piecewise((0.3 * t, t < 0.5), (0.3 * t + sin(t - 0.5), True)))
    model.track("tip", bar.at(1, 0))
    model.scene("led", ["gravity", "coil"], ["hand"])
    model.scene("hung", ["gravity", "coil"], start={bar.phi: -1.0, bar.omega: 0.0})
    model.scene("still", ["gravity", "coil"], guess={bar.phi: -1.0}, analysis="equilibrium")
    model.scene("moved", ["coil"], ["hand"], analysis="kinematics")
    return model


Run = Callable[[Any], Result]
CASES: dict[str, tuple[Callable[[], Model], str, Run]] = {
    "sticking": (sled, "run", lambda m: m.simulate(2.0, 201)),
    "steps": (sled, "run", lambda m: m.simulate(1.0, "steps")),
    "impacts": (ball, "rigid", lambda m: m.simulate(3.0, 301)),
    "bare": (ball, "bare", lambda m: m.simulate(3.0, 301)),
    "penalty": (ball, "soft", lambda m: m.simulate(3.0, 301)),
    "implicit": (ball, "soft", lambda m: m.simulate(3.0, 31, method="radau5")),
    "released": (cut, "swing", lambda m: m.simulate(1.5, 151)),
    "reduced": (cut, "swing", lambda m: m.simulate(1.5, 151, formulation="reduced")),
    "redundant": (crank, "hung", lambda m: m.simulate(1.0, 21)),
    "inverse dynamics": (crank, "led", lambda m: m.inverse_dynamics(1.0, 21)),
    "kinematics": (crank, "led", lambda m: m.kinematics(1.0, 21)),
    "geometry": (crank, "moved", lambda m: m.kinematics(1.0, 21)),
    "equilibrium": (crank, "still", lambda m: m.equilibrium()),
}


def assert_same(late: Result, named: Result, bits: bool = True) -> None:
    """That all series of effects, powers, energies, reactions and points are the same."""
    assert_array_equal(late.t, named.t)
    kinds = ("effect", "power", "nonconservative power", "energy", "reaction", "point")
    rows = named.description.series.of_kind(*kinds)
    assert len(rows) > 1
    for row in rows:
        if row.kind.endswith("power"):
            part = "whole" if row.kind == "power" else "nonconservative"
            found, wanted = (r.power(row.element, part) for r in (late, named))
        else:
            found, wanted = late[row.name], named[row.name]
        if bits:
            assert_array_equal(found, wanted, err_msg=row.name)
        else:
            size = np.abs(np.nan_to_num(wanted)).max()
            np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * size, err_msg=row.name)


@pytest.mark.parametrize("case", CASES)
def test_an_output_afterwards_is_that_of_a_run_that_names_it(
    case: str, workshop: Path, tmp_path: Path
) -> None:
    make, scene, run = CASES[case]
    model = make()
    words = ("default", *(w for w in OF_ANALYSIS[model.scenes[scene].analysis] if w != "works"))
    machine = load(model, scene, folder=workshop)
    late = run(machine)
    named = run(load(model, model.scenes[scene].with_(outputs=words), folder=workshop))
    bits = case != "bare"  # which eliminates fewer multipliers
    if bits:
        assert_array_equal(late.samples.q, named.samples.q)
    assert_same(late, named, bits)
    for event in late.events[:3]:
        for side in ("before", "after"):
            assert_same(late.at(event.time, side), named.at(event.time, side), bits)
    if case != "equilibrium":
        late.save(tmp_path / "late.nc")
        assert_same(load_result(tmp_path / "late.nc", machine), named, bits)


def test_the_side_of_a_jump_in_time(workshop: Path) -> None:
    """The rows beside a jump, and that of a start on one, have the force of their side."""
    sliding = load(sled(), folder=workshop).simulate(1.0, 11)
    sides = [float(sliding.at(0.5, side)["kick.fx"][0]) for side in ("before", "after")]
    assert sides == [6.0, -2.0]
    falling = load(ball(), "soft", folder=workshop).simulate(1.0, 11)
    assert_array_equal(falling.force("push", "fx"), 1.0 + falling.t)


def test_a_power_is_found_however_the_default_is_written(workshop: Path) -> None:
    model = ball()
    declared = model.scenes["soft"]
    left_out = load(model, declared, folder=workshop)
    written = load(model, declared.with_(outputs=["default"]), folder=workshop)
    assert written.path == left_out.path
    result = written.simulate(1.0, 11)
    np.testing.assert_allclose(result.power("gravity"), -9.81 * result["ball.vy"], rtol=1e-14)
    more = load(model, declared.with_(outputs=["default", "gap(floor)"]), folder=workshop)
    assert {*more.description.powers.names} == {*left_out.description.powers.names}


def test_what_is_no_function_of_states_is_refused(workshop: Path) -> None:
    result = load(ball(), "soft", folder=workshop).simulate(0.1, 3)
    with pytest.raises(InputError, match=r"outputs=\['default', 'work\(strut\)'\]"):
        result.work("strut")
    with pytest.raises(UnknownNameError, match=r"nearest: .*strut\.force"):
        result["strut.forse"]
    with pytest.raises(InputError, match="no length of 'floor'"):
        result.length("floor")
    moved = load(crank(), "moved", folder=workshop).kinematics(0.1, 3)
    with pytest.raises(InputError, match=r"force\(coil\) needs masses and forces"):
        moved.force("coil")
