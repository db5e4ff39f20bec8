"""Signs of assembly modes: to which side each link turns into the next, few that distinguish them.

A sign is that of the sine of the angle between the ways from pin to pin in two links. The places of
pins follow from the derivatives of their constraints by the angles of bodies, the arms of the pins.
"""

from itertools import product

import numpy as np
import numpy.typing as npt

from runtime.assembly.joint_closing import Selection
from runtime.mechanism.dense_equations import Equations, FloatArray

_STRAIGHT = 1e-6  # accuracy: sine of two links in line, which turn to neither side
_BENT = 0.05  # measured: sine of two links that a person sees turn; signs of less come last


def distinguishing_signs(
    equations: Equations, t: float, positions: FloatArray, free: Selection
) -> tuple[list[str], npt.NDArray[np.int64]]:
    """Names of signs, and the signs, (K, names), of the modes at `positions`, (K, n).

    The next one tells most modes apart. Modes that have all in common stay alike.
    """
    sines = _turns(equations, t, positions)
    if int(free.sum()) == equations.m:
        matrices = [equations.jacobian(t, q)[:, free] for q in positions]
        sines["det"] = 0.5 * _BENT * np.array([np.linalg.slogdet(m)[0] for m in matrices])
    names, table = [*sines], np.array([*sines.values()]).reshape(-1, len(positions)).T
    clear, signs = np.abs(table).min(axis=0).clip(max=_BENT), np.sign(table).astype(np.int64)
    left = np.flatnonzero(clear > _STRAIGHT).tolist()
    chosen, told = list[int](), 1

    def tells(k: int) -> tuple[int, float]:
        """How many modes differ by the signs chosen and this one, and how clear it is."""
        return len(np.unique(signs[:, [*chosen, k]], axis=0)), float(clear[k])

    while left and tells(best := max(left, key=tells))[0] > told:
        told = tells(best)[0]
        chosen.append(best)
    return [names[k] for k in chosen], signs[:, chosen]


def _turns(equations: Equations, t: float, positions: FloatArray) -> dict[str, FloatArray]:
    """Of pins A-B-C, A and B on one body, B and C on another, the sines at B, (K,)."""
    description = equations.description
    column = {row.name: k for k, row in enumerate(description.coordinates)}
    slopes = np.array([equations.jacobian(t, q) for q in positions])
    places, bodies = dict[str, FloatArray](), dict[str, list[str]]()
    for k, row in enumerate(description.constraints):
        if (row.kind, row.row) == ("revolute", "x"):
            entries = description.jacobian_columns[description.jacobian_rows == k].tolist()
            owners = [description.coordinates[e].name.rpartition(".")[0] for e in entries]
            body, *other = dict.fromkeys(owners)
            bodies[row.element] = [body, *other, ""][:2]  # the ground has no name
            x, phi = column[f"{body}.x"], column.get(f"{body}.phi")
            place = positions[:, x] + 1j * positions[:, x + 1]
            if phi is not None:
                place += (slopes[:, k + 1, phi] - 1j * slopes[:, k, phi]) / slopes[:, k, x]
            places[row.element] = place
    sines = dict[str, FloatArray]()
    for b in places:
        first, second = ([p for p in places if body in bodies[p]] for body in bodies[b])
        for a, c in product(first, second):
            if len({a, b, c}) == 3:
                into, out = places[b] - places[a], places[c] - places[b]
                length = np.maximum(np.abs(into) * np.abs(out), 1e-300)  # safety: pins in one place
                sines[f"{a}-{b}-{c}"] = (np.conj(into) * out).imag / length
    return sines
