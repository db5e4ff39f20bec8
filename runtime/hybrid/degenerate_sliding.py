"""Small systems for what is held at once, also where several hold one freedom."""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.function_table import SLIDING_COUNT, response_of, rigid_of, sliding_functions_of
from runtime.core.jit import inner
from runtime.linalg.lu import equilibrate
from runtime.linalg.rank_policy import SAME_HOLD


@inner
def least(
    context: Integers, matrix: Vector, right: Vector, count: int, reach: Vector, slack: float
) -> int:
    """As `solve_equilibrated`, for the smallest of many solutions; 1 where there is none.

    Several frictions of one freedom hold it in many ways, of which the sum of |column| x²/reach is
    least here: each then bears the same part of its reach, so that they hold whatever can be held,
    and let go together. Rows are made orthogonal one after the other (Gram and Schmidt, twice);
    those of which nothing is left follow from the others. Those of contacts come first, and must
    not follow from each other: contacts can do without one that does what others do.

    Parameters
    ----------
    matrix, right
        By rows, of the `count` functions that are held; both are overwritten, `right` with x.
    reach : (s,)
        What each x may be at most; overwritten.
    slack
        By which a row that follows from others may differ from what they say, in parts of its
        terms.
    """
    rigid = rigid_of(context)
    held = sliding_functions_of(context)
    if equilibrate(matrix, right, count) != 0:
        return 1
    for c in range(count):
        norm = 0.0
        for i in range(count):
            norm += matrix[i * count + c] ** 2
        if not norm > 0.0:
            return 1
        reach[c] = np.sqrt(reach[c] / np.sqrt(norm))
        for i in range(count):
            matrix[i * count + c] *= reach[c]
    for turn in range(2):
        for i in range(count):
            firm = rigid[held[i]] >= 0
            if firm != (turn == 0):
                continue
            size, scale = 0.0, max(1.0, abs(right[i]))
            for c in range(count):
                size += matrix[i * count + c] ** 2
            for _ in range(2):
                for j in range(count):
                    done = j < i if (rigid[held[j]] >= 0) == firm else turn == 1
                    if not done:
                        continue
                    along = 0.0
                    for c in range(count):
                        along += matrix[i * count + c] * matrix[j * count + c]
                    for c in range(count):
                        matrix[i * count + c] -= along * matrix[j * count + c]
                    right[i] -= along * right[j]
                    scale = max(scale, abs(along * right[j]))
            rest = 0.0
            for c in range(count):
                rest += matrix[i * count + c] ** 2
            root = np.sqrt(rest)
            if root > SAME_HOLD * np.sqrt(size):
                for c in range(count):
                    matrix[i * count + c] /= root
                right[i] /= root
                continue
            if firm or not abs(right[i]) <= slack * scale:
                return 1
            for c in range(count):
                matrix[i * count + c] = 0.0
            right[i] = 0.0
    for c in range(count):
        total = 0.0
        for i in range(count):
            total += right[i] * matrix[i * count + c]
        reach[c] *= total
    for c in range(count):
        right[c] = reach[c]
    return 0


@inner
def same(context: Integers, k: int, other: int) -> bool:
    """Whether what holds two of the held functions acts on one freedom; after `bent`."""
    count = context[SLIDING_COUNT]
    held = sliding_functions_of(context)
    matrix = response_of(context)
    c, d = 0, 0
    for i in range(count):
        c = i if held[i] == k else c
        d = i if held[i] == other else d
    product = matrix[c * count + c] * matrix[d * count + d]
    crossed = matrix[c * count + d] * matrix[d * count + c]
    return bool(abs(product - crossed) <= SAME_HOLD * abs(product))
