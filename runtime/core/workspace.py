"""What a run remembers: the rows of the workspace and the record of where it stands.

The workspace `w` is one flat float64 array of rows of length 2 n, n coordinates. A row that holds a
state has q in its first half and v in its second; a row that holds a derivative has v, then a.
Everything that a run needs to go on lies in these arrays, so that it can stop after any step and
continue with the same bits.
"""

from typing import Any

import numpy as np
from numba import from_dtype, types

Y0 = 0  # state at the start of the step
Y1 = 1  # state at its end
STAGE = 2  # state at a stage
DELTA = 3  # dq, dv of the last correction
SAMPLE = 4  # state off the steps: outputs, look-ahead
ATOL = 5  # absolute tolerances of q and of v
PARTITION = 6  # weights of the correction (n), then scale of each coordinate (n)
UNIT = 7  # state that probes the conditioning of the partition
K = 8  # first of 16 rows of stage derivatives
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
MISMATCH = BETWEEN + 3  # how far these are from the cubic of g
RESERVE = MISMATCH + 1  # running maximum of |g| while the function itself is held at zero
NOW = RESERVE + 1  # g itself, also of what is held
RATE_NOW = NOW + 1  # its rate
PREFERRED = RATE_NOW + 1  # mode that is tried first
STRUCK = PREFERRED + 1  # 1: this contact takes part in the impact
IMPACT_AT = STRUCK + 1  # time of the last impact of this contact
FLIGHT = IMPACT_AT + 1  # time between its last two impacts
SWITCH_ROWS = FLIGHT + 1

_FLOATS = [
    "t",  # where the run stands
    "t_end",
    "duration",  # of the whole run
    "h",  # length of the next step
    "h_min",
    "h_max",
    "rtol",
    "error",  # of the last trial step, over the tolerance
    "error_old",  # of the last accepted step
    "remembered",  # error of the last step, as it counts for the next one's length; 0: none
    "length_old",  # of that step
    "exponent",  # of the step control, 1 over the order of the error
    "beta",
    "safety",
    "shrink",  # least ratio of two steps' lengths
    "grow",  # largest
    "ratio_limit",  # speeds of dependent over independent coordinates that ask for a probe
    "growth_limit",  # entry of H that asks for a new partition
    "largest_dq",
    "event_span",  # time that the last events took
    "stretch",  # ratio of two steps' lengths that the switching functions allow
    "flight",  # time to the next impact of a contact that bounces
    "finest",  # length of a step that is never too long for them
    "permitted",  # error that a step may have, over the tolerance: 1 but where rounding exceeds it
    "vanishing",  # time from now at which constraints seem to become dependent
    "tried",  # length of a step that was taken for good, but for this; 0 for none
    "turn",  # instant at which the step over a singular position begins
    "leap",  # length of that step
    "blind_from",  # samples between these two instants stay as they are interpolated
    "blind_to",
    "look_at",  # instant at which the constraints are looked at again
    "quiet",  # instant until which a singular position is not looked for
    "usual",  # length of the last accepted step of free choice
    "foresight",  # change of the coordinates, in their sizes, over which one is looked for
    "lent_until",  # instant from which a method that was lent is not needed
]
_INTEGERS = [
    "last",  # row, after K, of the derivative at the end of a step
    "stage_calls",
    "order",  # power of a step's length in the error estimate of the first one
    "dense_rows",
    "dense_calls",
    "fixed",  # 1: no error control
    "steps",
    "rejected",
    "retakes",
    "rhs",
    "corrections",
    "newton",
    "automatic",  # 1: the method may be changed
    "patience",  # how many times longer than at first it is watched before that
    "iterations",  # of Newton's method in the steps of implicit methods
    "jacobians",
    "factorizations",
    "dense_outputs",
    "events",
    "repartitions",
    "max_steps",
    "max_events",
    "every_step",  # 1: a sample at the end of every step
    "samples",  # rows of the output written
    "next_sample",  # of the instants asked for
    "logged_events",  # rows of the event buffer written
    "logged_repartitions",  # rows of the partition log written
    "rank",  # of the Jacobian
    "check_in",  # steps to the next probe of the partition
    "probe",  # how often the partition was probed
    "weak",  # accepted states in a row with a weak pivot
    "weak_row",  # 1 + constraint of the weak pivot
    "reason",  # why the last trial step was rejected
    "rejected_before",
    "shrinking",  # events in a row, each in less time than the one before
    "standing",  # events in a row without time between them
    "blamed",  # switching function for which no mode is consistent, or -1
    "index",  # function or constraint that an outcome concerns
    "lent",  # 1: another method steps near a singular position than elsewhere
    "plan",  # what is planned about a singular position, one of the below
]
FREE, APPROACHING, CROSSING, LEAVING, MISSING = 0, 1, 2, 3, 4
"""What is planned about singular positions: nothing; to come to where a step across begins; that
step; to get away; to follow the bend in which the motion misses one."""

RUN = np.dtype(
    [(name, np.float64) for name in _FLOATS] + [(name, np.int64) for name in _INTEGERS], align=True
)
Run = np.ndarray[Any, np.dtype[np.void]]
run_record = types.Array(from_dtype(RUN), 1, "C")
