"""Typical sizes of a machine's coordinates: what a tolerance is measured by unless one is given."""

import numpy as np

from runtime.assembly.dense_equations import Equations, FloatArray

# measured: part of the largest distance from the origin; a machine counts as no smaller
_PLACES = 0.01
_NOTHING = 1e-9  # accuracy: m; a length below this is rounding


def magnitudes(equations: Equations, t: float, q: FloatArray) -> FloatArray:
    """Typical size of each coordinate at a position, m or rad.

    Angles have size 1. Lengths have that of the mechanism: its longest arm; where no angle enters
    a length, the largest distance from the origin at the start; where that is zero too, the
    largest length in the constraints, then among the parameters, and 1 m where there is none.

    Parameters
    ----------
    q : (n,)
        An assembled position.

    Returns
    -------
    (n,)
    """
    angle = equations.description.is_angle
    places = float(np.abs(q[~angle]).max(initial=0.0))
    matrix = equations.jacobian(t, q)
    mixed = np.any(matrix[:, ~angle] != 0.0, axis=1)
    reach = float(np.abs(matrix[np.ix_(mixed, angle)]).max(initial=0.0))
    if reach > _NOTHING:
        return equations.scale(max(reach, _PLACES * places))
    if places > _NOTHING:
        return equations.scale(places)
    units = equations.row_units(matrix)
    gaps = equations.constraints(t, np.zeros(equations.n))
    fixed = max((abs(gap) for gap, unit in zip(gaps, units, strict=True) if unit == "m"), default=0)
    if not fixed > _NOTHING:
        declared = zip(equations.description.parameters, equations.p, strict=False)
        fixed = max((abs(value) for row, value in declared if row.unit == "m"), default=0.0)
    return equations.scale(float(fixed) if fixed > _NOTHING else 1.0)
