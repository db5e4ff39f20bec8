"""The constraints and their Jacobian by scaled coordinates and time."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from runtime.core.arrays import Integers, Matrix, Vector
from runtime.core.jit import addresses
from runtime.linalg.least_norm import SPARSE_FROM
from runtime.singularity import search_function_table as st

SHORTEST = 0.1  # safety: of a row's longest length; no unit row, since it may vanish

Kernel = Callable[..., Any]


class Layout(NamedTuple):
    """A table, and the arrays by name whose addresses it holds."""

    table: Integers
    arrays: dict[str, Any]


@dataclass
class ScaledConstraints:
    """The constraints of a machine with each coordinate in units of its `scale`."""

    constraints: Kernel
    jacobian: Kernel
    velocity_rhs: Kernel
    rows: Integers  # (nnz,), as `columns`: where the values of `jacobian` belong
    columns: Integers
    p: Vector  # parameters
    scale: Vector  # (n,), typical size of a change of each coordinate
    independent: Integers  # constraints none of which follows from the others everywhere
    m: int  # number of constraints
    shortest: Vector | None = None  # (m,): rows shorter than that count as so long; none if None

    @property
    def is_large(self) -> bool:
        """Whether sparse factors take less than dense ones."""
        return self.scale.size >= SPARSE_FROM

    @cached_property
    def layout(self) -> Layout:
        """The table by which compiled searches reach these arrays and kernels."""
        (at_row, at_column), layout, n = self.places, st.TABLE, self.scale.size
        table = np.zeros(layout.size, np.int64)
        first = layout.slots["constraints"]
        table[first : first + 3] = addresses((self.constraints, self.jacobian, self.velocity_rhs))
        table[st.COORDINATES], table[st.UNKNOWNS], table[st.CONSTRAINT_COUNT] = n, n + 1, self.m
        table[st.ROWS], table[st.PARAMETER_COUNT] = self.independent.size, self.p.size
        table[st.DENSE_ROWS] = 0 if self.is_large else self.independent.size
        table[st.NONZEROS], table[st.ENTRIES] = self.rows.size, at_row.size
        arrays = layout.allot(table)
        reals = {"parameters": self.p, "scale": self.scale}
        numbers = {"independent": self.independent}
        numbers |= {"entry_rows": at_row, "entry_columns": at_column}
        for kind, given in ((np.float64, reals), (np.int64, numbers)):
            for name, array in given.items():
                arrays[name] = np.ascontiguousarray(array, dtype=kind)
                table[layout.slots[name]] = arrays[name].ctypes.data
        arrays["lengths"][:], arrays["speed"][:] = 1.0, 1.0
        if self.shortest is not None:
            arrays["shortest"][:] = self.shortest[self.independent]
        for name in ("row_order", "row_place", "column_order", "column_place"):
            arrays[name][:] = np.arange(arrays[name].size)
        return Layout(table, arrays)

    def entries(self, t: float, q: Vector, unit: float) -> Vector:
        """Non-zeros of Φ_q, columns scaled, then Φ_t times `unit`; at `places`, (nnz + m,)."""
        values = np.zeros(self.rows.size + self.m)
        rate = values[self.rows.size :]
        self.jacobian(t, q, self.p, values[: self.rows.size])
        values[: self.rows.size] *= self.scale[self.columns]
        self.velocity_rhs(t, q, self.p, rate)
        rate *= -unit
        return values

    @cached_property
    def places(self) -> tuple[Integers, Integers]:
        """Rows and columns of `entries`; dependent rows are set aside behind the others."""
        order = np.full(self.m, self.independent.size)
        order[self.independent] = np.arange(self.independent.size)
        rows = np.append(self.rows, np.arange(self.m))
        columns = np.append(self.columns, np.full(self.m, self.scale.size))
        return order[rows], columns

    def dense(self, entries: Vector) -> Matrix:
        """The matrix of `entries`, independent rows only, shape (m', n + 1)."""
        matrix = np.zeros((self.independent.size + 1, self.scale.size + 1))
        matrix[self.places] = entries
        return matrix[:-1]

    def least_lengths(self, t: float, q: Vector, sizes: Vector, drivers: Any) -> Vector:
        """Lengths, (m,), below which rows of `drivers`, (m,), are no unit rows; of joints 0.

        Poses away from q by about `sizes` tell how long rows are: one may vanish at a start.
        """
        squares = np.zeros(self.m)
        away = 0.3 * sizes * np.random.default_rng(2).normal(size=(2, self.scale.size))
        for pose in (q + away) if drivers.any() else ():
            found = np.nan_to_num(self.entries(t, pose, 0.0)[: self.rows.size] ** 2, posinf=0.0)
            squares = np.maximum(squares, np.bincount(self.rows, found, minlength=self.m))
        least: Vector = SHORTEST * np.sqrt(squares) * drivers
        return least

    def weakest(self, t: float, q: Vector) -> tuple[Vector, float, Vector]:
        """Left vector u and size of the least singular value of Φ_q, and ν; of unit rows, (m',).

        The size is not a number where an entry is none.
        """
        matrix = self.dense(self.entries(t, q, 1.0))
        if not np.isfinite(matrix).all():
            return matrix[:, 0], np.nan, matrix[:, -1]
        lengths = np.linalg.norm(matrix[:, :-1], axis=1)
        matrix /= np.where(lengths > 0.0, lengths, 1.0)[:, None]
        left, values, _ = np.linalg.svd(matrix[:, :-1])
        return left[:, -1], float(values[-1]), -matrix[:, -1]

    def gaps(self, t: float, q: Vector) -> Vector:
        """Φ, shape (m',)."""
        phi = np.zeros(self.m)
        self.constraints(t, q, self.p, phi)
        return phi[self.independent]
