"""Layout of METHOD_FLOATS and METHOD_INTEGERS, in which an implicit method keeps its state.

The duties of a method, beside its formulas:

- `stages` calls `list_unknowns` first, leaves the dependent half of Y1 uncorrected, and writes
  STEP_ERROR after the step;
- `accepted` counts EQUAL, sets H_BASE and ERROR_BASE, keeps LOW, and answers `suits_explicit`;
- `restart` zeroes EQUAL, CURRENT and LOW; a multistep method begins its history anew.

| place | who writes it | who reads it |
|---|---|---|
| FREEDOMS, PARTITIONED, unknowns | `list_unknowns` | all |
| CURRENT | `differentiate` 1; `list_unknowns`, the iteration, `restart` 0 | `step_solver` |
| FACTORED_FOR | `step_solver`; `differentiate` 0 | `step_solver` |
| TOLERANCE, ENOUGH | `set_tolerance` | the iteration, error estimates |
| RATE, ITERATIONS | the iteration | the iteration; `propose` |
| STEP_ERROR | `stages` | `error` |
| EQUAL, H_BASE | `accepted`, `restart` | prediction, `propose`, error estimates |
| ERROR_BASE | `accepted` | `propose` |
| LOW | `accepted`, `restart` | setting of unknowns |
| SETTLED | `list_unknowns` 0; `accepted` of a multistep method | `set_tolerance` |
| STIFFNESS, DAMPING | `differentiate` | `suits_explicit`, choice of order, `auto` |
| CALM, STIFF | `suits_explicit`; `auto` | the same |

LOWER, HIGHER, the numbers from CHANGE on, STEP_ORDER, NEXT_ORDER and REJECTED are BDF's alone:
another method may keep its own numbers there, as in rows 0 to 19.
"""

from runtime.core.arrays import Context, Integers, Matrix, Vector, view
from runtime.core.function_table_slots import COORDINATES
from runtime.core.jit import fetched

# Rows of the workspace, in every implicit method.
LAST = 1  # after K: the derivative at the end of the step
DENSE_ROWS = 6  # of the dense output's coefficients

# METHOD_FLOATS: numbers, then rows of length 2 n, then matrices.
FACTORED_FOR = 0  # the `scale` of `step_solver` for which the matrices are factored
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
ROWS = 25
# Matrices of order f: G_u, G_u̇, factors of the real one; of the complex one, of order 2 f.
BY_U, BY_RATE, REAL, COMPLEX = 0, 1, 2, 3

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
    return NUMBERS + 2 * n * ROWS + 7 * n * n, COUNTS + 4 * n


@fetched
def rows(context: Context) -> Matrix:
    """All rows of METHOD_FLOATS, (ROWS, 2 n)."""
    found: Matrix = view(context.method_floats, NUMBERS, (ROWS, 2 * context[COORDINATES]))
    return found


@fetched
def half(context: Context, index: int, second: int) -> Vector:
    """First (0) or second (1) half of row `index`, (n,): of positions or of velocities."""
    n = context[COORDINATES]
    found: Vector = view(context.method_floats, NUMBERS + n * (2 * index + second), n)
    return found


@fetched
def derivative(context: Context, index: int) -> Matrix:
    """The matrix `BY_U` or `BY_RATE`, (f, f)."""
    n, f = context[COORDINATES], context.method_integers[FREEDOMS]
    found: Matrix = view(context.method_floats, NUMBERS + n * (2 * ROWS + index * n), (f, f))
    return found


@fetched
def factors(context: Context, index: int) -> Vector:
    """The matrix `REAL` or `COMPLEX`, flat, in room for order n or 2 n."""
    n = context[COORDINATES]
    size = 4 * n * n if index == COMPLEX else n * n
    found: Vector = view(context.method_floats, NUMBERS + n * (2 * ROWS + index * n), size)
    return found


@fetched
def pivots(context: Context, index: int) -> Integers:
    """Pivots of the factored matrix `REAL` or `COMPLEX`."""
    n = context[COORDINATES]
    found: Integers = view(context.method_integers, COUNTS + (index - 1) * n, (index - 1) * n)
    return found


@fetched
def unknowns(context: Context) -> Integers:
    """Coordinates that are unknowns of the step, of which the first f are valid, (n,)."""
    found: Integers = view(context.method_integers, COUNTS, context[COORDINATES])
    return found
