"""Generalized forces of all effects by virtual work: Σ f s_q over the scalars s that f moves."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import hypot, tanh
from typing import Any

import numpy as np

from tests.random_mechanisms import parts
from tests.random_mechanisms.constraint_equations import Placement, along_and_across, law
from tests.random_mechanisms.jets import Derivatives, Jet, derivatives, sqrt


@dataclass
class Works:
    """The generalized force, the potential energy, and what rubbing joints need."""

    at: Placement
    n: int
    force: Any
    modes: Mapping[str, int]  # effect → see `side`
    potential: float = 0.0

    def push(self, s: Any, force: float) -> None:
        """A force along a scalar."""
        if isinstance(s, Jet):
            self.force = self.force + force * derivatives(s, self.n).by_q

    def measured(self, s: Jet) -> Derivatives:
        """A scalar's value and derivatives."""
        return derivatives(s, self.n)


def works(mechanism: parts.Mechanism, at: Placement, n: int, modes: Mapping[str, int]) -> Works:
    """All effects but the friction of joints, and what keeps a slip or a gap as it is."""
    total = Works(at, n, np.zeros(n), modes)
    for effect in mechanism.effects:
        _act(effect, mechanism, total)
    return total


def _now(of: parts.Law, at: Placement) -> float:
    return float(np.real(np.atleast_1d(law(of, at.t).c0)[-1]))


def _act(effect: parts.Effect, mechanism: parts.Mechanism, total: Works) -> None:
    at = total.at
    match effect:
        case parts.Gravity(_, (gx, gy)):
            for k, body in enumerate(mechanism.bodies):
                x, y = at.origin(k)
                total.push(x, body.mass * gx)
                total.push(y, body.mass * gy)
                height = gx * total.measured(x).value + gy * total.measured(y).value
                total.potential -= body.mass * height
        case parts.Spring(_, i, j, k, free, c, actuator):
            dx, dy = at.span(i, j)
            length = sqrt(dx * dx + dy * dy)
            _spring(total, length, k, free, c, _now(actuator, at))
        case parts.TorsionSpring(_, i, j, k, free, c):
            _spring(total, at.angle(j) - at.angle(i), k, free, c, 0.0)
        case parts.Bushing(_, i, j, stiffness, damping, free):
            shift = at.back(i.body, at.span(i, j))
            turn = at.angle(j.body) - at.angle(i.body)
            for s, k, c, rest in zip((*shift, turn), stiffness, damping, (0, 0, free), strict=True):
                _spring(total, s, k, rest, c, 0.0)
        case parts.Force(_, on, fx, fy, frame):
            push = _now(fx, at), _now(fy, at)
            if frame == "body":
                turned = at.turned(on.body, push)
                push = total.measured(turned[0]).value, total.measured(turned[1]).value
            for s, f in zip(at.point(on), push, strict=True):
                total.push(s, f)
        case parts.Torque(_, on, value, drag):
            phi = at.angle(on)
            total.push(phi, _now(value, at) - drag * total.measured(phi).rate)
        case parts.DryFriction(name, i, j, axis, normal, mu, creep):
            s = along_and_across(at, i, j, axis)[0]
            total.push(s, -mu * normal * side(total, name, total.measured(s).rate, creep))
        case parts.Contact(_, i, j, direction, free, k, c):
            gap = along_and_across(at, i, j, direction)[0] - free
            now = total.measured(gap)
            if now.value < 0:
                total.push(gap, -(k * now.value + c * now.rate))
                total.potential += 0.5 * k * now.value**2


def _spring(total: Works, s: Any, k: float, free: float, c: float, actuator: float) -> None:
    now = total.measured(s)
    total.push(s, -(k * (now.value - free) + c * now.rate + actuator))
    total.potential += 0.5 * k * (now.value - free) ** 2


def side(total: Works, name: str, slip: float, creep: float | None) -> float:
    """What friction is multiplied by: ±1 where it slides, 0 where it sticks, between with a creep.

    Without modes it is the sign of the slip.
    """
    if creep is not None:
        return tanh(slip / creep)
    return total.modes.get(name, float(np.sign(slip)))


def switching_scalar(effect: parts.Effect, mechanism: parts.Mechanism, at: Placement) -> Any:
    """The slip of a friction or the gap of a contact, whose events end a smooth motion; or None."""
    match effect:
        case parts.JointFriction(_, joint, _, None):
            stated: Any = next(j for j in mechanism.joints if j.name == joint)
            if isinstance(stated, parts.Revolute):
                return at.angle(stated.j.body) - at.angle(stated.i.body)
            return along_and_across(at, stated.i, stated.j, stated.axis)[0]
        case parts.DryFriction(_, i, j, axis, _, _, None):
            return along_and_across(at, i, j, axis)[0]
        case parts.RigidContact(_, i, j, direction, free) | parts.Contact(_, i, j, direction, free):
            return along_and_across(at, i, j, direction)[0] - free
    return None


@dataclass(frozen=True)
class Rub:
    """A joint that rubs: the generalized force for a normal force of 1 N."""

    joint: str
    length: float | None
    pin: bool
    per_normal: Any
    effect: str
    limit: float  # the largest force that sticks, for a normal force of 1 N


def rubbing(effect: parts.Effect, mechanism: parts.Mechanism, total: Works) -> Iterator[Rub]:
    """The friction of a joint, if that is what the effect is."""
    if not isinstance(effect, parts.JointFriction):
        return
    joint: Any = next(j for j in mechanism.joints if j.name == effect.joint)
    at, pin = total.at, isinstance(joint, parts.Revolute)
    if pin:
        s = at.angle(joint.j.body) - at.angle(joint.i.body)
    else:
        s = along_and_across(at, joint.i, joint.j, joint.axis)[0]
    now = total.measured(s)
    arm = effect.radius if effect.radius is not None else 1.0
    slides = side(total, effect.name, now.rate, effect.creep)
    most = arm * (effect.static or effect.coefficient)
    per_normal = -effect.coefficient * arm * slides * now.by_q
    yield Rub(joint.name, effect.length, pin, per_normal, effect.name, most)


def normal_force(rub: Rub, reaction: dict[str, float]) -> float:
    """What presses, from the reaction of the joint."""
    if rub.pin:
        return hypot(reaction["fx"], reaction["fy"])
    if rub.length is None:
        return abs(reaction["fy"])
    ends = (0.5 * reaction["fy"] + k * reaction["torque"] / rub.length for k in (1, -1))
    return sum(map(abs, ends))
