"""Random chains of rods with states, samples, latches, ends, and joints that come and go.

`controlled_chain(seed)` is the same for a seed. A chain hangs from the ground; one of its joints
may be released, and the angle between two rods may be locked for a while.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from sympy import Max, Min

from codegen import Model, t

G = 9.81


@dataclass(frozen=True)
class Condition:
    """A quantity ("phi", "omega", "time", "current") of a rod above or below a level."""

    kind: str
    rod: int
    level: float
    above: bool


@dataclass(frozen=True)
class Motor:
    """A torque K i on a rod; di/dt = (V - R i - K ω)/L."""

    rod: int
    resistance: float
    inductance: float
    constant: float
    voltage: float


@dataclass(frozen=True)
class Controller:
    """A sampled torque on a rod, kp (0.2 - φ) - kd ω within a limit, with a delay."""

    rod: int
    every: float
    delay: float
    kp: float
    kd: float
    most: float


@dataclass(frozen=True)
class Push:
    """A torque on a rod while a condition holds, or from then on until another begins to hold."""

    rod: int
    torque: float
    when: Condition
    reset: Condition | None = None


@dataclass(frozen=True)
class Lock:
    """The angle from a rod to the next is held at a value once it exceeds it, up to an instant."""

    rod: int
    angle: float
    until: float | None


@dataclass(frozen=True)
class ControlledChain:
    """A chain of n rods; lengths, masses, moments of inertia, dampings, angles, rates, (n,) each.

    `integral` is a rod and the limit of the angle that a state integrates, as a torque on it.
    """

    seed: int
    length: Any
    mass: Any
    inertia: Any
    damping: Any
    angle: Any
    rate: Any
    begin: float
    end: float
    motor: Motor | None
    integral: tuple[int, float] | None
    controller: Controller | None
    latch: Push | None
    push: Push | None
    count: Condition | None
    until: Condition | None
    release: tuple[int, Condition] | None
    lock: Lock | None

    @property
    def rods(self) -> int:
        """How many there are."""
        return len(self.mass)

    @property
    def parts(self) -> str:
        """What it has, in words."""
        names = ("motor", "integral", "controller", "latch", "push", "count", "until", "release",
                 "lock")  # fmt: skip
        return f"{self.rods} rods " + " ".join(n for n in names if getattr(self, n) is not None)

    def model(self) -> Model:
        """Its declaration, with the scene "run"."""
        return _Declaration(self).model


def controlled_chain(seed: int) -> ControlledChain:
    """The chain of a seed."""
    random = np.random.default_rng(seed)
    n = int(random.integers(1, 4))

    def uniform(low: float, high: float) -> float:
        return float(random.uniform(low, high))

    def rod() -> int:
        return int(random.integers(n))

    def has(share: float) -> bool:
        return bool(random.random() < share)

    sizes = [random.uniform(*span, n) for span in ((0.5, 1.2), (0.5, 2), (0.05, 0.3), (0.05, 0.5))]
    angle, rate = random.uniform(-2.1, -0.1, n), random.uniform(-1, 4, n)
    begin = 0.37 if has(1 / 3) else 0.0
    motor = None
    if has(0.7):
        motor = Motor(rod(), uniform(0.5, 2), uniform(0.01, 0.2), uniform(0.2, 0.8), uniform(-4, 8))
    kinds = ["phi", "omega", "time"] + ["current"] * (motor is not None)

    def condition() -> Condition:
        kind = str(random.choice(kinds))
        spans = {"phi": (-1.2, 1.0), "omega": (-2, 4), "time": (begin - 0.1, begin + 1.3),
                 "current": (-1, 3)}  # fmt: skip
        return Condition(kind, rod(), uniform(*spans[kind]), kind == "time" or has(0.7))

    controller = None
    if has(0.7):
        every, delays = uniform(0.02, 0.11), (0.0, 0.0, 1.0, 0.5, 2.3)
        delay = float(random.choice(delays)) * every
        controller = Controller(rod(), every, delay, uniform(2, 8), uniform(0.2, 1), uniform(1, 4))
    integral = (rod(), uniform(0.2, 0.6)) if has(0.4) else None
    latch = push = lock = None
    if has(0.6):
        latch = Push(rod(), uniform(-3, 3), condition(), condition() if has(0.6) else None)
    if has(0.4):
        push = Push(rod(), uniform(-2, 2), condition())
    if n > 1 and has(0.5):
        first = int(random.integers(n - 1))
        locked = float(angle[first + 1] - angle[first]) + uniform(0.1, 0.6)
        lock = Lock(first, locked, begin + uniform(0.1, 1.3) if has(0.6) else None)
    return ControlledChain(
        seed, *sizes, angle, rate, begin, begin + uniform(0.8, 1.6), motor, integral, controller,
        latch, push, condition() if has(0.3) else None, condition() if has(0.3) else None,
        (rod(), condition()) if has(0.5) else None, lock,
    )  # fmt: skip


class _Declaration:
    """The words of a chain's declaration."""

    def __init__(self, chain: ControlledChain) -> None:
        self.chain = chain
        self.model = model = Model(f"controlled_chain_{chain.seed}", gravity=(0, -G))
        columns = zip(chain.mass, chain.inertia, strict=True)
        self.rods = rods = [
            model.body(f"b{i}", mass=m, inertia=j) for i, (m, j) in enumerate(columns)
        ]
        self.joints = []
        for i, rod in enumerate(rods):
            above = rods[i - 1].at(chain.length[i - 1] / 2, 0) if i else model.ground.at(0, 0)
            self.joints.append(model.revolute(f"j{i}", above, rod.at(-chain.length[i] / 2, 0)))
        self.effects: list[Any] = ["gravity"]
        for i, rod in enumerate(rods):
            self._torque(f"d{i}", i, -chain.damping[i] * rod.omega)
        self.current = self._declare_states()
        self._declare_pushes()
        self._connect()
        start = {}
        for i, rod in enumerate(rods):
            start |= {rod.phi: float(chain.angle[i]), rod.omega: float(chain.rate[i])}
        until = {"ended": self._holds(chain.until)} if chain.until else None
        model.scene("run", self.effects, start=start, until=until)

    def _torque(self, name: str, rod: int, value: Any, **words: Any) -> None:
        self.model.torque(name, on=self.rods[rod], value=value, **words)
        self.effects.append(name)

    def _holds(self, condition: Condition) -> Any:
        rod, level = self.rods[condition.rod], condition.level
        value = {"phi": rod.phi, "omega": rod.omega, "time": t}
        quantity = self.current if condition.kind == "current" else value[condition.kind]
        return quantity > level if condition.above else quantity < level

    def _declare_states(self) -> Any:
        chain, model, current = self.chain, self.model, None
        if (motor := chain.motor) is not None:
            omega = self.rods[motor.rod].omega
            current = model.state(
                "current",
                lambda i: (motor.voltage - motor.resistance * i - motor.constant * omega)
                / motor.inductance,
                start=0.3, unit="A",
            )  # fmt: skip
            self._torque("motor", motor.rod, motor.constant * current)
        if chain.integral is not None:
            rod, most = chain.integral
            angle = self.rods[rod].phi
            z = model.state("z", lambda z: Max(-most, Min(most, -angle)) - 0.1 * z)
            self._torque("integral", rod, z)
        if (given := chain.controller) is not None:
            rod = self.rods[given.rod]
            asked = given.kp * (0.2 - rod.phi) - given.kd * rod.omega
            limited = Max(-given.most, Min(given.most, asked))
            u = model.sampled("u", given.every, limited, delay=given.delay, start=0.5)
            self._torque("controller", given.rod, u)
        return current

    def _declare_pushes(self) -> None:
        chain, model = self.chain, self.model
        if (latch := chain.latch) is not None:
            reset = None if latch.reset is None else self._holds(latch.reset)
            on = model.latch("on", when=self._holds(latch.when), reset=reset)
            self._torque("latched", latch.rod, latch.torque, when=on)
        if (push := chain.push) is not None:
            self._torque("push", push.rod, push.torque, when=self._holds(push.when))
        if chain.count is not None:
            counted = self._holds(chain.count)
            self.effects.append(model.sampled("count", when=counted, value=lambda n: n + 1))

    def _connect(self) -> None:
        chain, model = self.chain, self.model
        if (lock := chain.lock) is not None:
            turned = self.rods[lock.rod + 1].phi - self.rods[lock.rod].phi
            held = model.constraint("lock", turned - lock.angle)
            until = None if lock.until is None else t > lock.until
            model.engage(held, when=turned > lock.angle, until=until)
        if chain.release is not None:
            number, condition = chain.release
            model.release(self.joints[number], when=self._holds(condition))
