"""The equations of a scene in reduced coordinates: those that no constraint gives explicitly."""

from dataclasses import dataclass, replace
from functools import cached_property
from types import ModuleType

import numpy as np

from runtime.core import kernel_abi as kernels
from runtime.core.arrays import Integers, Kernel, Matrix, Vector
from runtime.core.jit import addresses
from runtime.core.system import System
from runtime.mechanism.module_tables import Description
from runtime.mechanism.system import Tangents, common_system, gather_tangents


@dataclass(frozen=True, eq=False)
class Reduced:
    """The compiled equations and their tables."""

    description: Description
    kernels: kernels.Kernels
    tangents: Tangents
    # (t, q, v, p, turns, all_q, all_v): all coordinates, with so many whole turns of `angles`
    expand: Kernel
    # (t, all_q, p, out): a number for each of `branches`, whose sign is that of the branch
    sides: Kernel
    dead_centres: Kernel
    reduced_mass: Kernel  # (t, q, p, values): structural non-zeros of M_r
    kept: Integers  # columns of the coordinates that are integrated
    closures: tuple[int, ...]  # rows of the constraints between them
    angles: Integers  # columns of the angles in closed form
    branches: tuple[tuple[int, int], ...]  # (column, row of the loop) of those angles with a branch
    jacobian: tuple[Integers, Integers]
    mass: tuple[Integers, Integers]
    slots: int  # length of ``p``: parameters, branches, constants

    @cached_property
    def system(self) -> System:
        """The reduced equations, as the integrator takes them."""
        n, m, places = len(self.kept), len(self.closures), self.kept.tolist()
        behind = len(self.description.parameters) + len(self.branches)
        return replace(
            common_system(self.description, self.kernels, *self.jacobian, n, m),
            dead_centres=self.dead_centres,
            loops=len(self.branches),
            states=tuple(map(places.index, self.description.state_columns)),
            sampled=tuple(map(places.index, self.description.sampled_columns)),
            shares=tuple((k, behind + i) for i, k in enumerate(self.description.shares)),
            superposes=self.description.superposes,
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
        from runtime.mechanism.angle_unwrapping import follow  # compiles where it is used

        all_q, all_v = np.zeros((2, len(t), len(self.description.coordinates)))
        t_first, first = start
        arrays = first, first[self.kept], t, q, v, p, sizes, all_q, all_v
        table = addresses([self.expand])
        follow(table, self.angles, t_first, *map(np.ascontiguousarray, arrays))
        return all_q, all_v


def gather_reduced(module: ModuleType, description: Description) -> Reduced:
    """Take the equations out of a loaded module."""
    names = ["KEPT", "ANGLES", "JACOBIAN_ROWS", "JACOBIAN_COLUMNS", "MASS_ROWS", "MASS_COLUMNS"]
    indices = (np.array(getattr(module, name), dtype=np.int64) for name in names)
    kept, angles, rows, columns, mass_rows, mass_columns = indices
    return Reduced(
        description=description, kernels=kernels.gather(module), tangents=gather_tangents(module),
        expand=module.expand, sides=module.branches, dead_centres=module.dead_centres,
        reduced_mass=module.reduced_mass, kept=kept,
        closures=tuple(module.CLOSURES), angles=angles, branches=tuple(module.BRANCHES),
        jacobian=(rows, columns), mass=(mass_rows, mass_columns),
        slots=len(description.parameters) + len(module.BRANCHES) + len(module.CONSTANTS)
        + getattr(module, "WORKSPACE", 0),
    )  # fmt: skip
