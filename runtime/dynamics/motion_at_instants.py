"""The motion of a result at any instant: the run is taken again from the checkpoint before it.

It has the same steps and bits, and samples at the instants that are asked for, so that these are
those of `t_eval`, whatever the method, the coordinates and the modes. Driven motions are followed
again from their start.
"""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import AnalysisError, InputError
from codegen.files.generated_modules import content_hash
from runtime.core.outcomes import Outcome
from runtime.dynamics.continued_state import discrete_state
from runtime.dynamics.driven_motion_past_kinks import follow_past_kinks
from runtime.dynamics.output_quantities import along_intervals, evaluate
from runtime.integrate.checkpoints import Checkpoint, Checkpoints, Passed, Until
from runtime.integrate.problem import Discrete, Options
from runtime.integrate.run import Change
from runtime.integrate.sampling import INTERVAL
from runtime.integrate.trajectory import Trajectory
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.progress_bar import silent
from runtime.results.assembled_state import Assembly, DiscreteState
from runtime.results.result import Result
from runtime.results.samples import Samples

if TYPE_CHECKING:
    from runtime.dynamics.formulations import Coordinates
    from runtime.dynamics.prepared_simulation import PreparedSimulation

SAVED = (
    "method", "rtol", "atol_q", "atol_v", "correction", "time_scale", "first_step", "h_max",
    "max_steps", "max_bytes", "step_limit",
)  # fmt: skip
"""Options of a run that a file keeps."""

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
    samples_taken: bool = True  # whether clocks have renewed what is due there
    last: Discrete | None = None  # where clocks and conditions stand there

    def sampled(self, t: float) -> bool:
        """Whether clocks have renewed what is due in the state at an instant of the span, s."""
        return t < self.end or self.samples_taken

    def scene(self, t: float) -> str:
        """The scene whose joints act at an instant of the span, s."""
        return self.ready.mechanism.description.scene

    def discrete(self, result: Result, t: float) -> DiscreteState | None:
        """Where clocks and watched conditions stand at an instant of the span, s."""
        ready, stand = self.ready, self.last
        if stand is not None and t < self.end:
            passed, kept = list[Passed](), self.checkpoints.before(t)

            def watched(change: Change | None) -> Change:
                passed.append(Passed(t, change))
                return passed[0]

            options = replace(self.options, t_eval=np.array([t]), quadrature=False, chunk=1)
            known = None if kept is None else self.known(result, kept.t)
            self.coordinates.retaken(options, kept, watched, known)
            stand = passed[0].stand
        return discrete_state(ready.mechanism, ready.p, stand)

    @property
    def span(self) -> tuple[float, float]:
        """First and last instant, s."""
        return self.ready.given_t, self.end

    @property
    def t_end(self) -> float:
        """The end that was asked for, s."""
        return float(self.ready.t_end)

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
        known = None if kept is None else self.known(result, kept.t)
        last = float(times[-1])
        watched = partial(Until, last)
        return self.coordinates.retaken(options, kept, watched, known)

    def known(self, result: Result, t: float) -> tuple[float, FloatArray] | None:
        """The last sample up to the instant `t`, s, and all its coordinates."""
        rows = np.flatnonzero(result.t <= t)
        if not len(rows):
            return None
        row = rows[result.t[rows].argmax()]
        return float(result.t[row]), result.samples.q[row]

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

    def saved(self) -> dict[str, Any]:
        """Its start and its settings."""
        ready, begin = self.ready, self.ready.begin
        options = {name: getattr(self.options, name) for name in SAVED}
        return {
            "t": begin.t, "q": begin.q, "v": begin.v, "given_t": ready.given_t, "end": self.end,
            "taken": (ready.samples_taken, self.samples_taken), "handover": ready.handover,
            "discrete": (ready.discrete, self.last),
            "t_end": ready.t_end, "formulation": self.coordinates.name, "options": options,
            "source": _source(ready.mechanism),
        }  # fmt: skip

    def resumed(
        self, result: Result, t_end: Any, t_eval: Any, max_steps: int | None, progress: bool
    ) -> Result:
        """The run up to another end; see `Result.resume`."""
        from runtime.dynamics.resumption import resume  # which stands above

        return resume(result, self, t_end, t_eval, max_steps, progress)

    def _with_works(self, result: Result, times: FloatArray) -> Found:
        """The same with works, which go on from those of the last known instant before."""
        base, known = self._known_works(result, float(times[0]))
        kept = self.checkpoints.before(base)
        run = self._retaken(result, kept, np.union1d([base], times), quadrature=True)
        ends, totals = self.works_from(kept, run, base)
        places = np.searchsorted(ends, times)
        works = {name: known[name] + total[places] for name, total in totals.items()}
        return self._evaluated(run, times), works

    def _known_works(self, result: Result, t: float) -> tuple[float, dict[str, float]]:
        """The last instant up to `t` at which the result has works, and these, J."""
        known = np.ones(len(result.t), np.bool_)
        for work in result.works.values():
            known &= np.isfinite(work)
        rows = np.flatnonzero(known & (result.t <= t))
        if not len(rows):
            return self.ready.begin.t, dict.fromkeys(result.works, 0.0)
        row = rows[result.t[rows].argmax()]
        return float(result.t[row]), {name: float(w[row]) for name, w in result.works.items()}

    def works_from(
        self, kept: Checkpoint | None, run: Trajectory, base: float
    ) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Ends of the intervals of a quadrature from a checkpoint on, and works since `base`."""
        if kept is not None:  # the interval that begins there has no sample at its start
            t = np.concatenate([[kept.t], run.t])
            q, v = np.vstack([run.q[:1], run.q]), np.vstack([run.v[:1], run.v])
            run = replace(run, t=t, q=q, v=v, modes=np.vstack([run.modes[:1], run.modes]))
        mechanism, p = self.coordinates.mechanism, self.ready.p
        power = evaluate(mechanism, p, run.t, run.q, run.v, run.modes).power
        ends, works = run.t[::INTERVAL], dict[str, FloatArray]()
        first = int(np.searchsorted(ends, base))
        for name, column in mechanism.description.work_rows.items():
            pieces = along_intervals(run.t, power[:, column])
            pieces[:first] = 0.0
            works[name] = np.concatenate([[0.0], np.cumsum(pieces)])
        return ends, works


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

    @property
    def t_end(self) -> float:
        """The last instant, s."""
        return self.span[1]

    def sampled(self, t: float) -> bool:
        """No clock renews anything in a motion that drivers prescribe."""
        return False

    def scene(self, t: float) -> str:
        """The scene, whose joints act all the time."""
        return self.mechanism.description.scene

    def discrete(self, result: Result, t: float) -> None:
        """Nothing is sampled or watched in a motion that drivers prescribe."""
        return

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

    def saved(self) -> dict[str, Any]:
        """Its start and its instants."""
        start = self.start
        return {"t": start.t, "q": start.q, "v": start.v, "preferred": self.preferred,
                "times": self.times, "source": _source(self.mechanism)}  # fmt: skip

    def resumed(self, result: Result, *_: Any) -> Result:
        """None: drivers prescribe the motion at every instant."""
        raise InputError(
            f"{self.mechanism.title}: a simulation goes on from where it stopped, and "
            f"{result.analysis} has every instant at once. Ask for it up to a later one."
        )


def _source(mechanism: Mechanism) -> dict[str, str] | None:
    """Where a machine comes from: model file ("" of one that was declared), scene and content."""
    origin = mechanism.origin
    if origin is None:
        return None
    file = str(origin.model) if isinstance(origin.model, Path) else ""
    return {"model": file, "scene": mechanism.description.scene,
            "content": content_hash(origin.path, origin.digest)}  # fmt: skip
