"""The motion of a controlled chain by dense matrices and SciPy, which know nothing of its kernels.

Between conditions and samples `solve_ivp` integrates M q̈ + Φ_qᵀ λ = Q, Φ_q q̈ = γ, in all
coordinates; conditions are its events, and a lock that engages is an impact.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from tests.random_mechanisms.controlled_chains import Condition, ControlledChain, G, Lock

TOLERANCES = {"rtol": 1e-11, "atol": 1e-12, "max_step": 0.02}
NEAR = 1e-12  # s: two instants are one


@dataclass
class Motion:
    """The reference: states and values by instant, changes of joints, and the end."""

    samples: dict[float, tuple[Any, dict[str, float]]] = field(default_factory=dict)
    changes: list[tuple[float, str]] = field(default_factory=list)  # "release", "engage", "unlock"
    end: float = 0.0
    stopped: bool = False


class ControlledMotion:
    """A chain on its way: y = (q, v, current, z), what acts, and what is held."""

    def __init__(self, chain: ControlledChain) -> None:
        self.chain, self.n = chain, 3 * chain.rods
        self.t, self.y = chain.begin, self._start()
        self.masses = np.column_stack([chain.mass, chain.mass, chain.inertia]).ravel()
        self.joints, self.locked = [True] * chain.rods, False
        self.values = {"u": 0.5, "on": 0.0, "count": 0.0}
        self.conditions: dict[str, Condition | Lock] = {}
        self._name_conditions()
        self.holds = {name: self._excess(name, self.t, self.y) > 0 for name in self.conditions}
        given = chain.controller
        first = 0 if given is None else int(np.ceil((self.t - NEAR) / given.every))
        self.sample, self.acting, self.waiting = first, first, dict[int, float]()
        self.motion = Motion()

    def _start(self) -> Any:
        """Positions and velocities at the start, by the rods from the ground on."""
        chain, place, speed, q, v = self.chain, np.zeros(2), np.zeros(2), [], []
        for angle, rate, half in zip(chain.angle, chain.rate, chain.length / 2, strict=True):
            along = half * np.array([np.cos(angle), np.sin(angle)])
            across = half * rate * np.array([-np.sin(angle), np.cos(angle)])
            q += [*(place + along), angle]
            v += [*(speed + across), rate]
            place, speed = place + 2 * along, speed + 2 * across
        return np.array([*q, *v, 0.3, 0.0])

    def _name_conditions(self) -> None:
        chain = self.chain
        named = {
            "set": chain.latch and chain.latch.when, "reset": chain.latch and chain.latch.reset,
            "push": chain.push and chain.push.when, "count": chain.count, "until": chain.until,
            "release": chain.release and chain.release[1], "engage": chain.lock,
        }  # fmt: skip
        if chain.lock is not None and chain.lock.until is not None:
            named["unlock"] = Condition("time", 0, chain.lock.until, True)
        self.conditions = {name: one for name, one in named.items() if one is not None}

    def _excess(self, name: str, t: float, y: Any) -> float:
        """Above 0 where a condition holds."""
        one = self.conditions[name]
        if isinstance(one, Lock):
            return float(y[3 * one.rod + 5] - y[3 * one.rod + 2] - one.angle)
        value = {
            "phi": y[3 * one.rod + 2], "omega": y[self.n + 3 * one.rod + 2], "time": t,
            "current": y[-2],
        }[one.kind]  # fmt: skip
        return float(value - one.level) if one.above else float(one.level - value)

    def _jacobian(self, q: Any, v: Any) -> tuple[Any, Any]:
        """Φ_q and γ of the constraints that act."""
        rows, gammas = [], []
        for i, acts in enumerate(self.joints):
            for axis in (0, 1) if acts else ():
                row, gamma = np.zeros(self.n), 0.0
                for k, sign in ((i, -1.0), (i - 1, 1.0)):
                    if k >= 0:
                        half, angle, rate = self.chain.length[k] / 2, q[3 * k + 2], v[3 * k + 2]
                        row[3 * k + axis] = sign
                        row[3 * k + 2] = half * (-np.sin(angle), np.cos(angle))[axis]
                        gamma += half * (np.cos(angle), np.sin(angle))[axis] * rate**2
                rows.append(row)
                gammas.append(gamma)
        if self.locked:
            row = np.zeros(self.n)
            row[3 * self.chain.lock.rod + 5], row[3 * self.chain.lock.rod + 2] = 1.0, -1.0
            rows.append(row)
            gammas.append(0.0)
        return np.array(rows).reshape(len(rows), self.n), np.array(gammas)

    def _solve(self, jacobian: Any, forces: Any, gammas: Any) -> Any:
        count = len(jacobian)
        matrix = np.block([[np.diag(self.masses), jacobian.T],
                           [jacobian, np.zeros((count, count))]])  # fmt: skip
        return np.linalg.solve(matrix, np.concatenate([forces, gammas]))[: self.n]

    def _rates(self, t: float, y: Any) -> Any:
        chain, q, v, (current, z) = self.chain, y[: self.n], y[self.n : -2], y[-2:]
        forces, rates = np.zeros(self.n), np.zeros(2)
        forces[1::3], forces[2::3] = -chain.mass * G, -chain.damping * v[2::3]
        if (motor := chain.motor) is not None:
            forces[3 * motor.rod + 2] += motor.constant * current
            left = motor.voltage - motor.resistance * current
            rates[0] = (left - motor.constant * v[3 * motor.rod + 2]) / motor.inductance
        if chain.integral is not None:
            rod, most = chain.integral
            forces[3 * rod + 2] += z
            rates[1] = np.clip(-q[3 * rod + 2], -most, most) - 0.1 * z
        if chain.controller is not None:
            forces[3 * chain.controller.rod + 2] += self.values["u"]
        if chain.latch is not None:
            forces[3 * chain.latch.rod + 2] += chain.latch.torque * self.values["on"]
        if chain.push is not None:
            forces[3 * chain.push.rod + 2] += chain.push.torque * self.holds["push"]
        jacobian, gammas = self._jacobian(q, v)
        return np.concatenate([v, self._solve(jacobian, forces, gammas), rates])

    def _renew_by_clock(self) -> None:
        given = self.chain.controller
        if given is None:
            return
        while self.acting < self.sample and self._acts_at(self.acting) <= self.t + NEAR:
            self.values["u"] = self.waiting.pop(self.acting)
            self.acting += 1
        if self.sample * given.every <= self.t + NEAR:
            angle, rate = self.y[3 * given.rod + 2], self.y[self.n + 3 * given.rod + 2]
            asked = given.kp * (0.2 - angle) - given.kd * rate
            self.waiting[self.sample] = float(np.clip(asked, -given.most, given.most))
            self.sample += 1
            if given.delay == 0:
                self._renew_by_clock()

    def _acts_at(self, number: int) -> float:
        return number * self.chain.controller.every + self.chain.controller.delay

    def _next_stop(self) -> float:
        """The next instant that is known before: of a clock, of a condition on time, the end."""
        stops = [self.chain.end]
        if self.chain.controller is not None:
            stops.append(self.sample * self.chain.controller.every)
            stops += [self._acts_at(self.acting)] if self.acting < self.sample else []
        for one in self.conditions.values():
            timed = isinstance(one, Condition) and one.kind == "time"
            stops += [one.level] if timed and one.level > self.t + NEAR else []
        return min(stops)

    def _begin(self, names: Iterable[str]) -> bool:
        """Let conditions begin to hold; whether the run ends."""
        began = [*names]
        if "set" in began:
            self.values["on"] = 1.0
        if "reset" in began:
            self.values["on"] = 0.0
        self.values["count"] += "count" in began
        return "until" in began

    def _connect(self, names: Iterable[str]) -> bool:
        """Let joints come and go by conditions that have begun to hold; whether any did."""
        before = len(self.motion.changes)
        for name in names:
            if name == "release" and self.joints[self.chain.release[0]]:
                self.joints[self.chain.release[0]] = False
            elif name == "unlock" and self.locked:
                self.locked = False
            elif name == "engage" and not (self.locked or self.holds.get("unlock", False)):
                self.locked, v = True, self.y[self.n : -2]
                jacobian, _ = self._jacobian(self.y[: self.n], v)
                self.y = self.y.copy()
                self.y[self.n : -2] += self._solve(jacobian, 0.0 * v, -jacobian @ v)
            else:
                continue
            self.motion.changes.append((self.t, name))
        return len(self.motion.changes) > before

    def _keep(self, t: float, y: Any) -> None:
        self.motion.samples[t] = (y.copy(), dict(self.values))

    def run(self, times: Any) -> Motion:
        """The motion to its end, with samples at instants, s."""
        self._renew_by_clock()
        first = [name for name, holds in self.holds.items() if holds]
        stopped = self._begin(first)
        if not stopped and self._connect(first):
            stopped = self._follow_jump(())
        self._keep(self.t, self.y)
        while not stopped and self.t < self.chain.end - NEAR:
            stopped = self._advance(times)
        self.motion.end, self.motion.stopped = self.t, stopped
        return self.motion

    def _advance(self, times: Any) -> bool:
        """Integrate to the next instant at which anything changes; whether the run ends there."""
        watched = [
            name for name, one in self.conditions.items()
            if not (isinstance(one, Condition) and one.kind == "time")
            and not (name == "engage" and self.locked)
        ]  # fmt: skip
        events = [partial(self._excess, name) for name in watched]
        for name, event in zip(watched, events, strict=True):
            event.terminal, event.direction = True, -1.0 if self.holds[name] else 1.0
        found = solve_ivp(
            self._rates, (self.t, self._next_stop()), self.y, "DOP853", events=events or None,
            dense_output=True, **TOLERANCES,
        )  # fmt: skip
        for at in times[(times > self.t) & (times <= found.t[-1])]:
            self._keep(at, found.sol(at))
        self.t, self.y = float(found.t[-1]), found.y[:, -1]
        pairs = zip(watched, found.t_events or [], strict=False)
        met = [name for name, instants in pairs if len(instants)]
        for name, one in self.conditions.items():
            timed = isinstance(one, Condition) and one.kind == "time"
            if timed and not self.holds[name] and one.level <= self.t + NEAR:
                met.append(name)
        for name in met:
            self.holds[name] = not self.holds[name]
        began = [name for name in self.conditions if name in met and self.holds[name]]
        self._renew_by_clock()
        stopped = self._begin(began)
        if not stopped and self._connect(began):
            stopped = self._follow_jump(met)
        return stopped

    def _follow_jump(self, met: Iterable[str]) -> bool:
        """What begins to hold as velocities have jumped; whether the run ends."""
        began = []
        for name in self.conditions:
            if name not in met and name != "engage":
                holds = self._excess(name, self.t, self.y) > 0
                began += [name] if holds and not self.holds[name] else []
                self.holds[name] = holds
        if self._begin(began):
            return True
        return self._connect(began) and self._follow_jump(met)
