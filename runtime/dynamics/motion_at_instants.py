"""The motion of a simulation at any instant: the run is taken again from the checkpoint before it.

It has the same steps and bits, and samples at the instants that are asked for, so that these are
those of `t_eval`, whatever the method, the coordinates and the modes.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import AnalysisError, InputError
from codegen.files.generated_modules import content_hash
from runtime.assembly.assemble import assemble
from runtime.dynamics.formulations import Coordinates, formulate
from runtime.dynamics.output_quantities import along_intervals, evaluate
from runtime.dynamics.prepared_simulation import PreparedSimulation, discrete_state
from runtime.integrate.checkpoints import Checkpoint, Checkpoints, Passed, Until
from runtime.integrate.clocks import queue_length, read_clocks
from runtime.integrate.problem import Discrete, Options, Trajectory
from runtime.integrate.sampling import INTERVAL
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.results.assembled_state import Assembly, DiscreteState, State
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.results.saved_result import floats

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

    def __getstate__(self) -> dict[str, Any]:
        """The machine, start and settings of the run, as files keep them; no checkpoints."""
        if "coordinates" not in vars(self):
            return vars(self)
        ready, description = self.ready, self.ready.mechanism.description
        values = dict(zip(description.parameters.names, ready.p.tolist(), strict=False))
        ends = {"end": self.end, "samples_taken": self.samples_taken, "last": self.last}
        return {"again": (ready.mechanism, ready.p, ready.begin, values, self._settings()), **ends}

    def __getattr__(self, name: str) -> Any:
        """Of a pickled run, what is prepared again when it is first needed."""
        if name not in ("coordinates", "options", "checkpoints") or "again" not in vars(self):
            raise AttributeError(name)
        found = simulated_again(*vars(self)["again"])
        vars(self).update(vars(found))
        return getattr(found, name)

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

    @property
    def behind(self) -> float:
        """The first instant of a run that begins on a kink, s, else -inf."""
        return self.ready.begin.t if self.ready.begin.t > self.ready.given_t else -np.inf

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
        t = max(float(result.t[row]), self.ready.begin.t)
        return t, {name: float(w[row]) for name, w in result.works.items()}

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
        return {**self._settings(), "source": source_of(self.ready.mechanism)}

    def _settings(self) -> dict[str, Any]:
        ready, begin = self.ready, self.ready.begin
        options = {name: getattr(self.options, name) for name in SAVED}
        return {
            "t": begin.t, "q": begin.q, "v": begin.v, "given_t": ready.given_t, "end": self.end,
            "taken": (ready.samples_taken, self.samples_taken), "length": ready.given_length,
            "discrete": (ready.discrete, self.last),
            "t_end": ready.t_end, "formulation": self.coordinates.name, "options": options,
        }  # fmt: skip

    resumed = resumed


def source_of(mechanism: Mechanism) -> dict[str, str] | None:
    """Where a machine comes from: model file ("" of one that was declared), scene and content."""
    origin = mechanism.origin
    if origin is None:
        return None
    file = str(origin.model) if isinstance(origin.model, Path) else ""
    return {"model": file, "scene": mechanism.description.scene,
            "content": content_hash(origin.text)}  # fmt: skip


def start_again(
    mechanism: Mechanism, p: FloatArray, t: float, q: FloatArray, v: FloatArray
) -> Assembly:
    """The assembled start of a motion that began at these coordinates and velocities, (n,) each."""
    start = assemble(Equations(mechanism, p), t, start_at=State(t, q, v))
    return replace(start, q=q, v=v)


def simulated_again(
    mechanism: Mechanism, p: FloatArray, start: Assembly, parameters: Mapping[str, float],
    kept: dict[str, Any],
) -> SimulatedMotion:  # fmt: skip
    """The run of a simulation from a start, of what was kept of it; without its functions."""

    def missing(*_: Any) -> float:
        raise InputError(
            f"{mechanism.title}: the controllers of this run are functions that no file keeps, so "
            "it cannot be taken again. Simulate anew."
        )

    length = kept["length"] if "length" in kept else kept["handover"]  # of older files
    ready = PreparedSimulation(
        mechanism, kept["t_end"], t_start=start.t, parameters=parameters, guess=None,
        start=start, controllers=dict.fromkeys(mechanism.description.controllers, missing),
        length=length if length is None else float(length),
    )  # fmt: skip
    ready.given_t = kept["given_t"]
    ready.samples_taken, taken = kept["taken"]
    ready.discrete, last = (_discrete(mechanism, p, stand) for stand in kept["discrete"])
    options = Options(**kept["options"])
    coordinates = formulate(ready, kept["formulation"], options.method, options.correction)
    return SimulatedMotion(coordinates, options, Checkpoints(), kept["end"], taken, last)


def _discrete(mechanism: Mechanism, p: FloatArray, stand: Any) -> Discrete | None:
    """Where clocks and conditions stand, by the tables of the machine; InputError if by others."""
    if stand is None:
        return None
    clocks = read_clocks(mechanism.system, p)
    count, queue = len(clocks), queue_length(clocks)
    ticks = floats(stand.ticks, (2 * count,), "ticks").astype(np.int64)
    ahead = np.diff(ticks.reshape(count, 2))  # from the next sample to the next that acts
    if ((ahead > 0) | (ahead < -queue)).any():
        raise InputError("the array ticks of the file has clocks that wait for what never comes.")
    waiting = floats(stand.waiting, (count, queue), "waiting")
    watched = len(mechanism.description.watched)
    return Discrete(ticks, waiting, floats(stand.held, (watched,), "held"))
