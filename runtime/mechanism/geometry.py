"""The picture of a mechanism at given states, by the companion module of its geometry."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.drawing.layout import SAMPLES, BodyLayout, Layout, ShapeLayout
from runtime.mechanism.companion_modules import load_companion
from runtime.mechanism.mechanism import Mechanism

FloatArray = npt.NDArray[np.float64]


class Geometry(NamedTuple):
    """What a mechanism looks like at k instants."""

    layout: Layout
    numbers: FloatArray  # those that the layout's slots stand for, (k, slots)
    curves: tuple[FloatArray, ...]  # of each curve the points, m, (SAMPLES, 2)


def geometry(
    mechanism: Mechanism, p: FloatArray, t: FloatArray, q: FloatArray, v: FloatArray
) -> Geometry:
    """The geometry at states.

    Parameters
    ----------
    mechanism
        Its companion module is built where it is missing.
    p : (np,)
        Parameters, with or without the constants behind them.
    t, q, v : (k,), (k, n), (k, n)
        Instants in s, coordinates and velocities.
    """
    module = load_companion(mechanism.origin, "picture", mechanism.title, mechanism.path)
    bodies = tuple(BodyLayout(*row) for row in module.BODIES)
    rows = tuple(ShapeLayout(*row) for row in module.SHAPES)
    count = sum(what == "curve" for row in rows for what, _ in row.fields)
    layout = Layout(mechanism.title.replace("/", ", "), bodies, rows, count)
    numbers = np.zeros((len(t), layout.size))
    q, v = np.ascontiguousarray(q, dtype=float), np.ascontiguousarray(v, dtype=float)
    for k in range(len(t)):
        module.picture(float(t[k]), q[k], v[k], p, numbers[k])
    points = np.zeros((SAMPLES, 2 * count))
    if count:
        for k, alpha in enumerate(np.linspace(0.0, 2.0 * np.pi, SAMPLES)):
            module.curves(alpha, p, points[k])
    return Geometry(layout, numbers, tuple(points[:, 2 * k : 2 * k + 2] for k in range(count)))
