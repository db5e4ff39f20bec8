"""Unwrapping of angles that kernels give by sine and cosine: followed through whole turns."""

import numpy as np
from numba import types

from runtime.core.arrays import Integers, Matrix, Vector, f8, integers, matrix, none, vector
from runtime.core.jit import ADDRESSES, allocating, at

_expand = at(types.FunctionType(none(f8, *[vector] * 6)), 0)
# measured: rad, or part of a length's size, between two positions at which angles are followed
_STRIDE = 0.5
_FAR = 1.0  # safety: rad by which an angle may move from one position to the next
_FINEST = 1e-4  # safety: part of a stride; no shorter ones are tried
_TURN = 2.0 * np.pi


@allocating(
    none(ADDRESSES, integers, f8, *[vector] * 3, matrix, matrix, vector, vector, matrix, matrix)
)
def follow(
    table: Integers, angles: Integers, t_first: float, first: Vector, here: Vector, t: Vector,
    q: Matrix, v: Matrix, p: Vector, sizes: Vector, all_q: Matrix, all_v: Matrix,
) -> None:  # fmt: skip
    """Fill `all_q` and `all_v` by the `expand` in `table`; `here`, where the walk stands, moves."""
    expand = _expand(table)
    count, n = angles.size, here.size
    turns, none = np.zeros(count), np.zeros(count)
    at, still = np.zeros(n), np.zeros(n)
    place, rate = np.zeros(first.size), np.zeros(first.size)
    followed, moved = np.zeros(count), np.zeros(count)
    for i in range(count):
        followed[i] = first[angles[i]]
    now = t_first
    for sample in range(t.size):
        way = 0.0
        for j in range(n):
            way = max(way, abs(q[sample, j] - here[j]) / sizes[j])
        longest = min(1.0, _STRIDE / way) if way > 0.0 else 1.0
        x, step = 0.0, longest
        while count > 0 and x < 1.0:
            end = 1.0 if x + 1.001 * step >= 1.0 else x + step
            for j in range(n):
                at[j] = here[j] + end * (q[sample, j] - here[j])
            expand(now + end * (t[sample] - now), at, still, p, none, place, rate)
            farthest = 0.0
            for i in range(count):
                apart = place[angles[i]] - followed[i]
                moved[i] = apart - _TURN * np.round(apart / _TURN)
                farthest = max(farthest, abs(moved[i]))
            if farthest > _FAR and step > _FINEST * longest:
                step *= 0.5
                continue
            for i in range(count):
                if np.isfinite(moved[i]):
                    followed[i] += moved[i]
                    turns[i] = np.round((followed[i] - place[angles[i]]) / _TURN)
            x = end
            step = min(2.0 * step, longest)
        expand(t[sample], q[sample], v[sample], p, turns, all_q[sample], all_v[sample])
        for j in range(n):
            here[j] = q[sample, j]
        now = t[sample]
