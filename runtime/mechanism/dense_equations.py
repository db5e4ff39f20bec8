"""The equations of a machine at one instant, for analyses of few positions; impacts of its joints.

Matrices are dense, but that of the constraints' derivatives is also there as its non-zeros, which
is the form for machines of many coordinates. Contacts that are closed and freewheels, which only
push, take part in an impact.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.core.arrays import Kernel
from runtime.core.kinds import MIXED, SLIDING
from runtime.linalg.least_norm import SPARSE_FROM
from runtime.linalg.unit_euler_parameters import normalise
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.table_rows import MASS_LAW
from runtime.mechanism.typical_sizes import StartTable, measure, measure_rows, start_table
from runtime.singularity.scaled_constraints import ScaledConstraints

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

KEPT = 1e-13  # accuracy: of a function's size; joints that keep it at zero keep it so closely


class Equations:
    """Kernels of a machine with its parameter values bound."""

    def __init__(self, mechanism: Mechanism, p: FloatArray) -> None:
        self.mechanism, self.description, self.p = mechanism, mechanism.description, p
        self.kernels, self.table = mechanism.kernels, mechanism.kernel_table
        self.independent = np.array(mechanism.independent, dtype=np.int64)
        self.boundaries = self.description.boundaries
        self.bands = np.zeros(len(self.boundaries))  # of g about zero, see `widen_bands`
        self.n, self.m = len(self.description.coordinates), len(self.description.constraints)
        self.still = np.zeros(self.n)  # velocities at rest: zero, but for states of first order
        rows, names = enumerate(self.description.constraints), self.description.coordinates.names
        self.mass_laws = [(i, names.index(row.name)) for i, row in rows if row.kind == MASS_LAW]
        self.is_large = self.n >= SPARSE_FROM  # so that sparse factors take less than dense ones

    @cached_property
    def start(self) -> StartTable:
        """Room in which compiled code assembles and measures."""
        return start_table(self.mechanism)

    @property
    def whole(self) -> "Equations":
        """The equations with all constraints, also those that follow from others."""
        whole = self.mechanism.whole
        return self if whole is None else Equations(whole, self.p)

    def scaled(self, scale: FloatArray, independent: IntArray) -> ScaledConstraints:
        """The constraints in units of `scale`, of which `independent` follow from no others."""
        kernels, rows = self.kernels, self.description.jacobian_rows
        columns = self.description.jacobian_columns
        functions = kernels.constraints, kernels.jacobian, kernels.velocity_rhs
        return ScaledConstraints(*functions, rows, columns, self.p, scale, independent, self.m)

    def constraints(self, t: float, q: FloatArray) -> FloatArray:
        """Φ(q, t), shape (m,)."""
        return _filled(self.m, self.kernels.constraints, t, q, self.p)

    def jacobian(self, t: float, q: FloatArray) -> FloatArray:
        """Φ_q, shape (m, n)."""
        return self._dense(self.slopes(t, q))

    def _dense(self, slopes: FloatArray) -> FloatArray:
        matrix = np.zeros((self.m, self.n))
        matrix[self.description.jacobian_rows, self.description.jacobian_columns] = slopes
        return matrix

    def slopes(self, t: float, q: FloatArray) -> FloatArray:
        """The structural non-zeros of Φ_q, shape (nnz,), at the places of the description."""
        return _filled(len(self.description.jacobian_rows), self.kernels.jacobian, t, q, self.p)

    def matrix_of(self, slopes: FloatArray) -> FloatArray | Any:
        """Φ_q of these non-zeros, (nnz,), shape (m, n): dense, of a large machine sparse."""
        return self.sparse_jacobian(slopes) if self.is_large else self._dense(slopes)

    def sparse_jacobian(self, slopes: FloatArray) -> Any:
        """Φ_q of these non-zeros, (nnz,), as SciPy's sparse matrix by rows, shape (m, n)."""
        from scipy.sparse import csr_array  # small machines load none of it

        rows, columns = self.description.jacobian_rows, self.description.jacobian_columns
        return csr_array((slopes, (rows, columns)), shape=(self.m, self.n))

    def velocity_rhs(self, t: float, q: FloatArray) -> FloatArray:
        """ν = -Φ_t, shape (m,)."""
        return _filled(self.m, self.kernels.velocity_rhs, t, q, self.p)

    @property
    def is_scleronomic(self) -> bool:
        """Whether no constraint depends on time: ν has no operations, and is zero always."""
        still = not dict(self.description.operations).get("velocity_rhs")
        zeros, ones = np.zeros(self.n), np.ones(len(self.p))
        return still and not _filled(self.m, self.kernels.velocity_rhs, 1.0, zeros, ones).any()

    def acceleration_rhs(self, t: float, q: FloatArray, v: FloatArray) -> FloatArray:
        """γ, shape (m,)."""
        return _filled(self.m, self.kernels.acceleration_rhs, t, q, v, self.p)

    def mass(self, q: FloatArray) -> FloatArray:
        """M, shape (n, n)."""
        rows, columns = self.description.mass_rows, self.description.mass_columns
        matrix = np.zeros((self.n, self.n))
        matrix[rows, columns] = _filled(len(rows), self.kernels.mass, q, self.p)
        return matrix

    def masses(self, q: FloatArray) -> FloatArray:
        """The diagonal of M, shape (n,)."""
        rows, columns = self.description.mass_rows, self.description.mass_columns
        values, diagonal = _filled(len(rows), self.kernels.mass, q, self.p), np.zeros(self.n)
        diagonal[rows[rows == columns]] = values[rows == columns]
        return diagonal

    def forces(self, t: float, q: FloatArray, v: FloatArray, modes: IntArray) -> FloatArray:
        """Q, shape (n,); of a condition in mode 2 the mean of both sides, here as below."""
        kernel = self.kernels.applied_forces
        return self._mean_of_sides(modes, lambda m: _filled(self.n, kernel, t, q, v, self.p, m))

    def _mean_of_sides(
        self, modes: IntArray, values: Callable[[IntArray], FloatArray]
    ) -> FloatArray:
        """Values by modes 0 and 1; of a balanced condition in mode 2 the mean of those of both."""
        balanced = (modes == SLIDING) & (self.boundaries != MIXED)
        plain = np.where(balanced, 0, modes)
        base = total = values(plain)
        for k in np.flatnonzero(balanced):
            plain[k] = 1
            total = total + 0.5 * (values(plain) - base)
            plain[k] = 0
        return total

    def potential(self, t: float, q: FloatArray, modes: IntArray) -> float:
        """V in J."""
        kernel = self.kernels.potential
        return float(self._mean_of_sides(modes, lambda m: np.array(kernel(t, q, self.p, m))))

    def potential_gradient(self, t: float, q: FloatArray, modes: IntArray) -> FloatArray:
        """∂V/∂q, shape (n,)."""
        kernel = self.kernels.potential_gradient
        return self._mean_of_sides(modes, lambda m: _filled(self.n, kernel, t, q, self.p, m))

    def motion(
        self, t: float, q: FloatArray, v: FloatArray, modes: IntArray
    ) -> tuple[FloatArray, FloatArray, int]:
        """Accelerations, multipliers, and 1 + the constraint whose pivot is weak, or 0."""
        a, lam = np.zeros(self.n), np.zeros(self.m)
        return a, lam, int(self.kernels.accelerations(t, q, v, self.p, modes, a, lam))

    def at_rest(self, t: float, q: FloatArray) -> FloatArray:
        """Velocities at rest, (n,): `still`, and of masses the rates by their laws."""
        for i, k in self.mass_laws * len(self.mass_laws):  # a law may have the mass of another
            self.still[k] += (self.velocity_rhs(t, q) - self.jacobian(t, q) @ self.still)[i]
        return self.still

    def rest_modes(self, t: float, q: FloatArray) -> IntArray:
        """Modes at rest, shape (s,); a condition at its boundary has the mode that is given there.

        That is 2 of a balanced one, and of mixed ones, which kernels know at rest.
        """
        g = self.switching(t, q, self.still)
        modes: IntArray = np.where(
            np.abs(g) <= self.bands, np.minimum(self.boundaries, SLIDING), g > 0.0
        )
        return modes.astype(np.int64)

    def widen_bands(self, t: float, q: FloatArray, scale: FloatArray) -> None:
        """Let functions be zero at rest that joints keep at zero to rounding, near q.

        It is a part of what they change by when all coordinates change by `scale`.
        """
        if self.m == 0 or len(self.bands) == 0:
            return
        rates, count, still = self.kernels.switching_rates, len(self.bands), np.zeros(self.n)
        rest = _filled(count, rates, t, q, still, still, self.p)
        slopes = [_filled(count, rates, t, q, v, still, self.p) - rest for v in np.diag(scale)]
        self.bands = KEPT * np.nan_to_num(np.abs(slopes)).sum(axis=0)

    def switching(self, t: float, q: FloatArray, v: FloatArray) -> FloatArray:
        """g, shape (s,)."""
        return _filled(len(self.description.switches), self.kernels.switching, t, q, v, self.p)

    def reactions(
        self, t: float, q: FloatArray, v: FloatArray, lam: FloatArray, modes: IntArray
    ) -> FloatArray:
        """Rows of REACTIONS for given multipliers."""
        out = _filled(len(self.description.reactions), self.kernels.reactions, t, q, v, self.p, lam)
        self.kernels.switched_reactions(t, q, v, self.p, modes, lam, out)
        return out

    def row_units(self, slopes: FloatArray) -> list[str]:
        """Unit of each constraint: m² of links, m of other lengths, else of its coordinates."""
        units = [row.unit for row in self.description.coordinates]
        found: list[set[str]] = [set() for _ in range(self.m)]
        rows, columns = self.description.jacobian_rows, self.description.jacobian_columns
        for e in np.flatnonzero(slopes != 0.0):
            found[rows[e]].add(units[columns[e]])
        return [
            "m^2" if row.kind in ("distance", "revolute-revolute")
            else "m" if "m" in of or not of else of.pop() if len(of) == 1 else "1"
            for row, of in zip(self.description.constraints, found, strict=True)
        ]  # fmt: skip

    def size(self, t: float, q: FloatArray) -> float:
        """A length typical of the mechanism, in m, from how angles enter lengths; 1 if none do."""
        return self._measured(t, q, 0)

    def length(self, t: float, q: FloatArray) -> float:
        """The length to which tolerances are relative, in m; see `magnitudes`."""
        return self._measured(t, q, 1)

    def _measured(self, t: float, q: FloatArray, question: int) -> float:
        return float(measure(self.start.table, t, np.ascontiguousarray(q), self.p, question))

    def row_scale(self, t: float, q: FloatArray, size: float) -> FloatArray:
        """Typical change of each constraint, (m,): `size` for lengths, else 1.

        A row whose slopes are far from that, such as the square of a length, is measured by them.
        """
        measure_rows(self.start.table, t, np.ascontiguousarray(q), self.p, size)
        scale: FloatArray = self.start.arrays["row_scale"].copy()
        return scale

    def turned(self, q: FloatArray) -> FloatArray:
        """Poses with every angle of q turned by half a radian or so, each by another, (2, n)."""
        turned: FloatArray = q + self.mechanism.shape["turns"]
        normalise(turned, self.mechanism.shape["turning"])
        return turned

    def impact(self, t: float, q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Velocities behind an impact of all constraints, (n,), and its impulses Λ, (m,).

        M Δv + Φ_qᵀ Λ = 0, Φ_q (v + Δv) = ν.
        """
        whole = self.whole
        gap = whole.velocity_rhs(t, q) - whole.jacobian(t, q) @ v
        change, multipliers = self.responses(t, q, np.zeros((self.n, 1)), gap[:, None])
        return v + change[:, 0], multipliers[:, 0]

    def responses(
        self, t: float, q: FloatArray, impulses: FloatArray, jumps: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Changes of velocities, (n, k), and impulses Λ, (m, k), by k impulses with jumps of Φ_q v.

        M Δv + Φ_qᵀ Λ = `impulses`, (n, k), Φ_q Δv = `jumps`, (m, k), in units in which every
        coordinate has the inertia 1 and every row of Φ_q the length 1.
        """
        jacobian, mass = self.whole.jacobian(t, q), self.mass(q)
        diagonal = np.diag(mass)
        unit = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        rows = jacobian * unit
        size = np.linalg.norm(rows, axis=1)
        row_unit = 1.0 / np.where(size > 0.0, size, 1.0)
        rows *= row_unit[:, None]
        none = np.zeros((len(rows), len(rows)))
        matrix = np.block([[mass * np.outer(unit, unit), rows.T], [rows, none]])
        right = np.vstack([unit[:, None] * impulses, row_unit[:, None] * jumps])
        change = np.linalg.lstsq(matrix, right, rcond=None)[0]
        return unit[:, None] * change[: self.n], row_unit[:, None] * change[self.n :]

    def scale(self, size: float) -> FloatArray:
        """Typical changes of coordinates, (n,): `size` for lengths, 1 for angles, a state's own."""
        shape = self.mechanism.shape
        typical: FloatArray = np.where(shape["scaled_by_length"] != 0, size, shape["typical"])
        return typical


def _filled(count: int, kernel: Kernel, *arguments: Any) -> FloatArray:
    """The numbers that a kernel writes into its last argument, shape (count,)."""
    out = np.zeros(count)
    kernel(*arguments, out)
    return out


def magnitudes(equations: Equations, t: float, q: FloatArray) -> FloatArray:
    """Typical size of each coordinate at an assembled position q, in its unit; both (n,).

    Angles and numbers have size 1. Lengths have that of the mechanism: its longest arm; where no
    angle enters a length, the largest distance from the origin at the start; where that is zero
    too, the largest length in the constraints, then among the parameters, and 1 m where there is
    none.
    """
    return equations.scale(equations.length(t, q))


def row_lengths(matrix: FloatArray) -> FloatArray:
    """Lengths of the rows of a matrix, (m,); 1 of an empty one."""
    lengths = np.linalg.norm(matrix, axis=1)
    return np.where(lengths == 0.0, 1.0, lengths)


_EXACT = 1e-12  # accuracy: of the largest rates that velocities give; slower approaches are none
_REACHED = 1e-9  # accuracy: of the same; velocities that miss their conditions by more
_SLOW = 1e-3  # safety: sizes a second; of what rests but for rounding
_TOUCHING = 1e-9  # accuracy: of the machine's lengths; a contact with a gap below it is closed


class Contradiction(Exception):  # noqa: N818 (it is caught where joints engage)
    """Joints and contacts that permit no velocities; the message names the contacts."""


def rate_rows(equations: Equations, t: float, q: FloatArray) -> FloatArray:
    """By velocities, (s, n): derivatives of slips, and of the rates of gaps."""
    start = approaches(equations, t, q, np.zeros(equations.n))
    rows = [approaches(equations, t, q, one) - start for one in np.eye(equations.n)]
    return np.array(rows).T


def approaches(equations: Equations, t: float, q: FloatArray, v: FloatArray) -> FloatArray:
    """The rates of gaps, and all other switching functions as they are, (s,)."""
    found, rate = equations.switching(t, q, v), np.zeros(len(equations.description.switches))
    rigid = list(equations.mechanism.system.rigid)
    equations.kernels.switching_rates(t, q, v, np.zeros(equations.n), equations.p, rate)
    found[rigid] = rate[rigid]
    return found


def impact(
    equations: Equations, t: float, q: FloatArray, v: FloatArray, length: float
) -> tuple[FloatArray, FloatArray, float]:
    """Velocities behind an impact, (n,), the impulses Λ of the joints, (m,), and a work, J.

    That is the work of the impulses at drivers and moving places, at the rates of these.

    M Δv + Φ_qᵀ Λ = Gᵀ P, Φ_q v⁺ = ν, P ≥ 0, G v⁺ ≥ 0, one of the two an equality, with the rates
    of gaps that are closed, by the machine's `length`, m, and the slips of freewheels. Contacts
    that approach each other in that very instant rebound, ġ⁺ ≥ -e ġ⁻. Of all velocities that the
    conditions permit these are the nearest to those that the joints alone would leave, by the
    kinetic energy of the difference: C. L. Lawson and R. J. Hanson, Solving Least Squares Problems
    (1974), chapter 23.

    Raises Contradiction where there are none, or the search for them does not end.
    """
    alone, multipliers = equations.impact(t, q, v)
    rates = equations.velocity_rhs(t, q)
    work = float(-multipliers @ rates)
    system, before = equations.mechanism.system, approaches(equations, t, q, v)
    gaps = equations.switching(t, q, v)
    contacts = [k for k in system.rigid if gaps[k] <= _TOUCHING * length]
    held = np.array([*contacts, *system.one_way], dtype=np.int64)
    if not len(held):
        return alone, multipliers, work
    restitution = np.zeros(len(system.rigid))
    equations.kernels.restitution(equations.p, restitution)
    target = np.zeros(len(before))
    target[list(system.rigid)] = -restitution * np.minimum(before[list(system.rigid)], 0.0)
    after = approaches(equations, t, q, alone)
    missing = (target - after)[held]
    rows, scale = rate_rows(equations, t, q)[held], equations.scale(length)
    pace = np.maximum(np.abs(v), np.abs(alone)) / scale
    pace[[row.column for row in equations.description.states]] = 0.0
    fastest = float((np.abs(rows) @ scale).max() * max(pace.max(), _SLOW))
    if missing.max() <= _EXACT * fastest:
        return alone, multipliers, work
    change, forces = equations.responses(t, q, rows.T, np.zeros((equations.m, len(held))))
    try:
        pushes = _pushes(equations.mass(q), change, rows @ change, missing)
    except RuntimeError as found:
        names = [equations.description.switches[k].name for k in held]
        raise Contradiction(f"no impulses of {' and '.join(names)} were found with it") from found
    ended, reached = alone + change @ pushes, missing - rows @ change @ pushes
    if not reached.max() <= _REACHED * fastest:
        missed = held[~(reached <= _REACHED * fastest)]
        names = [equations.description.switches[k].name for k in missed]
        raise Contradiction(f"with it the joints move {' and '.join(names)} against what holds it")
    multipliers += forces @ pushes
    moving = approaches(equations, t, q, np.zeros(equations.n))[held]
    return ended, multipliers, float(-multipliers @ rates - pushes @ moving)


def _pushes(
    mass: FloatArray, change: FloatArray, gains: FloatArray, missing: FloatArray
) -> FloatArray:
    """P ≥ 0, (k,), of the least ‖x‖ with Eᵀ x ≥ `missing`, x = E P and E = √M `change`."""
    from scipy.optimize import nnls  # other runs load none of it

    values, vectors = np.linalg.eigh(mass)
    root = vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T
    size = float(np.abs(missing).max())
    stacked = np.vstack([root @ change, missing / size])
    unit, _ = nnls(stacked, np.append(np.zeros(len(mass)), 1.0))
    rest = 1.0 - float(missing @ unit) / size
    pushes: FloatArray = size * unit / rest if rest > 0.0 else np.full(len(missing), np.nan)
    acting = np.flatnonzero(pushes > 0.0)
    exact = np.linalg.lstsq(gains[np.ix_(acting, acting)], missing[acting], rcond=None)[0]
    if (exact > 0.0).all():
        pushes[acting] = exact
    return pushes
