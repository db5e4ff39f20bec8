"""The table by which compiled code reaches a machine: what stands where, and how it is taken out.

One array of integers holds addresses of kernels, of the loop's own parts and of arrays, and a few
numbers. It is handed from function to function in place of them all, so that a part that needs
something rare costs the others nothing.
"""

from enum import IntEnum, auto

from runtime.core.jit import at
from runtime.core.signatures import (
    Accelerations,
    AccelerationsTangent,
    AppliedForces,
    Attempt,
    Correct,
    Correction,
    CorrectionTangent,
    Dense,
    Emit,
    Error,
    Field,
    FirstStep,
    Hook,
    Impact,
    Jacobian,
    Limit,
    Locate,
    Margins,
    Mass,
    Passed,
    Propose,
    Reactions,
    Repartition,
    ReturnHeld,
    RightSide,
    Sampled,
    Settle,
    Slope,
    Stages,
    StateRightSide,
    SwitchedReactions,
    Switching,
    SwitchingRates,
    Transition,
    Vanishing,
    Watch,
)


class Slot(IntEnum):
    """Places in the table."""

    @staticmethod
    def _generate_next_value_(name: str, start: int, count: int, last: list[int]) -> int:
        return count

    # Kernels of the machine.
    ACCELERATIONS = auto()
    CORRECTION = auto()
    JACOBIAN = auto()
    SWITCHING = auto()
    SWITCHING_RATES = auto()
    CONSTRAINTS = auto()
    VELOCITY_RHS = auto()
    ACCELERATION_RHS = auto()
    MASS = auto()
    APPLIED_FORCES = auto()
    GAP_ACCELERATIONS = auto()
    REACTIONS = auto()
    SWITCHED_REACTIONS = auto()
    ACCELERATIONS_TANGENT = auto()
    CORRECTION_TANGENT = auto()
    DEAD_CENTRES = auto()
    # The method.
    STAGES = auto()
    ERROR = auto()
    DENSE = auto()
    PROPOSE = auto()
    ACCEPTED = auto()
    RESTART = auto()
    # Parts of the loop.
    CORRECT = auto()
    ATTEMPT = auto()
    REPARTITION = auto()
    LOCATE = auto()
    SAMPLED = auto()
    SETTLE = auto()
    BEGIN = auto()
    FIRST_STEP = auto()
    EMIT = auto()
    WATCH = auto()
    BENT = auto()
    BENT_SLOPE = auto()
    IMPACT = auto()
    RETURN_HELD = auto()
    TRANSITION = auto()
    LIMITED = auto()
    MARGINS = auto()
    VANISHING = auto()
    PASSED = auto()
    # Numbers.
    COORDINATES = auto()
    CONSTRAINT_COUNT = auto()
    RANK = auto()
    SWITCHES = auto()
    NONZEROS = auto()
    LOG_ROWS = auto()
    BENDS = auto()
    HELD = auto()
    STABILIZED = auto()
    RIGID_COUNT = auto()
    REACTION_ROWS = auto()
    EACH_STAGE = auto()
    CORRECTING = auto()
    PARAMETER_COUNT = auto()
    LOOPS = auto()
    PLAN_SIZE = auto()
    # Arrays.
    JACOBIAN_ROWS = auto()
    JACOBIAN_COLUMNS = auto()
    JACOBIAN_VALUES = auto()
    DENSE_JACOBIAN = auto()
    ROW_ORDER = auto()
    COLUMN_ORDER = auto()
    LOG_TIMES = auto()
    LOG_SETS = auto()
    LOW = auto()
    HIGH = auto()
    SHARE = auto()
    RIGID = auto()
    STICKS = auto()
    RESTITUTION = auto()
    PLAIN = auto()
    LIMITS = auto()
    SOUGHT = auto()
    UNIT = auto()
    REACTION = auto()
    WORK = auto()
    SETTINGS = auto()
    WEIGHTS = auto()
    MEMORY = auto()
    NOTES = auto()
    PIVOTS = auto()
    PIVOT_COLUMNS = auto()
    PLAN = auto()
    LOOP_ROWS = auto()
    NEARNESS = auto()
    SPREADS = auto()
    WORKSPACE = auto()
    SURFACES = auto()
    PARAMETERS = auto()
    MODES = auto()
    MULTIPLIERS = auto()


accelerations_of = at(Accelerations, Slot.ACCELERATIONS)
correction_of = at(Correction, Slot.CORRECTION)
jacobian_of = at(Jacobian, Slot.JACOBIAN)
switching_of = at(Switching, Slot.SWITCHING)
switching_rates_of = at(SwitchingRates, Slot.SWITCHING_RATES)
constraints_of = at(RightSide, Slot.CONSTRAINTS)
velocity_rhs_of = at(RightSide, Slot.VELOCITY_RHS)
acceleration_rhs_of = at(StateRightSide, Slot.ACCELERATION_RHS)
mass_of = at(Mass, Slot.MASS)
applied_forces_of = at(AppliedForces, Slot.APPLIED_FORCES)
gap_accelerations_of = at(SwitchingRates, Slot.GAP_ACCELERATIONS)
accelerations_tangent_of = at(AccelerationsTangent, Slot.ACCELERATIONS_TANGENT)
correction_tangent_of = at(CorrectionTangent, Slot.CORRECTION_TANGENT)
stages_of = at(Stages, Slot.STAGES)
error_of = at(Error, Slot.ERROR)
dense_of = at(Dense, Slot.DENSE)
propose_of = at(Propose, Slot.PROPOSE)
accepted_of = at(Hook, Slot.ACCEPTED)
restart_of = at(Hook, Slot.RESTART)
correct_of = at(Correct, Slot.CORRECT)
attempt_of = at(Attempt, Slot.ATTEMPT)
repartition_of = at(Repartition, Slot.REPARTITION)
locate_of = at(Locate, Slot.LOCATE)
sampled_of = at(Sampled, Slot.SAMPLED)
settle_of = at(Settle, Slot.SETTLE)
begin_of = at(Settle, Slot.BEGIN)
first_step_of = at(FirstStep, Slot.FIRST_STEP)
emit_of = at(Emit, Slot.EMIT)
watch_of = at(Watch, Slot.WATCH)
bent_of = at(Field, Slot.BENT)
bent_slope_of = at(Slope, Slot.BENT_SLOPE)
limited_of = at(Limit, Slot.LIMITED)
margins_of = at(Margins, Slot.MARGINS)
reactions_of = at(Reactions, Slot.REACTIONS)
switched_reactions_of = at(SwitchedReactions, Slot.SWITCHED_REACTIONS)
transition_of = at(Transition, Slot.TRANSITION)
impact_of = at(Impact, Slot.IMPACT)
return_held_of = at(ReturnHeld, Slot.RETURN_HELD)
vanishing_of = at(Vanishing, Slot.VANISHING)
dead_centres_of = at(Switching, Slot.DEAD_CENTRES)
passed_of = at(Passed, Slot.PASSED)

# Compiled code needs plain numbers.
COORDINATES = int(Slot.COORDINATES)
CONSTRAINT_COUNT = int(Slot.CONSTRAINT_COUNT)
RANK = int(Slot.RANK)
SWITCHES = int(Slot.SWITCHES)
NONZEROS = int(Slot.NONZEROS)
LOG_ROWS = int(Slot.LOG_ROWS)
BENDS = int(Slot.BENDS)
EACH_STAGE = int(Slot.EACH_STAGE)
CORRECTING = int(Slot.CORRECTING)
JACOBIAN_ROWS = int(Slot.JACOBIAN_ROWS)
JACOBIAN_COLUMNS = int(Slot.JACOBIAN_COLUMNS)
JACOBIAN_VALUES = int(Slot.JACOBIAN_VALUES)
DENSE_JACOBIAN = int(Slot.DENSE_JACOBIAN)
ROW_ORDER = int(Slot.ROW_ORDER)
COLUMN_ORDER = int(Slot.COLUMN_ORDER)
LOG_TIMES = int(Slot.LOG_TIMES)
LOG_SETS = int(Slot.LOG_SETS)
HELD = int(Slot.HELD)
STABILIZED = int(Slot.STABILIZED)
RIGID_COUNT = int(Slot.RIGID_COUNT)
LOW = int(Slot.LOW)
HIGH = int(Slot.HIGH)
SHARE = int(Slot.SHARE)
RIGID = int(Slot.RIGID)
STICKS = int(Slot.STICKS)
RESTITUTION = int(Slot.RESTITUTION)
PLAIN = int(Slot.PLAIN)
LIMITS = int(Slot.LIMITS)
SOUGHT = int(Slot.SOUGHT)
UNIT = int(Slot.UNIT)
REACTION = int(Slot.REACTION)
REACTION_ROWS = int(Slot.REACTION_ROWS)
WORK = int(Slot.WORK)
SETTINGS = int(Slot.SETTINGS)
WEIGHTS = int(Slot.WEIGHTS)
MEMORY = int(Slot.MEMORY)
NOTES = int(Slot.NOTES)
PIVOTS = int(Slot.PIVOTS)
PIVOT_COLUMNS = int(Slot.PIVOT_COLUMNS)
PLAN = int(Slot.PLAN)
PLAN_SIZE = int(Slot.PLAN_SIZE)
WORKSPACE = int(Slot.WORKSPACE)
SURFACES = int(Slot.SURFACES)
PARAMETERS = int(Slot.PARAMETERS)
PARAMETER_COUNT = int(Slot.PARAMETER_COUNT)
MODES = int(Slot.MODES)
MULTIPLIERS = int(Slot.MULTIPLIERS)
LOOPS = int(Slot.LOOPS)
LOOP_ROWS = int(Slot.LOOP_ROWS)
NEARNESS = int(Slot.NEARNESS)
SPREADS = int(Slot.SPREADS)
