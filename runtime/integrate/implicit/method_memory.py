"""Where an implicit method keeps what it must remember in METHOD_FLOATS and METHOD_INTEGERS."""

from runtime.core.array_types import Integers, Vector
from runtime.core.array_views import view
from runtime.core.function_table import method_floats_of, method_integers_of
from runtime.core.jit import fetched

# METHOD_FLOATS: numbers, then rows of length 2 n, then matrices.
C_FACTORED = 0  # the c for which a matrix is factored
RATE = 1  # of Newton's convergence: what is still missing over the last change
STEP_ERROR = 2  # of the last trial step, over the tolerance
H_BASE = 3  # distance of a multistep method's history; length of a one-step method's last step
ERROR_BASE = 4  # error of that step
ENOUGH = 5  # how far Newton's method is taken, over the tolerance of the step
LOWER, HIGHER = 6, 7  # the error that a multistep method would have made at other orders
STIFFNESS = 8  # spectral radius of the derivatives, 1/s
DAMPING = 9  # -cos of the angle of those eigenvalues: 1 without vibration, 0 without damping
CHANGE = 10  # first of 72 numbers in which a change of the step's length is worked out
NUMBERS = 82
# Rows: the first 20 are a method's; then directions for the derivatives, then the tolerance.
IN, OUT, SLOPE, TOLERANCE = 20, 21, 22, 23
LOW = 24  # what rounding cut off the state at the start of the step
LINES = 25

# METHOD_INTEGERS: counts, then the unknowns (n), pivots (n), pivots of the complex matrix (2 n).
FREEDOMS = 0  # f
CURRENT = 1  # 1: the derivatives are of these unknowns, and Newton's method converges fast
STEP_ORDER = 2
EQUAL = 3  # steps of this length and order
NEXT_ORDER = 4
REJECTED = 5  # rejected steps up to the last accepted one
ITERATIONS = 6  # of the last step
CALM = 7  # steps in a row that an explicit method could have taken
STIFF = 8  # steps of an explicit method that were limited by stability
PARTITIONED = 9  # 1: dependent coordinates are recovered at every iterate
SETTLED = 10  # steps since the unknowns were other ones
COUNTS = 11


def memory(n: int) -> tuple[int, int]:
    """Numbers that an implicit method keeps for n coordinates: floats and integers."""
    return NUMBERS + 2 * n * LINES + 7 * n * n, COUNTS + 4 * n


@fetched
def floats(context: Integers, n: int) -> Vector:
    """All of METHOD_FLOATS."""
    found: Vector = method_floats_of(context)
    return found


@fetched
def line(memory: Vector, index: int, n: int) -> Vector:
    """Row `index` of METHOD_FLOATS."""
    found: Vector = view(memory, NUMBERS + index * 2 * n, 2 * n)
    return found


@fetched
def matrix(memory: Vector, index: int, n: int) -> Vector:
    """G_u (0), G_u̇ (1), factors of the real (2) and of the complex matrix (3), flat."""
    found: Vector = view(
        memory, NUMBERS + 2 * n * LINES + index * n * n, (4 if index == 3 else 1) * n * n
    )
    return found


@fetched
def counts(context: Integers, n: int) -> Integers:
    """All of METHOD_INTEGERS."""
    found: Integers = method_integers_of(context)
    return found
