"""Random machines whose joints come and go at one instant, and what their impacts do, by hand.

Sliders and rotors with constant forces, and perhaps a bar that swaps its pins, move by t² at the
most up to an instant that is known: conditions of t and of positions begin to hold there, those of
velocities by the impact of the others. A second instant releases some joints again. The reference
has the rows of all joints as numbers, and projects velocities onto what they permit; it shares
nothing with the library but the declaration.
"""

from dataclasses import dataclass, field
from itertools import combinations, count
from typing import Any

import numpy as np

from codegen import Model, t

FAST = 0.1  # m/s, rad/s: what begins in this instant is not in doubt


@dataclass
class Joint:
    """Linear in the coordinates: row · q - offset - speed t = 0; or a pin of the bar."""

    name: str
    row: np.ndarray
    speed: float = 0.0
    offset: float = 0.0
    arm: float = 0.0  # of a pin, from the bar's centre, m
    acts: bool = False  # before the first instant
    condition: tuple[str, int, float] | None = None  # ("t" | "q" | "v", coordinate, sign)
    level: float = 0.0  # of the condition
    until: bool = False  # whether it changes again at the second instant

    def rows(self, q: np.ndarray) -> np.ndarray:
        """Its rows by velocities, (k, n)."""
        if not self.arm:
            return self.row[None, :]
        found = np.zeros((2, len(q)))
        found[:, -3:-1] = np.eye(2)
        found[:, -1] = self.arm * np.array([-np.sin(q[-1]), np.cos(q[-1])])
        return found

    def holds(self, q: np.ndarray, v: np.ndarray) -> bool:
        """Whether its condition holds at the first instant."""
        assert self.condition is not None
        kind, k, sign = self.condition
        return kind != "v" or sign * (v[k] - self.level) > 0


@dataclass
class Machine:
    """A machine, its start, and what is to happen at its first instant."""

    seed: int
    mass: np.ndarray
    rotor: np.ndarray  # which of the coordinates are angles
    force: np.ndarray
    rub: np.ndarray  # N, N m: of dry friction
    joints: list[Joint]
    walls: list[tuple[int, float, float]]  # (coordinate, side, restitution) of closed contacts
    clutch: tuple[int, int] | None  # driver and driven
    grips: bool  # whether it does at the start
    driver: Joint | None
    bar: bool
    q: np.ndarray  # at the start
    v: np.ndarray
    first: float  # s
    second: float
    end: float = 0.0
    there: list[np.ndarray] = field(default_factory=list)  # q and v just before the first instant

    def unilateral(self) -> np.ndarray:
        """By velocities, what may not become negative: rates of closed gaps, slips."""
        rows = [side * np.eye(len(self.q))[k] for k, side, _ in self.walls]
        if self.clutch:
            one, two = self.clutch
            rows.append(np.eye(len(self.q))[two] - np.eye(len(self.q))[one])
        return np.array(rows).reshape(-1, len(self.q))

    def bilateral(self, acting: list[Joint], q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows of what acts, (m, n), and their rates, (m,)."""
        every = [*([self.driver] if self.driver else []), *acting]
        rows = [one.rows(q) for one in every]
        rates = [np.full(len(r), one.speed) for one, r in zip(every, rows, strict=True)]
        n = len(self.q)
        return np.vstack([np.zeros((0, n)), *rows]), np.concatenate([np.zeros(0), *rates])

    def model(self, name: str, order: np.random.Generator | None) -> Model:
        """The declaration; `order` mixes joints, and what releases and engages them."""
        model = Model(name)
        bodies, places, rates = [], [], []
        for k in range(len(self.mass) - 3 * self.bar):
            if self.rotor[k]:
                one = model.body(f"r{k}", mass=1.0, inertia=self.mass[k])
                model.revolute(f"axle{k}", model.ground.at(k, 0), one)
                place, rate = one.phi, one.omega
            else:
                one = model.particle(f"s{k}", mass=self.mass[k])
                model.absolute(f"rail{k}", one, "y", float(k))
                place, rate = one.x, one.vx
            bodies.append(one)
            places.append(place)
            rates.append(rate)
        if self.bar:
            one = model.body("bar", mass=self.mass[-3], inertia=self.mass[-1])
            bodies += [one] * 3
            places += [one.x, one.y, one.phi]
            rates += [one.vx, one.vy, one.omega]
        effects = self._effects(model, bodies, places, rates)
        joints = (
            self.joints
            if order is None
            else [self.joints[k] for k in order.permutation(len(self.joints))]
        )
        made = {one.name: self._declared(model, one, places, bodies) for one in joints}
        changing = [one for one in joints if one.condition]
        for k in np.arange(len(changing)) if order is None else order.permutation(len(changing)):
            one = changing[int(k)]
            kind, j, sign = one.condition
            symbol = {"t": t, "q": places[j], "v": rates[j]}[kind]
            when = symbol > one.level if sign > 0 else symbol < one.level
            word = model.release if one.acts else model.engage
            word(made[one.name], when=when, until=t > self.second if one.until else None)
        drivers = []
        if self.driver:
            (k,) = np.flatnonzero(self.driver.row)
            drivers = [model.driver("drive", places[k], self.driver.offset + self.driver.speed * t)]
        values = dict(zip(places, self.q.tolist(), strict=True))
        values |= dict(zip(rates, self.v.tolist(), strict=True))
        model.scene("run", effects, drivers, start=values, outputs="all")
        return model

    def _effects(self, model: Model, bodies: Any, places: Any, rates: Any) -> list[Any]:
        found = []
        for k in range(len(self.mass) - 3 * self.bar):
            if self.force[k]:
                word = model.torque if self.rotor[k] else model.force
                found.append(word(f"push{k}", bodies[k], self.force[k]))
            if self.rub[k]:
                found.append(
                    model.dry_friction(
                        f"rub{k}", slip=rates[k], normal=self.rub[k], coefficient=1.0
                    )
                )
        for k, side, e in self.walls:
            found.append(
                model.contact(f"wall{k}", gap=side * (places[k] - self.q[k]), restitution=e)
            )
        if self.clutch:
            found.append(model.one_way_clutch("clutch", *(bodies[k] for k in self.clutch)))
        return found

    def _declared(self, model: Model, joint: Joint, places: Any, bodies: Any) -> Any:
        if joint.arm:
            angle = self.q[-1] if joint.acts else self.there[0][-1]
            centre = self.q[-3:-1] if joint.acts else self.there[0][-3:-1]
            at = centre + joint.arm * np.array([np.cos(angle), np.sin(angle)])
            return model.revolute(
                joint.name, model.ground.at(*at.tolist()), bodies[-1].at(joint.arm, 0)
            )
        sides = sum(float(c) * place for c, place in zip(joint.row, places, strict=True) if c)
        return model.constraint(joint.name, sides - joint.offset - joint.speed * t)


def projected(
    mass: np.ndarray, v: np.ndarray, rows: np.ndarray, rates: np.ndarray, sides: np.ndarray,
    least: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:  # fmt: skip
    """Velocities v⁺ nearest by M with rows · v⁺ = rates, sides · v⁺ ≥ least; Λ, P; None: none.

    M (v⁺ - v) = -rowsᵀ Λ + sidesᵀ P.
    """
    for size in range(len(sides) + 1):
        for held in map(list, combinations(range(len(sides)), size)):
            every = np.vstack([rows, sides[held]])
            wanted = np.concatenate([rates, least[held]])
            scaled = every / np.sqrt(mass)
            impulse = np.linalg.lstsq(scaled @ scaled.T, wanted - every @ v, rcond=1e-12)[0]
            after = v + (every.T @ impulse) / mass
            pushes = np.zeros(len(sides))
            pushes[held] = impulse[len(rows) :]
            if np.abs(every @ after - wanted).max(initial=0.0) > 1e-9:
                continue
            if (pushes >= -1e-12).all() and (sides @ after >= least - 1e-9).all():
                return after, -impulse[: len(rows)], pushes
    return None


@dataclass
class Round:
    """What changes in one impact, and what that does."""

    changed: list[Joint]
    impulses: dict[str, np.ndarray]
    lost: float
    work: float  # of drivers and moving places, J
    unique: bool  # whether the impulses are


def rounds(machine: Machine) -> tuple[list[Round], np.ndarray, list[Joint]] | None:
    """The impacts of the first instant, velocities behind it, and what acts then; None: none."""
    q, v = machine.there
    acting = [one for one in machine.joints if one.acts]
    pending = [one for one in machine.joints if one.condition]
    found, mass = [], machine.mass
    while changed := [one for one in pending if one.holds(q, v)]:
        pending = [one for one in pending if one not in changed]
        gone, come = ([one for one in changed if one.acts is acts] for acts in (True, False))
        acting = [one for one in acting if one not in gone] + come
        impulses, lost, work, unique = {}, 0.0, 0.0, True
        if come:
            rows, rates = machine.bilateral(acting, q)
            sides = machine.unilateral()
            # contacts that approach in this instant are there already at rest
            done = projected(mass, v, rows, rates, sides, np.zeros(len(sides)))
            if done is None:
                return None
            after, multipliers, _ = done
            work = float(-multipliers @ rates)
            lost = float((mass * (v - after)) @ (v + after)) / 2 + work
            unique = np.linalg.matrix_rank(np.vstack([rows, sides]) / np.sqrt(mass), 1e-9) == len(
                rows
            ) + len(sides)
            v, at = after, int(machine.driver is not None)
            for one in acting:
                size = len(one.rows(q))
                if one in come:
                    impulses[one.name] = -multipliers[at : at + size]
                at += size
        found.append(Round(changed, impulses, lost, work, unique))
    return found, v, acting


def random_machine(seed: int) -> Machine:
    """A machine of this seed, the first of many drawn that is sound."""
    r = np.random.default_rng(seed)
    return next(filter(None, (_drawn(seed, r) for _ in count(1))))


def _drawn(seed: int, r: np.random.Generator) -> Machine | None:
    plain, bar = int(r.integers(2, 6)), bool(r.random() < 0.1)
    n = plain + 3 * bar
    rotor = np.array([r.random() < 0.4 for _ in range(plain)] + [False] * (3 * bar), bool)
    mass = r.uniform(0.5, 3.0, n)
    q, v = r.uniform(-1, 1, n), r.uniform(-2, 2, n)
    force = np.where(r.random(n) < 0.4, r.uniform(-2, 2, n), 0.0)
    rub = np.where(r.random(n) < 0.25, r.uniform(0.1, 0.5, n), 0.0)
    if bar:
        mass[-2], force[-3:], rub[-3:] = mass[-3], 0, 0
    first = float(r.uniform(0.3, 0.8))
    free, walls, driver, clutch = list(r.permutation(plain)), [], None, None
    if r.random() < 0.4:
        k, side = int(free.pop()), float(r.choice([-1, 1]))
        walls, v[k], force[k], rub[k] = (
            [(k, side, float(r.choice([0, 0.5])))],
            0,
            -side * r.uniform(0.5, 2),
            0,
        )
    if free and r.random() < 0.4:
        k = int(free.pop())
        driver = Joint("drive", np.eye(n)[k], speed=v[k], offset=q[k])
        force[k] = rub[k] = 0
    rotors = [k for k in range(plain) if rotor[k]]
    if len(rotors) >= 2 and r.random() < 0.6:
        clutch = (rotors[0], rotors[1]) if v[rotors[0]] < v[rotors[1]] else (rotors[1], rotors[0])
    joints, number = list[Joint](), int(r.choice([2, 3, 4, 4]))
    if bar:
        arm = float(r.uniform(0.3, 0.8))
        pins = [Joint("A", np.zeros(n), arm=-arm, acts=True), Joint("B", np.zeros(n), arm=arm)]
        for pin in pins:
            pin.condition = ("t", 0, 1.0)
        joints += pins
        across = -arm * np.array([-np.sin(q[-1]), np.cos(q[-1])])
        v[-3:-1] = -across * v[-1]
    while len(joints) < number:
        row = np.zeros(n)
        chosen = r.choice(plain, size=min(plain, int(r.integers(1, 3))), replace=False)
        row[chosen[0]] = 1.0
        if len(chosen) > 1:
            row[chosen[1]] = float(r.choice([-1.0, -0.5, 0.7]))
        one = Joint(f"j{len(joints)}", row, acts=bool(r.random() < 0.35))
        one.until = not one.acts and bool(r.random() < 0.4)
        one.speed = float(r.uniform(-1, 1)) if not one.acts and r.random() < 0.15 else 0.0
        one.condition = (str(r.choice(["t", "q", "q", "v"])), int(r.integers(plain)), 1.0)
        joints.append(one)
    grips, second = (
        clutch is not None and bool(r.random() < 0.4),
        first + float(r.uniform(0.2, 0.5)),
    )
    machine = Machine(
        seed, mass, rotor, force, rub, joints, walls, clutch, grips, driver, bar, q, v, first,
        second,
    )  # fmt: skip
    machine.end = machine.second + 0.3
    return machine if _moves_up_to_the_first_instant(machine) and _has_levels(machine) else None


def _moves_up_to_the_first_instant(machine: Machine) -> bool:
    """Find the state there; whether the motion is that of constant accelerations until then."""
    mass, q, T = machine.mass, machine.q, machine.first
    acting = [one for one in machine.joints if one.acts]
    rows, rates = machine.bilateral(acting, q)
    if np.linalg.matrix_rank(rows, 1e-9) < len(rows):
        return False
    sides = machine.unilateral()
    closed = sides[: len(machine.walls) + machine.grips]
    held, none = np.vstack([rows, closed]), np.zeros(len(closed))
    if np.linalg.matrix_rank(held, 1e-9) < len(held):
        return False
    done = projected(mass, machine.v, held, np.append(rates, none), sides[:0], none[:0])
    assert done is not None
    v = machine.v = done[0]
    for one in acting:
        one.offset = float(one.row @ q)
    if (machine.rub * (np.abs(v) < FAST)).any():
        return False
    push = machine.force - machine.rub * np.sign(v)
    whirl = np.zeros(len(rows))
    if machine.bar:  # the pin A, which acts: its centre turns about it
        at = 1 if machine.driver else 0
        for one in acting:
            if one.arm:
                whirl[at : at + 2] = one.arm * v[-1] ** 2 * np.array([np.cos(q[-1]), np.sin(q[-1])])
            at += len(one.rows(q))
    done = projected(mass, push / mass, rows, whirl, closed, none)
    if done is None or np.abs(sides[: len(machine.walls)] @ done[0]).max(initial=0.0) > 1e-9:
        return False
    a = done[0]
    there_q, there_v = q + v * T + a * T**2 / 2, v + a * T
    if machine.bar:
        pin = next(one for one in acting if one.arm)
        centre = q[-3:-1] - -pin.arm * np.array([np.cos(q[-1]), np.sin(q[-1])])
        there_q[-1] = q[-1] + v[-1] * T
        turned = pin.arm * np.array([np.cos(there_q[-1]), np.sin(there_q[-1])])
        there_q[-3:-1] = centre - turned
        there_v[-1] = v[-1]
        there_v[-3:-1] = -pin.arm * v[-1] * np.array([-np.sin(there_q[-1]), np.cos(there_q[-1])])
    machine.there = [there_q, there_v]
    if machine.clutch:
        slips = [float(sides[-1] @ u) for u in (v, there_v)]
        if not (machine.grips and slips[1] < 1e-12) and min(slips[machine.grips :]) < FAST:
            return False
    stays = np.sign(v) == np.sign(there_v)
    return bool((stays & (np.abs(there_v) > FAST))[machine.rub > 0].all())


def _has_levels(machine: Machine) -> bool:
    """Find levels of all conditions; whether none begins to hold before, and all is decided."""
    q, v = machine.there
    for one in machine.joints:
        if not one.acts and not one.arm:
            one.offset = float(one.row @ q - one.speed * machine.first)
        kind, k, _ = one.condition
        if kind == "t":
            one.level = machine.first
        elif kind == "q":
            if min(abs(v[k]), abs(machine.v[k])) < FAST or v[k] * machine.v[k] < 0:
                return False
            one.condition, one.level = (kind, k, float(np.sign(v[k]))), float(q[k])
    early = [one for one in machine.joints if one.condition[0] != "v"]
    late = [one for one in machine.joints if one.condition[0] == "v"]
    machine.joints = early
    done = rounds(machine) if early else None
    machine.joints = [*early, *late]
    if done is None:
        return False
    for one in late:
        kind, k, _ = one.condition
        jump = done[1][k] - v[k]
        if abs(jump) < 2 * FAST:
            return False
        one.level = float(v[k] + jump / 2)
        one.condition = (kind, k, float(np.sign(jump)))
        if one.holds(q, machine.v) or abs(machine.v[k] - one.level) < FAST / 4:
            return False
    done = rounds(machine)
    return done is not None and len({j.name for r in done[0] for j in r.changed}) >= 2
