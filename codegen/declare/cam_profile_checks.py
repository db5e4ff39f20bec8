"""Shapes of cams: whether a profile is closed, smooth, and convex where its follower needs it."""

import math
from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt
import sympy

from codegen.declare.body import Curve
from codegen.declare.symbols import alpha
from codegen.declare.table_function import TableAtom

SAMPLES = 720  # safety: places on a profile at which its shape is looked at, every half degree
ALPHAS = tuple(2 * math.pi * k / SAMPLES for k in range(SAMPLES + 1))
# accuracy: gap, corner or stop of a profile, in parts of its size, that rounding explains
TOLERANCE = 1e-9
UNDEFINED = (ArithmeticError, ValueError, TypeError, NameError)
"""Errors that functions of numbers raise outside their domain."""
Samples = npt.NDArray[np.float64]


def profile_problems(profile: sympy.Matrix, closed: bool, convex: bool) -> Iterator[str]:
    """Problems of x'(α), y'(α), m, with parameters at their default values.

    Only a closed curve has a range of α that is known, and is looked at along all of it.
    """
    strangers = profile.free_symbols - {alpha}
    if strangers:
        names = ", ".join(sorted(repr(s.name) for s in strangers))
        yield f"unknown symbol {names}; a profile is written in alpha and parameters."
        return
    first, second = profile.diff(alpha), profile.diff(alpha, 2)
    if first.is_zero_matrix:
        yield f"{tuple(profile)} is a point, not a curve; write it in alpha."
        return
    if not closed:
        return
    try:
        points = _sampled((*profile, *first, *second))
    except UNDEFINED as error:
        yield f"the profile {tuple(profile)} cannot be evaluated from α = 0 to 2π: {error}."
        return
    if not np.isfinite(points).all():
        yield f"the profile {tuple(profile)} is not finite everywhere from α = 0 to 2π."
        return
    size = float(np.abs(points[:, :2]).max()) or 1.0
    gaps = np.abs(points[-1] - points[0])
    for fault, ends, gap in (
        ("does not close", "ends", gaps[:2].max()),
        ("has a corner where it closes", "tangents", gaps[2:4].max()),
    ):
        if gap > TOLERANCE * size:
            yield (
                f"the profile {fault}: its {ends} at α = 0 and 2π are {gap:.3g} m apart; give "
                "functions of period 2π."
            )
            return
    dx, dy, x2, y2 = points.T[2:] / size  # no product overflows, however large it is
    speeds = np.hypot(dx, dy)
    slowest = int(np.argmin(speeds))
    if speeds[slowest] <= TOLERANCE:
        yield (
            f"the profile has a cusp: at α = {ALPHAS[slowest]:.4g} rad its tangent is "
            f"{size * speeds[slowest]:.3g} m per rad; give a smooth profile."
        )
    elif convex:
        bends = dx * y2 - dy * x2
        bends *= 1.0 if bends.sum() > 0 else -1.0
        least = int(np.argmin(bends))
        if bends[least] <= TOLERANCE:
            curvature = bends[least] / speeds[least] ** 3 / size
            yield (
                f"the profile is not convex: at α = {ALPHAS[least]:.4g} rad its curvature is "
                f"{curvature:.3g} 1/m, and a flat face needs a positive one everywhere; enlarge "
                "the base circle, or use a roller."
            )


def pace(profile: sympy.Matrix) -> float:
    """|c'(0)|, m per rad, to three digits, for a curve written in alpha and numbers; else 1."""
    try:
        slope = _sampled(tuple(profile.diff(alpha)), at=(0.0,))[0]
    except UNDEFINED:
        return 1.0
    size = math.hypot(*slope)
    return float(f"{size:.3g}") if 0.0 < size < math.inf else 1.0


def places(profile: sympy.Matrix) -> Samples:
    """Points of a curve that is written in alpha and numbers, at `ALPHAS`, samples × 2."""
    return _sampled(tuple(profile))


def in_ground(curve: Curve, numbers: Mapping[sympy.Symbol, float]) -> Samples:
    """Points of a curve in the global frame for coordinates and parameters, samples × 2."""
    x, y = (float(a.subs(numbers)) for a in curve.body.position)
    c, s = (float(a.subs(numbers)) for a in curve.body.rotation)
    rotated = places(curve.at(alpha).subs(numbers)) @ np.array([[c, s], [-s, c]])
    points: Samples = rotated + np.array([x, y])
    return points


def outward(points: Samples) -> Samples:
    """Unit normals of a closed curve at its points, pointing out of it, samples × 2."""
    tangent = np.gradient(points, axis=0)
    tangent[0] = tangent[-1] = points[1] - points[-2]
    x, y = points.T
    turn = np.sign(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    normal = turn * np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    normals: Samples = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return normals


def _sampled(expressions: tuple[sympy.Expr, ...], at: tuple[float, ...] = ALPHAS) -> Samples:
    """Values at parameters of the curve, samples × expressions."""
    tables = {str(a): a.table for e in expressions for a in e.atoms(TableAtom)}
    tables["Interpolant"] = lambda table, order, at: table(at, order)
    everything = sympy.lambdify(alpha, expressions, [tables, "math"])
    return np.array([tuple(map(float, everything(value))) for value in at])
