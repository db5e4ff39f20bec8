"""Friction with a static coefficient breaks loose beside a velocity that a condition keeps at 0."""

from collections.abc import Callable
from itertools import product
from math import cos, sin
from pathlib import Path

import numpy as np
import pytest
import sympy
from scipy.optimize import brentq
from sympy import sign

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome

CARRIAGE, BLOCK = 2.0, 1.0  # kg
BRAKE, KINETIC, STATIC = 4.0, 2.0, 3.0  # N
PUSH, PULL = (3.0, 1.1), (4.5, 1.7)  # N and rad/s: on the carriage, on the block upon it
END = 8.0  # s


def _sine(of: tuple[float, float], order: int, t: float) -> float:
    """A force that swings, and its first and second integral."""
    f, w = of
    return (f * sin(w * t), -f / w * cos(w * t), -f / w**2 * sin(w * t))[order]


def _reference() -> tuple[list[float], list[float]]:
    """Instants of events, and (x, v) of carriage and block at the end, from event to event.

    Motions between events are closed forms. `brake` is the sign of the carriage's speed, and
    `rub` that of the block's upon it; 0 is rest there.
    """
    now, brake, rub, events = 0.0, 0, 0, list[float]()
    x, v = np.zeros(2), np.zeros(2)

    def forces(order: int, t: float) -> np.ndarray:
        """Of both, without what keeps them at rest, integrated so often."""
        const = (1.0, t, t * t / 2)[order]
        f = np.array([_sine(PUSH, order, t), _sine(PULL, order, t)])
        f += const * np.array([rub * KINETIC - brake * BRAKE, -rub * KINETIC])
        if rub == 0 and brake == 0:
            return np.zeros(2)
        if rub == 0:
            return np.array([CARRIAGE, BLOCK]) * f.sum() / (CARRIAGE + BLOCK)
        return f if brake else np.array([0.0, f[1]])

    def held(t: float) -> tuple[float, float]:
        """What the brake bears at rest, and the friction that sticks."""
        stuck = _sine(PULL, 0, t) - (forces(0, t)[1] if rub == 0 else 0.0)
        return _sine(PUSH, 0, t) + (rub * KINETIC if rub else stuck), stuck

    def moved(t: float) -> tuple[np.ndarray, np.ndarray]:
        masses, dt = np.array([CARRIAGE, BLOCK]), t - now
        first = forces(1, now)
        speed = v + (forces(1, t) - first) / masses
        return x + v * dt + (forces(2, t) - forces(2, now) - first * dt) / masses, speed

    def guards(t: float) -> tuple[float, float]:
        """Both positive until the mode of the brake, or of the friction, ends."""
        _, (a, b) = moved(t)
        bears, stuck = held(t)
        return brake * a if brake else BRAKE - abs(bears), (
            rub * (b - a) if rub else STATIC - abs(stuck)
        )

    def consistent(modes: tuple[int, int]) -> bool:
        """Whether the motion just behind is what (rub, brake) say; friction rather sticks."""
        nonlocal brake, rub
        rub, brake = modes
        soon, speeds = now + 1e-7, (v[0], v[1] - v[0])
        a, b = forces(0, soon) / (CARRIAGE, BLOCK)
        ways = [s or rate for s, rate in zip(speeds, (a, b - a), strict=True)]
        at_rest = speeds[0] == 0 and abs(held(soon)[0]) < BRAKE
        sticks = speeds[1] == 0 and abs(held(soon)[1]) < STATIC
        return bool(
            (brake * ways[0] > 0 if brake else at_rest) and (rub * ways[1] > 0 if rub else sticks)
        )

    while True:
        grid = np.linspace(now, END, 4001)[1:]
        ends = next((k for k, at in enumerate(grid) if min(guards(at)) < 0), None)
        if ends is None:
            return events, [*moved(END)[0], *moved(END)[1]]
        low = grid[ends - 1] if ends else now + 1e-6
        k = int(np.argmin(guards(grid[ends])))
        guard: Callable[[float], float] = lambda at, k=k: guards(at)[k]  # noqa: E731
        at = brentq(guard, low, grid[ends], xtol=1e-14)
        (x, v), now = moved(at), at
        events.append(at)
        if k == 0:
            v[0] *= 1 - abs(brake)
        elif rub:
            v[1] = v[0]
        rub, brake = next(filter(consistent, product((0, 1, -1), repeat=2)))


@pytest.mark.parametrize("method", ["dop853", "dopri5", "bdf", "radau5"])
def test_a_block_breaks_loose_on_a_carriage_that_its_brake_holds(
    workshop: Path, method: str
) -> None:
    model = Model("braked_carriage")
    carriage, block = model.particle("carriage", mass=CARRIAGE), model.particle("block", mass=BLOCK)
    model.absolute("rail", carriage, "y", 0.0)
    model.absolute("top", block, "y", 0.0)
    model.force("brake", carriage, fx=-BRAKE * sign(carriage.vx))
    model.dry_friction("rub", slip=block.vx - carriage.vx, normal=10.0, coefficient=0.2, static=0.3)
    for name, part, (f, w) in (("push", carriage, PUSH), ("pull", block, PULL)):
        model.force(name, part, fx=f * sympy.sin(w * t))
    at_rest = {part.x: 0.0 for part in (carriage, block)}
    at_rest |= {part.vx: 0.0 for part in (carriage, block)}
    model.scene("s", ["brake", "rub", "push", "pull"], start=at_rest)
    run = load(model, folder=workshop).simulate(END, rtol=1e-10, method=method, progress=False)
    events, state = _reference()
    assert run.outcome is Outcome.OK
    # Where both change at one instant, the run names both.
    times = [event.time for event in run.events]
    apart = [at for at, before in zip(times, [-1.0, *times], strict=False) if at - before > 1e-8]
    assert apart == pytest.approx(events, abs=1e-8)
    ends = [run.q("carriage.x"), run.q("block.x"), run.v("carriage.x"), run.v("block.x")]
    assert [series[-1] for series in ends] == pytest.approx(state, abs=1e-7)
