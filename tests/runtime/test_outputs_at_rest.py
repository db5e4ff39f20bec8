"""Outputs while conditions rest that nothing drives: a response by rounding moves no share."""

from pathlib import Path

import pytest
from sympy import Expr, Piecewise, cos, sign, sin, sqrt

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome

TRAVEL = Piecewise((0.35 * t**2, t < 0.6), (0.42 * t - 0.126 - 0.35 * (t - 0.6) ** 2, t < 1.2))


def _mixed(u: Expr) -> Expr:
    """3 where u > 0, -4 where u < 0, and 2 at rest."""
    at_rest = Piecewise((2, u >= 0), (0, True))
    return 3 * sign(u) + at_rest - Piecewise((2, u > 0), (1, u < 0), (0, True))


def _slider_crank(name: str, start: float, runs_on: bool) -> Model:
    """A crank, driven until 1.2 s from the angle `start`, and a slider; a mass may run on."""
    model = Model(name)
    crank, slider = model.body("crank", mass=1.0, inertia=0.2), model.particle("slider", mass=0.5)
    model.revolute("hinge", model.ground.at(0, 0), crank.at(0, 0))
    model.absolute("guide", slider, "y", 0.0)
    model.distance("rod", crank.at(0.3, 0), slider, 1.0)
    model.driver("drive", crank.phi, start + Piecewise(*TRAVEL.args, (0.252, True)))
    model.force("load", slider, fx=_mixed(slider.vx))
    drivers = ["drive"]
    if runs_on:
        runner = model.particle("runner", mass=1.0)
        model.driver("motor", runner.x, sin(3 * t))
        model.absolute("rail", runner, "y", 0.0)
        drivers.append("motor")
    model.scene("run", ["load"], drivers, guess={crank.phi: start, slider.x: 1.2})
    return model


@pytest.mark.parametrize("runs_on", [True, False])
@pytest.mark.parametrize("start", [0.3, 0.7, 1.1, 2.0, 3.6, 4.4, 5.2])
def test_the_drive_of_a_slider_at_rest_bears_its_conditions_as_they_are_written(
    workshop: Path, start: float, runs_on: bool
) -> None:
    """By virtual work: the torque is -2 N times dx/dφ of the slider.

    Where no other mass runs on, all accelerations are rounding, and the forces alone have a size.
    """
    name = f"rests_at_{10 * start:.0f}{'_beside' * runs_on}"
    machine = load(_slider_crank(name, start, runs_on), "run", folder=workshop)
    times = [1.3, 1.7, 2.0]
    for result in machine.simulate(2.0, times), machine.inverse_dynamics(times):
        assert result.outcome is Outcome.OK
        angle = start + 0.252
        height = 0.3 * sin(angle)
        slope = -height - height * 0.3 * cos(angle) / sqrt(1.0 - height**2)
        torque = result.reaction("drive", "torque")
        assert torque == pytest.approx([-2.0 * float(slope)] * 3, abs=1e-9)
