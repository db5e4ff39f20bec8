"""Runs that begin on a kink of a law, where rounding hides on which side of it their start lies."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Abs, Max, Min, Piecewise, sin

from codegen import Model, t
from runtime import load
from runtime.machine_facade import Machine

KINK = 0.1 + 0.2  # s; there the first piece holds in floats, and intervals find the second alone
BEFORE, AFTER = 0.5, -0.3  # m/s
LAWS = {
    "least": Min(0.5 * t, 0.5 * KINK - 0.3 * (t - KINK)),
    "most": -Max(-0.5 * t, -0.5 * KINK + 0.3 * (t - KINK)),
    "pieces": Piecewise((0.5 * t, t < KINK), (0.5 * KINK - 0.3 * (t - KINK), True)),
    "closed_pieces": Piecewise((0.5 * t, t <= KINK), (0.5 * KINK - 0.3 * (t - KINK), True)),
}
# A rod of 1 kg and 0.2 kg m², hinged 0.4 m beside its centre, turns by m h (v- - v+) / (J + m h²).
STRUCK = 0.4 * (BEFORE - AFTER) / (0.2 + 0.4**2)


def cart(name: str, folder: Path, scene: str = "whole") -> Machine:
    """A cart under a law, with a rod that hangs on it without gravity."""
    model = Model(f"kink_{name}")
    c, rod = model.particle("c", mass=2.0), model.body("rod", mass=1.0, inertia=0.2)
    model.constraint("rail", c.y)
    model.driver("d", c.x, LAWS[name])
    model.revolute("hinge", c, rod.at(0, 0.4))
    model.scene("whole", [], ["d"], start={rod.phi: 0.0, rod.omega: 0.0})
    model.scene("alone", [], ["d"], without=[rod])
    return load(model, scene, folder=folder)


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize("name", LAWS)
def test_an_impact_comes_once_wherever_a_run_is_parted(
    workshop: Path, name: str, formulation: str
) -> None:
    machine, ulp = cart(name, workshop), np.spacing(KINK)
    for part in (KINK - ulp, KINK, KINK + ulp):
        first = machine.simulate(part, [0.0, part], formulation=formulation)
        for rest in (
            first.resume(1.0, [1.0]),
            machine.simulate(1.0, [part, 1.0], start=first, formulation=formulation),
            machine.simulate(1.0, [part, 1.0], start=first.state(part), formulation=formulation),
        ):
            assert rest.outcome.name == "OK", rest.message
            assert len([*first.events, *rest.events]) == 1
            assert_allclose(rest.v("c.vx")[-1], AFTER, rtol=1e-12)
            assert_allclose(rest.v("rod.omega")[-1], STRUCK, rtol=1e-9)


@pytest.mark.parametrize("name", LAWS)
def test_what_begins_on_a_kink_begins_behind_it(workshop: Path, name: str) -> None:
    whole, at = cart(name, workshop), [KINK, KINK + 1e-9, 1.0]
    alone = cart(name, workshop, "alone")
    for run in (
        whole.simulate(1.0, at, t_start=KINK),
        whole.simulate(1.0, at, t_start=KINK, formulation="reduced"),
        alone.kinematics(1.0, at, t_start=KINK),
        alone.inverse_dynamics(1.0, at, t_start=KINK),
    ):
        assert (run.outcome.name, run.events, run.t.tolist()) == ("OK", (), at)
        assert_allclose(run.v("c.vx"), AFTER, rtol=1e-12)


def test_the_first_row_is_the_instant_that_was_asked_for(workshop: Path) -> None:
    """Behind the kink, and `at`, `state` and works say the same of it."""
    model = Model("kink_of_a_sine", gravity=(0.0, -9.81))
    c, rod = model.particle("c", mass=2.0), model.body("rod", mass=1.0, inertia=0.2)
    model.constraint("rail", c.y)
    model.driver("d", c.x, Abs(sin(t)))
    model.revolute("hinge", c, rod.at(0, 0.4))
    model.torque("brake", rod, -0.1 * rod.omega)
    start = {rod.phi: 0.2, rod.omega: 0.0}
    outputs = ["default", "work(brake)"]
    model.scene("whole", ["gravity", "brake"], ["d"], start=start, outputs=outputs)
    model.scene("alone", ["gravity"], ["d"], without=[rod])
    driven = load(model, "alone", folder=workshop).kinematics(5.0)
    machine = load(model, "whole", folder=workshop)
    run = machine.simulate(1.0, [0.0, 0.5, 1.0])
    for r in (driven, run, machine.simulate(1.0, "steps")):
        assert (r.t[0], r.at(0.0).t[0]) == (0.0, 0.0)
        assert_allclose([r.v("c.vx")[0], r.at(0.0).v("c.vx")[0]], 1.0, rtol=1e-12)
    again = machine.simulate(1.0, [0.0, 0.5, 1.0], start=run.state(0.0))
    assert (again.t.tolist(), again.events) == ([0.0, 0.5, 1.0], ())
    assert_allclose(again.samples.v, run.samples.v, rtol=1e-9, atol=1e-12)
    assert_allclose(run.at([0.0, 0.5]).works["brake"], run.works["brake"][:2], rtol=1e-9)
