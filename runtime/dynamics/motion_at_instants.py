"""The motion of a simulation at any instant: the run is taken again from the checkpoint before it.

It has the same steps and bits, and samples at the instants that are asked for, so that these are
those of `t_eval`, whatever the method, the coordinates and the modes.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import AnalysisError
from codegen.files.generated_modules import content_hash
from runtime.dynamics.formulations import Coordinates
from runtime.dynamics.output_quantities import along_intervals, evaluate
from runtime.dynamics.prepared_simulation import PreparedSimulation, discrete_state
from runtime.integrate.checkpoints import Checkpoint, Checkpoints, Passed, Until
from runtime.integrate.problem import Discrete, Options, Trajectory
from runtime.integrate.sampling import INTERVAL
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.results.assembled_state import DiscreteState
from runtime.results.result import Result
from runtime.results.samples import Samples

SAVED = (
    "method", "rtol", "atol_q", "atol_v", "correction", "time_scale", "first_step", "h_max",
    "max_steps", "max_bytes", "step_limit",
)  # fmt: skip
"""Options of a run that a file keeps."""

Found = tuple[Samples, dict[str, FloatArray]]
"""Samples, and works of the result's effects and drivers, at k instants."""


def resumed(motion: Any, result: Result, *arguments: Any) -> Result:
    """The run of a simulation up to another end; see `Result.resume`."""
    from runtime.dynamics.resumption import resume  # which stands above

    return resume(result, motion, *arguments)


@dataclass(frozen=True)
class SimulatedMotion:
    """The run behind a result of a simulation."""

    coordinates: Coordinates
    options: Options
    checkpoints: Checkpoints
    end: float  # last instant that the run reached, s
    samples_taken: bool = True  # whether clocks have renewed what is due there
    last: Discrete | None = None  # where clocks and conditions stand there

    @property
    def ready(self) -> PreparedSimulation:
        """The start of the run."""
        return self.coordinates.ready

    @property
    def span(self) -> tuple[float, float]:
        """First and last instant, s."""
        return self.ready.given_t, self.end

    @property
    def t_end(self) -> float:
        """The end that was asked for, s."""
        return float(self.ready.t_end)

    def scene(self, t: float) -> str:
        """The scene whose joints act at an instant of the span, s."""
        return self.ready.mechanism.description.scene

    def clocks(self, result: Result, t: float) -> tuple[bool, DiscreteState | None]:
        """Whether clocks have renewed what is due at an instant, s, and where they stand there."""
        ready, stand = self.ready, self.last
        if stand is not None and t < self.end:
            kept, passed = self.checkpoints.before(t), Passed(t)
            options = replace(self.options, t_eval=np.array([t]), quadrature=False, chunk=1)
            self._retaken(result, kept, options, passed)
            stand = passed.stand
        found = discrete_state(ready.mechanism, ready.p, stand)
        return t < self.end or self.samples_taken, found

    def at(self, result: Result, times: FloatArray) -> Found:
        """At ascending instants, (k,), of the span, s."""
        times = np.maximum(times, self.ready.begin.t)
        parts: list[Samples] = []
        works: dict[str, list[FloatArray]] = {name: [] for name in result.works}
        for before, part in self.checkpoints.groups(times.tolist()):
            kept, asked, here, base = before, times[part], times[part], 0.0
            if works:  # which go on from those of the last known instant before
                base, known = self._known_works(result, float(here[0]))
                kept, asked = self.checkpoints.before(base), np.union1d([base], here)
            options = replace(self.options, t_eval=asked, quadrature=bool(works))
            run = self._retaken(result, kept, options, Until(float(here[-1])))
            if works:
                ends, totals = self.works_from(kept, run, base)
                places = np.searchsorted(ends, here)
                for name, total in totals.items():
                    works[name].append(known[name] + total[places])
            parts.append(self._evaluated(run, here))
        return Samples.joined(parts), {
            name: np.concatenate(pieces) for name, pieces in works.items()
        }

    def _retaken(
        self, result: Result, kept: Checkpoint | None, options: Options, change: Until
    ) -> Trajectory:
        """The run from a checkpoint on, None: its start."""
        return self.coordinates.run(options, change, kept, self.known(result, kept))

    def known(self, result: Result, kept: Checkpoint | None) -> tuple[float, FloatArray] | None:
        """The last sample up to a checkpoint, s, and all its coordinates."""
        rows = np.flatnonzero(result.t <= (-np.inf if kept is None else kept.t))
        if not len(rows):
            return None
        row = rows[result.t[rows].argmax()]
        return float(result.t[row]), result.samples.q[row]

    def _known_works(self, result: Result, t: float) -> tuple[float, dict[str, float]]:
        """The last instant up to `t` at which the result has works, and these, J."""
        known = result.t <= t
        for work in result.works.values():
            known &= np.isfinite(work)
        rows = np.flatnonzero(known)
        if not len(rows):
            return self.ready.begin.t, dict.fromkeys(result.works, 0.0)
        row = rows[result.t[rows].argmax()]
        return float(result.t[row]), {name: float(w[row]) for name, w in result.works.items()}

    def _evaluated(self, run: Trajectory, times: FloatArray) -> Samples:
        """All that is computed from the states of a run at these instants."""
        rows = np.searchsorted(run.t, times)
        if len(run.t) == 0 or rows[-1] >= len(run.t) or (run.t[rows] != times).any():
            raise AnalysisError(
                f"{self.ready.mechanism.title}: the run, taken again up to t = {times[-1]:.9g} s, "
                f"stopped before ({run.outcome}). Take instants of `Result.t`, or `t_eval`."
            )
        return evaluate(
            self.coordinates.equations, run.t[rows], run.q[rows], run.v[rows], run.modes[rows]
        )

    def works_from(
        self, kept: Checkpoint | None, run: Trajectory, base: float
    ) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Ends of the intervals of a quadrature from a checkpoint on, and works since `base`."""
        t, q, v, modes = run.t, run.q, run.v, run.modes
        if kept is not None:  # the interval that begins there has no sample at its start
            t = np.concatenate([[kept.t], t])
            q, v = np.vstack([q[:1], q]), np.vstack([v[:1], v])
            modes = np.vstack([modes[:1], modes])
        equations, ends, works = self.coordinates.equations, t[::INTERVAL], dict[str, FloatArray]()
        power = evaluate(equations, t, q, v, modes).power
        for name, column in equations.description.work_rows.items():
            pieces = along_intervals(t, power[:, column])
            pieces[: int(np.searchsorted(ends, base))] = 0.0
            works[name] = np.concatenate([[0.0], np.cumsum(pieces)])
        return ends, works

    def saved(self) -> dict[str, Any]:
        """Its start and its settings."""
        ready, begin = self.ready, self.ready.begin
        options = {name: getattr(self.options, name) for name in SAVED}
        return {
            "t": begin.t, "q": begin.q, "v": begin.v, "given_t": ready.given_t, "end": self.end,
            "taken": (ready.samples_taken, self.samples_taken), "length": ready.given_length,
            "discrete": (ready.discrete, self.last),
            "t_end": ready.t_end, "formulation": self.coordinates.name, "options": options,
            "source": source_of(ready.mechanism),
        }  # fmt: skip

    resumed = resumed


def source_of(mechanism: Mechanism) -> dict[str, str] | None:
    """Where a machine comes from: model file ("" of one that was declared), scene and content."""
    origin = mechanism.origin
    if origin is None:
        return None
    file = str(origin.model) if isinstance(origin.model, Path) else ""
    return {"model": file, "scene": mechanism.description.scene,
            "content": content_hash(origin.path, origin.digest)}  # fmt: skip
