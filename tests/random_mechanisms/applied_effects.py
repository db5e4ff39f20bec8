"""Random forces on a mechanism, and drivers whose laws begin as it moves."""

from math import hypot, pi

import numpy as np

from tests.random_mechanisms import parts
from tests.random_mechanisms.constraint_equations import Placement, equations
from tests.random_mechanisms.jets import derivatives, variables
from tests.random_mechanisms.parts import GROUND, End, Law
from tests.random_mechanisms.pose_analysis import (
    LEAST_SINGULAR_VALUE,
    freedoms,
    slips_are_independent,
)
from tests.random_mechanisms.pose_builder import PoseBuilder, less, polar

RUBBING = (parts.Revolute, parts.Translational, parts.Slot)


class Units:
    """Force, stiffness and damping of a mechanism's size."""

    def __init__(self, build: PoseBuilder) -> None:
        s = build.scales
        self.length, self.time = s.length, s.time
        self.force = s.mass * s.length / s.time**2
        self.torque = self.force * s.length
        self.stiffness = self.force / s.length
        self.damping = self.stiffness * s.time


def swinging(build: PoseBuilder, size: float) -> Law:
    """A load about 0 that varies in time."""
    offset, amplitude = (size * build.between(-1, 1) for _ in range(2))
    return Law(offset, 0.0, amplitude, build.between(1, 6) / build.scales.time, build.angle())


def add_effects(build: PoseBuilder, friction: str) -> None:
    """Gravity mostly, and a few of everything else; `friction` is a word of `FRICTION`."""
    u = Units(build)
    if build.chance(0.8):
        g = polar(build.between(1, 10) * u.length / u.time**2, build.angle())
        build.effects.append(parts.Gravity("gravity", g))
    wishes = (
        (0.5, _spring), (0.3, _spring), (0.3, _torsion_spring), (0.15, _bushing),
        (0.3, _force), (0.4, _torque),
    )  # fmt: skip
    for probability, add in wishes:
        if build.chance(probability):
            add(build, u)
    if friction == "sticking":
        _sticking(build, u)
    elif friction == "smooth":
        _friction(build, u)


def _bodies(pin: parts.Revolute) -> tuple[int, int]:
    return pin.i.body, pin.j.body


def _two(build: PoseBuilder) -> tuple[int, int]:
    """Two different bodies, one of which may be the ground."""
    i, j = build.random.choice(len(build.bodies) + 1, 2, replace=False) - 1
    return int(i), int(j)


def _ends(build: PoseBuilder, reach: float) -> tuple[End, End] | None:
    """Points of two bodies that are apart; one on the ground is anywhere."""
    i, j = _two(build)
    here, there = (build.somewhere(b, reach * (3.0 if b == GROUND else 0.5)) for b in (i, j))
    if hypot(*less(here, there)) < 0.2 * reach:
        return None
    return build.end(i, here), build.end(j, there)


def _spring(build: PoseBuilder, u: Units) -> None:
    ends = _ends(build, u.length)
    if ends is None:
        return
    now = hypot(*less(build.place(ends[1]), build.place(ends[0])))
    stiffness = build.between(2, 30) * u.stiffness
    damping = build.between(0.05, 1.0) * u.damping if build.chance(0.5) else 0.0
    actuator = swinging(build, u.force) if build.chance(0.3) else Law()
    numbers = stiffness, now * build.between(0.6, 1.4), damping, actuator
    build.effects.append(parts.Spring(build.name("spring"), *ends, *numbers))


def _torsion_spring(build: PoseBuilder, u: Units) -> None:
    pins = [
        j for j in build.joints
        if isinstance(j, parts.Revolute)
        and not (build.is_particle(j.i.body) or build.is_particle(j.j.body))
    ]  # fmt: skip
    if not pins:
        return
    pin = pins[int(build.random.integers(len(pins)))]
    now = build.pose(pin.j.body)[1] - build.pose(pin.i.body)[1]
    numbers = (
        build.between(0.5, 5) * u.torque,
        now + build.between(-0.5, 0.5),
        build.between(0.0, 0.3) * u.torque * u.time,
    )
    name = build.name("coil")
    build.effects.append(parts.TorsionSpring(name, pin.i.body, pin.j.body, *numbers))


def _bushing(build: PoseBuilder, u: Units) -> None:
    ends = _ends(build, u.length)
    if ends is None or any(build.is_particle(e.body) for e in ends):
        return
    (i, j), turn = ends, u.torque
    stiffness = (build.between(2, 20) * u.stiffness, build.between(2, 20) * u.stiffness)
    damping = (build.between(0, 1) * u.damping, build.between(0, 1) * u.damping)
    stiff = (*stiffness, build.between(0.5, 3) * turn)
    damp = (*damping, build.between(0.0, 0.2) * turn * u.time)
    free = build.pose(j.body)[1] - build.pose(i.body)[1] + build.between(-0.5, 0.5)
    build.effects.append(parts.Bushing(build.name("bushing"), i, j, stiff, damp, free))


def _force(build: PoseBuilder, u: Units) -> None:
    body = int(build.random.integers(len(build.bodies)))
    end = build.end(body, build.somewhere(body, 0.5 * u.length))
    laws = swinging(build, 3 * u.force), swinging(build, 3 * u.force)
    frame = "ground" if build.is_particle(body) else build.one_of("ground", "body")
    build.effects.append(parts.Force(build.name("push"), end, *laws, frame))


def _torque(build: PoseBuilder, u: Units) -> None:
    turning = [k for k, body in enumerate(build.bodies) if body.inertia is not None]
    if turning:
        body = turning[int(build.random.integers(len(turning)))]
        drag = build.between(0.0, 0.3) * u.torque * u.time
        law = swinging(build, 2 * u.torque)
        build.effects.append(parts.Torque(build.name("motor"), body, law, drag))


def _joints_that_rub(build: PoseBuilder) -> list:
    return [
        j for j in build.joints
        if isinstance(j, RUBBING)
        and not (isinstance(j, parts.Revolute) and any(map(build.is_particle, _bodies(j))))
    ]  # fmt: skip


def _friction(build: PoseBuilder, u: Units) -> None:
    """Friction in one joint or two that creep at rest, and a belt now and then."""
    joints = _joints_that_rub(build)
    order = build.random.permutation(len(joints))[: 1 if build.chance(0.6) else 2]
    for k in order.tolist():
        joint = joints[k]
        pin = isinstance(joint, parts.Revolute)
        creep = build.between(0.1, 0.4) * (1.0 if pin else u.length) / u.time
        radius = build.between(0.02, 0.06) * u.length if pin else None
        guide = isinstance(joint, parts.Translational) and build.chance(0.4)
        length = build.between(0.5, 1.0) * u.length if guide else None
        numbers = build.between(0.05, 0.25), creep, radius, length
        build.effects.append(parts.JointFriction(build.name("rub"), joint.name, *numbers))
    if build.chance(0.3) and (ends := _ends(build, u.length)):
        axis = polar(1.0, build.angle())
        normal, mu = build.between(0.5, 3) * u.force, build.between(0.1, 0.4)
        creep = build.between(0.1, 0.4) * u.length / u.time
        build.effects.append(parts.DryFriction(build.name("belt"), *ends, axis, normal, mu, creep))


def _sticking(build: PoseBuilder, u: Units) -> None:
    """Friction that sticks, in as many joints and on as many belts as there are freedoms, or two.

    Their slips are independent: how several frictions share one freedom is a convention.
    """
    joints = _joints_that_rub(build)
    for k in build.random.permutation(len(joints)).tolist()[:2]:
        joint = joints[k]
        pin = isinstance(joint, parts.Revolute)
        radius = build.between(0.05, 0.25) * u.length if pin else None
        guide = isinstance(joint, parts.Translational) and build.chance(0.4)
        length = build.between(0.5, 1.0) * u.length if guide else None
        mu = build.between(0.1, 0.4)
        static = mu * build.between(1.0, 1.6) if build.chance(0.5) else None
        numbers = mu, None, radius, length, static
        build.effects.append(parts.JointFriction(build.name("rub"), joint.name, *numbers))
        _keep_if_independent(build)
    if build.chance(0.5) and (ends := _ends(build, u.length)):
        axis = polar(1.0, build.angle())
        normal, mu = build.between(0.5, 8) * u.force, build.between(0.1, 0.5)
        static = mu * build.between(1.0, 1.6) if build.chance(0.5) else None
        numbers = normal, mu, None, static
        build.effects.append(parts.DryFriction(build.name("belt"), *ends, axis, *numbers))
        _keep_if_independent(build)


def _keep_if_independent(build: PoseBuilder) -> None:
    """Take the last friction away unless its slip is independent of all others and the joints."""
    mechanism = mechanism_of(build)
    if not slips_are_independent(mechanism, build.scales.length):
        build.effects.pop()


def add_contact(build: PoseBuilder, rigid: bool = False) -> None:
    """A stop on the ground, a little ahead of a body's point, that yields or is rigid."""
    u = Units(build)
    body = int(build.random.integers(len(build.bodies)))
    at = build.somewhere(body, 0.5 * u.length)
    direction = build.angle()
    gap = build.between(0.02, 0.3) * u.length
    free = build.length(0.0, 0.2)
    x, y = polar(gap + free, direction)
    foot = End(GROUND, (at[0] - x, at[1] - y))
    stiffness, damping = build.between(50, 500) * u.stiffness, build.between(0, 3) * u.damping
    line = polar(1.0, direction)
    name = build.name("stop")
    ends = foot, build.end(body, at)
    if rigid:
        e = build.between(0.2, 0.8) if build.chance(0.7) else 0.0
        build.effects.append(parts.RigidContact(name, *ends, line, free, e))
        return
    build.effects.append(parts.Contact(name, *ends, line, free, stiffness, damping))


def add_drivers(build: PoseBuilder, count: int) -> None:
    """Drivers of well-determined quantities at rest; `set_laws` says how they move."""
    candidates = _candidates(build)
    for k in build.random.permutation(len(candidates)).tolist():
        if not count:
            return
        build.joints.append(candidates[k](build.name("drive")))
        found = freedoms(mechanism_of(build), build.scales.length)
        if found.least > LEAST_SINGULAR_VALUE:
            count -= 1
        else:
            build.joints.pop()


def _candidates(build: PoseBuilder) -> list:
    """What may be driven, as functions of the driver's name."""
    found: list = []
    for joint in build.joints:
        if isinstance(joint, parts.Revolute):
            i, j = joint.i, joint.j
            if build.is_particle(i.body) or build.is_particle(j.body):
                continue
            if i.body == GROUND:
                found.append(lambda name, j=j: parts.PointDriver(name, j, "phi", Law()))
            else:
                found.append(lambda name, i=i, j=j: parts.RelativeDriver(name, i, j, "phi", Law()))
        elif isinstance(joint, parts.Translational | parts.Slot):
            i, j, axis = joint.i, joint.j, joint.axis
            found.append(
                lambda name, i=i, j=j, axis=axis: parts.TranslationDriver(name, i, j, axis, Law())
            )
    if (ends := _ends(build, build.scales.length)) is not None:
        found.append(lambda name: parts.DistanceDriver(name, *ends, Law()))
    body = int(build.random.integers(len(build.bodies)))
    end = build.end(body, build.somewhere(body, 0.3 * build.scales.length))
    letter = build.one_of("x", "y")
    found.append(lambda name: parts.PointDriver(name, end, letter, Law()))
    return found


def mechanism_of(build: PoseBuilder) -> parts.Mechanism:
    """What the builder has collected."""
    return parts.Mechanism(tuple(build.bodies), tuple(build.joints), tuple(build.effects))


def set_laws(build: PoseBuilder, velocities: np.ndarray) -> None:
    """Laws that begin in the pose with the velocities of the coordinates, and swing about them."""
    mechanism = mechanism_of(build)
    q = np.array(mechanism.pose)
    jets, time = variables(q, velocities, 0.0)
    at = Placement(mechanism, jets, time)
    for k, joint in enumerate(build.joints):
        if not isinstance(joint, parts.DRIVERS):
            continue
        now = derivatives(equations(joint, at)[0], len(q))
        angular = getattr(joint, "letter", "") == "phi"
        size = (1.0 if angular else 0.5 * build.scales.length) * build.between(0.05, 0.3)
        frequency, phase = build.between(1, 5) / build.scales.time, build.between(-pi, pi)
        if angular and build.chance(0.4):  # through full turns, or as far as the machine goes
            amplitude, rate = 0.0, now.rate
        else:  # about the pose: the mean rate is small
            rate = build.between(-0.1, 0.1) * size / build.scales.time
            cosine = float(np.cos(phase))
            cosine = float(np.copysign(max(abs(cosine), 0.3), cosine))
            phase = float(np.arccos(cosine))
            amplitude = (now.rate - rate) / (frequency * float(np.cos(phase)))
        law = Law(now.value, rate, amplitude, frequency, phase)
        build.joints[k] = type(joint)(**(joint.__dict__ | {"law": law}))
