"""The motion of a result at any instant: the run is taken again from the checkpoint before it.

It has the same steps and bits, and samples at the instants that are asked for, so that these are
those of `t_eval`, whatever the method, the coordinates and the modes. Driven motions are followed
again from their start.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from codegen.errors import AnalysisError
from runtime.core.outcomes import Outcome
from runtime.dynamics.driven_motion_past_kinks import follow_past_kinks
from runtime.dynamics.output_quantities import evaluate
from runtime.dynamics.work import along_intervals
from runtime.integrate.checkpoints import Checkpoint, Checkpoints
from runtime.integrate.problem import Options
from runtime.integrate.sampling import INTERVAL
from runtime.integrate.trajectory import Trajectory
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.progress_bar import silent
from runtime.results.assembled_state import Assembly
from runtime.results.result import Result
from runtime.results.samples import Samples

if TYPE_CHECKING:
    from runtime.dynamics.formulations import Coordinates
    from runtime.dynamics.prepared_simulation import PreparedSimulation

Found = tuple[Samples, dict[str, FloatArray]]
"""Samples, and works of the result's effects and drivers, at k instants."""


@dataclass(frozen=True)
class SimulatedMotion:
    """The run behind a result of a simulation."""

    ready: "PreparedSimulation"
    coordinates: "Coordinates"
    options: Options
    checkpoints: Checkpoints
    end: float  # last instant that the run reached, s

    @property
    def span(self) -> tuple[float, float]:
        """First and last instant, s."""
        return self.ready.given_t, self.end

    def at(self, result: Result, times: FloatArray) -> Found:
        """At ascending instants, (k,), of the span, s."""
        times = np.maximum(times, self.ready.begin.t)
        parts: list[Samples] = []
        works: dict[str, list[FloatArray]] = {name: [] for name in result.works}
        for kept, part in self.checkpoints.groups(times.tolist()):
            if works:
                samples, found = self._with_works(result, times[part])
                for name, work in found.items():
                    works[name].append(work)
            else:
                run = self._retaken(result, kept, times[part], quadrature=False)
                samples = self._evaluated(run, times[part])
            parts.append(samples)
        joined = Samples._make(map(np.concatenate, zip(*parts, strict=True)))
        return joined, {name: np.concatenate(pieces) for name, pieces in works.items()}

    def _retaken(
        self, result: Result, kept: Checkpoint | None, times: FloatArray, *, quadrature: bool
    ) -> Trajectory:
        """The run from a checkpoint on with samples at these instants."""
        options = replace(self.options, t_eval=times, quadrature=quadrature)
        known = None
        if kept is not None:
            before = int(np.searchsorted(result.t, kept.t, side="right")) - 1
            if before >= 0:
                known = float(result.t[before]), result.samples.q[before]
        return self.coordinates.retaken(options, kept, float(times[-1]), known)

    def _evaluated(self, run: Trajectory, times: FloatArray) -> Samples:
        """All that is computed from the states of a run at these instants."""
        rows = np.searchsorted(run.t, times)
        if len(run.t) == 0 or rows[-1] >= len(run.t) or (run.t[rows] != times).any():
            raise AnalysisError(
                f"{self.ready.mechanism.title}: the run, taken again up to t = {times[-1]:.9g} s, "
                f"stopped before ({run.outcome}). Take instants of `Result.t`, or `t_eval`."
            )
        mechanism, p = self.coordinates.mechanism, self.ready.p
        return evaluate(mechanism, p, run.t[rows], run.q[rows], run.v[rows], run.modes[rows])

    def _with_works(self, result: Result, times: FloatArray) -> Found:
        """The same with works, which go on from those of the last known instant before."""
        begin, known = self.ready.begin.t, np.ones(len(result.t), np.bool_)
        for work in result.works.values():
            known &= np.isfinite(work)
        rows = np.flatnonzero(known & (result.t <= times[0]))
        base = float(result.t[rows[-1]]) if len(rows) else begin
        kept = self.checkpoints.before(base)
        asked = np.union1d([base], times)
        run = self._retaken(result, kept, asked, quadrature=True)
        samples = self._evaluated(run, times)
        if kept is not None:  # the interval that begins there has no sample at its start
            t = np.concatenate([[kept.t], run.t])
            q, v = np.vstack([run.q[:1], run.q]), np.vstack([run.v[:1], run.v])
            run = replace(run, t=t, q=q, v=v, modes=np.vstack([run.modes[:1], run.modes]))
        mechanism, p = self.coordinates.mechanism, self.ready.p
        power = evaluate(mechanism, p, run.t, run.q, run.v, run.modes).power
        ends, works = run.t[::INTERVAL], dict[str, FloatArray]()
        first, places = int(np.searchsorted(ends, base)), np.searchsorted(ends, times)
        for name, column in result.description.work_rows.items():
            pieces = along_intervals(run.t, power[:, column])
            start = float(result.works[name][rows[-1]]) if len(rows) else 0.0
            total = start + np.concatenate([[0.0], np.cumsum(pieces[first:])])
            works[name] = total[places - first]
        return samples, works


@dataclass(frozen=True)
class DrivenMotionAtInstants:
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

    def at(self, result: Result, times: FloatArray) -> Found:
        """At ascending instants, (k,), of the span, s: followed again from the start."""
        equations = Equations(self.mechanism, self.p)
        motion, _ = follow_past_kinks(equations, times, self.start, self.preferred, silent)
        if len(motion.t) != len(times) or motion.outcome is not Outcome.OK:
            raise AnalysisError(
                f"{self.mechanism.title}: the motion cannot be followed to t = {times[-1]:.9g} s. "
                f"{motion.message}"
            )
        return evaluate(self.mechanism, self.p, motion.t, motion.q, motion.v), {}
