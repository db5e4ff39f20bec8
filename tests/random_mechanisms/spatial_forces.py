"""Forces on the bodies of a spatial mechanism: a wrench about each centre of mass, and a potential.

Everything is in global axes.
"""

from typing import Any

import numpy as np

from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_constraints import Frames, Layout, Scalars, SpatialState, cross
from tests.random_mechanisms.spatial_friction import bushing


def wrenches(layout: Layout, state: SpatialState, turns: Scalars, t: float) -> tuple[Any, float]:
    """Forces and torques (n, 6) of all effects, and the potential of gravity and springs.

    `turns` are the angles of `layout.angles`.
    """
    at, mechanism = Frames(state), layout.mechanism
    found = np.zeros((len(mechanism.bodies) + 1, 6))
    return found[:-1], sum(_add(e, layout, at, turns, t, found) for e in mechanism.effects)


def _add(
    effect: Any, layout: Layout, at: Frames, turns: Scalars, t: float, found: Any
) -> float:  # fmt: skip
    """Add an effect's wrenches to those found (n + 1, 6), and return its potential."""
    match effect:
        case parts.Gravity(_, g):
            masses = np.array([body.mass for body in layout.mechanism.bodies])
            found[:-1, :3] += masses[:, None] * np.asarray(g)
            return -float(masses @ at.r[:-1] @ np.asarray(g))
        case parts.Force(_, body, place, laws, frame):
            arm = at.R[body] @ layout.fixed_point(body, place)
            _push(found, body, arm, _components(at, body, laws, frame, t))
            return 0.0
        case parts.Torque(_, body, laws, frame):
            found[body, 3:] += _components(at, body, laws, frame, t)
            return 0.0
        case parts.Spring(_, i, j, at_i, at_j, stiffness, free, damping, actuator):
            arms = [at.R[b] @ layout.fixed_point(b, p) for b, p in ((i, at_i), (j, at_j))]
            span = at.r[j] + arms[1] - at.r[i] - arms[0]
            length = float(np.sqrt(span @ span))
            rate = at.v[j] + cross(at.w[j], arms[1]) - at.v[i] - cross(at.w[i], arms[0])
            u = span / length
            pull = stiffness * (length - free) + damping * float(u @ rate) + actuator(t)
            _push(found, i, arms[0], pull * u)
            _push(found, j, arms[1], -pull * u)
            return 0.5 * stiffness * (length - free) ** 2
        case parts.TorsionSpring(_, joint, stiffness, free, damping):
            place = layout.angles.index(joint)
            by, angle = turns.by[place], float(turns.value[place])
            rate = float(np.sum(by * np.concatenate([at.v, at.w], axis=1)))
            found -= (stiffness * (angle - free) + damping * rate) * by
            return 0.5 * stiffness * (angle - free) ** 2
        case parts.Bushing():
            return bushing(layout, at, effect, found)
        case parts.Friction():  # of reactions, which are not known yet
            return 0.0
    raise NotImplementedError(type(effect))


def _components(at: Frames, body: int, laws: Any, frame: str, t: float) -> Any:
    values = np.array([law(t) for law in laws])
    return at.R[body] @ values if frame == "body" else values


def _push(found: Any, body: int, arm: Any, force: Any) -> None:
    found[body, :3] += force
    found[body, 3:] += cross(arm, force)
