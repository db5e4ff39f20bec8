"""Impacts of random mechanisms in space by Newton's and Euler's equations: contacts and catches.

Velocities are ṙ and ω in global axes. An impact has M Δ + Jᵀ Λ = Gᵀ P and J (v + Δ) = ν; P ≥ 0
pushes along contacts. A mechanism may have a joint that engages at the start and is closed there, a
joint that is released a while later, and a contact whose gap closes after a millisecond or so.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from codegen import Model, t
from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_constraints import (
    Frames,
    Scalars,
    SpatialState,
    distances,
    offsets,
)
from tests.random_mechanisms.spatial_declaration import SpatialDeclaration, add
from tests.random_mechanisms.spatial_dynamics import SpatialDense
from tests.random_mechanisms.spatial_generator import random_spatial_mechanism
from tests.random_mechanisms.spatial_motion import motion

SHORT = 1e-3  # s: until the gap closes, about
RELEASED, END = 0.02, 0.04  # s
FAST = 0.2  # m/s: the approach of a contact, at least
MOBILE = 1e-2  # of the largest change of a velocity: that of the gap's rate, at least
AGREED = 1e-10  # m/s: of the rate of a gap
ROUNDS = 20


@dataclass(frozen=True)
class Touch:
    """A rigid contact at the drawing, along `axis` of body i; of two spheres where that is None."""

    i: int
    j: int
    at_i: Any
    at_j: Any
    axis: Any
    free: float
    restitution: float

    def gap(self, dense: SpatialDense, state: SpatialState) -> tuple[float, Any]:
        """g, and its slopes by ṙ and ω."""
        ends = []
        for body, at in ((self.i, self.at_i), (self.j, self.at_j)):
            ends += [np.array([body]), dense.layout.fixed_point(body, at)[None]]
        found: Scalars
        if self.axis is None:
            found = distances(Frames(state), *ends)
        else:
            axis = dense.layout.fixed_vector(self.i, self.axis)[None]
            found = offsets(Frames(state), np.array([self.i]), axis, *ends)
        return float(found.value[0]) - self.free, found.by[0, :-1].ravel()


def speeds(state: SpatialState) -> Any:
    """ṙ and ω, body by body, (6n,)."""
    return np.concatenate([state.v, state.w], axis=1).ravel()


def impact(
    dense: SpatialDense, state: SpatialState, rows: Any, rebounds: Any, t: float = 0.0
) -> SpatialState:
    """The velocities behind an impact of all joints and of contacts with slopes `rows`, (k, 6n)."""
    e, v = dense.system(state, t), speeds(state)
    rows = np.reshape(rows, (-1, len(v)))
    target = -np.asarray(rebounds) * np.minimum(rows @ v, 0.0)
    root = np.linalg.cholesky(e.mass)
    for pushed in product((False, True), repeat=len(rows)):
        kept = rows[list(pushed)]
        held = np.linalg.solve(root, np.vstack([e.jacobian, kept]).T).T
        missing = np.concatenate([e.nu - e.jacobian @ v, (target - rows @ v)[list(pushed)]])
        impulses = np.linalg.lstsq(held @ held.T, missing, rcond=1e-11)[0]
        after = v + np.linalg.solve(root.T, held.T @ impulses)
        pushes = impulses[len(e.jacobian) :]
        if (pushes >= 0).all() and (rows @ after >= target - AGREED).all():
            v, w = after.reshape(dense.n, 2, 3).transpose(1, 0, 2)
            return replace(state, v=v, w=w)
    raise AssertionError("no impulses solve the impact")


@dataclass(frozen=True)
class Changing:
    """A mechanism with a joint that engages at t = 0, one released later, and a contact."""

    mechanism: parts.SpatialMechanism
    caught: str
    freed: str
    touch: Touch
    start: SpatialState

    def without(self, *names: str) -> SpatialDense:
        """The dense equations without some joints."""
        joints = tuple(j for j in self.mechanism.joints if j.name not in names)
        return SpatialDense(replace(self.mechanism, joints=joints))

    def model(self, name: str) -> Model:
        """The declaration, with a scene ``"run"``."""
        to, one = SpatialDeclaration(self.mechanism, name), self.touch
        for part in (*self.mechanism.joints, *self.mechanism.effects):
            add(part, to)
        if self.caught:
            to.model.engage(self.caught, when=t > 0)
        if self.freed:
            to.model.release(self.freed, when=t > RELEASED)
        fixed = None
        if one.axis is not None:
            fixed = self.without().layout.fixed_vector(one.i, one.axis).tolist()
        to.model.contact(
            "touch", to.at(one.i, one.at_i), to.at(one.j, one.at_j), direction=fixed,
            free_length=one.free, restitution=one.restitution,
        )  # fmt: skip
        effects = ["touch", *(e.name for e in self.mechanism.effects)]
        to.model.scene("run", effects)
        model: Model = to.model
        return model

    @cached_property
    def states(self) -> list[SpatialState]:
        """Just behind the first impact, and at the end."""
        dense, state = self.without(), self.start
        if self.caught:
            state = impact(dense, state, [], [])
        instant = SHORT
        for _ in range(ROUNDS):  # Newton's method for the instant of the impact
            before = motion(dense, state, [0.0, instant])[-1]
            gap, slope = self.touch.gap(dense, before)
            step = gap / float(slope @ speeds(before))
            instant -= step
            if abs(step) < 1e-15:
                break
        after = impact(dense, before, [slope], [self.touch.restitution])
        times = [instant, RELEASED, END]
        state = motion(dense, after, times[:2])[-1]
        return [after, motion(self.without(self.freed), state, times[1:])[-1]]


def random_changing(seed: int, family: str) -> Changing | None:
    """The machine of a seed; None where none of its contacts stays open behind the impact."""
    whole = random_spatial_mechanism(seed, family, "free").parts
    undeclared = parts.TorsionSpring
    whole = replace(whole, effects=tuple(e for e in whole.effects if type(e) is not undeclared))
    random = np.random.default_rng([seed, 17])
    names = [joint.name for joint in whole.joints]
    caught, freed = (str(n) for n in random.choice([*names, ""], 2))
    freed = "" if freed == caught else freed
    held = replace(whole, joints=tuple(j for j in whole.joints if j.name != caught))
    start = SpatialDense(held).random_velocity(seed)
    dense = SpatialDense(whole)
    moving = impact(dense, start, [], [])
    v = speeds(moving)
    for _ in range(200):
        i, j = (int(k) for k in random.choice(range(-1, dense.n), 2, replace=False))
        i, j = (i, j) if j >= 0 else (j, i)
        ats = [np.array(whole.bodies[k].r if k >= 0 else (0.0, 0, 0)) for k in (i, j)]
        at_i, at_j = (at + 0.3 * random.normal(size=3) for at in ats)
        axis = random.normal(size=3) if random.random() < 0.6 else None
        axis = None if axis is None else axis / np.linalg.norm(axis)
        touch = Touch(i, j, at_i, at_j, axis, 0.0, float(random.uniform(0.2, 1.0)))
        gap, slope = touch.gap(dense, moving)
        if axis is not None and slope @ v > 0:
            touch = replace(touch, axis=-axis)
            gap, slope = touch.gap(dense, moving)
        rate = float(slope @ v)
        change = speeds(impact(dense, moving, [slope], [touch.restitution])) - v
        push = np.abs(change).max()
        if rate > -FAST or not slope @ change > MOBILE * push or (axis is None and gap < 0.2):
            continue
        made = Changing(whole, caught, freed, replace(touch, free=gap + SHORT * rate), start)
        opened, _ = made.touch.gap(dense, made.states[1])
        return made if opened > 1e-3 * FAST else None
    return None
