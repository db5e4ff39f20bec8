"""Angular velocities among the start values: ω' of bodies in space, as linear rows of the start.

At an assembled position 2 G ṗ = ω' is linear in velocities, as Φ_q v = ν is.
"""

from typing import NamedTuple

import numpy as np

from codegen.errors import AssemblyError
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.spins import matrix_g

_MET = 1e-9  # accuracy: scaled gap of a row that is met, relative to the largest velocity


class Spin(NamedTuple):
    """A component of ω' that holds at the start."""

    name: str
    first: int  # column of the body's e0
    axis: int
    value: float  # rad/s


def with_spins(
    equations: Equations, t: float, q: FloatArray, v: FloatArray, scale: FloatArray,
    fixed: np.ndarray[tuple[int], np.dtype[np.bool_]], given: tuple[Spin, ...],
) -> FloatArray:  # fmt: skip
    """Velocities, (n,), moved as little as joints, drivers and the given ω' allow.

    Those that are `fixed`, (n,), keep their values. Raises AssemblyError where that cannot be.
    """
    rows = np.zeros((len(given), len(q)))
    for row, spin in zip(rows, given, strict=True):
        p = slice(spin.first, spin.first + 4)
        row[p] = 2.0 * matrix_g(q[p])[spin.axis]
    matrix = np.vstack([equations.jacobian(t, q), rows])
    right = np.array([*equations.velocity_rhs(t, q), *(spin.value for spin in given)])
    v, scaled = v.copy(), matrix * scale
    unit = np.abs(scaled).max(axis=1, initial=1.0)  # a row about to vanish stays short
    matrix_in_units = scaled[:, ~fixed] / unit[:, None]
    for _ in range(2):
        step = np.linalg.lstsq(matrix_in_units, (right - matrix @ v) / unit, rcond=1e-12)[0]
        v[~fixed] += scale[~fixed] * step
    gaps = np.abs(matrix @ v - right)
    most = _MET * max(1.0, float(np.abs(right).max(initial=0.0)))
    if gaps.max(initial=0.0) <= most:
        return v
    reached, missed = rows @ v, gaps[-len(given) :] > most
    text = ", ".join(
        f"{spin.name} = {spin.value:.6g} rad/s, where {x:.6g} is nearest"
        for spin, x, told in zip(given, reached.tolist(), missed | ~missed.any(), strict=True)
        if told
    )
    held = zip(equations.description.coordinates, v.tolist(), fixed.tolist(), strict=True)
    others = [f"{row.velocity} = {x:.6g} {row.velocity_unit}" for row, x, kept in held if kept]
    raise AssemblyError(
        f"{equations.description.title}: angular velocities contradict the joints, drivers or "
        f"other start velocities at t = {t:g} s: {text}{'; fixed are ' * bool(others)}"
        f"{', '.join(others)}. Leave those out that follow from others."
    )
