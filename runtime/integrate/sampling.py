"""Samples of a run: at the instants asked for, or at the end of every step."""

from runtime.constraints.newton_return import FAILED, WEAK
from runtime.core.array_views import view
from runtime.core.dense_output import interpolate
from runtime.core.function_table import CORRECTING, HELD, correct_of, dense_of, return_held_of
from runtime.core.jit import addressed, inner
from runtime.core.signatures import EMIT, IntegerMatrix, Integers, Matrix, Vector
from runtime.core.workspace import PROJECTION, ROWS, SAMPLE, Y1, Run


@inner
def record(
    t: float,
    state: int,
    w: Vector,
    run: Run,
    modes: Integers,
    out_t: Vector,
    out_y: Matrix,
    out_modes: IntegerMatrix,
) -> None:
    """Append the state in row `state` and the modes in force to the samples."""
    r = run[0]
    length = w.size // ROWS
    y = view(w, state * length, length)
    at = r.samples
    out_t[at] = t
    for j in range(length):
        out_y[at, j] = y[j]
    for k in range(modes.size):
        out_modes[at, k] = modes[k]
    r.samples += 1


@addressed(EMIT)
def emit(
    machine: Integers,
    t: float,
    t1: float,
    h: float,
    dense_ready: int,
    w: Vector,
    run: Run,
    p: Vector,
    modes: Integers,
    lam: Vector,
    t_eval: Vector,
    out_t: Vector,
    out_y: Matrix,
    out_modes: IntegerMatrix,
) -> int:
    """Write the samples after `t` up to `t1`, corrected onto the constraints and what is held.

    Returns a negative number where a sample could not be corrected, else 0.
    """
    r = run[0]
    if r.every_step != 0:
        record(t1, Y1, w, run, modes, out_t, out_y, out_modes)
        return 0
    while r.next_sample < t_eval.size and t_eval[r.next_sample] <= t1:
        at = t_eval[r.next_sample]
        if at == t1:
            record(t1, Y1, w, run, modes, out_t, out_y, out_modes)
        else:
            if dense_ready == 0:
                dense_of(machine)(machine, t, h, w, p, modes, lam)
                dense_ready = 1
                r.dense_outputs += 1
                r.rhs += r.dense_calls
            interpolate(w, r.dense_rows, (at - t) / h, SAMPLE)
            # Near a singular position a return onto the constraints would move the sample further
            # than it errs.
            corrected = lam.size > 0 and machine[CORRECTING] != 0
            if corrected and not r.blind_from < at < r.blind_to:
                result = correct_of(machine)(machine, at, SAMPLE, PROJECTION, w, p)
                if result == FAILED:
                    return FAILED
                r.corrections += result % WEAK
            if machine[HELD] != 0:
                return_held_of(machine)(machine, at, SAMPLE, w, p, modes, lam)
            record(at, SAMPLE, w, run, modes, out_t, out_y, out_modes)
        r.next_sample += 1
    return 0
