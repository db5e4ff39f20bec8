"""Balance of energy in a run: the work of each step explains the change of energy in it.

    Δ(T + V) = ∫ Σ powers dt

Powers are those of effects without a potential, as which one counts that depends on the time, of
drivers and of constraints that move. Four steps in a row are watched, then 92 are not, but for the
first 96 and the last of a run; where nothing but potentials acts, the energy tells of these too. At
the end of a step a parabola through the last three powers tells what it can. Where it leaves a
larger part of the exchanged energy unexplained than it has lately in steps that were right, and in
a few steps of every run, the work is integrated by Gauss' rule over the dense output, and compared
with what the tolerances permit, and with the rounding of the potential. Where it is more, shorter
steps are taken, and a fault that stays ends the run. At an event the pieces of the potential have
to meet, and an impact must not raise the kinetic energy where nothing moves by itself.

Nothing is said of steps in sliding modes, near singular positions, or without control of the error.

By how much the energy of a right run may miss its balance, in the loop and between samples.

Rounding of a potential whose terms cancel: what their sum does not show, its values scatter.

In a row of equally spaced states a smooth function has small differences of a high order, a jump
has large ones in its own neighbourhood, and rounding has them everywhere. The shape of a potential
that is too fine for a row has them too, but so have its slopes then: for a wave of any length the
tenth difference of the values is no larger than the ninth one of slope times distance. In a short
row coarse rounding does not show, as neighbours are equal; rows of many lengths are looked at.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, f8, integers
from runtime.core.dense_output import interpolate
from runtime.core.jit import addressed, inner
from runtime.core.kinds import SLIDING
from runtime.core.loop_record import Plan, run_record
from runtime.integrate.sampling import NODES, WEIGHTS

ERRORS = 50.0  # measured: tolerances by which the energy of a step may err
PART = 1e-3  # safety: of the energy that a step exchanges; so much need not be explained
ROUNDING = 1e-13  # accuracy: of an energy; rounding of the sums that it is made of
CERTAIN = 16.0  # measured: times the scatter of a potential; largest difference by rounding


Differences = tuple[float, float, float, float, float, float, float, float, float, float, float]

_GAIN = 430.0  # formula: root of the sum of squares of the coefficients of a tenth difference
_ORDER = 10  # measured: of the differences; lower orders show the shape of a potential more
_BLOCKS, _EACH = 4, 8  # measured: groups of differences, of which a jump disturbs two
_POINTS = 66  # formula: intervals of all groups
_SHAPE = 4.0  # safety: differences of slopes that the shape of a potential may reach
_LEAST_WAY, _LONGER = 1e-9, 10.0  # measured: first row in coordinates' sizes; growth of rows
_LONG, _LONGEST = 3.0, 3e6  # measured: of coordinates' sizes; last row if V varies, and if not


@inner
def evaluate_along(context: Context, t: float, way: float, i: int) -> float:
    """V of the state number i in a row, J; its positions go to row SAMPLE, the way to DELTA."""
    q0, q = context.q0, ws.positions(context, ws.SAMPLE)
    size, step = ws.row_of(context, ws.SIZE), ws.positions(context, ws.DELTA)
    for j in range(context[ft.COORDINATES]):
        # coordinates that moved alike would hide what depends on their differences
        turn = (1.0 - 2.0 * (j % 2)) * (1.0 + 0.3 * (j % 3))
        step[j] = way * turn * size[j] / _POINTS
        q[j] = q0[j] + i * step[j]
    return float(abi.potential_of(context)(t, q, context.parameters, context.modes))


@inner
def take_differences(value: float, before: Differences) -> Differences:
    """Differences of the orders 0 to 10 that end at this value, from those one place before."""
    d1 = value - before[0]
    d2 = d1 - before[1]
    d3 = d2 - before[2]
    d4 = d3 - before[3]
    d5 = d4 - before[4]
    d6 = d5 - before[5]
    d7 = d6 - before[6]
    d8 = d7 - before[7]
    d9 = d8 - before[8]
    return value, d1, d2, d3, d4, d5, d6, d7, d8, d9, d9 - before[9]


@inner
def measure_scatter(context: Context, t: float, way: float) -> tuple[float, int]:
    """Scatter of V along a row of states, J, or 0 for its shape; most equal pairs of a group."""
    q, step = ws.positions(context, ws.SAMPLE), ws.positions(context, ws.DELTA)
    gradient, least, most = ws.second_half(context, ws.DELTA), np.inf, 0
    for block in range(_BLOCKS):
        values = slopes = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        scatter, shape, equal = 0.0, 0.0, 0
        for i in range(_ORDER + _EACH):
            value = evaluate_along(context, t, way, 2 * _EACH * block + i)
            abi.potential_gradient_of(context)(t, q, context.parameters, context.modes, gradient)
            slope = 0.0
            for j in range(context[ft.COORDINATES]):
                slope += gradient[j] * step[j]
            values, slopes = take_differences(value, values), take_differences(slope, slopes)
            equal += 1 if values[1] == 0.0 else 0
            if i >= _ORDER - 1:
                shape = max(shape, abs(slopes[_ORDER - 1]))
            if i >= _ORDER:
                scatter = max(scatter, abs(values[_ORDER]))
        if not np.isfinite(scatter + shape):
            return np.nan, most
        most = max(most, equal)
        least = min(least, scatter if scatter > _SHAPE * shape else 0.0)
    return least / _GAIN, most


@addressed(f8(integers, f8))
def measure_rounding(context: Context, t: float) -> float:
    """By how much two values of the potential about the step may differ by rounding, J."""
    rounding, before, equal, way = 0.0, 0, 0, _LEAST_WAY
    # where many neighbours are equal, few show their rounding; one row more: in the first that is
    # longer, all groups need not scatter
    while way < _LONG or (way < _LONGEST and 2 * before > _ORDER + _EACH):
        before = equal
        scatter, equal = measure_scatter(context, t, way)
        if not np.isfinite(scatter):
            break
        rounding = max(rounding, CERTAIN * scatter)
        way *= _LONGER
    return rounding


RULE = tuple(float(weight) for weight in WEIGHTS)
OUTER = 1.0 / (3.0 * NODES[4] ** 2)  # formula: weights of the first, third and fifth node alone
INNER = 2.0 - 2.0 * OUTER  # formula: so that parabolas are integrated

_MEET = 1e-9  # accuracy: of the energy; difference up to which the pieces of a potential meet
_ROUGH = 0.01  # measured: of the exchanged energy; a parabola of the powers explains the rest
_MORE = 4.0  # measured: growth of the unexplained part from which on the step is examined
_FORGET = 0.98  # measured: part of both that the next step keeps: one step in 70 is examined
_SELDOM = 60  # measured: steps before the first look in any case; k² times as many before the k-th
_OFTEN = 1024  # measured: most steps between two looks, each of which costs some evaluations
_WATCHED, _CYCLE = 4, 96  # measured: steps watched of so many; 0.3 to 1.8 % of a run in all


@inner
def evaluate_power(context: Context, t: float, row: int, known: bool) -> float:
    """Σ powers of the state in a row of the workspace, W; `known`: the multipliers are its."""
    r, p, modes = run_record(context), context.parameters, context.modes
    q, v = ws.positions(context, row), ws.velocities(context, row)
    lam, total = context.multipliers, 0.0
    if r.power_rows > 0:
        if not known and context[ft.POWER_OF_MULTIPLIERS] != 0:
            lam = context.base_multipliers
            abi.accelerations_of(context)(t, q, v, p, modes, context.second_scratch, lam)
            r.balance_rhs += 1
        abi.powers_of(context)(t, q, v, p, modes, lam, context.power_values)
        for i in range(r.power_rows):
            total += context.power_values[i]
    return total


@inner
def permit_error(context: Context, t: float, row: int) -> float:
    """By how much the tolerances permit the energy of a state to err, J."""
    r, p, n = run_record(context), context.parameters, context[ft.COORDINATES]
    q, v = ws.positions(context, row), ws.velocities(context, row)
    atol, kinetic = ws.row_of(context, ws.ATOL), abi.kinetic_energy_of(context)
    errors, gradient = ws.first_half(context, ws.DELTA), ws.second_half(context, ws.DELTA)
    for j in range(n):
        errors[j] = atol[n + j] + r.rtol * abs(v[j])
    # Schwarz' inequality in the metric of the masses
    energy, least = kinetic(q, v, p), kinetic(q, errors, p)
    error = 2.0 * np.sqrt(abs(energy * least)) + least
    abi.potential_gradient_of(context)(t, q, p, context.modes, gradient)
    for j in range(n):
        error += abs(gradient[j]) * (atol[j] + r.rtol * abs(q[j]))
    return float(ERRORS * error + ROUNDING * energy)


@inner
def integrate_power(context: Context, t: float, h: float) -> tuple[float, float, float]:
    """Work over the step by its dense output, how rough that is, and what was exchanged, J."""
    r = run_record(context)
    work, rough, size = 0.0, 0.0, 0.0
    if r.power_rows == 0:
        return work, rough, size
    ft.dense_of(context)(context, t, h)
    r.balance_rhs += r.dense_calls
    for i in range(5):
        node = NODES[i]
        x = 0.5 * (1.0 + node)
        interpolate(context, r.dense_rows, x, ws.SAMPLE)
        power = evaluate_power(context, t + x * h, ws.SAMPLE, False)
        work += RULE[i] * power
        size += RULE[i] * abs(power)
        if i == 2:
            rough += INNER * power
        elif i % 2 == 0:
            rough += OUTER * power
    return 0.5 * h * work, 0.5 * h * abs(work - rough), 0.5 * h * size


@inner
def start_balance(context: Context, t: float, row: int) -> None:
    """Energy and power of the state in a row of the workspace, from which a step begins."""
    r = run_record(context)
    q, v = ws.positions(context, row), ws.velocities(context, row)
    potential = abi.potential_of(context)(t, q, context.parameters, context.modes)
    r.energy = abi.kinetic_energy_of(context)(q, v, context.parameters) + potential
    r.energy_step, r.slope = r.steps, np.nan
    r.power = evaluate_power(context, t, row, False)
    r.scatter = permit_error(context, t, row)


@inner
def is_explained(context: Context, t: float, h: float, change: float) -> bool:
    """Whether the work over the step is its change of energy, as well as the run can tell."""
    r = run_record(context)
    work, rough, size = integrate_power(context, t, h)
    r.scatter = max(permit_error(context, t, ws.Y0), permit_error(context, r.end, ws.Y1))
    r.unexplained, r.explained = change - work, work
    rounding = r.rounding + ROUNDING * (abs(r.energy) + abs(change))
    steps = 1 + r.steps - r.energy_step
    permitted = r.scatter * steps + rounding + rough + PART * (size + abs(change))
    if not abs(change - work) > permitted:
        return True
    r.rounding = max(r.rounding, measure_rounding(context, t))
    return not abs(change - work) > permitted + r.rounding


@addressed(ft.BALANCE)
def balance_step(context: Context) -> int:
    """1 where the step that is about to be accepted breaks the balance of energy, else 0.

    `run.explained` is the work then, and `run.unexplained` the change of energy less that.
    """
    r = run_record(context)
    t, t1, h = r.t, r.end, r.length
    # the next step, or the first of the next ones that are watched in a row
    last = r.steps % _CYCLE + 1 >= _WATCHED and r.steps >= _CYCLE and t1 >= r.doubtful
    r.balance_at = r.steps + (_CYCLE - r.steps % _CYCLE if last else 1)
    if context[ft.SLIDING_COUNT] != 0 or r.plan != Plan.FREE or r.planned != 0:
        r.energy = np.nan
        return 0
    if np.isnan(r.energy) or (r.energy_step != r.steps and r.power_rows != 0):
        start_balance(context, t, ws.Y0)
    p, modes = context.parameters, context.modes
    known = r.dense_ready == 0
    potential = abi.potential_of(context)(t1, context.q1, p, modes)
    energy = abi.kinetic_energy_of(context)(context.q1, context.v1, p) + potential
    power = evaluate_power(context, t1, ws.Y1, known)
    change = energy - r.energy
    slope, curvature = (power - r.power) / h, 0.0
    if not np.isnan(r.slope):
        curvature = 2.0 * (slope - r.slope) / (h + r.slope_over)
    left = abs(change - 0.5 * h * (r.power + power) + h * h * h * curvature / 12.0)
    noise = r.scatter * (1 + r.steps - r.energy_step) + r.rounding
    exchanged = 0.5 * h * (abs(r.power) + abs(power)) + noise
    r.usual_part *= _FORGET
    r.rounding *= _FORGET
    due = r.balances * min(r.balances * _SELDOM, _OFTEN) <= r.steps or t1 >= r.t_end
    due = due or t < r.doubtful
    if left > max(_ROUGH, _MORE * r.usual_part) * exchanged or due:
        r.balances += 1 if due and not t < r.doubtful else 0
        if not is_explained(context, t, h, change):
            r.doubts = r.doubts + 1 if t < r.doubtful else 1
            r.doubtful, r.balance_at = max(r.doubtful, t1), r.steps
            return 1
        r.usual_part = max(r.usual_part, left / max(exchanged, 1e-300))
    r.energy, r.power, r.energy_step = energy, power, r.steps + 1
    r.slope, r.slope_over = slope, h
    return 0


@inner
def is_scleronomic(context: Context, t: float) -> bool:
    """Whether nothing moves by itself at Y1: no driver, no constraint and no gap of a contact."""
    q, p, rest = context.q1, context.parameters, ws.positions(context, ws.SAMPLE)
    rates, rest_rates = ws.row_of(context, ws.PREDICTED), ws.switch_row(context, ws.TRIAL)
    abi.velocity_rhs_of(context)(t, q, p, rates)
    rest.fill(0.0)
    abi.switching_rates_of(context)(t, q, rest, rest, p, rest_rates)
    for i in range(context[ft.CONSTRAINT_COUNT]):
        if rates[i] != 0.0:
            return False
    for k in range(context[ft.SWITCHES]):
        if context.rigid[k] >= 0 and rest_rates[k] != 0.0:
            return False
    return True


@addressed(ft.BALANCE)
def balance_event(context: Context) -> int:
    """1 where energy jumps at an event, to the modes and velocities that Y1 has now, else 0.

    The pieces of a potential have to meet, and an impact may take energy but not give any.
    """
    r = run_record(context)
    q, v, p = context.q1, context.v1, context.parameters
    former, potential = context.former_modes, abi.potential_of(context)
    r.energy = np.nan  # velocities and forces are others from here on
    r.explained = 0.0
    if context[ft.RIGID_COUNT] != 0:
        gain = abi.kinetic_energy_of(context)(q, v, p) - r.before_event
        if gain > _MEET * r.before_event and is_scleronomic(context, r.end):
            r.unexplained = gain
            if gain > _MEET * r.before_event + permit_error(context, r.end, ws.Y1):
                return 1
    apart = context[ft.SLIDING_COUNT] != 0 or r.plan != Plan.FREE
    for k in range(former.size):
        apart = apart or former[k] == SLIDING
    if apart:
        return 0
    now, before = potential(r.end, q, p, context.modes), potential(r.end, q, p, former)
    if now == before:
        return 0
    bound = _MEET * (abi.kinetic_energy_of(context)(q, v, p) + abs(now) + abs(before))
    if not abs(now - before) > bound:
        return 0
    r.unexplained = now - before
    r.rounding = max(r.rounding, measure_rounding(context, r.end))
    bound += permit_error(context, r.end, ws.Y1) + r.rounding
    return 1 if abs(now - before) > bound else 0
