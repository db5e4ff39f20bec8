"""`random_spatial_mechanism`: a sound mechanism in space for a seed, with a consistent state.

Bodies and joints are drawn in one configuration, so that every loop is closed at the drawing;
whatever is near a singular pose, locked, or redundant at its drawing alone is drawn anew.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_constraints import SpatialState
from tests.random_mechanisms.spatial_dynamics import DenseError, SpatialDense, moved
from tests.random_mechanisms.spatial_loops import (
    CONCURRENT,
    GENERAL,
    LINKS,
    OF_OTHERS,
    OTHERS,
    PARALLEL,
    TWICE,
    Drawing,
    concurrent_loop,
    general_loop,
    parallel_loop,
    twice_held,
    vector,
)
from tests.random_mechanisms.spatial_motion import motion
from tests.random_mechanisms.spatial_parts import GROUND, Law

FAMILIES = ("tree", "one loop", "two loops", "three loops")
OTHER = "other joints"  # a family that comes where it is asked for, and changes no other one
DRIVEN = ("free", "partly", "wholly")
SOUND = 5e-3  # the least singular value of independent rows, over the largest
NEAR = 1e-3  # the same along the motion
FAST = 20.0  # m/s, and rad/s
HORIZONS = (0.5, 0.2)
LOOSE = 1e-7  # of motions whose states are of use whatever their accuracy
TRIES = 60


@dataclass(frozen=True)
class RandomSpatialMechanism:
    """A mechanism in space, the state at which it is assembled, and what kind it is.

    Attributes
    ----------
    seed, family, driven
        What it was made from.
    loops
        The word of each loop, with the way in which it is special.
    parts
        All numbers, at the drawing, from which the dense equations are made.
    state
        The drawing with velocities that meet the constraints at t = 0.
    freedoms
        Degrees of freedom that the drivers leave.
    redundant
        Rows that depend on others.
    horizon
        How long a trajectory is to run, s.
    """

    seed: int
    family: str
    driven: str
    loops: tuple[str, ...]
    parts: parts.SpatialMechanism
    state: SpatialState
    freedoms: int
    redundant: int
    horizon: float

    def states(self, count: int) -> list[tuple[float, SpatialState]]:
        """Instants from 0 to the horizon with states that meet the constraints, on one motion."""
        instants = np.linspace(0.0, self.horizon, count).tolist()
        found = motion(SpatialDense(self.parts), self.state, instants, LOOSE)
        return [*zip(instants, found, strict=True)]


def random_spatial_mechanism(
    seed: int, family: str | None = None, driven: str | None = None
) -> RandomSpatialMechanism:
    """The mechanism of a seed, the same in every process.

    `family` and `driven` are drawn from `FAMILIES` and `DRIVEN` unless given; `OTHER`, too, may be.
    """
    first = np.random.default_rng([seed, 0])
    drawn = str(first.choice(FAMILIES)), str(first.choice(DRIVEN, p=(0.5, 0.3, 0.2)))
    family, driven = family or drawn[0], driven or drawn[1]
    for attempt in range(TRIES):
        random = np.random.default_rng([seed, 1, attempt])
        to = Drawing(random)
        loops = _draw_others(to) if family == OTHER else _draw(to, FAMILIES.index(family))
        if loops is None:
            continue
        freedoms, _ = SpatialDense(to.mechanism).freedoms(SpatialDense(to.mechanism).at_drawing)
        wanted = {"free": 0, "partly": freedoms // 2, "wholly": min(freedoms, 6)}[driven]
        mechanism = _driven(to, wanted)
        if mechanism is None:
            continue
        mechanism = replace(mechanism, effects=tuple(_effects(to)))
        if family == OTHER:
            mechanism = replace(
                mechanism, effects=(*mechanism.effects, *_other_effects(to, driven == "free"))
            )
        dense = SpatialDense(mechanism)
        state = dense.random_velocity(seed)
        horizon = _horizon(dense, state)
        if horizon:
            left, redundant = dense.freedoms(state)
            return RandomSpatialMechanism(
                seed, family, driven, tuple(loops), mechanism, state, left, redundant, horizon
            )
    raise AssertionError(f"no mechanism for the seed {seed}")


def _draw(to: Drawing, loops: int) -> list[str] | None:
    """Loops with trees on them; the loops' words, or None where one does not succeed."""
    words = []
    hanging = int(to.random.integers(1, 6)) if not loops else int(to.random.integers(0, 2))
    most = 7 if loops == 1 else 4  # joints in a loop
    for k in range(loops + hanging):
        bodies, joints = list(to.bodies), list(to.joints)
        for _ in range(TRIES):
            to.bodies, to.joints = list(bodies), list(joints)
            word = _add_loop(to, most) if k < loops else _hang(to)
            if is_sound(to.mechanism):
                break
        else:
            return None
        words.append(word)
    return [word for word in words if word]


def _other_effects(to: Drawing, free: bool) -> list[parts.SpatialEffect]:
    """A bushing, and friction in a joint whose reaction no redundant row leaves open."""
    random = to.random
    i, j = to.host(), to.host(ground=False)
    i = GROUND if i == j else i
    wide = random.normal(size=(2, 6, 6)) * np.array([3.0, 0.4])[:, None, None]
    of = [tuple(map(tuple, (one @ one.T).tolist())) for one in wide]
    at, axes = vector(to.near(to.place(j), 0.3)), Rotation.random(random_state=random).as_matrix()
    preload = tuple((3.0 * random.normal(size=6)).tolist())
    found: list[Any] = [parts.Bushing("rubber", i, j, at, tuple(map(vector, axes)), *of, preload)]
    dense = SpatialDense(to.mechanism)
    rubbing = (parts.Revolute, parts.Cylindrical, parts.Translational)
    joints = [joint for joint in to.joints if isinstance(joint, rubbing)]
    if free and joints and not dense.freedoms(dense.at_drawing)[1]:
        joint = joints[int(random.integers(len(joints)))]
        creep, radius, length, collar = random.uniform(0.05, 0.5, 4).tolist()
        words: dict[str, Any] = {"radius": 0.3 * radius, "length": 2 * length}
        if isinstance(joint, parts.Revolute):
            words["collar"] = 0.3 * collar
        found.append(parts.Friction("rub", joint.name, 0.1, creep, **words))
    return found


def _draw_others(to: Drawing) -> list[str] | None:
    """A loop with other joints, or two wheels that mesh; and a body on another joint."""
    word = str(to.random.choice([*OF_OTHERS, "gear", "rack"]))
    if word in OF_OTHERS:
        general_loop(to, word, (GROUND, GROUND))
    else:
        last = "RT"[word == "rack"]
        _hang(to, "R")
        _hang(to, last, GROUND if to.random.random() < 0.5 else 0)
        kind, ratio = parts.Rack if last == "T" else parts.Gear, float(to.random.uniform(-2, 2))
        to.joints.append(kind(word, "R1", f"{last}2", ratio))
    _hang(to, OTHERS)
    return [word] if is_sound(to.mechanism) else None


def _hang(to: Drawing, letters: str = "RRSUTCWD", host: int | None = None) -> str:
    """A body on any other."""
    host = to.host() if host is None else host
    point = to.near(to.place(host), 0.5)
    letter = str(to.random.choice([*letters]))
    far = to.near(point, 0.5) if letter in LINKS else point
    to.join(letter, host, to.body(far, to.near(far, 0.6)), point, None, far)
    return ""


def _add_loop(to: Drawing, most: int) -> str:
    kind = str(
        to.random.choice(["general", "parallel", "concurrent", "twice"], p=(0.6, 0.2, 0.1, 0.1))
    )
    host = to.host()
    match kind:
        case "general":
            word = str(to.random.choice([w for w in GENERAL if len(w) <= most]))
            general_loop(to, word, (host, to.host()))
        case "parallel":
            word, axis = str(to.random.choice(PARALLEL)), to.direction()
            made = parallel_loop(to, word, (host, host), axis)
            if (
                most > 4 and to.random.random() < 0.4
            ):  # another loop in the same planes, on links of the first
                other = str(to.random.choice(PARALLEL))
                parallel_loop(to, other, (made[0], host), axis)
                word += "+" + other
        case "concurrent":
            word = str(to.random.choice(CONCURRENT))
            concurrent_loop(to, word, host)
        case _:
            word = str(to.random.choice(TWICE))
            twice_held(to, word, host)
    return f"{kind} {word}"


def is_sound(mechanism: parts.SpatialMechanism) -> bool:
    """Whether it moves, is far from singular, and is as redundant close by as at its drawing."""
    dense = SpatialDense(mechanism)
    state = dense.at_drawing
    rank = dense.system(state, 0.0).rank
    if rank == 6 * dense.n or dense.least_singular_value(state, rank) < SOUND:
        return False
    moving = dense.random_velocity(0)
    velocity = np.concatenate([moving.v, moving.w], axis=1).ravel()
    try:
        close = dense.closed(moved(moving, 0.05 * velocity / np.linalg.norm(velocity)), 0.0, rank)
    except DenseError:
        return False
    return dense.system(close, 0.0).rank == rank


def _horizon(dense: SpatialDense, state: SpatialState) -> float:
    """How long it moves at moderate speeds, far from singular poses; 0 where that is too short."""
    rank = dense.system(state, 0.0).rank
    for horizon in HORIZONS:
        try:
            found = motion(dense, state, np.linspace(0.0, horizon, 11).tolist(), LOOSE)
        except DenseError:
            continue
        fast = max(float(np.abs([s.v, s.w]).max()) for s in found)
        if fast < FAST and all(dense.least_singular_value(s, rank) > NEAR for s in found):
            return horizon
    return 0.0


def _driven(to: Drawing, wanted: int) -> parts.SpatialMechanism | None:
    """With drivers for some freedoms, each of which moves something that no other does."""
    plain = to.mechanism
    for _ in range(TRIES):
        drivers = len(to.joints) - len(plain.joints)
        if drivers == wanted:
            return to.mechanism
        dense = SpatialDense(to.mechanism)
        rank = dense.system(dense.at_drawing, 0.0).rank
        to.joints.append(_driver(to, plain))
        dense = SpatialDense(to.mechanism)
        more = dense.system(dense.at_drawing, 0.0).rank
        if more == rank or dense.least_singular_value(dense.at_drawing, more) < SOUND:
            to.joints.pop()
    return None


def _driver(to: Drawing, plain: parts.SpatialMechanism) -> parts.SpatialJoint:
    name, random = f"driver{len(to.joints)}", to.random
    driven = {p.joint for p in to.joints if isinstance(p, parts.AngleDriver | parts.SlideDriver)}
    turning = [
        j.name for j in plain.joints if isinstance(j, parts.TURNING) and j.name not in driven
    ]
    sliding = [
        j.name for j in plain.joints if isinstance(j, parts.SLIDING) and j.name not in driven
    ]
    choice = random.random()
    if turning and choice < 0.5:
        return parts.AngleDriver(name, str(random.choice(turning)), _law(random))
    if sliding and choice < 0.75:
        return parts.SlideDriver(name, str(random.choice(sliding)), _law(random))
    body = to.host(ground=False)
    at = to.near(to.place(body), 0.3)
    if choice < 0.9:
        k = int(random.integers(3))
        return parts.PointDriver(name, body, vector(at), "xyz"[k], _law(random, float(at[k])))
    other = to.host()
    other = GROUND if other == body else other
    far = to.near(to.place(other), 0.8)
    law = _law(random, float(np.linalg.norm(far - at)))
    return parts.DistanceDriver(name, other, body, vector(far), vector(at), law)


def _law(random: Any, offset: float = 0.0, size: float = 0.2) -> Law:
    rate, amplitude, phase = random.uniform(-size, size, 3).tolist()
    return Law(offset, rate, amplitude, float(random.uniform(1.0, 4.0)), phase / size)


def _effects(to: Drawing) -> list[parts.SpatialEffect]:
    random, chance = to.random, to.random.random
    found: list[parts.SpatialEffect] = []
    if chance() < 0.8:
        g = (0.0, 0.0, -9.81) if chance() < 0.5 else vector(9.81 * to.direction())
        found.append(parts.Gravity("gravity", g))
    for kind in ("force", "torque"):
        if chance() < 0.5:
            laws = tuple(_law(random, random.normal(), 2.0) for _ in range(3))
            frame, body = str(random.choice(["global", "body"])), to.host(ground=False)
            if kind == "torque":
                found.append(parts.Torque(kind, body, laws, frame))
            else:
                at = vector(to.near(to.place(body), 0.3))
                found.append(parts.Force(kind, body, at, laws, frame))
    if chance() < 0.6:
        i, j = to.host(), to.host(ground=False)
        i = GROUND if i == j else i
        at_i, at_j = to.near(to.place(i), 0.8), to.near(to.place(j), 0.3)
        length = float(np.linalg.norm(at_j - at_i))
        damping = float(random.uniform(0, 3)) if chance() < 0.5 else 0.0
        actuator = _law(random, random.normal()) if chance() < 0.4 else parts.REST
        found.append(parts.Spring(
            "spring", i, j, vector(at_i), vector(at_j), float(random.uniform(5, 50)),
            float(length * random.uniform(0.6, 1.2)), damping, actuator,
        ))  # fmt: skip
    turning = [j.name for j in to.joints if isinstance(j, parts.TURNING)]
    if turning and chance() < 0.6:
        free, damping = float(random.uniform(-8, 8)), float(random.uniform(0, 0.3))
        name, stiffness = str(random.choice(turning)), float(random.uniform(0.05, 0.5))
        found.append(parts.TorsionSpring("torsion", name, stiffness, free, damping))
    return found
