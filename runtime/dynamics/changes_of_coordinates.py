"""Runs in reduced coordinates that pass the dead centres of their loops in all coordinates.

Near a dead centre the kept coordinates describe the motion badly, as a poor partition does. The
run then goes on in all coordinates, and returns to the reduced ones where every loop is well away
from its dead centre, on the branches on which the machine stands by then. It is one run: modes,
events, samples, counts and the length of the steps are handed over, and each change is a
repartition of the result. Where reduced equations fail for another reason, all coordinates take
over as well: what ends a run is an outcome in these.
"""

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.core.arrays import Integers, Vector
from runtime.core.loop_record import Plan
from runtime.core.outcomes import Outcome
from runtime.core.system import System
from runtime.core.workspace_rows import PARTITION
from runtime.hybrid.step_limits import LEAST
from runtime.integrate.checkpoints import Checkpoint, Checkpoints, Snapshot, restore, snapshot
from runtime.integrate.problem import (
    Events,
    Options,
    Partitions,
    Passage,
    Problem,
    Stops,
    Trajectory,
    refuse_misfits,
)
from runtime.integrate.recording_buffers import in_order
from runtime.integrate.run import Change, Progress, Run
from runtime.integrate.run_state import COUNTS
from runtime.integrate.step import Signal

if TYPE_CHECKING:
    from runtime.dynamics.formulations import ReducedCoordinates

_BACK = 0.16  # measured: of the largest ρ²; above it a run returns to reduced coordinates
_AWAY = 4.0  # measured: fewest steps to the next dead centre with which it returns
_LOOK_EVERY = 4  # measured: steps in all coordinates between two looks
_PATIENCE = 16  # safety: steps in all coordinates after reduced equations fail, at first
_GOING, _LEAVE, _OK = int(Signal.GOING), int(Signal.LEAVE), int(Outcome.OK)
_KEPT = ("made", "start", "free", "largest", "until", "patience")  # by a checkpoint
_FAILED = {
    Outcome.SINGULAR, Outcome.NEWTON_FAILED, Outcome.NOT_FINITE, Outcome.STEP_TOO_SMALL,
}  # fmt: skip
# in all coordinates too
_ALIKE = {Outcome.MAX_STEPS, Outcome.MEMORY, Outcome.INTERRUPTED, Outcome.OUT_OF_RANGE}


class RunsSnapshot(NamedTuple):
    """Where the runs of a change of coordinates stand."""

    less: Snapshot | None
    whole: Snapshot | None
    reduced: bool  # whether the reduced coordinates are those of the present leg
    rest: dict[str, Any]  # attributes of `Changes`

    @property
    def nbytes(self) -> int:
        """Bytes that it takes."""
        return sum(kept.nbytes for kept in (self.less, self.whole) if kept is not None)

    @property
    def longest(self) -> float:
        """Length of the last step and of the next one, the larger, s."""
        present = self.less if self.reduced else self.whole
        assert present is not None
        return present.longest


class _Leg(NamedTuple):
    """A part of the run in one kind of coordinates."""

    path: Trajectory  # in all coordinates
    t: float  # its start, s
    free: npt.NDArray[np.bool_]  # (n,): independent coordinates there


class Changes:
    """One run in reduced coordinates, and in all coordinates where these are poor."""

    def __init__(self, taken: "ReducedCoordinates", options: Options) -> None:
        self.taken, self.reduced, self.options = taken, taken.reduced, options
        self.less: Run | None = None  # in reduced coordinates
        self.made: tuple[float, Vector, Vector] | None = None  # the state for which that was made
        self.whole: Run | None = None  # in all of them, where needed
        self.legs: list[_Leg] = []
        self.largest = np.zeros(self.reduced.system.loops)
        self.until, self.patience = 0, _PATIENCE

    def run(
        self, change: Change, kept: Checkpoint | None, known: tuple[float, Vector] | None,
        progress: Progress | None,
    ) -> Trajectory:  # fmt: skip
        """The whole run, in all coordinates, or from a checkpoint on; see `Coordinates.run`."""
        if isinstance(change, Checkpoints):
            change.state_of = lambda _: self.snapshot()

        def changed(run: Run, code: int) -> tuple[Run, int]:
            self.present, code = self._changed(run, code)
            return change(self.present, code)

        self.present = self._begin() if kept is None else self._restored(kept.state, known)
        return self._joined(self.present.execute(progress, changed, started=kept is not None))

    def _begin(self) -> Run:
        """The first run, in the coordinates that suit the start."""
        begin = self.taken.begin
        self.start = begin.t, begin.q  # where the present leg starts
        self.free = np.zeros(len(begin.q), np.bool_)
        self.free[self.reduced.kept] = True  # what is independent there
        if self._is_safe(begin.t, begin.q, begin.v, LEAST, 0.0):
            return self._make_less(begin.t, begin.q, begin.v)
        return self._make_whole()

    def _restored(self, place: RunsSnapshot, known: tuple[float, Vector] | None) -> Run:
        """The run of a checkpoint."""
        vars(self).update(place.rest)
        if known is not None and known[0] >= self.start[0]:
            self.start = known
        if place.less is not None and self.made is not None:
            restore(self._make_less(*self.made), place.less)
        if place.whole is not None:
            restore(self._make_whole(), place.whole)
        run = self.less if place.reduced else self.whole
        assert run is not None
        return run

    def snapshot(self) -> RunsSnapshot:
        """Where the runs stand."""
        less, whole = (None if run is None else snapshot(run) for run in (self.less, self.whole))
        rest = {name: getattr(self, name) for name in _KEPT}
        return RunsSnapshot(less, whole, self.present is self.less, rest)

    def _changed(self, run: Run, code: int) -> tuple[Run, int]:
        """Change coordinates where that is due; see `runtime.integrate.run.Change`."""
        if run is self.whole:
            r = run.state.record
            free = r["plan"] == Plan.FREE and not r["lent"] and r["steps"] >= self.until
            if code == _GOING and r["steps"] > 0 and free:
                (q, v), h = run.state.y, float(r["h"])
                if self._is_safe(float(r["t"]), q, v, _BACK, _AWAY * h):
                    return self._return(run, q, v)
            return run, code
        unstarted = code > 0 and run.state.record["steps"] == 0 and not self.legs
        if unstarted and code not in _ALIKE:
            self._be_patient(0)
            run = self._make_whole()
            code = run.start()
            return run, _GOING if code == _OK else code
        if code == _LEAVE or code in _FAILED:
            return self._leave(run, code)
        return run, code

    # -- changes -----------------------------------------------------------------------------

    def _leave(self, less: Run, code: int) -> tuple[Run, int]:
        """Go on in all coordinates from where the reduced ones are poor, or failed."""
        path = self._finish(less, less.result(Outcome.OK, 0.0))
        whole = self.whole or self._make_whole()
        if code != _LEAVE:
            self._be_patient(int(whole.state.record["steps"]))
        code = whole.take_over(less, path.final_q, path.final_v)
        self.free = whole.state.rows[PARTITION, 0] == 0.0
        return whole, _GOING if code == _OK else code

    def _return(self, whole: Run, q: Vector, v: Vector) -> tuple[Run, int]:
        """Go on in reduced coordinates, if a run starts there."""
        t, kept = float(whole.state.record["t"]), self.reduced.kept
        less = self.less or self._make_less(t, q, v)
        less.state.p[:] = self.reduced.parameters(self.taken.ready.p, t, q)
        if less.take_over(whole, q[kept], v[kept]) != _OK:
            self._be_patient(int(whole.state.record["steps"]))
            return whole, _GOING
        self._finish(whole, whole.result(Outcome.OK, 0.0))
        independent = less.state.rows[PARTITION, 0] == 0.0
        self.free = np.zeros(len(q), dtype=np.bool_)
        self.free[kept] = independent if self.reduced.closures else True
        return less, _GOING

    def _finish(self, run: Run, path: Trajectory) -> Trajectory:
        """End the present leg; its path in all coordinates."""
        if run is self.less:
            path = self.taken.all_coordinates(path, self.start, run.state.p)
        self.legs.append(_Leg(path, self.start[0], self.free))
        self.start = path.final_t, path.final_q
        return path

    def _be_patient(self, steps: int) -> None:
        """Stay in all coordinates for longer, as the reduced equations failed."""
        self.until = steps + self.patience
        self.patience *= 2

    def _is_safe(self, t: float, q: Vector, v: Vector, least: float, ahead: float) -> bool:
        """Whether loops stay off dead centres for `ahead` s: ρ² above `least` of its largest."""
        if not self.largest.size:
            return True
        square, rate, size = self.taken.squares(t, q, v)
        self.largest = np.fmax(self.largest, size)
        far = (square > least * self.largest) & (2.0 * square > -rate * ahead)
        return bool(far.all())

    # -- runs --------------------------------------------------------------------------------

    def _make_less(self, t: float, q: Vector, v: Vector) -> Run:
        self.made = t, q.copy(), v.copy()
        problem = self.taken.problem(t, q, v)
        stops = self._stops_of_all(problem.stops)
        problem = problem._replace(t0=self.taken.begin.t, stops=stops)
        self.less = self._new_run(self.taken.system, problem)
        return self.less

    def _make_whole(self) -> Run:
        cartesian, begin = self.taken.cartesian(self.options.method), self.taken.begin
        problem = cartesian.problem(begin.t, begin.q, begin.v)
        self.whole = self._new_run(cartesian.system, problem)
        self.whole.most = _LOOK_EVERY
        return self.whole

    def _new_run(self, system: System, problem: Problem) -> Run:
        refuse_misfits(problem, self.options)
        return Run(system, problem, self.options)

    def _stops_of_all(self, stops: Stops | None) -> Stops | None:
        """Stops that are passed in all coordinates; velocities behind them are kept ones."""
        if stops is None:
            return None
        given, more = stops.passage, stops.further

        def passage(number: int, q: Vector, v: Vector, modes: Integers) -> Passage:
            less, reduced, n = self.less, self.reduced, len(self.start[1])
            if less is None or len(q) == n:
                return given(number, q, v, modes)
            t, turns = float(less.state.record["t"]), np.zeros(len(reduced.angles))
            all_q, all_v = np.zeros(n), np.zeros(n)
            reduced.expand(t, q, v, less.state.p, turns, all_q, all_v)
            found = given(number, all_q, all_v, modes)
            return found if found.v is None else found._replace(v=found.v[reduced.kept])

        further = None if more is None else lambda: self._stops_of_all(more())
        return stops._replace(passage=passage, further=further)

    # -- the result --------------------------------------------------------------------------

    def _joined(self, last: Trajectory) -> Trajectory:
        """The legs as one run, that ended as the last of them."""
        run = self.less if last.q.shape[1] == len(self.reduced.kept) and self.less else self.whole
        assert run is not None
        last, rigid = self._finish(run, last), self.taken.system.rigid
        if len(self.legs) == 1:
            return last._replace(events=in_order(last.events, last.final_t, rigid))
        paths = [leg.path for leg in self.legs]
        states = [made.state for made in (self.less, self.whole) if made is not None]
        records = [state.record for state in states]
        counts = {name: sum(r[name].item() for r in records) for name in COUNTS}
        counts["largest_dq"] = max(r["largest_dq"].item() for r in records)
        # Near a dead centre the fastest motions are those of the singular position: what decays in
        # both kinds of coordinates is a motion of the machine.
        decay = min(state.mean_decay for state in states)
        partitions = self._partitions()
        counts["repartitions"] = len(partitions.t) - 1
        samples = zip(*((path.t, path.q, path.v, path.modes) for path in paths), strict=True)
        t, q, v, modes = map(np.concatenate, samples)
        logged = zip(*(vars(path.events).values() for path in paths), strict=True)
        events = in_order(Events(*map(np.concatenate, logged)), last.final_t, rigid)
        return last._replace(
            first_t=paths[0].first_t, t=t, q=q, v=v, modes=modes, events=events,
            statistics=replace(last.statistics, **counts), partitions=partitions,
            decay=decay,
            crossings=tuple(crossing for path in paths for crossing in path.crossings),
        )  # fmt: skip

    def _partitions(self) -> Partitions:
        """Every change of the independent coordinates, those between the legs included."""
        changes: list[tuple[float, npt.NDArray[np.bool_]]] = []
        for leg in self.legs:
            logged = leg.path.partitions
            if not len(logged.t) or logged.t[0] > leg.t:
                changes.append((leg.t, leg.free))
            changes += zip(logged.t.tolist(), logged.independent, strict=True)
        times, free = zip(*changes, strict=True)
        return Partitions(np.array(times), np.array(free))
