"""The reference of motions with events, against motions that are known in closed form."""

from typing import Any

import numpy as np
import pytest

from tests.random_mechanisms import parts
from tests.random_mechanisms.dense_dynamics import Dense
from tests.random_mechanisms.dense_hybrid import Hybrid
from tests.random_mechanisms.parts import GROUND, End, Law

BLOCK = (parts.Body("block", 2.0, None, (0.0, 1.0, 0.0)),)
ORIGIN, CENTRE = End(GROUND, (0.0, 0.0)), End(0, (0.0, 0.0))
DOWN = parts.Gravity("gravity", (0.0, -10.0))


def hybrid(*effects: parts.Effect, held: bool = False) -> Hybrid:
    """A particle above the ground, or `held` at its height."""
    joints = (parts.Absolute("height", CENTRE, "y", 1.0),) if held else ()
    return Hybrid(Dense(parts.Mechanism(BLOCK, joints, effects), 1.0))


def moved(of: Hybrid, vx: float, instants: list[float]) -> tuple[Any, Any, int]:
    return of.motion(np.array([0.0, 1.0]), np.array([vx, 0.0]), instants)


def test_a_ball_bounces_until_it_lies() -> None:
    """Falls take √(2 h/g), the flights half of it, an eighth ..; after 5/3 of it it lies."""
    floor = parts.RigidContact("floor", ORIGIN, CENTRE, (0.0, 1.0), 0.0, 0.25)
    first = (2.0 / 10.0) ** 0.5
    q, v, events = moved(hybrid(DOWN, floor), 0.3, [0.0, 1.25 * first, 2.0 * first])
    # In the middle of the first flight it is a quarter as high.
    assert q[1] == pytest.approx([0.375 * first, 0.0625], abs=1e-9)
    assert q[2] == pytest.approx([0.6 * first, 0.0], abs=1e-9)
    assert v[2] == pytest.approx([0.3, 0.0], abs=1e-9)
    assert 6 < events < 14


def test_a_block_slides_sticks_and_breaks_loose() -> None:
    """It stops after v/(μ g), and moves again where the push exceeds μ_s N."""
    rub = parts.DryFriction("rub", ORIGIN, CENTRE, (1.0, 0.0), 20.0, 0.2, None, 0.3)
    push = parts.Force("push", CENTRE, Law(rate=3.0), Law(), "ground")
    q, v, events = moved(hybrid(rub, push, held=True), 0.0, [0.0, 2.0, 3.0])
    # It breaks loose at 6 N, after 2 s; then 2 x'' = 3 t - 4.
    assert q[1][0] == pytest.approx(0.0, abs=1e-12)
    assert v[2][0] == pytest.approx(0.5 * (1.5 * 5.0 - 4.0), abs=1e-9)
    assert events == 1
    q, v, events = moved(hybrid(rub, held=True), 1.0, [0.0, 0.25, 1.0])
    assert q[1][0] == pytest.approx(0.25 - 0.0625, abs=1e-10)
    assert q[2][0] == pytest.approx(0.25, abs=1e-10)
    assert v[2][0] == pytest.approx(0.0, abs=1e-12)


def test_a_body_lifts_off_where_the_reaction_would_pull() -> None:
    """A lift that grows by 4 N/s carries 20 N after 5 s."""
    floor = parts.RigidContact("floor", ORIGIN, CENTRE, (0.0, 1.0), 1.0, 0.0)
    lift = parts.Force("lift", CENTRE, Law(), Law(rate=4.0), "ground")
    q, _, events = moved(hybrid(DOWN, floor, lift), 0.0, [0.0, 4.0, 6.0])
    assert q[1][1] == pytest.approx(1.0, abs=1e-12)
    assert q[2][1] == pytest.approx(1.0 + 1.0 / 3.0, abs=1e-9)
    assert events == 1
