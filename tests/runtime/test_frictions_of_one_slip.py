"""Frictions with the same slip share one switch: they hold, break loose and slide together."""

from pathlib import Path
from typing import Any

import pytest
from sympy import Piecewise, sign

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome


@pytest.mark.parametrize("static", [None, (0.15, 0.3)])
@pytest.mark.parametrize("method", ["dop853", "bdf"])
def test_frictions_of_one_guide_add_up(
    workshop: Path, static: tuple[float, float] | None, method: str
) -> None:
    """20 N press on both, and 4 t pulls: 6 N of sliding, 6 or 9 N of static friction."""
    model = Model(f"two_frictions_{'static' if static else 'plain'}", gravity=(0, -10.0))
    body = model.body("body", mass=2.0, inertia=1.0)
    guide = model.translational("guide", model.ground, body, axis=(1, 0))
    one, two = static or (None, None)
    model.friction("one", guide, 0.1, static=one)
    model.friction("two", guide, 0.2, static=two)
    model.force("pull", body, 4.0 * t, 0)
    model.scene("s", ["gravity", "one", "two", "pull"], start={body.x: 0.0, body.vx: 0.0})
    run = load(model, folder=workshop).simulate(
        3.0, [1.49, 3.0], rtol=1e-9, method=method, progress=False
    )
    loose = 2.25 if static else 1.5  # s

    def way(at: float) -> float:
        return at**3 / 3.0 - 1.5 * at**2

    moved = way(3.0) - way(loose) - (loose**2 - 3.0 * loose) * (3.0 - loose)
    assert run.outcome is Outcome.OK
    assert run.q("body.x") == pytest.approx([0.0, moved], abs=1e-8)


def test_frictions_of_opposite_slips_stop_a_motion_together(workshop: Path) -> None:
    """5 N of 50 at first: the middle moves by 0.1 m in every swing, and the fifth ends at rest."""
    model = Model("opposite_slips")
    p = model.particle("p", mass=1.0)
    model.dry_friction("one", coefficient=0.3, normal=10.0, slip=p.vx)
    model.dry_friction("two", coefficient=0.2, normal=10.0, slip=-p.vx)
    model.spring("coil", model.ground.at(0, 0), p, stiffness=100.0, free_length=1.0)
    model.scene("s", ["one", "two", "coil"], start={p.x: 1.47, p.y: 0.0, p.vx: 0.0, p.vy: 0.0})
    run = load(model, folder=workshop).simulate(5.0, [5.0], rtol=1e-9, progress=False)
    assert run.outcome is Outcome.OK
    # 0.47, -0.37, 0.27, -0.17, 0.07, 0.03 less than 0.05: it stays
    assert run.q("p.x")[-1] == pytest.approx(1.03, abs=1e-7)


def holds(condition: Any) -> Any:
    """1 where it holds, else 0."""
    return Piecewise((1, condition), (0, True))


WRITTEN = {
    "above": lambda v: 2 * holds(v > 0),
    "at_least": lambda v: 2 * holds(v >= 0),
    "both_sides": lambda v: 3 * holds(v > 0) + holds(v < 0),
}
"""Name of a law → conditions on v that change a friction of 5 N."""


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("name", WRITTEN)
def test_a_friction_and_conditions_on_its_slip_slide_by_one_share(
    workshop: Path, name: str, way: int
) -> None:
    """A pull of 2 t stops a motion against it, and moves the bead when it exceeds the law ahead."""
    extra = WRITTEN[name]
    ahead, behind = (-5 * side + extra(side) for side in (1, -1))  # N at v > 0 and v < 0
    loose = float(-ahead if way > 0 else behind) / 2  # s
    runs = []
    for writing in ("apart", "one_sign"):
        model = Model(f"{name}_{writing}_{way + 1}")
        bead = model.particle("bead", mass=1.0)
        law = -5 * sign(bead.vx) + extra(bead.vx)
        if writing == "one_sign":
            law = (ahead + behind) / 2 + (ahead - behind) / 2 * sign(bead.vx)
        model.force("rub", bead, fx=way * 2 * t + law)
        model.scene("s", ["rub"], start={bead.x: 0, bead.y: 0, bead.vx: -way, bead.vy: 0})
        run = load(model, folder=workshop).simulate(4.0, [0.9, 4.0], rtol=1e-9, progress=False)
        assert run.outcome is Outcome.OK
        assert run.v("bead.x") == pytest.approx([0.0, way * (4.0 - loose) ** 2], abs=1e-8)
        runs.append(run)
    assert runs[0].q("bead.x") == pytest.approx(runs[1].q("bead.x"), abs=1e-8)


def test_what_switches_with_a_declared_friction_has_its_share(workshop: Path) -> None:
    """2 t pulls against 5 N; 2 N help where v > 0, so that it slides with α = (5 + 2 t)/8."""
    model = Model("declared")
    bead = model.particle("bead", mass=1.0)
    model.dry_friction("rub", coefficient=0.5, normal=10.0, slip=bead.vx)
    model.force("pull", bead, fx=2 * t)
    model.force("assist", bead, fx=2.0, when=bead.vx > 0)
    model.force("beside", bead, fy=sign(bead.vx) + holds(bead.vx >= 0))
    start = {bead.x: 0, bead.y: 0, bead.vx: 0, bead.vy: 0}
    model.scene("s", ["rub", "pull", "assist", "beside"], start=start)
    run = load(model, folder=workshop).simulate(2.0, [0, 1.0, 2.0], rtol=1e-9, progress=False)
    assert run.outcome is Outcome.OK
    (event,) = run.events
    assert event.time == pytest.approx(1.5, rel=1e-9)
    assert run.share("rub")[:2] == pytest.approx([5 / 8, 7 / 8])
    assert run.a("bead.y") == pytest.approx([3 * 5 / 8 - 1, 3 * 7 / 8 - 1, 2.0])
    assert run.a("bead.x") == pytest.approx([0.0, 0.0, 1.0])
