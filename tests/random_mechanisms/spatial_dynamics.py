"""Accelerations and reactions of a spatial mechanism by Newton's and Euler's equations, by hand.

The unknowns are r̈ and ω̇ of every body in global axes, with rotation matrices and no parameters
of rotations. Redundant rows are welcome: accelerations are unique, and multipliers have least norm.
Nothing of it comes from the library.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import qr
from scipy.spatial.transform import Rotation

from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_constraints import Frames, Layout, Scalars, SpatialState, cross
from tests.random_mechanisms.spatial_forces import wrenches
from tests.random_mechanisms.spatial_friction import friction

DEPENDENT = 1e-8  # singular values below this part of the largest are those of dependent rows
CLOSED = 1e-14
ROUNDS = 30
TURNS, AGREED = 100, 1e-12  # of friction and reactions


class DenseError(ArithmeticError):
    """The dense formulation cannot go on either."""


@dataclass(frozen=True)
class SpatialSystem:
    """M a + Jᵀ λ = Q and J a = γ at a state, a = (r̈, ω̇) body by body; J v = ν; the residual Φ."""

    mass: Any
    jacobian: Any
    force: Any
    gamma: Any
    nu: Any
    phi: Any
    scalars: Scalars
    turns: Scalars
    potential: float

    @cached_property
    def singular(self) -> tuple[Any, Any, Any]:
        """U, s and Vᵀ of J, complete."""
        return np.linalg.svd(self.jacobian)

    @property
    def rank(self) -> int:
        """Independent rows of J."""
        s = self.singular[1]
        return int(np.sum(s > DEPENDENT * s[0])) if s.size else 0


@dataclass(frozen=True)
class Reaction:
    """What body i exerts on body j: force, and torque about `point`, in global axes.

    `determined` (6,) says which components no redundant row leaves open.
    """

    point: Any
    force: Any
    torque: Any
    determined: Any


@dataclass(frozen=True)
class SpatialSolution:
    """Accelerations r̈ and ω̇ (n, 3) in global axes, and ω̇′ (n, 3) in body axes."""

    r: Any
    w: Any
    body_w: Any
    system: SpatialSystem

    @cached_property
    def lam(self) -> Any:
        """The multipliers of least norm."""
        e = self.system
        a = np.concatenate([self.r, self.w], axis=1).ravel()
        return _least(e.jacobian.T, e.force - e.mass @ a, e.rank)


class SpatialDense:
    """A spatial mechanism's equations of motion."""

    def __init__(self, mechanism: parts.SpatialMechanism) -> None:
        self.mechanism, self.layout = mechanism, Layout(mechanism)
        self.n = len(mechanism.bodies)
        self._masses = np.array([body.mass for body in mechanism.bodies])
        self._inertias = np.array([body.inertia for body in mechanism.bodies], float)

    @property
    def at_drawing(self) -> SpatialState:
        """The drawing, at rest."""
        return self.layout.at_drawing

    def system(self, state: SpatialState, t: float) -> SpatialSystem:
        """Everything that holds at a state."""
        n, eye = self.n, np.arange(3)
        inertia = state.R @ self._inertias @ state.R.transpose(0, 2, 1)
        mass = np.zeros((n, 6, n, 6))
        for k in range(n):
            mass[k, eye, k, eye] = self._masses[k]
            mass[k, 3:, k, 3:] = inertia[k]
        scalars, turns = self.layout.scalars(state)
        applied, potential = wrenches(self.layout, state, turns, t)
        applied[:, 3:] -= cross(state.w, np.einsum("kij,kj->ki", inertia, state.w))
        law, rate, second = self.layout.laws(t)
        return SpatialSystem(
            mass.reshape(6 * n, 6 * n), scalars.by[:, :-1].reshape(-1, 6 * n), applied.ravel(),
            second - scalars.second, rate, scalars.value - law, scalars, turns, potential,
        )  # fmt: skip

    def solve(
        self, state: SpatialState, t: float = 0.0, rows: Any = None
    ) -> SpatialSolution:  # fmt: skip
        """Accelerations and multipliers at a state that meets the constraints.

        Near one, too, where independent `rows` are given, on which alone the others depend.
        Friction and the reactions that it follows from are found by turns.
        """
        e = self.system(state, t)
        solved, laws = self._solved(state, e, rows), self.frictions
        rubbed = np.zeros_like(e.force)
        for _ in range(TURNS if laws else 0):
            before, rubbed = rubbed, np.zeros_like(e.force)
            for law in laws:
                by = self.reaction(law.joint, state, solved)
                rubbed += friction(self.layout, law, state, by.force, by.torque)[0].ravel()
            solved = self._solved(state, replace(e, force=e.force + rubbed), rows)
            if np.abs(rubbed - before).max() <= AGREED * np.abs([rubbed, e.force]).max():
                return solved
        if laws:
            raise DenseError(f"friction does not agree with reactions at t = {t:g} s")
        return solved

    @cached_property
    def frictions(self) -> list[parts.Friction]:
        """The frictions in joints."""
        return [e for e in self.mechanism.effects if isinstance(e, parts.Friction)]

    def _solved(self, state: SpatialState, e: SpatialSystem, rows: Any) -> SpatialSolution:
        if rows is not None:
            kept, none = e.jacobian[rows], np.zeros((len(rows), len(rows)))
            matrix = np.block([[e.mass, kept.T], [kept, none]])
            a = np.linalg.solve(matrix, np.concatenate([e.force, e.gamma[rows]]))[: 6 * self.n]
            return self._solution(state, e, a)
        root = np.linalg.cholesky(e.mass)
        free = np.linalg.solve(root, e.force)
        scaled = np.linalg.solve(root, e.jacobian.T).T
        a = np.linalg.solve(root.T, free + _least(scaled, e.gamma - scaled @ free, e.rank))
        return self._solution(state, e, a)

    def independent_rows(
        self, state: SpatialState, t: float, rank: int
    ) -> tuple[Any, float]:  # fmt: skip
        """`rank` rows of J of which none depends on others, and their weakest pivot."""
        if not rank:
            return np.zeros(0, int), 1.0
        by, order = qr(self.system(state, t).jacobian.T, mode="r", pivoting=True)
        return order[:rank], float(abs(by[rank - 1, rank - 1] / by[0, 0]))

    def _solution(self, state: SpatialState, e: SpatialSystem, a: Any) -> SpatialSolution:
        r, w = a.reshape(self.n, 2, 3).transpose(1, 0, 2)
        return SpatialSolution(r, w, np.einsum("kji,kj->ki", state.R, w), e)

    def reaction(
        self, name: str, state: SpatialState, solution: SpatialSolution, point: Any = None
    ) -> Reaction:
        """The wrench on body j of a joint or driver at its point on j, or at a given point.

        `point` is in global axes. A point driver acts on its body.
        """
        body, place = self._end(name)
        arm = Frames(state).R[body] @ self.layout.fixed_point(body, place)
        centre = Frames(state).r[body]
        point = centre + arm if point is None else np.asarray(point, float)
        rows = self.layout.rows[name]
        by = -solution.system.scalars.by[rows, body].copy()  # on j, about its centre of mass
        by[:, 3:] -= cross(point - centre, by[:, :3])
        wrench = solution.lam[rows] @ by
        left = solution.system.singular[0][:, solution.system.rank :]
        open_ = np.linalg.norm(left[rows].T @ by, axis=0) if left.size else np.zeros(6)
        return Reaction(point, wrench[:3], wrench[3:], open_ < 1e-9)

    def effort(self, name: str, solution: SpatialSolution) -> float:
        """The force or torque of a driver, positive where it works on a coordinate that grows."""
        (row,) = range(*self.layout.rows[name].indices(len(solution.lam)))
        return -float(solution.lam[row])

    def angle(self, name: str, state: SpatialState) -> float:
        """The angle of a joint that a driver or a spring asks for, with its turns."""
        return float(self.layout.scalars(state)[1].value[self.layout.angles.index(name)])

    def energy(self, state: SpatialState, t: float = 0.0) -> float:
        """Kinetic energy, and the potential of gravity and springs."""
        e, velocity = self.system(state, t), np.concatenate([state.v, state.w], axis=1).ravel()
        return 0.5 * float(velocity @ e.mass @ velocity) + e.potential

    @cached_property
    def _rank(self) -> int:
        return self.system(self.at_drawing, 0.0).rank

    def freedoms(self, state: SpatialState, t: float = 0.0) -> tuple[int, int]:
        """Degrees of freedom, and redundant rows, at a state."""
        e = self.system(state, t)
        return 6 * self.n - e.rank, len(e.jacobian) - e.rank

    def least_singular_value(self, state: SpatialState, rank: int, t: float = 0.0) -> float:
        """The `rank`-th singular value of J over its largest."""
        s = self.system(state, t).singular[1]
        return float(s[rank - 1] / s[0]) if rank else 1.0

    def closed(
        self, state: SpatialState, t: float = 0.0, rank: int | None = None
    ) -> SpatialState:  # fmt: skip
        """A state near by that meets the constraints in position and velocity.

        The Jacobian has the given `rank`, or that of the drawing.

        Raises
        ------
        DenseError
            Where Newton's method does not close the joints.
        """
        rank = self._rank if rank is None else rank
        for _ in range(ROUNDS):
            e = self.system(state, t)
            step = _least(e.jacobian, -e.phi, rank)
            state = moved(state, step)
            if np.abs(step).max(initial=0.0) < CLOSED * (1.0 + np.abs(state.r).max()):
                break
        else:
            raise DenseError(f"the joints do not close at t = {t:g} s")
        e = self.system(state, t)
        velocity = np.concatenate([state.v, state.w], axis=1).ravel()
        velocity = velocity + _least(e.jacobian, e.nu - e.jacobian @ velocity, rank)
        v, w = velocity.reshape(self.n, 2, 3).transpose(1, 0, 2)
        return replace(state, v=v, w=w, turned=e.turns.value)

    def random_velocity(self, seed: int, speed: float = 1.0, t: float = 0.0) -> SpatialState:
        """The drawing with random velocities of all that may move."""
        random = np.random.default_rng([seed, 3])
        v, w = speed * random.normal(size=(2, self.n, 3))
        return self.closed(replace(self.at_drawing, v=v, w=w), t)

    def _end(self, name: str) -> tuple[int, Any]:
        joint: Any = self.mechanism.joint(name)
        if isinstance(joint, parts.AngleDriver | parts.SlideDriver | parts.Gear):
            joint = self.mechanism.joint(joint.joint)
        if isinstance(joint, parts.PointDriver):
            return joint.body, joint.at
        return joint.j, getattr(joint, "at_j", None) or joint.at


def moved(state: SpatialState, step: Any) -> SpatialState:
    """A state after small displacements and turns in global axes, body by body."""
    shift, turn = np.asarray(step).reshape(len(state.r), 2, 3).transpose(1, 0, 2)
    return replace(state, r=state.r + shift, R=Rotation.from_rotvec(turn).as_matrix() @ state.R)


def _least(matrix: Any, right: Any, rank: int) -> Any:
    """The least solution of equations of which `rank` are independent."""
    if not rank:
        return np.zeros(matrix.shape[1])
    u, s, vt = np.linalg.svd(matrix, full_matrices=False)
    return vt[:rank].T @ ((u[:, :rank].T @ right) / s[:rank])
