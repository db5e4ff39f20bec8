"""The motions that meet in a singular position of a driven machine.

At a bifurcation Phi_q has lost one row and one direction n. The velocity is v_p + c n, and the
missing equation is the one that the accelerations must obey to exist: l gamma(v) = 0 with l from
l Phi_q = 0. It is quadratic in c: two branches, one, or none.
"""

import numpy as np

from runtime.analyses.equations import Equations, FloatArray

_LOST = 1e-5  # singular value, rows and coordinates scaled, below which a direction is lost
_SOLVED = 1e-6


def branches(
    equations: Equations, t: float, q: FloatArray, wished: FloatArray, scale: FloatArray
) -> list[tuple[FloatArray, FloatArray]]:
    """Velocities and accelerations of the branches at q, nearest to the wished velocities first.

    Where two are equally near, none is given: nothing says which is meant.
    """
    matrix = equations.jacobian(t, q) * scale
    lengths = np.linalg.norm(matrix, axis=1)
    matrix = matrix / lengths[:, None]
    left, values, right = np.linalg.svd(matrix)
    if int((values < _LOST).sum()) != 1 or matrix.shape[0] != matrix.shape[1]:
        return []
    inverse = np.linalg.pinv(matrix, rcond=_LOST)
    nu = equations.velocity_rhs(t, q) / lengths
    base = wished / scale
    base = base - inverse @ (matrix @ base - nu)
    speed = max(float(np.abs(base).max()), 1e-300)
    if abs(float(left[:, -1] @ nu)) > _SOLVED * speed:
        return []
    free = right[-1] * speed

    def lack(c: float) -> float:
        gamma = equations.acceleration_rhs(t, q, (base + c * free) * scale) / lengths
        return float(left[:, -1] @ gamma) / speed**2

    at = lack(-1.0), lack(0.0), lack(1.0)
    square, slope = 0.5 * (at[0] + at[2]) - at[1], 0.5 * (at[2] - at[0])
    size = max(abs(square), abs(slope), abs(at[1]))
    if size <= 1e-9:
        return []
    roots = np.roots([square, slope, at[1]] if abs(square) > 1e-9 * size else [slope, at[1]])
    real = sorted((float(c.real) for c in roots if abs(c.imag) <= 1e-6), key=abs)
    if len(real) == 2 and abs(abs(real[0]) - abs(real[1])) <= 1e-6 < abs(real[0] - real[1]):
        return []
    found = []
    for c in real:
        v = (base + c * free) * scale
        gamma = equations.acceleration_rhs(t, q, v) / lengths
        found.append((v, (inverse @ gamma) * scale))
    return found
