"""Rank: the size below which a pivot, a singular value or a remainder counts as zero.

The matrices are Jacobians Φ_q, and small ones made from them, with rows divided by their lengths or
largest entries and columns multiplied by typical changes of the coordinates. A pivot is then about
the distance of its row from the rows before it, the smallest singular value the distance from a
matrix of less rank (Eckart and Young, 1936): pure numbers from 0 to 1. An exact zero comes out as
large as the noise of the matrix, and a tolerance is a multiple of that noise. The constants below
differ in the noise, which is that of the position at which the matrix is known.

The size of the matrix does not enter. The rows have few non-zeros, and elimination with pivots
chosen by size adds up few roundings: along runs of 4, 8 and 16 parallel cranks (n = 15, 27 and 51)
the pivot that ought to be zero was at most 5e-16, 5e-16 and 1e-15.
"""

NO_PIVOT = 1e-10
"""accuracy: Is there a pivot left, where the position is known to rounding? Noise: 1e-15, as
measured above; the margin is for units and masses that spread over several powers of ten."""

REDUNDANT = 1e-8
"""accuracy: Does a row follow from those before it, so that the sign of its pivot says nothing?
Noise: 1e-9, the error of a position close to a singular one, where Newton's method stalls; besides,
elimination by rows lets errors grow more than full pivoting. Users: eliminations along a motion, in
`singularity.prediction`, `continuation.predictor_corrector`, `linalg`; not `assembly.redundancy`,
which names redundant constraints by LOST."""

LOST = 1e-6
"""accuracy: Is a direction lost at a position that was assembled, and may be a singular one? Noise:
√EPS = 1.5e-8, to which Newton's method finds a double root. Users: `assembly.redundancy`,
`continuation.singular_position_messages` and `continuation.bifurcation_branches`."""

SAME_HOLD = 1e-11
"""accuracy: Does a sliding mode or closed contact hold a freedom that others hold already? The
matrix of their responses, a few rows solved for to rounding, is not one of distances: light bodies
make genuine pivots small, so the margin is less."""

NO_DIVISOR = 1e-13
"""safety: Can one divide by a pivot whose place is given? This is no question of rank: close to a
singular position such a pivot is small, and the result is judged by its residual."""
