"""Forces that bend where their machine rests: they are continuous there, and do not slide."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Abs, Expr, Max, Piecewise, pi, sign

from codegen import Model
from runtime import load
from runtime.core.kinds import SLIDING
from runtime.core.outcomes import Outcome

LAWS: dict[str, Callable[[Expr], Expr]] = {
    "abs": lambda v: 3000 * v + 1000 * Abs(v),
    "pieces": lambda v: Piecewise((4000 * v, v > 0), (2000 * v, True)),
    "max": lambda v: 2000 * v + 2000 * Max(v, 0),
}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau5", "bdf", "auto"])
def test_a_spring_with_a_one_sided_damper_comes_to_rest(
    workshop: Path, law: str, method: str
) -> None:
    """A mass of 40 kg on a strut: its valve bends at the speed 0, where it comes to rest."""
    model = Model(f"strut_{law}", gravity=(0, -9.81))
    wheel = model.particle("wheel", mass=40.0)
    force = LAWS[law]
    ground = model.ground.at(0, 1)
    model.spring("leg", ground, wheel, force=lambda x, v: 12000 * (x - 1) + force(v))
    start = {wheel.x: 0.0, wheel.y: 0.0, wheel.vx: 0.0, wheel.vy: -0.5}
    model.scene("drop", ["gravity", "leg"], start=start)
    # Between the ends of steps at its edge of stability dop853 errs by more than the tolerance.
    r = load(model, folder=workshop).simulate(20.0, "steps", method=method)
    assert r.outcome is Outcome.OK, r.message
    assert_allclose(r.q("wheel.y")[-1], -40 * 9.81 / 12000, rtol=1e-6)
    assert abs(r.v("wheel.vy")[-1]) < 1e-6
    assert not (r.samples.modes == SLIDING).any()


@pytest.mark.parametrize("method", ["dop853", "bdf"])
def test_a_hinge_with_a_one_sided_damper_comes_to_rest(workshop: Path, method: str) -> None:
    model = Model("hinge_at_rest", gravity=(0, -9.81))
    rod = model.body("rod", mass=2.0, inertia=0.1)
    model.revolute("hinge", model.ground.at(0, 0), rod.at(-0.5, 0))
    model.torque("damper", on=rod, value=-30 * rod.omega - 12 * Abs(rod.omega))
    model.scene("falls", ["gravity", "damper"], start={rod.phi: -0.3, rod.omega: 0.0})
    r = load(model, folder=workshop).simulate(80.0, method=method)
    assert r.outcome is Outcome.OK, r.message
    assert_allclose(r.q("rod.phi")[-1], -float(pi) / 2, atol=1e-6)


def test_a_force_that_jumps_at_rest_still_slides(workshop: Path) -> None:
    model = Model("brake_at_rest")
    mass = model.particle("mass", mass=2.0)
    model.absolute("rail", mass, "y", 0.0)
    model.force("brake", mass, fx=3 - 5 * sign(mass.vx) - 0.5 * mass.vx)
    model.scene("stops", ["brake"], start={mass.x: 0.0, mass.vx: 1.0})
    r = load(model, folder=workshop).simulate(3.0)
    assert r.outcome is Outcome.OK
    assert r.samples.modes[-1] == SLIDING
    assert r.v("mass.vx")[-1] == 0.0
    assert_allclose(r.samples.share[-1], 0.8, rtol=1e-9)  # 3 - 5 (2 α - 1) = 0
    assert np.isfinite(r.samples.a).all()
