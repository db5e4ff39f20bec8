"""The table by which compiled code reaches a machine, its method, the loop's parts and its arrays.

`x_of(context)` takes a function out of the table, ``context.x`` is an array of it, ``context[X]`` a
number. A part that needs something rare thus costs the others nothing.
"""

from runtime.core.arrays import f8, i8, integers, none, vector
from runtime.core.function_table_layout import TableLayout

TABLE = TableLayout(attributes=True)  # the declaration that all below derives from

RECENT = 8  # instants of the last events that are kept

# Numbers.
COORDINATES = TABLE.number("coordinates")  # n
CONSTRAINT_COUNT = TABLE.number("constraint_count")  # m
SWITCHES = TABLE.number("switches")  # s
RANK = TABLE.number("rank")  # of the Jacobian
NONZEROS = TABLE.number("nonzeros")  # structural, of the Jacobian
PARAMETER_COUNT = TABLE.number("parameter_count")  # derived constants included
RIGID_COUNT = TABLE.number("rigid_count")  # rigid contacts
SUPERPOSES = TABLE.number("superposes")  # 0: friction follows from what keeps functions at zero
LINEAR_REACTIONS = TABLE.number("linear_reactions")  # 0: friction follows from multipliers
REACTION_ROWS = TABLE.number("reaction_rows")
POWER_OF_MULTIPLIERS = TABLE.number("power_of_multipliers")  # 1: powers depend on them
POWER_ROWS = TABLE.number("power_row_count")  # works that are outputs included
LOOPS = TABLE.number("loops")  # that kernels close in closed form
SPARSE = TABLE.number("sparse")  # 1: a large machine, whose Jacobian is never a dense matrix
DENSE_ROWS = TABLE.number("dense_rows")  # its rows where it is one
PLAN_SIZE = TABLE.number("plan_size")  # of the elimination
WORKSPACE_SIZE = TABLE.number("workspace_size")
SWITCHING_SIZE = TABLE.number("switching_size")
METHOD_FLOATS_SIZE = TABLE.number("method_floats_size")  # floats that a method remembers
METHOD_INTEGERS_SIZE = TABLE.number("method_integers_size")  # integers that a method remembers
LOG_ROWS = TABLE.number("log_rows")  # room for changes of the partition
SAMPLE_TIMES = TABLE.number("sample_time_count")  # instants of samples that are asked for
OUT_ROWS = TABLE.number("out_rows")  # room for samples
EVENT_ROWS = TABLE.number("event_rows")  # room for events
STOPS = TABLE.number("stop_count")  # instants, known beforehand, at which steps end
MODIFIED = TABLE.number("modified")  # not 0: the right-hand side is not the kernel's alone
SLIDING_COUNT = TABLE.number("sliding_count")  # functions in sliding mode
STABILIZED = TABLE.number("stabilized")  # 1: constraints are stabilized by Baumgarte's terms
PEAKS = TABLE.number("peaks")  # functions of the position that may peak within a step
STATES = TABLE.number("states")  # states of first order that no clock renews
SAMPLED = TABLE.number("sampled")  # values that clocks renew
WATCHED = TABLE.number("watched_count")  # conditions that are watched
CONTROLLERS = TABLE.number("controllers")  # those among them that Python computes
QUEUE = TABLE.number("queue")  # samples of one value that wait for their delay, at most
EACH_STAGE = TABLE.number("each_stage")  # 1: every stage returns onto the constraints
CORRECTING = TABLE.number("correcting")  # how a step returns onto them

# The method. Arguments are in the comments.
STAGES = i8(integers, f8, f8)  # context t h; Newton iterations, negative where one failed
ERROR = f8(integers, f8, f8)  # context h rtol; over the tolerance, root mean square
DENSE = i8(integers, f8, f8)  # context t h
PROPOSE = f8(integers, f8)  # context h; ratio of two steps' lengths
HOOK = i8(integers, f8, f8)  # context t h; 1: another method is due
DIFFERENTIATE = i8(integers, f8, i8)  # context t state
stages_of = TABLE.function("stages", STAGES)
error_of = TABLE.function("error", ERROR)
dense_of = TABLE.function("dense", DENSE)
propose_of = TABLE.function("propose", PROPOSE)
accepted_of = TABLE.function("accepted", HOOK)
restart_of = TABLE.function("restart", HOOK)

# Parts of the loop.
PART = i8(integers)  # context; what follows, see `integrate.step`
CORRECT = i8(integers, f8, i8, i8)  # context t row weighing
TRIAL_STEP = i8(integers, f8, f8)  # context t h
REPARTITION = i8(integers, f8, i8)  # context t state
LOCATE = f8(integers)  # context
SAMPLE_FUNCTION = f8(integers, f8, i8)  # context x k
SELECT_MODES = i8(integers, i8, f8, f8, i8)  # context first t d state
FIRST_STEP = f8(integers, f8, f8, f8, i8)  # context t h_max rtol order
EMIT = i8(integers, f8, f8, f8, i8)  # context t t1 h dense_ready
SCREEN_STEP = i8(integers, f8, f8, f8)  # context t h t1
ACCELERATIONS = i8(
    integers, f8, vector, vector, integers, vector, vector
)  # context t q v modes a lam
RHS = i8(integers, f8, i8, i8)  # context t state derivative
IMPACT = f8(integers, i8, f8, i8)  # context first t state; time of the next flight
RETURN_TO_SURFACES = i8(integers, f8, i8)  # context t state
TRANSITION = i8(integers, i8, f8, f8)  # context crossing t h
FRICTION_MARGIN = f8(integers, f8, vector, vector, i8)  # context t q v k
MARGINS = none(integers, f8, i8, i8)  # context t state slot
VANISHING = f8(integers, f8, f8, i8)  # context t h state
RESOLVED_PART = f8(integers)  # context; of a step, at most 1
GUARD_BRANCHES = i8(integers, f8, f8, i8)  # context t h taken
BALANCE = i8(integers)  # context; 1: energy is not balanced
correct_of = TABLE.function("correct", CORRECT)
trial_step_of = TABLE.function("trial_step", TRIAL_STEP)
repartition_of = TABLE.function("repartition", REPARTITION)
locate_of = TABLE.function("locate", LOCATE)
sample_function_of = TABLE.function("sample_function", SAMPLE_FUNCTION)
select_modes_of = TABLE.function("select_modes", SELECT_MODES)
initialize_modes_of = TABLE.function("initialize_modes", SELECT_MODES)
first_step_of = TABLE.function("first_step", FIRST_STEP)
emit_of = TABLE.function("emit", EMIT)
screen_step_of = TABLE.function("screen_step", SCREEN_STEP)
modified_accelerations_of = TABLE.function("modified_accelerations", ACCELERATIONS)
sliding_accelerations_of = TABLE.function("sliding_accelerations", ACCELERATIONS)
modified_rhs_of = TABLE.function("modified_rhs", RHS)
impact_of = TABLE.function("impact", IMPACT)
return_to_surfaces_of = TABLE.function("return_to_surfaces", RETURN_TO_SURFACES)
transition_of = TABLE.function("transition", TRANSITION)
friction_margin_of = TABLE.function("friction_margin", FRICTION_MARGIN)
margins_of = TABLE.function("margins", MARGINS)
vanishing_of = TABLE.function("vanishing", VANISHING)
guard_branches_of = TABLE.function("guard_branches", GUARD_BRANCHES)
balance_step_of = TABLE.function("balance_step", BALANCE)
balance_event_of = TABLE.function("balance_event", BALANCE)

# Of runs with peaks alone.
resolved_part_of = TABLE.function("resolved_part", RESOLVED_PART)

# Of large machines alone.
FIND_PIVOTS = i8(integers, i8, i8)  # context row search; 1: no row follows from others
order_sparsely_of = TABLE.function("order_sparsely", PART)
find_pivots_sparsely_of = TABLE.function("find_pivots_sparsely", FIND_PIVOTS)

# Of runs with sampled values alone.
renew_of = TABLE.function("renew", PART)
watch_of = TABLE.function("watch", PART)

# The run: see `workspace_rows` for the rows of the first two.
TABLE.floats("workspace", WORKSPACE_SIZE)
TABLE.floats("switching_rows", SWITCHING_SIZE)
TABLE.floats("parameters", PARAMETER_COUNT, allotted=False)
TABLE.integers("modes", SWITCHES)
TABLE.floats("multipliers", CONSTRAINT_COUNT)
TABLE.floats("power_values", POWER_ROWS)
RECORD = TABLE.number("record")  # address of the run's record, see `loop_record`
TABLE.floats("settings", (2, None))  # length of the step, Baumgarte's time, s
TABLE.floats("method_floats", METHOD_FLOATS_SIZE)  # of the method
TABLE.integers("method_integers", METHOD_INTEGERS_SIZE)  # of the method

# The constraints: structure of the Jacobian, the partition, its changes.
TABLE.integers("jacobian_rows jacobian_columns", NONZEROS, allotted=False)
TABLE.floats("jacobian_values", NONZEROS)
TABLE.matrix("dense_jacobian", DENSE_ROWS, COORDINATES)
TABLE.flat("flat_jacobian", "dense_jacobian")
TABLE.integers("row_order pivot_rows pivot_columns", CONSTRAINT_COUNT)
TABLE.integers("column_order", COORDINATES)
TABLE.floats("log_times", LOG_ROWS)
TABLE.integer_matrix("log_sets", LOG_ROWS, COORDINATES)
TABLE.floats("weights", (4, COORDINATES))  # of Baumgarte's terms
TABLE.matrix("pivots", (4, None), CONSTRAINT_COUNT)  # see `singularity.prediction`
TABLE.floats("shortest", CONSTRAINT_COUNT)  # lengths of rows below which they are no unit rows
TABLE.floats("pivot_history", (2, None))
TABLE.integers("elimination_plan", PLAN_SIZE)
TABLE.floats("loop_nearness", (7, LOOPS))

# Switching functions.
TABLE.integers("rigid", SWITCHES)  # number of the rigid contact, or -1
TABLE.floats("spreads", SWITCHES)
TABLE.floats("share share_low share_high", SWITCHES)
TABLE.integers("sticks", SWITCHES)  # a `Hold`
TABLE.integers("boundary", SWITCHES)  # a `Boundary`
TABLE.integers("table_part", SWITCHES)  # a `TablePart`
TABLE.integers("limits", (2, SWITCHES))  # rows of a force and of its bound, or -1
TABLE.integers("stiction_place", SWITCHES)  # of its force in p, or -1
TABLE.integers("share_place", SWITCHES)  # of its share in p, or -1
TABLE.floats("stiction_units", (2, SWITCHES))  # unit of the force, its bound
TABLE.floats("restitution_coefficients", RIGID_COUNT)

# Sliding modes: the base, in which nothing slides, and the change by each function that does.
# Responses are d(dg/dt) or d(g̈): those of the base, and of each change, by rows.
TABLE.integers("kernel_modes sliding_functions", SWITCHES)
TABLE.floats("base_accelerations", COORDINATES)
TABLE.floats("base_multipliers mixed_multipliers given_multipliers", CONSTRAINT_COUNT)
TABLE.matrix("unit_accelerations", SWITCHES, COORDINATES)
TABLE.matrix("unit_multipliers", SWITCHES, CONSTRAINT_COUNT)
TABLE.floats("response response_copy response_secant", SWITCHES, SWITCHES)
TABLE.floats("base_response response_column response_rates right_side", SWITCHES)
TABLE.integers("response_pivots", SWITCHES)
TABLE.floats("response_gaps", RIGID_COUNT)
TABLE.floats("forces", COORDINATES)
TABLE.floats("force_rates", SWITCHES)  # of each change, see `measure_forces`
TABLE.floats("reaction base_reaction unit_reaction", REACTION_ROWS)  # the first is mixed

# Functions of the position that may peak within a step: see `hybrid.step_limits`.
TABLE.integers("peak_kinds", PEAKS)
TABLE.floats("peak_exponents", PEAKS)
TABLE.matrix("peak_rows", (8, None), PEAKS)  # u, du/dt at both ends, between

TABLE.integers("state_columns", STATES)  # of the velocities that they are
TABLE.floats("state_direction", STATES)  # in sizes, in which their rates change fastest

# Values that clocks renew: see `integrate.sampled_values`.
TABLE.integers("sampled_columns sample_triggers due", SAMPLED)
TABLE.floats("sample_clocks", (2, SAMPLED))  # period and delay of each, s
TABLE.integers("ticks", (2, SAMPLED))  # numbers of the next sample and of the next to act
TABLE.floats("sample_values", SAMPLED)
TABLE.matrix("waiting_samples", SAMPLED, QUEUE)
TABLE.integers("ends_run", WATCHED)  # 1: the condition ends the run; 2: joints come or go there
TABLE.floats("watched_before watched_now", WATCHED)  # 1: it holds

# The search for consistent modes; the function of the event that was located.
TABLE.integers("candidate_modes members signs former_modes", SWITCHES)
TABLE.integers("crossed", (1, None))

# Instants at which steps end, and whether the run is left there; see `integrate.problem.Stops`.
TABLE.floats("stop_times", STOPS, allotted=False)
TABLE.integers("stop_kinds", STOPS, allotted=False)

# Samples and events, made by `integrate.recording_buffers`.
TABLE.floats("sample_times", SAMPLE_TIMES, allotted=False)
TABLE.floats("out_times", OUT_ROWS, allotted=False)
TABLE.matrix("out_states", OUT_ROWS, (2, COORDINATES), allotted=False)
TABLE.integer_matrix("out_modes", OUT_ROWS, SWITCHES, allotted=False)
TABLE.floats("recent_events", (RECENT, None))
TABLE.floats("event_times", EVENT_ROWS, allotted=False)
TABLE.integer_matrix("event_kinds", EVENT_ROWS, (2, None), allotted=False)
TABLE.matrix("event_states", EVENT_ROWS, (2, COORDINATES), allotted=False)
