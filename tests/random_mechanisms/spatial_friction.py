"""Friction in joints in space that creeps: forces and torques from the reactions, by hand."""

from typing import Any

import numpy as np

from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_constraints import (
    Frames,
    Layout,
    Scalars,
    SpatialState,
    cross,
    offsets,
)


def slide(layout: Layout, joint: Any, state: SpatialState) -> Scalars:
    """How far the point of body j is ahead of that of body i, along the axis of body i."""
    ends = (np.array([layout.fixed_point(b, joint.at)]) for b in (joint.i, joint.j))
    axis = np.array([layout.fixed_vector(joint.i, joint.axis)])
    i, j = np.array([joint.i]), np.array([joint.j])
    s_i, s_j = ends
    return offsets(Frames(state), i, axis, i, s_i, j, s_j)


def pressing(law: parts.Friction, joint: Any, axis: Any, force: Any, torque: Any) -> float:
    """N, by vectors across the axis, of the reaction on body j at its point."""
    along, about = float(axis @ force), float(axis @ torque)
    loads = [force - along * axis]
    if law.length is not None:
        moment = np.cross(torque, axis) / law.length
        loads = [loads[0] / 2 + moment, loads[0] / 2 - moment]
    total = sum(float(np.linalg.norm(load)) for load in loads)
    if law.collar is not None:
        total += law.collar / law.radius * abs(along)
    if isinstance(joint, parts.Translational) and law.radius is not None:
        total += abs(about) / law.radius
    return total


def friction(
    layout: Layout, law: parts.Friction, state: SpatialState, force: Any, torque: Any
) -> tuple[Any, float]:
    """Forces and torques (n, 6) on all bodies, and what is reported, for a joint's reaction."""
    joint: Any = layout.mechanism.joint(law.joint)
    at = Frames(state)
    axis = at.R[joint.i] @ layout.fixed_vector(joint.i, joint.axis)
    turning = np.zeros((len(at.r), 6))
    turning[joint.j, 3:] += axis
    turning[joint.i, 3:] -= axis
    slips = [slide(layout, joint, state).by[0]] * (not isinstance(joint, parts.Revolute))
    if not isinstance(joint, parts.Translational):
        slips.append((law.radius if slips else 1.0) * turning)
    velocity = np.concatenate([at.v, at.w], axis=1)
    rates = np.array([np.sum(by * velocity) for by in slips])
    normal = pressing(law, joint, axis, force, torque)
    arm = law.radius if isinstance(joint, parts.Revolute) else 1.0
    size = np.sqrt(rates @ rates + law.creep**2)
    shares = rates / size if len(slips) > 1 else np.tanh(rates / law.creep)
    pushes = -law.coefficient * arm * normal * shares
    told = pushes[0] if len(slips) == 1 else -law.coefficient * normal
    return sum(f * by for f, by in zip(pushes, slips, strict=True))[:-1], float(told)


def bushing(layout: Layout, at: Frames, law: parts.Bushing, found: Any) -> float:
    """Add the wrenches of a bushing to those found (n + 1, 6), and return its potential.

    With the rotation vector θ of C, Ċ = ω̃ C: θ̇ = ω - θ × ω / 2 + c θ × (θ × ω), and the torque
    of τ along θ is τ + θ × τ / 2 + c θ × (θ × τ).
    """
    K, damping = np.array(law.stiffness, float), np.array(law.damping, float)
    points = [at.R[b] @ layout.fixed_point(b, law.at) for b in (law.i, law.j)]
    drawn = [np.column_stack([layout.fixed_vector(b, a) for a in np.transpose(law.axes)])
             for b in (law.i, law.j)]  # fmt: skip
    of_i, of_j = at.R[law.i] @ drawn[0], at.R[law.j] @ drawn[1]
    away = at.r[law.j] + points[1] - at.r[law.i] - points[0]
    rate = at.v[law.j] + cross(at.w[law.j], points[1]) - at.v[law.i]
    rate = rate - cross(at.w[law.i], points[0] + away)
    turn = of_i.T @ of_j
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    angle = float(np.arctan2(np.linalg.norm(axis), np.trace(turn) - 1))
    theta = axis * angle / (2 * np.sin(angle)) if angle > 0 else axis / 2
    bend = 1 / angle**2 - (1 + np.cos(angle)) / (2 * angle * np.sin(angle)) if angle > 0 else 1 / 12

    def beside(vector: Any, sign: float) -> Any:
        once = np.cross(theta, vector)
        return vector + sign * once / 2 + bend * np.cross(theta, once)

    z = np.concatenate([of_i.T @ away, theta])
    speeds = np.concatenate([of_i.T @ rate, beside(of_i.T @ (at.w[law.j] - at.w[law.i]), -1.0)])
    elastic = K @ z + law.preload
    f = elastic + damping @ speeds
    force, torque = of_i @ f[:3], of_i @ beside(f[3:], 1.0)
    found[law.j] -= np.concatenate([force, np.cross(points[1], force) + torque])
    found[law.i] += np.concatenate([force, np.cross(points[0] + away, force) + torque])
    return float(z @ K @ z / 2 + np.array(law.preload) @ z)
