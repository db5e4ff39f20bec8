"""Accelerations, multipliers and reactions of a mechanism by dense algebra, written by hand.

The whole system [M Φ_qᵀ; Φ_q 0] is formed and solved at once, with Φ_q by complex steps and γ by
Taylor series of the equations in `constraint_equations`, Q by virtual work. Nothing of it comes
from the library.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import hypot
from typing import Any

import numpy as np

from tests.random_mechanisms import parts
from tests.random_mechanisms.constraint_equations import Placement, equations
from tests.random_mechanisms.jets import Derivatives, derivatives, variables
from tests.random_mechanisms.pose_analysis import column_sizes
from tests.random_mechanisms.reactions_by_hand import reaction
from tests.random_mechanisms.virtual_work import (
    Works,
    normal_force,
    rubbing,
    switching_scalar,
    works,
)

ROUNDS = 200  # of the normal forces of rubbing joints, which converge by a factor of about μ


@dataclass(frozen=True)
class Equations:
    """Everything that holds at a state, before it is solved."""

    rows: list[Derivatives]
    slices: dict[str, slice]
    works: Works
    at: Placement  # in plain numbers
    scalars: dict[str, Derivatives]  # effect → its slip or gap, where it switches

    @property
    def jacobian(self) -> Any:
        """Φ_q."""
        return np.array([row.by_q for row in self.rows])

    @property
    def phi(self) -> Any:
        """Φ."""
        return np.array([row.value for row in self.rows])

    @property
    def gamma(self) -> Any:
        """γ = -Φ̈ for accelerations of 0."""
        return np.array([-row.second for row in self.rows])

    @property
    def nu(self) -> Any:
        """ν = -Φ_t."""
        return np.array([-row.by_t for row in self.rows])


@dataclass(frozen=True)
class Solution:
    """q̈ and λ, and the reaction of each joint and driver by its components."""

    a: Any
    lam: Any
    reactions: dict[tuple[str, str], float]
    held: dict[str, float] = field(default_factory=dict)  # effect → force that keeps it
    limits: dict[str, float] = field(default_factory=dict)  # friction → the most that it keeps
    rises: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Effect → second derivative of its slip or gap, and the size of its terms."""
    scalars: dict[str, Derivatives] = field(default_factory=dict)  # of the equations


class Dense:
    """A mechanism's equations of motion."""

    def __init__(self, mechanism: parts.Mechanism, length: float) -> None:
        self.mechanism = mechanism
        self.names = mechanism.coordinates
        self.n = len(self.names)
        self.masses = np.array([self._mass(name) for name in self.names])
        self.sizes, self.length = column_sizes(self.names, length), length

    def _mass(self, name: str) -> float:
        owner, letter = name.split(".")
        body = next((b for b in self.mechanism.bodies if b.name == owner), None)
        if body is None:
            return 0.0
        return body.mass if letter in "xy" else float(body.inertia or 0.0)

    def equations(
        self, q: Any, v: Any, t: float, modes: Mapping[str, int] | None = None
    ) -> Equations:
        """Constraints and forces at a state; `modes` as in `solve`."""
        jets, time = variables(q, v, t)
        at, plain = Placement(self.mechanism, jets, time), Placement(self.mechanism, q, t)
        rows: list[Derivatives] = []
        slices = {}
        for joint in self.mechanism.joints:
            found = [derivatives(e, self.n) for e in equations(joint, at)]
            slices[joint.name] = slice(len(rows), len(rows) + len(found))
            rows += found
        pushed = works(self.mechanism, at, self.n, modes or {})
        switching = {
            f.name: switching_scalar(f, self.mechanism, at) for f in self.mechanism.effects
        }
        scalars = {k: derivatives(s, self.n) for k, s in switching.items() if s is not None}
        return Equations(rows, slices, pushed, plain, scalars)

    def solve(
        self, q: Any, v: Any, t: float, modes: Mapping[str, int] | None = None,
        given: Mapping[str, float] | None = None,
    ) -> Solution:  # fmt: skip
        """The motion at a state; joints that rub are solved by iteration from no friction.

        `modes`: effect → 0 where its slip or gap is kept as it is, ±1 where a friction slides.
        Without them every friction slides as its slip says, and every rigid contact is open.
        What is kept by a force that is `given`, N or N m, is no constraint.
        """
        e, forces = self.equations(q, v, t, modes), given or {}
        kept = [name for name in e.scalars if (modes or {}).get(name) == 0 and name not in forces]
        extra = [e.scalars[name] for name in kept]
        rows = [row.by_q for row in (*e.rows, *extra)]
        matrix, scale = self._system(np.array(rows) if rows else np.zeros((0, self.n)))
        gamma = np.array([-row.second for row in (*e.rows, *extra)])
        rubs = [r for f in self.mechanism.effects for r in rubbing(f, self.mechanism, e.works)]
        applied = sum((f * e.scalars[k].by_q for k, f in forces.items()), start=e.works.force)
        columns = [applied, *(rub.per_normal for rub in rubs)]
        right = [np.append(force, gamma if k == 0 else 0.0 * gamma)
                 for k, force in enumerate(columns)]  # fmt: skip
        solved = _solved(matrix, np.array(right).T * scale[:, None]) * scale[:, None]
        normals, joints = np.zeros(len(rubs)), {rub.joint for rub in rubs}
        for _ in range(ROUNDS):
            x = solved[:, 0] + solved[:, 1:] @ normals
            loads = {name: self._reaction(e, name, x[self.n :]) for name in joints}
            pressing = np.array([normal_force(rub, loads[rub.joint]) for rub in rubs])
            settled = np.all(np.abs(pressing - normals) <= 1e-15 * np.abs(pressing))
            normals = pressing
            if settled:
                break
        x = solved[:, 0] + solved[:, 1:] @ normals
        lam, a = x[self.n : self.n + len(e.rows)], x[: self.n]
        found = {
            (joint.name, component): value
            for joint in self.mechanism.joints
            for component, value in self._reaction(e, joint.name, lam).items()
        }
        held = dict(zip(kept, (-x[self.n + len(e.rows) :]).tolist(), strict=True))
        found |= {(name, word): f for name, f in held.items() for word in ("force", "torque")}
        limits = {r.effect: r.limit * n for r, n in zip(rubs, normals, strict=True)}
        # Where friction just breaks loose its slip's acceleration is rounding of all the others.
        most = self.sizes * float(np.abs(a / self.sizes).max())
        rises = {
            name: (float(s.by_q @ a) + s.second, float(np.abs(s.by_q) @ most) + abs(s.second))
            for name, s in e.scalars.items()
        }
        return Solution(a, lam, found, held, limits, rises, e.scalars)

    def impulse(self, q: Any, v: Any, t: float, wanted: Mapping[str, float]) -> tuple[Any, Any]:
        """Change of velocity, and impulses, that change the rates of scalars as wanted."""
        e = self.equations(q, v, t)
        matrix, scale = self._system(
            np.array([row.by_q for row in (*e.rows, *(e.scalars[name] for name in wanted))])
        )
        right = np.concatenate([np.zeros(self.n + len(e.rows)), list(wanted.values())])
        x = _solved(matrix, right * scale) * scale
        return x[: self.n], -x[self.n + len(e.rows) :]

    def independent(self, q: Any, t: float, names: Any) -> bool:
        """Whether scalars are independent of each other and of the joints."""
        e = self.equations(q, np.zeros(self.n), t)
        rows = [row.by_q * self.sizes for row in (*e.rows, *(e.scalars[name] for name in names))]
        if not rows:
            return True
        unit = np.array([row / max(float(np.linalg.norm(row)), 1e-300) for row in rows])
        return len(rows) <= self.n and float(np.linalg.svd(unit, compute_uv=False)[-1]) > 1e-3

    def _reaction(self, e: Equations, name: str, lam: Any) -> dict[str, float]:
        joint = next(j for j in self.mechanism.joints if j.name == name)
        rows = e.slices[name]
        force = -sum(
            (row.by_q * k for row, k in zip(e.rows[rows], lam[rows], strict=True)),
            start=np.zeros(self.n),
        )
        by_name = dict(zip(self.names, force.tolist(), strict=True))
        return reaction(joint, e.at, by_name, lam[rows])

    def _system(self, jacobian: Any) -> tuple[Any, Any]:
        """The matrix with rows and columns of about one size, and what they were multiplied by."""
        m = len(jacobian)
        scale = np.concatenate([self.sizes, np.ones(m)])
        heaviest = float(np.max(self.masses * self.sizes**2))
        scale[: self.n] /= np.sqrt(heaviest)
        rows = np.linalg.norm(jacobian * scale[: self.n], axis=1)
        scale[self.n :] = 1.0 / rows
        matrix = np.zeros((self.n + m, self.n + m))
        matrix[: self.n, : self.n] = np.diag(self.masses)
        matrix[self.n :, : self.n] = jacobian
        matrix[: self.n, self.n :] = jacobian.T
        return matrix * scale[:, None] * scale, scale

    def least_singular_value(self, q: Any, t: float, names: Sequence[str] = ()) -> float:
        """Of Φ_q with columns in typical sizes and rows of unit length, part of the largest.

        The slips or gaps of `names` are kept as further constraints.
        """
        e = self.equations(q, np.zeros(self.n), t)
        rows = [row.by_q for row in (*e.rows, *(e.scalars[name] for name in names))]
        jacobian = np.array(rows) * self.sizes
        jacobian /= np.linalg.norm(jacobian, axis=1, keepdims=True)
        values = np.linalg.svd(jacobian, compute_uv=False)
        return float(values[-1] / values[0])

    def closed(self, q: Any, v: Any, t: float) -> tuple[Any, Any]:
        """The state put onto the constraints by the least change in typical sizes.

        Raises
        ------
        ArithmeticError
            If Newton's method does not get there.
        """
        for _ in range(40):
            e = self.equations(q, v, t)
            if not e.rows:
                return q, v
            scaled = e.jacobian * self.sizes
            rows = np.linalg.norm(scaled, axis=1)
            inverse = np.linalg.pinv(scaled / rows[:, None])
            step = inverse @ (e.phi / rows)
            q = q - step * self.sizes
            if not np.all(np.isfinite(q)) or hypot(*step) > 1e3:
                break
            if hypot(*step) < 1e-13:
                rate = np.array([row.rate for row in e.rows])
                return q, v - (inverse @ (rate / rows)) * self.sizes
        raise ArithmeticError("Newton's method does not close the joints")


def _solved(matrix: Any, right: Any) -> Any:
    """The solution, improved once in extended precision."""
    x = np.linalg.solve(matrix, right)
    long = matrix.astype(np.longdouble)
    for _ in range(2):
        rest = right.astype(np.longdouble) - long @ x.astype(np.longdouble)
        x = x + np.linalg.solve(matrix, rest.astype(float))
    return x
