"""The record of a run: where it stands, how it steps, and what it has counted."""

from collections.abc import Callable
from enum import IntEnum, unique
from typing import Any

import numpy as np
from numba import from_dtype

from codegen.machine_code.table_values import record_at
from runtime.core.arrays import Integers
from runtime.core.function_table_slots import RECORD
from runtime.core.jit import inlined

_FLOATS = ["t_end", "h_min", "h_max", "rtol", "beta", "safety", "largest_dq"]
_FLOATS += [
    "t",  # where the run stands
    "duration",  # of the whole run
    "h",  # length of the next step
    "error",  # of the last trial step, over the tolerance
    "error_old",  # of the last accepted step
    "remembered",  # error of the last step, as it counts for the next one's length; 0: none
    "length_old",  # of that step
    "exponent",  # of the step control, 1 over the order of the error
    "shrink",  # least ratio of two steps' lengths
    "grow",  # largest
    "ratio_limit",  # speeds of dependent over independent coordinates that ask for a probe
    "growth_limit",  # entry of H that asks for a new partition
    "event_span",  # time that the last `RECENT` events took
    "stretch",  # ratio of two steps' lengths that the switching functions allow
    "flight",  # time to the next impact of a contact that bounces
    "finest",  # length of a step that is never too long for them
    "permitted",  # error that a step may have, over the tolerance: 1 but where rounding exceeds it
    "vanishing",  # time from now at which constraints seem to become dependent
    "tried",  # length of a step that met its tolerance, withheld for a singular position; 0: none
    "turn",  # instant at which the step over a singular position begins, or (MISSING) of a position
    "length_across",  # of the step over it; MISSING: half the width of the bend
    "blind_from",  # samples between these two instants stay as they are interpolated
    "blind_to",
    "look_at",  # instant at which the constraints are looked at again
    "quiet",  # instant until which a singular position is not looked for
    "usual",  # length of the last accepted step of free choice
    "length",  # of the trial step, up to an event where one lies in it
    "end",  # instant at which it ends
    "reach",  # its length without the event
    "next_length",  # of the step after it
    "followed",  # length of a step in which the fastest state of first order does not grow
    "radius",  # factor by which the rates of these states grew in its iteration; 0: not known
    "foresight",  # change of the coordinates, in their sizes, over which one is looked for
    "energy",  # T + V at the start of the next step, J; NaN: not known
    "power",  # of all effects and drivers there, W
    "slope",  # its mean change over the step before, W/s; NaN: not known
    "slope_over",  # length of that step
    "scatter",  # error of the energy that the tolerances permit, at the last look at its balance
    "usual_part",  # of the exchanged energy, which a parabola of powers left open lately
    "unexplained",  # change of the energy less the work of all effects and drivers, J
    "explained",  # that work
    "before_event",  # kinetic energy before an event, where contacts are rigid, J
    "rounding",  # of the potential, J, as far as it has been met
    "doubtful",  # end of a step whose energy was not explained; steps up to it are looked at again
    "lent_until",  # instant from which a method that was lent is not needed
    "stop",  # next instant, known beforehand, at which a step ends; infinite where there is none
    "sample_at",  # next instant at which a clock renews a value; infinite where there is none
    "pace_start",  # instant at which the number of steps had doubled for the last time
    "pace",  # time covered by the steps of the doubling before
    "limit",  # instant before which all steps to come would lie, at their pace; infinite: none
]
_INTEGERS = ["stage_calls", "dense_rows", "dense_calls", "max_steps", "max_events"]
_INTEGERS += ["steps", "rejected", "retakes", "events", "repartitions", "rhs", "dense_outputs"]
_INTEGERS += ["jacobians", "factorizations"]
_INTEGERS += [
    "last",  # row, after K, of the derivative at the end of a step
    "estimate_order",  # power of a step's length in its estimated error
    "fixed",  # 1: no error control
    "corrections",  # calls of the kernel `correction`
    "returns",  # onto the constraints, begun at the ends of steps
    "automatic",  # 1: the method may be changed
    "patience",  # how many times longer than at first it is watched before that
    "iterations",  # of Newton's method in the steps of implicit methods
    "every_step",  # kind of sampling: 0 at given instants, 1 at the end of every step, 2 quadrature
    "samples",  # rows of the output written
    "next_sample",  # of the instants asked for
    "logged_events",  # rows of the event buffer written
    "logged_repartitions",  # rows of the partition log written
    "rank",  # of the Jacobian
    "check_in",  # steps to the next probe of the partition
    "probe",  # how often the partition was probed
    "weak",  # accepted states in a row with a weak pivot
    "weak_row",  # 1 + constraint of the weak pivot
    "weak_return",  # the same in the last return onto the constraints; 0: none
    "reason",  # why the last trial step was rejected
    "rejected_before",
    # events in a row up to each of which the last `RECENT` took less time than up to the one before
    "shrinking",
    "standing",  # events in a row without time between them
    "blamed",  # switching function for which no mode is consistent, or -1
    "index",  # function or constraint that an outcome concerns
    "site",  # where it was set, a `Site`
    "lent",  # 1: another method steps near a singular position than elsewhere
    "planned",  # 1: a plan sets the end of this step
    "announced",  # 1: a singular configuration lies ahead of it
    "crossing",  # switching function of the event at which it ends, or -1
    "dense_ready",  # 1: its dense output is there
    "changed",  # events that were logged at its end
    "due",  # 1: another method is due
    "power_rows",  # of the powers that change the energy; -1: its balance is not known
    "energy_step",  # number of the step at whose start the energy was taken
    "balance_at",  # number of the next step whose balance of energy is watched
    "balances",  # looks at the balance of energy that were due
    "doubts",  # steps up to `doubtful` whose energy was not explained
    "balance_rhs",  # calls of `accelerations` for it
    "next_stop",  # its number
    "pace_steps",  # number of steps that is twice that at `pace_start`
    "pace_events",  # number of events at `pace_start`
    "unlimited",  # 1: a run whose steps get ever shorter goes on
    "slower",  # doublings in a row of which each covers less time than the one before
    "stopped_by",  # condition that has ended the run, or -1
    "plan",  # about a singular position, a `Plan`
    "resumed",  # 1: it goes on from a run in other coordinates, whose modes it takes over
]


@unique
class ConstraintReturn(IntEnum):
    """When and how a step returns onto the constraints: the number CORRECTING of the table."""

    NEVER = 0
    BY_PARTITION = 1
    BY_PROJECTION = 2
    IF_DRIFTED = 3


@unique
class Plan(IntEnum):
    """What a run does next about a singular position: the number `plan` of its record."""

    FREE = 0  # nothing is planned
    APPROACHING = 1  # it goes to the instant at which the step across begins
    CROSSING = 2  # the next step is the one across
    LEAVING = 3  # it gets away from the position
    MISSING = 4  # it follows the bend in which the motion misses the position


RUN = np.dtype(
    [(name, np.float64) for name in _FLOATS] + [(name, np.int64) for name in _INTEGERS], align=True
)


run_record: Callable[[Integers], Any] = record_at(from_dtype(RUN), RECORD)
"""The record of the run, of the type `RUN`, for compiled code."""


@inlined
def is_near_singularity(context: Integers) -> bool:
    """Whether a singular position is so near that no choice of independent coordinates is good."""
    plan = run_record(context).plan
    return bool(Plan.FREE < plan < Plan.MISSING)
