"""The members of an ensemble one after the other, in one compiled function.

It makes a run as `simulate` does, by the same compiled functions, as long as nothing calls for
more: the start is regular, the run reaches its end without a singular position or another method,
and no check at its end may find anything. Any other member is left to `simulate`.
"""

from typing import Any

import numpy as np

from runtime.assembly.regular_start import REGULAR, assemble_regular, place_counted
from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Vector, i8
from runtime.core.jit import inner, unlocked
from runtime.core.kernel_abi import conditions_of, constants_of, jacobian_of, mass_of
from runtime.core.kinds import KNOTS, SLIDING
from runtime.core.loop_record import run_record
from runtime.core.outcomes import Outcome
from runtime.dynamics.checks.screening import REVERSALS, count_unresolved, exceed_bound, screen
from runtime.dynamics.output_quantities import evaluate_samples, mix_rows
from runtime.integrate.initialization import start, write_start
from runtime.integrate.loop import advance
from runtime.integrate.step import Signal
from runtime.linalg.vectors import copy_vector, is_finite
from runtime.mechanism.typical_sizes import (
    compress,
    measure_length,
    spread_of_masses,
    write_mobility,
    write_scale,
)
from runtime.results.samples import Samples
from runtime.sweeps.ensemble_arrays import COMMON, DONE, LEFT, OWN, RESULTS, WAITING

_KNOTS = int(KNOTS)


@inner
def take_values(common: Any, own: Any, run: int) -> bool:
    """Write the parameters and start values of a member; false where a condition breaks."""
    copy_vector(common.p, own.p)
    copy_vector(common.q, own.q)
    copy_vector(common.v, own.v)
    for k in range(common.kinds.size):
        value, place = common.values[run, k], common.places[k]
        if common.kinds[k] == 0:
            own.p[place] = value
        elif common.kinds[k] == 1:
            own.q[place] = value
        else:
            own.v[place] = value
    constants_of(own.table)(own.p)
    conditions_of(own.table)(own.p, own.numbers)
    for c in range(common.first.size):
        number, low, high = own.numbers[common.first[c]], common.bounds[c, 0], common.bounds[c, 1]
        enough = np.isnan(low) or number > low or (number == low and common.bounds[c, 2] == 0.0)
        if not enough or not (np.isnan(high) or number <= high):
            return False
    return True


@inner
def write_inertia(common: Any, own: Any, q: Vector) -> bool:
    """Write the diagonal of M at q; false where a body has no positive finite mass."""
    mass_of(own.table)(q, own.p, own.masses)
    own.inertia[:] = 0.0
    for e in range(common.diagonal.size):
        if common.diagonal[e] >= 0:
            own.inertia[common.diagonal[e]] = own.masses[e]
    for j in range(q.size):
        if common.bodies[j] != 0 and not 0.0 < own.inertia[j] < np.inf:
            return False
    return True


@inner
def prepare_run(common: Any, own: Any, run: int) -> bool:
    """Put the table before the start of a member's run; false where that is not regular."""
    table, begin = own.table, own.start
    copy_vector(own.fresh_table, table)
    copy_vector(own.fresh_block, own.block)
    copy_vector(own.fresh_record, own.record)
    if not (take_values(common, own, run) and write_inertia(common, own, begin.neutral)):
        return False
    q, v, p, t = own.q, own.v, own.p, common.t
    place_counted(begin, t, p, q)
    if assemble_regular(begin, t, p, q, v) != REGULAR:
        return False
    write_scale(begin, measure_length(begin, t, q, p), own.sizes)
    write_inertia(common, own, q)
    write_mobility(own.inertia, own.sizes, begin.counted, own.mobility)
    compress(own.mobility, own.sizes)
    if common.widest < np.inf:
        jacobian_of(table)(t, q, p, own.slopes)
        for e in range(own.slopes.size):
            own.slopes[e] = abs(own.slopes[e])
        if not spread_of_masses(begin, own.inertia, own.slopes) < common.widest:
            return False
    write_start(table, q, v, own.sizes, own.mobility, common.absolute)
    return is_finite(own.mobility)


@inner
def take_samples(own: Any, samples: Any) -> bool:
    """Take over the states of the run; whether a function stays at zero in one of them."""
    context, sliding = own.table, False
    n = own.q.size
    for i in range(samples.t.size):
        samples.t[i] = context.out_times[i]
        for j in range(n):
            samples.q[i, j] = context.out_states[i, j]
            samples.v[i, j] = context.out_states[i, n + j]
        for k in range(samples.modes.shape[1]):
            mode = context.out_modes[i, k]
            samples.modes[i, k], own.modes[i, k] = mode, mode
            if mode == SLIDING:
                own.modes[i, k], sliding = 0, True
    return sliding


@inner
def is_beyond_doubt(common: Any, own: Any, samples: Any, unresolved: Any) -> bool:
    """Whether no check at the end may contradict a run, whose `unresolved` events are counted."""
    r, context, n = run_record(own.table), own.table, own.q.size
    if own.phi.size > 0 and exceed_bound(
        context, samples.t, samples.q, samples.residual, own.p, own.sizes, common.part, own.slopes
    ):
        return False
    e, s, last = r.logged_events, own.permitted.size, common.t
    for i in range(e):
        if not last <= context.event_times[i]:
            return False
        last = context.event_times[i]
    if not last <= r.t:
        return False
    if s == 0 and e == 0:
        return True
    own.scratch[:, :] = 0.0
    own.permitted[:] = 0.0
    states, kinds = context.event_states, context.event_kinds
    found = screen(
        context, own.p, samples.t, samples.q, samples.v, samples.modes, common.near, False,
        common.t, r.t, context.event_times[:e], states[:e, :n], states[:e, n:], kinds[:e, 0],
        kinds[:e, 1], r.rtol, ws.row_of(context, ws.ATOL), own.scratch, own.switches,
        own.reversed_event[:e], own.reached[:e], own.permitted,
    )  # fmt: skip
    if found == REVERSALS:
        count_unresolved(
            context.event_times[:e], kinds[:e, 0], own.reversed_event, own.reached, own.permitted,
            context.table_part, unresolved,
        )  # fmt: skip
    return found == 0 or found == REVERSALS  # noqa: PLR1714


@inner
def finish_run(common: Any, own: Any, results: Any, run: int) -> bool:
    """Compute the outputs of a run that has reached its end; false where it calls for more."""
    r, rows = run_record(own.table), results.samples
    samples = Samples(
        rows.t[run], rows.q[run], rows.v[run], rows.a[run], rows.lam[run], rows.reaction[run],
        rows.power[run], rows.energy[run], rows.residual[run], rows.modes[run], rows.share[run],
    )  # fmt: skip
    if r.t != r.t_end or r.samples != samples.t.size:
        return False
    if r.unlimited != 0 and np.isfinite(r.limit):
        return False
    sliding = take_samples(own, samples)
    samples.share[:, :] = np.nan
    begin = own.start
    evaluate_samples(
        own.table, samples, own.p, own.modes, begin.slope_rows, begin.slope_columns, own.slopes,
        own.phi, 0, own.phi[:0],
    )  # fmt: skip
    if sliding:
        copy_vector(own.fresh_mixing, own.mixing_block)
        mix_rows(
            own.mixing_table, begin, common.diagonal, samples, own.p, own.masses, own.powers, 0,
            own.phi[:0],
        )  # fmt: skip
    for k in range(samples.t.size):
        finite = is_finite(samples.a[k]) and is_finite(samples.reaction[k])
        if not (finite and is_finite(samples.power[k]) and is_finite(samples.energy[k])):
            return False
    unresolved = results.unresolved[run]
    unresolved[:, :] = 0.0
    if not is_beyond_doubt(common, own, samples, unresolved):
        return False
    results.steps[run], results.logged[run] = r.steps, r.logged_events
    table, kinds = own.table, own.table.event_kinds
    results.events[run] = 0
    for i in range(r.logged_events):
        results.events[run] += 1 if table.table_part[kinds[i, 0]] != _KNOTS else 0
    return True


@unlocked(i8(COMMON, OWN, RESULTS, i8, i8, i8))
def run_members(common: Any, own: Any, results: Any, first: Any, last: Any, budget: Any) -> int:
    """Run the waiting members from `first` up to `last`, with so many trial steps in all, about.

    Answers with the member to go on with, which may have begun; `last` where there is none.
    """
    run, r, s = first, run_record(own.table), own.permitted.size
    while run < last:
        going = own.begun[0] == run
        if results.status[run] == WAITING:
            if not going:
                going = prepare_run(common, own, run) and start(own.table) == Outcome.OK
            if going:
                own.begun[0] = run
                code = advance(own.table, budget)
                r.logged_repartitions = 0
                has_room = r.logged_events + 3 * s <= own.table[ft.EVENT_ROWS]
                if code == Signal.GOING and has_room:
                    return int(run)
                going = code == Outcome.OK and finish_run(common, own, results, run)
                budget -= min(budget - 1, r.steps + r.rejected)
            results.status[run] = DONE if going else LEFT
        own.begun[0] = -1
        run += 1
        if budget <= 1:
            return int(run)
    return int(run)
