"""Kinematic analysis: the motion of a machine whose drivers leave it no freedom."""

import time as clock
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError
from runtime.analyses.assemble import Assembly, assemble, start_values
from runtime.analyses.branches import branches
from runtime.analyses.door import shown
from runtime.analyses.equations import Equations, FloatArray
from runtime.analyses.outputs import evaluate
from runtime.analyses.redundant import sound, spared
from runtime.analyses.walking import (
    DONE,
    MARK,
    NEWTON,
    RECORD,
    REJECTED,
    STEP,
    STEPS,
    T,
    settle,
    walk,
)
from runtime.outcomes import Outcome
from runtime.progress import Progress, silent
from runtime.results.result import Result

if TYPE_CHECKING:
    from runtime.machine import Machine, Values

_CHUNK = 4096
_JUMPS = 2.0 ** np.arange(-34, -9)


class Walk(NamedTuple):
    """A driven motion: states at the instants reached, and where it locked, if it did."""

    t: FloatArray
    q: FloatArray
    v: FloatArray
    locked: bool
    message: str
    stats: dict[str, float]
    p: FloatArray


def kinematics(
    machine: "Machine",
    t_eval: npt.ArrayLike,
    *,
    parameters: "Values | None" = None,
    guess: "Values | None" = None,
    t_start: float = 0.0,
    progress: Progress = silent,
    analysis: str = "kinematics",
) -> Result:
    """Positions, velocities and accelerations at the instants `t_eval`.

    Where the machine locks up, the result reaches to the last instant before, followed by the last
    position at which it assembles; the outcome says so.

    Parameters
    ----------
    t_eval
        Instants in s, increasing.
    guess
        Start values by name, over those of the scene.
    t_start
        Instant in s to which the start values belong. The machine is assembled there and followed
        to the first of `t_eval`, so that it stays on the branch on which it starts.
    """
    began = clock.perf_counter()
    times = instants(t_eval)
    start = assemble(machine, guess, parameters, t_start)
    require_driven(machine, start, analysis)
    machine = sound(machine, start)
    wished = start_values(machine, guess).v
    found = follow(machine, times, start, wished, parameters, progress)
    samples = evaluate(machine, found.p, found.t, found.q, found.v)
    instants_lost = np.flatnonzero(np.isnan(samples.a).any(axis=1))
    found.stats["singular_instants"] = len(instants_lost)
    message = found.message
    if len(instants_lost) and not found.locked:
        where = ", ".join(f"{samples.t[index]:.6g}" for index in instants_lost[:5])
        message += (
            f" At {len(instants_lost)} of the instants (t = {where} s) the position is singular: "
            f"accelerations and reactions are not a number there."
        )
    found.stats["wall_seconds"] = clock.perf_counter() - began
    return Result(
        machine,
        samples,
        found.p,
        analysis=analysis,
        outcome=Outcome.LOCKED if found.locked else Outcome.OK,
        message=message + spared(start),
        stats=found.stats,
        not_unique=start.not_unique,
    )


def instants(t_eval: npt.ArrayLike) -> FloatArray:
    """The output instants as an array, checked."""
    try:
        given = np.asarray(t_eval)
    except (TypeError, ValueError):
        given = np.asarray(None)
    if given.dtype.kind not in "iuf":
        raise AnalysisError(f"t_eval is {shown(t_eval)}; it must be instants in s.")
    times = np.atleast_1d(given.astype(np.float64))
    if times.ndim != 1 or len(times) == 0 or not np.isfinite(times).all():
        raise AnalysisError("t_eval must be at least one finite instant in s, in one dimension.")
    backwards = np.flatnonzero(np.diff(times) <= 0.0)
    if len(backwards):
        place = int(backwards[0])
        raise AnalysisError(
            f"t_eval must increase: instant {place + 1} is {times[place + 1]:g} s "
            f"after {times[place]:g} s. Sort it and drop repetitions."
        )
    return times


def require_driven(machine: "Machine", start: Assembly, analysis: str) -> None:
    """Refuse a machine that its drivers leave free to move."""
    free = start.degrees_of_freedom
    if free == 0:
        return
    told = machine.description
    drivers = ", ".join(told.drivers) or "none"
    left_out = [row.name for row in told.left_out if "driver" in row.kind]
    hint = f" Declared but left out of this scene: {', '.join(left_out)}." if left_out else ""
    raise AnalysisError(
        f"{told.title}: {analysis.replace('_', ' ')} needs a machine without freedom, and "
        f"{free} degree{'s' if free > 1 else ''} of freedom "
        f"{'are' if free > 1 else 'is'} left ({len(told.coordinates)} coordinates, drivers: "
        f"{drivers}). Add {free} driver{'s' if free > 1 else ''} to the scene, "
        f"or ask for simulate.{hint}"
    )


def follow(
    machine: "Machine",
    times: FloatArray,
    start: Assembly,
    wished: FloatArray,
    parameters: "Values | None",
    progress: Progress,
) -> Walk:
    """Walk from the assembled start through `times`; `wished`: the start velocities asked for."""
    p = machine.parameter_values(parameters)
    equations = Equations(machine, p)
    scale = equations.scale(equations.size(start.t, start.q))
    w = scale * scale
    n, count = equations.n, len(times)
    q, v = start.q.copy(), start.v.copy()
    modes = np.zeros(len(machine.description.switches), dtype=np.int64)
    a, lam, weak = equations.motion(start.t, q, v, modes)
    q_out, v_out = np.zeros((count, n)), np.zeros((count, n))
    record = np.zeros(RECORD)
    record[T] = start.t
    span = max(abs(float(times[-1]) - start.t), 1e-300)
    record[STEP] = max(span, 1.0)
    work = np.zeros((5, n))
    singular: list[float] = []
    locked = False
    started = ""
    if weak or start.singular:
        # Here Phi_q says neither which branch it is nor how it curves.
        moves = bool((times != start.t).any())
        for v[:], a[:] in branches(equations, start.t, q, wished, scale):
            if not moves or _jump(
                equations, times, (q, v, a, lam), (w, scale), q_out, v_out, record
            ):
                break
        else:
            raise _singular_start(machine, start, weak)
        started = (
            f" Started in a singular position at t = {start.t:.6g} s, on the branch nearest to "
            f"the start velocities."
        )
    while record[MARK] < count and not locked:
        chunk = min(int(record[MARK]) + _CHUNK, count)
        status = walk(
            machine.kernel_table, times[:chunk],
            p, w, scale, q, v, a, modes, lam, q_out, v_out, record, work,
        )  # fmt: skip
        if status != DONE:
            before = float(record[T])
            locked = not _jump(equations, times, (q, v, a, lam), (w, scale), q_out, v_out, record)
            if not locked:
                singular.append(0.5 * (before + float(record[T])))
        progress(abs(float(record[T]) - start.t) / span)
    done = int(record[MARK])
    stats: dict[str, float] = {
        "steps": int(record[STEPS]),
        "rejected": int(record[REJECTED]),
        "newton_iterations": int(record[NEWTON]),
        "singular_crossings": len(singular),
    }
    if not locked:
        message = f"{count} instants from t = {times[0]:g} to {times[-1]:g} s.{started}"
        if singular:
            where = ", ".join(f"{t:.6g}" for t in singular[:5])
            message += (
                f" Crossed {len(singular)} singular position(s) at t = {where} s on the branch "
                f"on which the velocity is continuous."
            )
        return Walk(times, q_out, v_out, False, message, stats, p)
    reached = float(record[T])
    t_out, q_out, v_out = times[:done], q_out[:done], v_out[:done]
    if done == 0 or reached > times[done - 1]:
        t_out, q_out, v_out = (
            np.append(t_out, reached),
            np.vstack([q_out, q]),
            np.vstack([v_out, v]),
        )
    return Walk(t_out, q_out, v_out, True, _lock_up(equations, reached, q), stats, p)


def _jump(
    equations: Equations,
    times: FloatArray,
    state: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    weights: tuple[FloatArray, FloatArray],
    q_out: FloatArray,
    v_out: FloatArray,
    record: FloatArray,
) -> bool:
    """Try to step over a singular position; true if there is a smooth continuation behind it.

    Behind a bifurcation the machine assembles again close to the prediction and with a continuous
    velocity; behind a lock-up it does not. Instants within the jump take the prediction.
    """
    q, v, a, lam = state
    w, scale = weights
    t = float(record[T])
    modes = np.zeros(len(equations.description.switches), dtype=np.int64)
    dq, dv, info = np.zeros(len(q)), np.zeros(len(q)), np.zeros(3)
    speed = float(np.abs(v / scale).max())
    back = times[int(record[MARK])] < t
    for size in _JUMPS / max(speed, 1e-3):
        jump = -size if back else size
        ahead = t + jump
        if ahead > times[-1] and not back:
            break
        q_new, v_new = q + jump * v + 0.5 * jump**2 * a, v + jump * a
        predicted = v_new.copy()
        weak = settle(
            equations.kernels.correction, ahead, q_new, v_new, equations.p, w, scale, dq, dv, info
        )
        if weak != 0 or info[0] > 0.1 * size * speed:
            continue
        if np.abs((v_new - predicted) / scale).max() > 0.02 * speed:
            continue
        motion = equations.motion(ahead, q_new, v_new, modes)
        if motion.weak:
            continue
        done = int(record[MARK])
        # Going back, only the first instant can lie within the jump.
        last = min(done + 1, len(times)) if back else len(times)
        while done < last and (times[done] > ahead if back else times[done] < ahead):
            h = times[done] - t
            q_out[done], v_out[done] = q + h * v + 0.5 * h * h * a, v + h * a
            done += 1
        q[:], v[:], a[:], lam[:] = q_new, v_new, motion.a, motion.lam
        record[T], record[MARK], record[STEP] = ahead, done, 4.0 * size
        return True
    return False


def _singular_start(machine: "Machine", start: Assembly, weak: int) -> AnalysisError:
    """The error where the motion cannot be begun."""
    names = start.singular or (machine.constraints.names[weak - 1],)
    return AnalysisError(
        f"{machine.description.title}: the machine starts in a singular position at "
        f"t = {start.t:g} s ({', '.join(names)} {'has' if len(names) == 1 else 'have'} no hold "
        f"here), and no smooth motion leads out of it. Begin a little beside it: another t_start, "
        f"or other start values."
    )


def _lock_up(equations: Equations, t: float, q: FloatArray) -> str:
    """Name the drivers that cannot go on, the joints in their way, and the singular value."""
    told = equations.description
    ahead = equations.constraints(t + 1e-6 * max(abs(t), 1e-3), q)
    undefined = [row.element for row, gap in zip(told.constraints, ahead, strict=True)
                 if not np.isfinite(gap)]  # fmt: skip
    if undefined:
        return (
            f"Stopped at t = {t:.9g} s: {', '.join(dict.fromkeys(undefined))} has no value just "
            f"after. Look for a table asked beyond its ends, a division by zero or a root of a "
            f"negative number."
        )
    matrix = equations.jacobian(t, q) * equations.scale(equations.size(t, q))
    matrix /= np.linalg.norm(matrix, axis=1)[:, None]
    left, values, _ = np.linalg.svd(matrix)
    shares = np.abs(left[:, -1])
    taking = [
        told.constraints[int(row)].element
        for row in np.argsort(-shares)
        if shares[row] > 0.05 * shares.max()
    ]
    joints = [name for name in dict.fromkeys(taking) if name not in told.drivers]
    drivers = [name for name in dict.fromkeys(taking) if name in told.drivers] or told.drivers
    return (
        f"Locked up at t = {t:.9g} s: driver {', '.join(drivers)} cannot go on, "
        f"joints {', '.join(joints)} stand in the way (smallest singular value of Phi_q "
        f"{values[-1]:.1e}). Change the dimensions or the range of the driver."
    )
