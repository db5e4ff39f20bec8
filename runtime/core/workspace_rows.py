"""Rows of a run's workspace, by name, and how compiled code takes them out.

The workspace `w` is one flat float64 array of rows of length 2 n, n coordinates. A row that holds a
state has q in its first half and v in its second; a row that holds a derivative has v, then a.
Everything that a run needs to go on lies in these arrays, so that it can stop after any step and
continue with the same bits.
"""

from collections.abc import Callable
from typing import cast

from codegen.machine_code.table_values import row_at
from runtime.core.arrays import Integers, Vector
from runtime.core.function_table_slots import COORDINATES, SWITCHES, TABLE

Y0 = 0  # state at the start of the step
Y1 = 1  # state at its end
STAGE = 2  # state at a stage
DELTA = 3  # dq, dv of the last correction; free for others between corrections
SAMPLE = 4  # state off the steps: outputs, look-ahead
ATOL = 5  # absolute tolerances of q and of v
PARTITION = 6  # weights of the correction (n), then scale of each coordinate (n)
UNIT = 7  # state that probes the conditioning of the partition
# First of 16 rows of the method: the derivative at the start; `last` rows on, that at the end; the
# others are free, for derivatives at stages or states there.
K = 8
F = 24  # first of 8 rows of the dense output's coefficients
SIZE = 32  # size from which on a coordinate's or velocity's change is relative
PREDICTED = 33  # the step's result before correction
PROJECTION = 34  # weights of the projection (n)
ROWS = 35

# Rows of the switching workspace `sw`, each of length s.
G0 = 0  # g at the start of the step
R0 = 1  # dg/dt there
G1 = 2  # g at the end
R1 = 3  # dg/dt there
LARGEST = 4  # running maximum of |g|
BAND = 5  # > 0: g began this piece on its surface; below -BAND it has crossed it
SUSPECT = 6  # 1: this g may have crossed zero inside the step
TRIAL = 7  # g at a trial point
SCAN = 8  # first of SUBDIVISIONS + 1 rows: g at equal distances over the step
SUBDIVISIONS = 8
BETWEEN = SCAN + SUBDIVISIONS + 1  # first of 3 rows: g at points between the ends of the step
RESERVE = BETWEEN + 3  # running maximum of |g| while the function is in sliding mode
NOW = RESERVE + 1  # g itself, also in sliding mode
RATE_NOW = NOW + 1  # its rate
PREFERRED = RATE_NOW + 1  # mode that is tried first
STRUCK = PREFERRED + 1  # closing rate of a contact that takes part in the impact; 0 of others
IMPACT_AT = STRUCK + 1  # time of the last impact of this contact
FLIGHT = IMPACT_AT + 1  # time between its last two impacts
SWITCH_ROWS = FLIGHT + 1


_Row = Callable[[Integers, int], Vector]


def _row(array: str, count: int, factor: int, part: int | None, **named: int) -> _Row:
    """What takes a row of `factor` parts, or one, out of an array; those `named` are attributes."""
    return cast(_Row, row_at(TABLE.slots[array], count, factor, part, **named))


row_of = _row("workspace", COORDINATES, 2, None)  # row of the workspace, (2 n,)
# The first and the second half of such a row, (n,).
first_half = _row(
    "workspace", COORDINATES, 2, 0, q0=Y0, q1=Y1, dq=DELTA, first_scratch=DELTA,
    correction_weights=PARTITION,
)  # fmt: skip
second_half = _row(
    "workspace", COORDINATES, 2, 1, v0=Y0, v1=Y1, dv=DELTA, second_scratch=DELTA, scale=PARTITION
)
positions, velocities = first_half, second_half  # q and v of a row that holds a state
position_rates, velocity_rates = first_half, second_half  # of a row that holds a derivative
# Row of the switching workspace, (s,).
switch_row = _row(
    "switching_rows", SWITCHES, 1, None, g0=G0, r0=R0, g1=G1, r1=R1, largest=LARGEST, band=BAND,
    suspect=SUSPECT, trial=TRIAL, reserve=RESERVE, now=NOW, rate_now=RATE_NOW, preferred=PREFERRED,
    struck=STRUCK, impact_at=IMPACT_AT, flight=FLIGHT,
)  # fmt: skip
