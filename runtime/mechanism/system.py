"""A scene's kernels, and their exact derivatives, as systems that the integrator takes.

There is one in all coordinates, and one in the reduced ones: those that no constraint gives
explicitly. Angles that these leave out are given by sine and cosine: they are followed through
whole turns.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from types import ModuleType
from typing import NamedTuple

import numpy as np
from numba import types

from runtime.core.arrays import Integers, Kernel, Matrix, Vector, f8, integers, matrix, none, vector
from runtime.core.jit import ADDRESSES, addresses, allocating, at
from runtime.core.kernel_abi import Kernels, gather
from runtime.core.kinds import PeakKind
from runtime.core.system import System
from runtime.mechanism.module_tables import Description

_expand = at(types.FunctionType(none(f8, *[vector] * 6)), 0)
# measured: rad, or part of a length's size, between two positions at which angles are followed
_STRIDE = 0.5
_FAR = 1.0  # safety: rad; largest change of an angle from one position to the next
_FINEST = 1e-4  # safety: part of a stride; no shorter ones are tried
_TURN = 2.0 * np.pi


@allocating(
    none(ADDRESSES, integers, f8, *[vector] * 3, matrix, matrix, vector, vector, matrix, matrix)
)
def follow(
    table: Integers, angles: Integers, t_first: float, first: Vector, here: Vector, t: Vector,
    q: Matrix, v: Matrix, p: Vector, sizes: Vector, all_q: Matrix, all_v: Matrix,
) -> None:  # fmt: skip
    """Fill `all_q` and `all_v` by the `expand` in `table`; `here`, where the walk stands, moves."""
    expand = _expand(table)
    count, n = angles.size, here.size
    turns, none = np.zeros(count), np.zeros(count)
    at, still = np.zeros(n), np.zeros(n)
    place, rate = np.zeros(first.size), np.zeros(first.size)
    followed, moved = np.zeros(count), np.zeros(count)
    for i in range(count):
        followed[i] = first[angles[i]]
    now = t_first
    for sample in range(t.size):
        way = 0.0
        for j in range(n):
            way = max(way, abs(q[sample, j] - here[j]) / sizes[j])
        longest = min(1.0, _STRIDE / way) if way > 0.0 else 1.0
        x, step = 0.0, longest
        while count > 0 and x < 1.0:
            end = 1.0 if x + 1.001 * step >= 1.0 else x + step
            for j in range(n):
                at[j] = here[j] + end * (q[sample, j] - here[j])
            expand(now + end * (t[sample] - now), at, still, p, none, place, rate)
            farthest = 0.0
            for i in range(count):
                apart = place[angles[i]] - followed[i]
                moved[i] = apart - _TURN * np.round(apart / _TURN)
                farthest = max(farthest, abs(moved[i]))
            if farthest > _FAR and step > _FINEST * longest:
                step *= 0.5
                continue
            for i in range(count):
                if np.isfinite(moved[i]):
                    followed[i] += moved[i]
                    turns[i] = np.round((followed[i] - place[angles[i]]) / _TURN)
            x = end
            step = min(2.0 * step, longest)
        expand(t[sample], q[sample], v[sample], p, turns, all_q[sample], all_v[sample])
        for j in range(n):
            here[j] = q[sample, j]
        now = t[sample]


class Tangents(NamedTuple):
    """The compiled derivatives of a scene, along one direction (dq, dv) a call."""

    # (t, q, v, p, modes, dq, dv, da): da = (∂a/∂q) dq + (∂a/∂v) dv of what `accelerations` returns,
    # the modes fixed. All of q, v, dq, dv, da have shape (n,), SI units.
    accelerations_tangent: Kernel
    # (t, q, v, p, w, dq_in, dv_in, dq, dv): the same for both answers of `correction`. At a state
    # on the constraints, with w = 0 on the independent coordinates: e_k plus dq along (e_k, 0) is
    # the column H e_k of δq = H δq_independent, in which the dependent rows are -Φ_u⁻¹ Φ_v (R. A.
    # Wehage and E. J. Haug, Journal of Mechanical Design 104, 1982, 247-255); dv along (H e_k, 0)
    # is what that does to the dependent velocities.
    correction_tangent: Kernel


def gather_tangents(module: ModuleType) -> Tangents:
    """Take the derivatives out of a loaded module that has them."""
    return Tangents(*(getattr(module, name) for name in Tangents._fields))


def common_system(
    description: Description, kernels: Kernels, rows: Integers, columns: Integers, n: int, m: int,
    behind: int,
) -> System:  # fmt: skip
    """The entries common to all formulations; `rows`, `columns`: of the Jacobian's non-zeros.

    Shares stand in p from the place `behind` on.
    """
    sampled = description.sampled
    return System(
        **vars(kernels),
        jacobian_rows=rows,
        jacobian_columns=columns,
        coordinates=n,
        constraint_count=m,
        switches=len(description.switches),
        rigid=tuple(contact.switch for contact in description.rigid),
        sticking=tuple(k for k, row in enumerate(description.switches) if row.sticks),
        one_way=tuple(k for k, row in enumerate(description.switches) if row.one_way),
        boundaries=tuple(description.boundaries.tolist()),
        shares=tuple((k, behind + i) for i, k in enumerate(description.shares)),
        superposes=description.superposes,
        table_parts=description.table_parts,
        turning=tuple(first for _, first in description.turning),
        states=description.state_columns,
        sampled=description.sampled_columns,
        sampled_names=sampled,
        triggers=description.triggers or (-1,) * len(sampled),
        watches=tuple(
            0 if row.action == "sample" else 1 + row.reconnects for row in description.watched
        ),
        controllers=tuple(map(sampled.index, description.controllers)),
        peaks=tuple((PeakKind[row[1].upper()], row[2]) for row in description.peaks),
    )


class Reduced:
    """The compiled equations and the tables of a loaded module in reduced coordinates."""

    expand: Kernel
    """(t, q, v, p, turns, all_q, all_v): all coordinates, with so many whole turns of `angles`."""
    sides: Kernel
    """(t, all_q, p, out): a number for each of `branches`, whose sign is that of the branch."""
    dead_centres: Kernel
    reduced_mass: Kernel
    """(t, q, p, values): structural non-zeros of M_r."""

    def __init__(self, module: ModuleType, description: Description) -> None:
        def indices(*names: str) -> Iterator[Integers]:
            return (np.array(getattr(module, name), dtype=np.int64) for name in names)

        self.description, self.kernels = description, gather(module)
        self.tangents = gather_tangents(module)
        self.expand, self.sides = module.expand, module.branches
        self.dead_centres, self.reduced_mass = module.dead_centres, module.reduced_mass
        # columns of the coordinates that are integrated, and of the angles in closed form
        self.kept, self.angles = indices("KEPT", "ANGLES")
        rows, columns = indices("JACOBIAN_ROWS", "JACOBIAN_COLUMNS")
        self.jacobian = rows, columns
        self.mass = tuple(indices("MASS_ROWS", "MASS_COLUMNS"))
        # rows of the constraints between coordinates that are integrated
        self.closures: tuple[int, ...] = tuple(module.CLOSURES)
        # (column, row of the loop) of the angles in closed form with a branch
        self.branches: tuple[tuple[int, int], ...] = tuple(module.BRANCHES)
        # length of ``p``: parameters, branches, constants
        self.slots = len(description.parameters) + len(self.branches) + len(module.CONSTANTS)

    @cached_property
    def system(self) -> System:
        """The reduced equations, as the integrator takes them."""
        n, m, places = len(self.kept), len(self.closures), self.kept.tolist()
        behind = len(self.description.parameters) + len(self.branches)
        whole = (k for _, k in self.description.turning if {*range(k, k + 4)} <= {*places})
        return replace(
            common_system(self.description, self.kernels, *self.jacobian, n, m, behind),
            dead_centres=self.dead_centres,
            loops=len(self.branches),
            turning=tuple(map(places.index, whole)),
            states=tuple(map(places.index, self.description.state_columns)),
            sampled=tuple(map(places.index, self.description.sampled_columns)),
            **self.tangents._asdict(),
        )

    def row(self, index: int) -> int:
        """The machine's constraint that `index` of an outcome or a crossing means."""
        m = len(self.closures)
        return self.closures[index] if 0 <= index < m else index - m

    def parameters(self, p: Vector, t: float, q: Vector) -> Vector:
        """``p`` of these kernels, with the branches on which the machine stands at (t, q).

        `p` is that of the machine, q has all coordinates, (n,).
        """
        declared, count = len(self.description.parameters), len(self.branches)
        values, sides = np.zeros(self.slots), np.zeros(count)
        values[:declared] = p[:declared]
        values[declared : declared + count] = 1.0
        self.kernels.constants(values)
        self.sides(t, np.ascontiguousarray(q), values, sides)
        values[declared : declared + count] = np.where(sides < 0.0, -1.0, 1.0)
        self.kernels.constants(values)
        return values

    def inertia(self, t: float, q: Vector, p: Vector) -> Matrix:
        """M_r, (f, f), by the kept coordinates, (f,)."""
        values, mass = np.zeros(len(self.mass[0])), np.zeros((len(q), len(q)))
        self.reduced_mass(t, q, p, values)
        mass[self.mass] = values
        return mass

    def squares(self, t: float, q: Vector, v: Vector, p: Vector) -> tuple[Vector, Vector, Vector]:
        """ρ² of each of `branches` at a state in all coordinates, its rate, and its bound.

        ρ² vanishes at a dead centre. `p` is that of the machine; q and v have shape (n,).
        """
        out = np.zeros(3 * len(self.branches))
        place = self.parameters(p, t, q)
        self.dead_centres(t, q[self.kept], v[self.kept], place, out)
        return out[::3], out[1::3], out[2::3]

    def expanded(
        self, t: Vector, q: Matrix, v: Matrix, p: Vector,
        start: tuple[float, Vector], sizes: Vector,
    ) -> tuple[Matrix, Matrix]:  # fmt: skip
        """All coordinates and velocities, (k, n) each, at k instants in order.

        Angles in closed form are followed from the start, an instant and all coordinates (n,),
        along straight lines from one instant to the next. q and v, (k, f), are of the kept
        coordinates, as are their typical `sizes`, (f,).
        """
        all_q, all_v = np.zeros((2, len(t), len(self.description.coordinates)))
        t_first, first = start
        arrays = first, first[self.kept], t, q, v, p, sizes, all_q, all_v
        table = addresses([self.expand])
        follow(table, self.angles, t_first, *map(np.ascontiguousarray, arrays))
        return all_q, all_v
