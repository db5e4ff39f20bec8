"""Motions with friction that sticks and contacts that strike, by the dense equations and events.

Between events every friction slides to one side or keeps its slip, every contact is open or keeps
its gap, and the dense equations with these as further constraints (Haug, chapter 6) are integrated
by SciPy's DOP853 at 1e-12, whose terminal events end a piece: a slip that vanishes, a force of
friction that reaches μ_s N, a gap that closes, a reaction that would pull. Which modes follow is
found by trying all: what is kept must be kept by a force that exists, what is left must go where
its mode says. An impact obeys Newton's law with impulses that push. Nothing of it comes from the
library.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise, product
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from tests.random_mechanisms import parts
from tests.random_mechanisms.dense_dynamics import Dense, Solution
from tests.random_mechanisms.dense_motion import DenseError

RTOL = 1e-12
MOST_EVENTS = 2000  # safety: of a motion, before it is given up
PIECES = 40  # steps of a piece that reaches the next instant, at least
AT_REST = 1e-11  # accuracy: of the largest rate so far; less is no slip
AGREED = 1e-7  # accuracy: of the terms of an acceleration or force; by so much a mode may be wrong
TOUCHING = 1e-10  # accuracy: of a typical length; less is no gap
MISSED = 1e-8  # accuracy: of a typical length; a gap below minus this is an impact that was missed
RISING = 0.1  # safety: of the rise at the acceleration after an impact; so long a gap surely opens
UNSEEN = 1e-11  # accuracy: the same; flights that rise no higher are over
KEPT, OPEN = 0, 1

Modes = dict[str, int]


def switching_effects(mechanism: parts.Mechanism) -> dict[str, parts.Effect]:
    """Frictions that stick, rigid contacts, and contacts that yield, by name."""
    found: dict[str, parts.Effect] = {}
    for effect in mechanism.effects:
        dry = isinstance(effect, parts.JointFriction | parts.DryFriction) and effect.creep is None
        if dry or isinstance(effect, parts.RigidContact | parts.Contact):
            found[effect.name] = effect
    return found


class Hybrid:
    """A mechanism whose motion has events."""

    def __init__(self, dense: Dense) -> None:
        self.dense, self.length = dense, dense.length
        effects = switching_effects(dense.mechanism)
        self.contacts = {k: f for k, f in effects.items() if isinstance(f, parts.RigidContact)}
        self.stops = [k for k, f in effects.items() if isinstance(f, parts.Contact)]
        self.frictions = [k for k in effects if k not in self.contacts and k not in self.stops]
        self.given = {
            k: (f.static or f.coefficient) * f.normal
            for k, f in effects.items() if isinstance(f, parts.DryFriction)
        }  # fmt: skip
        self._known: tuple[Any, Solution] | None = None
        self._speed = 0.0  # the largest so far, in typical sizes
        self._flight = "", 0.0  # the contact that has just been struck, and until when it rises

    # -- motion ------------------------------------------------------------------------------

    def motion(self, q: Any, v: Any, instants: Sequence[float]) -> tuple[Any, Any, int]:
        """Positions and velocities at instants, (k, n) each, from the first on; count of events."""
        dense, sizes = self.dense, np.concatenate([self.dense.sizes] * 2)
        self._speed = float(np.abs(v / dense.sizes).max())
        modes = self._after_impact(q, v, float(instants[0]), {})
        found_q, found_v, events = [q], [v], 0
        for begin, end in pairwise(instants):
            t = float(begin)
            while t < end:
                stop = min(float(end), self._flight[1]) if self._flight[1] > t else float(end)
                t, y, fired = self._piece(t, stop, np.concatenate([q, v]) / sizes, modes)
                q, v = dense.closed(*np.split(y * sizes, 2), t)
                self._speed = max(self._speed, float(np.abs(v / dense.sizes).max()))
                self._check_gaps(q, v, t)
                if fired is not None:
                    modes, v = self._next(q, v, t, modes, fired)
                    events += 1
                    if events > MOST_EVENTS:
                        raise DenseError(f"too many events until t = {t:g} s")
            found_q.append(q)
            found_v.append(v)
        return np.array(found_q), np.array(found_v), events

    def _piece(self, t: float, end: float, y: Any, modes: Modes) -> tuple[float, Any, str | None]:
        """Until an event or the end: the time, the state, and what fired."""
        dense, sizes = self.dense, np.concatenate([self.dense.sizes] * 2)

        def solved(t: float, y: Any) -> Solution:
            key = (t, y.tobytes())
            if self._known is None or self._known[0] != (key, tuple(modes.items())):
                q, v = np.split(y * sizes, 2)
                self._known = (key, tuple(modes.items())), dense.solve(q, v, t, modes)
            return self._known[1]

        def rates(t: float, y: Any) -> Any:
            return np.concatenate([(y * sizes)[dense.n :], solved(t, y).a]) / sizes

        # A contact that has just been struck is zero but for rounding, and rises at first.
        rising = self._flight[0] if self._flight[1] > t else ""
        names = [k for k in (*self.frictions, *self.contacts, *self.stops) if k != rising]
        watched = [self._event(name, modes.get(name), solved) for name in names]
        scale = max(1.0, float(np.abs(y).max()))
        run = solve_ivp(
            rates, (t, end), y, method="DOP853", rtol=RTOL, atol=0.1 * RTOL * scale,
            events=watched, max_step=(end - t) / PIECES,
        )  # fmt: skip
        if run.status < 0:
            raise DenseError(f"the dense integration stops: {run.message}")
        first = [k for k, times in enumerate(run.t_events or []) if len(times)]
        if run.status == 1 and first:
            return float(run.t[-1]), run.y[:, -1], names[first[0]]
        return end, run.y[:, -1], None

    def _check_gaps(self, q: Any, v: Any, t: float) -> None:
        """Nothing is deeper than an impact that is about to be resolved."""
        scalars = self.dense.equations(q, v, t).scalars
        for name in self.contacts:
            if scalars[name].value < -MISSED * self.length:
                raise DenseError(f"an impact of {name} was missed before t = {t:g} s")

    def _event(self, name: str, mode: int | None, solved: Any) -> Any:
        """The function of time and state whose fall through zero ends a piece."""

        def value(t: float, y: Any) -> float:
            x = solved(t, y)
            if name in self.frictions:
                if mode == KEPT:
                    return self._limit(name, x) - abs(x.held[name])
                return float(mode or 0) * x.scalars[name].rate
            if mode == KEPT:
                return x.held[name]
            return float(x.scalars[name].value)

        value.terminal = True  # type: ignore[attr-defined]
        value.direction = 0.0 if name in self.stops else -1.0  # type: ignore[attr-defined]
        return value

    def _limit(self, name: str, x: Solution) -> float:
        return self.given.get(name, x.limits.get(name, 0.0))

    # -- modes -------------------------------------------------------------------------------

    def _next(self, q: Any, v: Any, t: float, modes: Modes, fired: str) -> tuple[Modes, Any]:
        """The modes after an event, and the velocities, which an impact changes."""
        if fired in self.stops:
            return modes, v
        kept = [name for name, mode in modes.items() if mode == KEPT]
        if modes[fired] == KEPT:
            # It broke loose, against the force that held it, or opened.
            force = self.dense.solve(q, v, t, modes).held[fired]
            left = OPEN if fired in self.contacts else -int(np.sign(force))
            others = {name: self._choices(name) for name in kept if name != fired}
            return self._settled(q, v, t, modes, {fired: (left,)} | others), v
        if fired in self.frictions:
            return self._settled(q, v, t, modes, {k: self._choices(k) for k in (fired, *kept)}), v
        before, v = v, self._struck(q, v, t, modes, fired, rebound=True)
        x = self.dense.solve(q, v, t, modes | dict.fromkeys(self.contacts, OPEN))
        leaving, fall = x.scalars[fired].rate, x.rises[fired][0]
        # For a part of its rise alone: accelerations change.
        self._flight = fired, t + RISING * leaving / -fall if leaving > 0.0 > fall else t
        if leaving > 0.0 > fall and 0.5 * leaving**2 / -fall < UNSEEN * self.length:
            v, self._flight = self._struck(q, before, t, modes, fired, rebound=False), ("", t)
        return self._after_impact(q, v, t, modes), v

    def _choices(self, name: str) -> tuple[int, ...]:
        return (KEPT, OPEN) if name in self.contacts else (KEPT, 1, -1)

    def _after_impact(self, q: Any, v: Any, t: float, modes: Modes) -> Modes:
        """Modes by the rates of slips and gaps; where these vanish, by trial."""
        scalars, open_now = self.dense.equations(q, v, t).scalars, {}
        choices: dict[str, tuple[int, ...]] = {}
        for name in (*self.frictions, *self.contacts):
            s = scalars[name]
            size = float(np.abs(s.by_q) @ self.dense.sizes) * self._speed + abs(s.by_t)
            rests = abs(s.rate) <= AT_REST * size
            if name in self.contacts:
                open_now[name] = OPEN
                rests = rests and abs(s.value) <= TOUCHING * self.length
            else:
                open_now[name] = 1 if s.rate > 0 else -1
            if rests:
                choices[name] = self._choices(name)
        return self._settled(q, v, t, modes | open_now, choices)

    def _settled(
        self, q: Any, v: Any, t: float, modes: Modes, choices: Mapping[str, tuple[int, ...]]
    ) -> Modes:
        """The modes that agree with the motion that they cause; those that keep most come first."""
        trials = [dict(zip(choices, chosen, strict=True)) for chosen in product(*choices.values())]
        for trial in sorted(trials, key=lambda one: -sum(mode == KEPT for mode in one.values())):
            wanted = modes | trial
            kept = [name for name, mode in wanted.items() if mode == KEPT]
            if not self.dense.independent(q, t, kept):
                continue
            x = self.dense.solve(q, v, t, wanted)
            if all(self._agrees(name, mode, x) for name, mode in trial.items()):
                return wanted
        raise DenseError(f"no modes agree at t = {t:g} s")

    def _agrees(self, name: str, mode: int, x: Solution) -> bool:
        rise, size = x.rises[name]
        if mode != KEPT:
            return mode * rise >= -AGREED * size
        force, typical = x.held[name], AGREED * float(np.abs(list(x.held.values())).max())
        if name in self.contacts:
            return force >= -typical
        return abs(force) <= self._limit(name, x) * (1 + AGREED) + 1e-3 * typical

    # -- impacts -----------------------------------------------------------------------------

    def _struck(self, q: Any, v: Any, t: float, modes: Modes, first: str, *, rebound: bool) -> Any:
        """Velocities after an impact: v + Σ P_i d_i, P ≥ 0, ġ⁺ ≥ -e ġ⁻, one of them an equality."""
        scalars = self.dense.equations(q, v, t).scalars
        near = {
            k for k in self.contacts
            if modes[k] == KEPT or abs(scalars[k].value) <= TOUCHING * self.length
        } | {first}  # fmt: skip
        target = {
            k: -(self.contacts[k].restitution if rebound else 0.0) * min(scalars[k].rate, 0.0)
            for k in near
        }
        for mask in sorted(product((True, False), repeat=len(near)), key=sum):
            pushing = [k for k, yes in zip(sorted(near), mask, strict=True) if yes]
            if not pushing or not self.dense.independent(q, t, pushing):
                continue
            wanted = {k: target[k] - scalars[k].rate for k in pushing}
            change, impulses = self.dense.impulse(q, v, t, wanted)
            after = {k: scalars[k].rate + float(scalars[k].by_q @ change) for k in near}
            slack = AT_REST * max(abs(s.rate) for s in scalars.values())
            if (impulses >= 0.0).all() and all(after[k] >= target[k] - slack for k in near):
                return v + change
        raise DenseError(f"no impulses agree at t = {t:g} s")
