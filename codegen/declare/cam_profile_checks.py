"""Shapes of cams: whether a profile is closed, smooth, and convex where its follower needs it."""

import math
from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt
import sympy

from codegen.declare.body import Curve
from codegen.declare.symbols import alpha
from codegen.parameter_conditions import ALPHAS, shape_problems
from codegen.tables.table_function import TableAtom

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
    if profile.diff(alpha).is_zero_matrix:
        yield f"{tuple(profile)} is a point, not a curve; write it in alpha."
        return
    if not closed:
        tangent = profile.diff(alpha)
        if any(a.has(alpha) for a in sympy.sqrt(tangent.dot(tangent)).atoms(sympy.Abs)):
            yield (
                f"the tangent {tuple(tangent)} of the profile {tuple(profile)} vanishes and turns "
                "round; write the line so that it goes one way, such as (1, alpha)."
            )
        return
    try:
        points = _sampled(derivatives(profile))
    except UNDEFINED as error:
        yield f"the profile {tuple(profile)} cannot be evaluated from α = 0 to 2π: {error}."
        return
    yield from shape_problems(points, convex)


def derivatives(profile: sympy.Matrix) -> tuple[sympy.Expr, ...]:
    """x, y and their first and second derivatives by α."""
    return (*profile, *profile.diff(alpha), *profile.diff(alpha, 2))


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


def compared(lengths: Samples) -> Samples:
    """Lengths without the digits, m, that rounding leaves to chance."""
    with np.errstate(over="ignore"):  # from 1e299 m on
        rounded: Samples = np.round(lengths, 9)
    return rounded


def outward(points: Samples) -> Samples:
    """Unit normals of a closed curve at its points, pointing out of it, samples × 2."""
    points = np.ldexp(points, -np.frexp(np.abs(points).max())[1])  # no square leaves the floats
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
