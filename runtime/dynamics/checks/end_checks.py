"""Checks at the end of a run that reached its end: what they find contradicts the outcome OK.

Switches that turned and turned back by less than the tolerance do little, and are named: their
events may be error alone. A motion may touch a switching surface and not cross it, as a slider does
whose dead centre is where a force begins, or may stay beside it, as two bodies do that part from a
stiff contact. A looser run then has events that a tighter one has not.
"""

import numpy as np
import numpy.typing as npt

from runtime.core.kinds import SLIDING
from runtime.core.outcomes import Outcome, Site
from runtime.dynamics.checks.finite_results import end_before_infinite
from runtime.dynamics.checks.screening import (
    APART,
    CLOSED,
    HUGE,
    RESIDUAL,
    SIDE,
    TINY,
    Suspicions,
    change_of_switch,
    count_unresolved,
    write_switching_values,
)
from runtime.integrate.problem import Events, Options, Trajectory
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.module_tables import Description
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.validation.profiles import describe_cuts

Rows = npt.NDArray[np.intp] | slice

_JUDGED = 8  # measured: samples of each function that are searched for a missed event
_SIDE_TOLERANCES = 10.0  # safety: tolerances of a function by which its mode may miss its sign
UNSCREENED = Suspicions(residuals=True)  # of a result without a run
_SHOWN = 3  # layout: switches that the sentence names


def check_result(
    result: Result, equations: Equations, sizes: FloatArray, options: Options,
    run: Trajectory | None = None, suspicions: Suspicions = UNSCREENED, *, energy: bool = False,
) -> None:  # fmt: skip
    """Take the outcome OK from a result that a check contradicts, and say where and by how much.

    What is not suspected is not looked at. The `energy` of samples is judged where the run has not
    looked at all of it.
    """
    end_before_infinite(result, equations)
    if result.outcome is not Outcome.OK:
        return
    samples = result.samples
    cuts, found = describe_cuts(equations.mechanism, equations.p, samples), ""
    if suspicions.residuals:
        found = _residuals(equations, samples, sizes, options)
    if run is not None:
        order = _order_of_events(run) if suspicions.order_of_events else ""
        modes = unexplained = ""
        if suspicions.modes:
            modes = _sides_of_modes(equations, samples, sizes, options, run)
        if energy:
            from runtime.dynamics.checks.energy_balance import describe_unexplained_energy

            steps = run.statistics.steps
            unexplained = describe_unexplained_energy(equations, samples, sizes, options, steps)
        found = " ".join(filter(None, [order, modes, found, unexplained]))
    if found := " ".join(filter(None, [cuts, found])):
        outcome, result.contradiction = Outcome.CONTRADICTED, found
        result.outcome, result.site = outcome, Site.CHECKS.of("")
        result.message = f"{outcome.meaning} {found} {outcome.advice} {result.message}"


def _residuals(equations: Equations, samples: Samples, sizes: FloatArray, options: Options) -> str:
    """A sentence on samples whose residual exceeds what the tolerances permit; empty for none.

    A coordinate may err by `atol + rtol size`, and a constraint by the sum of that over what enters
    it. Sizes, (n,), are those of the run, and at least the lengths and speeds that it reached;
    angles have the size 1 however many turns they have made, since sin φ knows nothing of them.
    """
    if not len(samples.t) or not equations.m:
        return ""
    reached = np.abs(samples.q).max(axis=0)
    lengths = np.where(equations.description.is_angle, sizes, np.maximum(sizes, reached))
    speeds = np.maximum(sizes, np.abs(samples.v).max(axis=0))
    poses = (0, len(samples.t) // 2, -1)  # an arm may vanish in one of three
    slopes = [np.abs(equations.slopes(float(samples.t[k]), samples.q[k])) for k in poses]
    matrix, rtol = equations.matrix_of(np.fmax.reduce(slopes)), max(options.rtol, CLOSED)
    absolute = options.absolute(sizes, rtol).reshape(2, -1)
    for residual, atol, size, name, unit in zip(
        samples.residual.T, absolute, (lengths, speeds), ("Φ", "Φ_q v - ν"),
        ("m or rad", "m/s or rad/s"), strict=True,
    ):  # fmt: skip
        permitted = RESIDUAL * float((matrix @ (atol + rtol * size)).max())
        broken = np.flatnonzero(~(residual <= permitted))  # what is no number is broken too
        if len(broken):
            first, worst = float(samples.t[broken[0]]), float(residual[broken].max())
            return (
                f"From t = {first:.6g} s on the constraints are not satisfied: |{name}| reaches "
                f"{worst:.3g} {unit}, and the tolerances permit {permitted:.3g}."
                + _unresolved_angles(equations, samples, permitted)
            )
    return ""


def _unresolved_angles(equations: Equations, samples: Samples, permitted: float) -> str:
    """A sentence on angles that are too large for their sines to be as exact as `permitted`."""
    last = np.where(equations.description.is_angle, np.abs(samples.q[-1]), 0.0)
    names = [equations.description.coordinates[k].name for k in np.flatnonzero(last > 1.0)]
    if not names or np.spacing(last.max()) < 0.1 * permitted:
        return ""
    return f" The angles {', '.join(names)} are as large as {last.max():.3g} rad: too few digits."


def _order_of_events(run: Trajectory) -> str:
    """A sentence on events that are out of order or outside of the run; empty for none."""
    times = np.concatenate([[run.first_t], run.events.t, [run.final_t]])
    back = np.flatnonzero(np.diff(times) < 0.0)
    if not len(back):
        return ""
    return (
        f"Its events are not in order: t = {times[back[0]]:.9g} s comes before "
        f"{times[back[0] + 1]:.9g} s."
    )


def _sides_of_modes(
    equations: Equations, samples: Samples, sizes: FloatArray, options: Options, run: Trajectory
) -> str:
    """A sentence on a mode that contradicts the sign of its function; empty for none.

    By more than the tolerances of coordinates and velocities explain: an event was missed.
    """
    switches, g = equations.description.switches, np.zeros(len(equations.description.switches))
    wrong = _wrong_sides(equations, samples, run)
    t, q, v = samples.t, samples.q, samples.v
    largest = np.concatenate([np.abs(q).max(axis=0), np.abs(v).max(axis=0)])
    change = options.absolute(sizes, options.rtol) + options.rtol * largest
    for k in np.flatnonzero(wrong.any(axis=0)):
        rows = np.flatnonzero(wrong[:, k])
        worst = rows[np.argmax(np.abs(wrong[rows, k]))]
        # Beside a place where it jumps the tolerances explain anything.
        for row in (worst, *rows[:: 1 + len(rows) // _JUDGED]):
            permitted = change_of_switch(
                equations.table, k, t[row], np.concatenate([q[row], v[row]]), change, equations.p, g
            )
            missed = np.flatnonzero(np.abs(wrong[:, k]) > _SIDE_TOLERANCES * permitted)
            if abs(wrong[row, k]) > _SIDE_TOLERANCES * permitted:
                return (
                    f"From t = {t[missed[0]]:.6g} s on the mode of {switches[k].title} contradicts "
                    f"its switching function, which is {wrong[row, k]:.3g} at t = {t[row]:.6g} s: "
                    "an event was missed."
                )
    return ""


def _wrong_sides(equations: Equations, samples: Samples, run: Trajectory) -> FloatArray:
    """Switching functions where they contradict the modes of their samples, else 0, (k, s).

    In the instant of an event they may, unless the next sample does too, and at a kink or a jump of
    a function of time, unless they do on both sides. Behind it those modes count that the next
    sample has, if there is no event between the two.
    """
    modes, moves = samples.modes, bool(equations.description.time_functions)
    apart = APART * max(abs(run.first_t), abs(run.final_t))

    def values(rows: Rows, way: float) -> FloatArray:
        """The functions so long, s, behind these samples."""
        g = np.zeros(samples.modes[rows].shape)
        t, q, v = samples.t[rows] + way, samples.q[rows], samples.v[rows]
        write_switching_values(equations.table, t, q + way * v, v, equations.p, g)
        return g

    g = values(slice(None), 0.0)
    sides = np.where(modes == SLIDING, 0, 2 * modes - 1)
    around = np.concatenate([samples.t[:1], samples.t, samples.t[-1:]])
    aside = (sides == 0) | np.isnan(g)
    lasts = np.where(aside, 0.0, np.abs(around[2:] - around[:-2])[:, None])
    logarithms = lasts * np.log(np.where(aside, 1.0, np.clip(np.abs(g), TINY, HUGE)))
    least = SIDE * np.exp(logarithms.sum(axis=0) / np.maximum(lasts.sum(axis=0), 1e-300))
    contradicts = sides * g < -least
    suspects = np.flatnonzero(contradicts.any(axis=1))
    wrong = np.where(contradicts, g, 0.0)
    again = np.where((wrong[1:] != 0.0) & (wrong[:-1] != 0.0), wrong[:-1], 0.0)
    events = np.searchsorted(run.events.t, samples.t - apart)  # so many come before a sample
    if len(suspects):
        near = np.searchsorted(run.events.t, samples.t[suspects] + apart, side="right")
        wrong[suspects[near > events[suspects]]] = 0.0
        for way in (-apart, apart):
            turned = sides[suspects] * values(suspects, way) > 0.0
            wrong[suspects] = np.where(turned, 0.0, wrong[suspects])
    if moves:
        behind = values(slice(None, -1), apart)
        same = (events[1:] == events[:-1])[:, None]
        # A sample in the instant of an event may have the modes of either side of it.
        until = np.searchsorted(run.events.t, samples.t[1:] + apart, side="right")
        either = (until == events[1:])[:, None] | (sides[:-1] * behind < -least)
        behind = np.where(same & either & (sides[1:] * behind < -least), behind, 0.0)
        wrong[:-1] = np.where(wrong[:-1] == 0.0, behind, wrong[:-1])
    wrong[:-1] = np.where(wrong[:-1] == 0.0, again, wrong[:-1])
    return wrong


def describe_unresolved_switches(
    equations: Equations, events: Events, suspicions: Suspicions
) -> tuple[int, str]:
    """The number of events within the tolerance, and a sentence that names them; 0 and empty.

    Between two events of a switch, each the other's reverse, its function is taken at the middle of
    Hermite's polynomial through both states. It may err by what it changes with each coordinate and
    velocity by their tolerances `atol + rtol |y|`.
    """
    if not suspicions.reversals:
        return 0, ""
    description = equations.description
    parts, found = np.array(description.table_parts), np.zeros((len(description.switches), 4))
    count_unresolved(events.t, events.index, *suspicions[-3:], parts, found)
    return int(found[:, 0].sum()), sentence_of_unresolved(description, found, len(events.t))


def sentence_of_unresolved(description: Description, found: FloatArray, count: int) -> str:
    """A sentence on switches with events within the tolerance, of `count` in all; or empty.

    `found`, (s, 4), is what `count_unresolved` writes.
    """
    within = np.flatnonzero(found[:, 0])
    if not len(within):
        return ""
    clauses = [
        f"{description.switches[int(k)].title} ({found[k, 0]:.0f} from t = {found[k, 1]:.6g} s on, "
        f"past zero by {found[k, 2]:.1g}, permitted {found[k, 3]:.1g})"
        for k in within
    ]
    shown = "; ".join(clauses[:_SHOWN]) + (" and others" if len(clauses) > _SHOWN else "")
    return (
        f" {found[:, 0].sum():.0f} of {count} events lie within the tolerance, and a tighter rtol "
        f"may not have them: {shown}."
    )
