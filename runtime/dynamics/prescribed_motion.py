"""Kinematics and inverse dynamics: the motion of a machine whose drivers leave no freedom.

Inverse dynamics adds the forces and torques that the motion takes: the multipliers of the drivers
produce it. A driver's reaction is what it exerts on the body that it moves. Rigid contacts, whose
state is not decided here, are refused. Laws of the drivers may bend or jump at instants known
beforehand.
"""

import time as clock
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError, InputError
from codegen.object_display import counted, listed
from runtime.assembly.assemble import assemble
from runtime.assembly.redundancy import redundancy_note, suited_equations
from runtime.assembly.start_values import start_note, start_values
from runtime.continuation.driven_motion import DrivenMotion, follow
from runtime.core.kinds import Direction
from runtime.core.outcomes import Outcome
from runtime.dynamics.checks.end_checks import check_result
from runtime.dynamics.checks.finite_results import finite_series
from runtime.dynamics.checks.frictions_at_rest import name_held_frictions
from runtime.dynamics.checks.kinks import end_motion_at_kink
from runtime.dynamics.impulses import with_impulses
from runtime.dynamics.motion_at_instants import Found, source_of
from runtime.dynamics.output_quantities import evaluate
from runtime.dynamics.prepared_simulation import passages_of
from runtime.explicit_time.instants import Kink
from runtime.explicit_time.passage import Passages
from runtime.integrate.problem import Options, Passage
from runtime.linalg.rank_policy import LOST
from runtime.mechanism.dense_equations import Equations, FloatArray, magnitudes
from runtime.mechanism.mechanism import Mechanism, Numbers
from runtime.mechanism.module_tables import Description
from runtime.progress_bar import Progress, silent
from runtime.results.assembled_state import Assembly, State
from runtime.results.motion_at_instants import Motion
from runtime.results.result import Result
from runtime.results.run_records import Event
from runtime.results.samples import Samples
from runtime.validation.arguments import instants, parameter_values, require_masses
from runtime.validation.finite_equations import left_tables, name_left_tables
from runtime.validation.scene_support import require_mass, require_no_rigid

_DIRECTIONS = {"crossing": int(Direction.CROSSED), "lock-up": int(Direction.LOCKED)}


def kinematics(
    mechanism: Mechanism, t_eval: npt.ArrayLike, *, parameters: Numbers | None = None,
    guess: Numbers | None = None, start: Assembly | State | Numbers | None = None,
    t_start: float = 0.0, progress: Progress = silent, analysis: str = "kinematics",
) -> Result:  # fmt: skip
    """Kinematics of `Machine.kinematics`; `analysis` names the analysis in messages."""
    began = clock.perf_counter()
    require_no_rigid(mechanism, analysis)
    times = instants(t_eval)
    p = parameter_values(mechanism, parameters)
    equations = Equations(mechanism, p)
    if isinstance(start, Assembly):
        start = State(start.t, start.q, start.v, start.coordinates)
    begin = assemble(equations, t_start, guess, start)
    _require_driven(equations, begin, analysis)
    equations = suited_equations(equations, begin)
    given = start if isinstance(start, State) else start_values(mechanism, guess, start)
    preferred = begin.v if getattr(given, "spins", ()) else given.v
    asked = _asked(equations, analysis)
    motion, kinks, behind = _follow_past_kinks(asked, times, begin, preferred, progress, times)
    motion = end_motion_at_kink(
        equations, begin, motion, lambda times: follow(equations, times, begin, preferred, silent)
    )
    if analysis != "kinematics" and len(motion.t) > 1 and np.isnan(motion.v[-1]).any():
        # Forces grow without bound where it locks; `singular` has the position.
        motion = motion._replace(t=motion.t[:-1], q=motion.q[:-1], v=motion.v[:-1])
    samples = evaluate(equations, motion.t, motion.q, motion.v)
    message = motion.message
    if analysis == "kinematics":
        message += _without_forces(equations, samples)
    singular = np.flatnonzero(np.isnan(samples.a).any(axis=1))
    if len(singular) and motion.outcome is Outcome.OK:
        where = ", ".join(f"{samples.t[index]:.6g}" for index in singular[:5])
        message += (
            f" At {len(singular)} of the instants (t = {where} s) the position is singular: "
            f"accelerations and reactions are not a number there."
        )
    crossed = [
        Event(row.title, row.time, _DIRECTIONS[row.kind], row.q, row.v)
        for row in motion.singular
        if row.kind in _DIRECTIONS and row.q is not None and row.v is not None
    ]
    events = sorted([*crossed, *kinks], key=lambda event: event.time)
    passed, jumps = with_impulses(equations, events, float(times[-1]))
    message += jumps
    motion.stats["singular_instants"] = len(singular)
    motion.stats["wall_seconds"] = clock.perf_counter() - began
    result = Result(
        mechanism.description, samples, p, analysis=analysis, outcome=motion.outcome,
        message=message + start_note(mechanism, begin, guess, start) + redundancy_note(begin),
        stats=motion.stats, events=passed, not_unique=begin.not_unique, singular=motion.singular,
    )  # fmt: skip
    result._mechanism = mechanism
    result._motion = DrivenMotionAtInstants(mechanism, p, begin, preferred, times)
    result._moved = samples.t if behind > begin.t else None
    name_left_tables(result, equations)
    check_result(result, equations, magnitudes(equations, begin.t, begin.q), Options(rtol=0.0))
    first = int((samples.t == behind).sum())
    result.samples = result.samples._replace(t=np.append(times[:first], result.t[first:]))
    return result


def _without_forces(equations: Equations, samples: Samples) -> str:
    """A sentence on forces that are no numbers; accelerations then follow from the constraints."""
    lost = np.isnan(samples.a.sum(axis=1))
    for k in np.flatnonzero(lost & np.isfinite(samples.v).all(axis=1)):  # a lock-up has no v
        t, q, v = float(samples.t[k]), samples.q[k], samples.v[k]
        if equations.motion(t, q, v, samples.modes[k] % 2)[2] == 0:
            gamma, lost[k] = equations.acceleration_rhs(t, q, v), False
            samples.a[k] = np.linalg.lstsq(equations.jacobian(t, q), gamma, rcond=None)[0]
    finite = np.all([*finite_series(equations.description, samples).values()], axis=0)
    without = samples.t[~finite & ~lost]
    if not len(without):
        return ""
    return (
        f" From t = {without[0]:.6g} s on some forces, reactions or energies are not numbers; the "
        "motion does not depend on them. inverse_dynamics says where they come from."
    )


def _asked(equations: Equations, analysis: str) -> Equations:
    """Those for which an analysis asks: kinematics for no force, nor for its law of time."""
    if analysis != "kinematics":
        return equations
    description, found = equations.description, copy(equations)
    moving = {row.element for row in description.constraints}
    laws = tuple(law for law in description.time_functions if law.name in moving)
    found.description = replace(description, has_masses=False, time_functions=laws)
    return found


def inverse_dynamics(
    mechanism: Mechanism, t_eval: npt.ArrayLike, *, parameters: Numbers | None = None,
    unknown: tuple[str, ...] | None = None, weights: Numbers | None = None, **options: Any,
) -> Result:  # fmt: skip
    """Motion, reactions, drives and powers at the instants `t_eval`; options as `kinematics`."""
    description = mechanism.description
    if not description.has_masses:
        raise AnalysisError(description.need_masses("inverse dynamics", ", or ask for kinematics"))
    require_masses(mechanism, parameter_values(mechanism, parameters))
    if sought := unknown is not None or weights:
        from runtime.dynamics.unknown_forces import describe_unknown, variant_with_unknown

        mechanism, given = variant_with_unknown(mechanism, unknown or (), weights or {})
        parameters = {**(parameters or {}), **given}
    options |= {"parameters": parameters, "analysis": "inverse dynamics"}
    result = kinematics(mechanism, t_eval, **options)
    require_mass(description, result.samples.t, result.samples.q)
    if sought:
        describe_unknown(result)
    name_held_frictions(result, Equations(mechanism, parameter_values(mechanism, parameters)))
    return result


@dataclass(frozen=True)
class DrivenMotionAtInstants(Motion):
    """The motion behind a result of kinematics or inverse dynamics."""

    mechanism: Mechanism
    p: FloatArray
    start: Assembly
    preferred: FloatArray  # velocities in a singular start, (n,)
    times: FloatArray  # instants of the result, s

    @property
    def span(self) -> tuple[float, float]:
        """First and last instant, s."""
        t, first, last = self.start.t, float(self.times[0]), float(self.times[-1])
        return min(t, first), max(t, last)

    @property
    def equations(self) -> Equations:
        """With kernels of least norm where constraints are redundant."""
        return suited_equations(Equations(self.mechanism, self.p), self.start)

    def scene(self, t: float) -> str:
        """The scene, whose joints act all the time."""
        return self.mechanism.description.scene

    def at(self, result: Result, times: FloatArray) -> Found:
        """At ascending instants, (k,), of the span, s: followed again from the start."""
        equations, start = self.equations, self.start
        asked = _asked(equations, result.analysis)
        motion, *_ = _follow_past_kinks(asked, times, start, self.preferred, silent, self.times)
        if len(motion.t) != len(times) or motion.outcome is not Outcome.OK:
            raise AnalysisError(
                f"{self.mechanism.title}: the motion cannot be followed to t = {times[-1]:.9g} s. "
                f"{motion.message}"
            )
        return evaluate(equations, motion.t, motion.q, motion.v), {}

    def saved(self) -> dict[str, Any]:
        """Its start and its instants."""
        start = self.start
        return {"t": start.t, "q": start.q, "v": start.v, "preferred": self.preferred,
                "times": self.times, "unknown": self.mechanism.description.unknown,
                "source": source_of(self.mechanism)}  # fmt: skip

    def resumed(self, result: Result, *_: Any) -> Result:
        """None: drivers prescribe the motion at every instant."""
        raise InputError(
            f"{self.mechanism.title}: a simulation goes on from where it stopped, and "
            f"{result.analysis} has every instant at once. Ask for it up to a later one."
        )


def _follow_past_kinks(
    equations: Equations, times: FloatArray, start: Assembly, preferred: FloatArray,
    progress: Progress, whole: FloatArray,
) -> tuple[DrivenMotion, list[Event], float]:  # fmt: skip
    """The motion of `follow`, up to where a law has no value or jumps, and the events of laws.

    `whole` are all instants of its result, s. The last number is the first instant, s: behind a
    kink at which the motion begins.
    """
    sizes, behind = magnitudes(equations, start.t, start.q), start.t
    span = min(start.t, float(whole.min())), max(start.t, float(whole.max()))
    passages = passages_of(equations, *span, sizes)
    if passages is None:
        return follow(equations, times, start, preferred, progress), [], behind
    path = np.concatenate([[start.t], times])
    ascending = bool((np.diff(path) >= 0.0).all())
    if ascending and (behind := passages.first_instant(start.q, start.v)) > start.t:
        path = np.maximum(path, behind)
        passages = Passages(equations, behind, span[1], sizes)
    passed, ends = _kink_events_and_ends(passages, start, ascending)
    reached, end = _instants_before_end(path, ends)
    done = path[1 : 1 + reached]
    instants = done
    if ascending and reached:
        sides = [t for kink, _ in passed for t in kink[:2] if start.t <= t <= done[-1]]
        instants = np.union1d(done, sides)
    motion = follow(equations, instants if reached else path[:1], start, preferred, progress)
    rows = {float(t): row for row, t in enumerate(motion.t[: len(instants)])}
    found = []
    for kink, passage in passed:
        row = rows.get(kink.after)
        if row is not None and instants is not done:
            state = motion.q[row], motion.v[row]
            title = equations.description.time_functions[passage.source].title
            found.append(Event(title, kink.after, int(passage.event or 0), *state))
    return _of_instants(equations, motion, times, done, instants, end), found, behind


def _kink_events_and_ends(
    passages: Passages, start: Assembly, ascending: bool
) -> tuple[list[tuple[Kink, Passage]], list[tuple[float, Passage]]]:
    """The kinks that are events, and where laws end and how, each with its passage."""
    passed, ends = list[tuple[Kink, Passage]](), list[tuple[float, Passage]]()
    for part in passages.parts():
        for kink in part.kinks:
            g = passages.equations.switching(kink.before, start.q, start.v)
            state = start.q, start.v, (g > 0.0).astype(np.int64)
            passage, end = passages.passage(kink, *state), kink.before
            if kink.steep is not None:
                steep = passages.steep(kink, *state)
                if steep.outcome is not Outcome.OK:  # a run ends there first
                    passage, end = steep, kink.steep
            if passage.outcome is not Outcome.OK:
                ends.append((end, passage))
            elif passage.event is not None:
                passed.append((kink, passage))
        if part.crowd is not None:
            ends.append((part.crowd[0], passages.crowded(part)))
        if ends and ascending:
            break
    return passed, ends


def _instants_before_end(
    path: FloatArray, ends: list[tuple[float, Passage]]
) -> tuple[int, tuple[float, Passage] | None]:
    """How many instants are reached before a law ends, and where and how that is; None: all."""
    for reached, (a, b) in enumerate(pairwise(path.tolist())):
        within = [end for end in ends if min(a, b) <= end[0] < max(a, b)]
        if within:
            return reached, min(within, key=lambda end: abs(end[0] - a))
    return len(path) - 1, None


def _of_instants(
    equations: Equations, motion: DrivenMotion, times: FloatArray, done: FloatArray,
    instants: FloatArray, end: tuple[float, Passage] | None,
) -> DrivenMotion:  # fmt: skip
    """The motion at the instants that were asked for, its outcome that of a law that ends it."""
    if instants is not done:  # ascending
        wanted = done[done <= motion.t[-1]]
        rows = np.searchsorted(motion.t, wanted)
        if motion.outcome is not Outcome.OK and not (len(rows) and rows[-1] == len(motion.t) - 1):
            rows = np.append(rows, len(motion.t) - 1)
        motion = motion._replace(t=motion.t[rows], q=motion.q[rows], v=motion.v[rows])
    if motion.outcome is not Outcome.OK:
        return motion
    _, _, notes = motion.message.partition(" s.")
    message = f"{counted(len(times), 'instant')} from t = {times[0]:g} to {times[-1]:g} s.{notes}"
    if end is None:
        return motion._replace(message=message)
    (t, passage), state = end, (motion.q[-1], motion.v[-1])
    outcome, text = passage.outcome, passage.text
    if left := left_tables(equations, t, *state, not equations.description.has_masses, soon=True):
        outcome, text = Outcome.OUT_OF_RANGE, f"{left} {Outcome.OUT_OF_RANGE.advice}"
    if not len(done):
        text += f" No instant that was asked for is reached: the row is t = {motion.t[-1]:.9g} s."
    return motion._replace(outcome=outcome, message=f"Stopped before t = {t:.9g} s. {text}")


def _require_driven(equations: Equations, at: Assembly, analysis: str) -> None:
    """Refuse a machine that its drivers leave free to move."""
    description, free = equations.description, at.degrees_of_freedom
    if free == 0:
        return
    slopes = equations.jacobian(at.t, at.q) * equations.scale(equations.size(at.t, at.q))
    is_position = np.array([not row.is_state for row in description.coordinates])
    squares = np.sum(np.linalg.svd(slopes[:, is_position])[2][-free:] ** 2, axis=0)
    squares[equations.mechanism.shape["counted"][is_position] > 0] = 0.0  # of joints, not bodies
    owners = np.array([row.name.rpartition(".")[0] for row in description.positions])
    moves = {one: float(squares[owners == one].sum()) for one in owners.tolist()}
    most = [one for one in sorted(moves, key=moves.__getitem__)[:-4:-1] if moves[one] > LOST]
    who = f"most of all move {', '.join(most)}" if len(most) > 1 else f"{most[0]} alone moves"
    drivers = ", ".join(description.drivers) or "none"
    left_out = [row.name for row in description.left_out if "driver" in row.kind]
    hint = f" Declared but left out of this scene: {', '.join(left_out)}." if left_out else ""
    if rods := [*_spinning_rods(description)]:
        hint += (
            f" Between two ball joints, {listed(rods)} may spin about the line of these: make one "
            "end universal, or use distance without the rod."
        )
    raise AnalysisError(
        f"{description.title}: {analysis.replace('_', ' ')} needs a machine without freedom, and "
        f"{free} degree{'s' if free > 1 else ''} of freedom "
        f"{'are' if free > 1 else 'is'} left ({len(description.positions)} coordinates, drivers: "
        f"{drivers}); {who}. Add {free} driver{'s' if free > 1 else ''} to the scene, or the joint "
        "that is missing (`linkwright check` names the bodies that one joint alone holds), or ask "
        f"for simulate.{hint}"
    )


def _spinning_rods(description: Description) -> Iterator[str]:
    """The bodies in space that two ball joints hold, and nothing else."""
    rows, columns = description.jacobian_rows, description.jacobian_columns
    for body, k in description.turning:
        held = np.unique(rows[(columns >= k - 3) & (columns < k + 4)])
        kinds = sorted(description.constraints[row].kind for row in held)
        if kinds == ["body", *["spherical"] * 6]:
            yield body
