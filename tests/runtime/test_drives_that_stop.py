"""Conditions on what a driver brings to zero and keeps there: the motion stays on the surface."""

from collections.abc import Callable
from pathlib import Path

import pytest
from sympy import Expr, Heaviside, Piecewise, sign

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome

# Speeds up, slows down, and stands still from t = 1.2 s on, at x = 0.
TRAVEL = Piecewise(
    (0.35 * t**2 - 0.252, t < 0.6),
    (0.42 * (t - 0.6) - 0.35 * (t - 0.6) ** 2 - 0.126, t < 1.2),
    (0.0, True),
)
ON = [
    ("sign", lambda u: 3 * sign(u), 0.0),
    ("half", lambda u: 3 * Heaviside(u), 1.5),
    ("open", lambda u: Piecewise((3, u > 0), (0, True)), 0.0),
    ("closed", lambda u: Piecewise((3, u >= 0), (0, True)), 3.0),
    ("not_above", lambda u: Piecewise((3, u <= 0), (0, True)), 3.0),
    ("mixed", lambda u: 3 * sign(u) + Piecewise((5, u > 0), (0, True)) + 2 * Heaviside(u), 1.0),
]


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize("between", [False, True])
@pytest.mark.parametrize(("name", "law", "at_rest"), ON)
def test_a_condition_holds_as_written_where_a_drive_stands(
    workshop: Path, name: str, law: Callable[[Expr], Expr], at_rest: float, between: bool,
    formulation: str,
) -> None:  # fmt: skip
    """On the speed of a drive; `between` two blocks, either of which goes on to move."""
    model = Model(f"stop_{name}_{between}")
    block, other = model.particle("block", mass=2.0), model.particle("other", mass=1.0)
    for one in block, other:
        model.absolute(f"guide_{one.name}", one, "y", 0.0)
    if between:
        model.relative_driver("drive", block, other, "x", TRAVEL)
        speed = other.vx - block.vx
    else:
        model.driver("drive", block.x, TRAVEL)
        speed = block.vx
    gauge = model.particle("gauge", mass=1.0)
    model.force("reading", gauge, fx=law(speed))
    model.force("load", other, fx=1.0)
    start = {gauge.x: 0.0, gauge.y: 0.0, gauge.vx: 0.0, gauge.vy: 0.0}
    model.scene("run", ["reading", "load"], ["drive"], start=start)
    machine = load(model, "run", folder=workshop)
    result = machine.simulate(2.0, [0.3, 1.0, 1.3, 2.0], formulation=formulation)
    assert result.outcome is Outcome.OK
    moving = float(law(sign(1)))
    assert result.a("gauge.x") == pytest.approx([moving, moving, at_rest, at_rest], abs=1e-9)
    assert result.v("gauge.x")[-1] == pytest.approx(1.2 * moving + 0.8 * at_rest, abs=1e-7)


@pytest.mark.parametrize(("name", "law", "at_rest"), ON)
def test_a_place_that_a_drive_reaches_and_keeps_is_on_its_boundary(
    workshop: Path, name: str, law: Callable[[Expr], Expr], at_rest: float
) -> None:
    model = Model(f"stop_at_{name}")
    block, gauge = model.particle("block", mass=2.0), model.particle("gauge", mass=1.0)
    model.absolute("guide", block, "y", 0.0)
    model.driver("drive", block.x, TRAVEL)
    model.force("reading", gauge, fx=law(block.x))
    start = {gauge.x: 0.0, gauge.y: 0.0, gauge.vx: 0.0, gauge.vy: 0.0}
    model.scene("run", ["reading"], ["drive"], start=start)
    result = load(model, "run", folder=workshop).simulate(2.0, [0.3, 1.0, 1.3, 2.0])
    assert result.outcome is Outcome.OK
    before = float(law(sign(-1)))
    assert result.a("gauge.x") == pytest.approx([before, before, at_rest, at_rest], abs=1e-9)
