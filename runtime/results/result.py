"""The result of an analysis: series over time, how the run went, and how it ended."""

import json
import os
from dataclasses import KW_ONLY, InitVar, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from codegen import __version__
from codegen.errors import InputError
from codegen.object_display import counted
from codegen.readers import arguments as readers
from codegen.readers.calls import checked_class, named_attributes
from runtime.core.outcomes import Outcome
from runtime.mechanism.module_tables import Description
from runtime.results.assembled_state import State
from runtime.results.motion_at_instants import Motion, at, state
from runtime.results.result_display import html_of_result, text_of
from runtime.results.result_figures import ResultFigures
from runtime.results.run_records import (
    Ending,
    Event,
    ReachedAccuracy,
    Reconnection,
    SingularPosition,
)
from runtime.results.samples import FloatArray, Partition, Samples, plain

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from runtime.mechanism.mechanism import Mechanism


@named_attributes
@checked_class
@dataclass(eq=False, repr=False)
class Result(ResultFigures):
    """Motion of a machine at the instants `t`.

    Attributes
    ----------
    samples
        The arrays, one row an instant.
    outcome
        How the analysis ended; `message` says it in full, with time and joint.
    site
        The function that ended the run, and its finding, if several functions lead to the outcome;
        empty otherwise.
    contradiction
        The finding of a check that contradicts the results, with numbers; empty if there is none.
    stats
        Counts of steps, evaluations and iterations, explained in
        `runtime.integrate.problem.Statistics`, and the wall time in s. `crossing_error`: largest
        error of a step across a singular configuration, divided by the tolerance;
        `integration_seconds`: processor time of the integration alone.
    events
        Changes of modes and impacts between the instants; in driven motions crossings, lock-ups
        and kinks of laws of time, while `mode` has the conditions of forces.
    partitions
        The independent coordinates of a simulation: the first choice, then every change.
    works
        Work of effects and drivers since the start in J, by name, each (k,).
    not_unique
        Joints, drivers and frictions whose forces the motion does not determine; the result has the
        smallest forces.
    singular
        The singular configurations that the run met, in order.
    accuracy
        In a simulation with an accuracy target: the accuracy reached, and how it was estimated.
    parameters
        Parameter values by name.
    ended_by
        The condition of ``until=``, in the scene or the call, that ended the run; empty if none
        did.
    reconnections
        The joints that were released or engaged in a run, with their impulses.
    reconnection
        For a part of a run: the change of joints that ended the part, and the state there.
    work_at_end
        Works at the end of a run, J; the end may be later than the last instant.
    """

    description: Description
    samples: Samples
    p: InitVar[FloatArray]  # values of the parameters, and of the constants behind them
    _: KW_ONLY
    analysis: str
    outcome: Outcome
    message: str
    stats: dict[str, float] = field(default_factory=dict)
    site: str = ""
    contradiction: str = ""
    events: tuple[Event, ...] = ()
    partitions: tuple[Partition, ...] = ()
    works: dict[str, FloatArray] = field(default_factory=dict)
    work_at_end: dict[str, float] = field(default_factory=dict)
    not_unique: tuple[str, ...] = ()
    singular: tuple[SingularPosition, ...] = ()
    accuracy: ReachedAccuracy | None = None
    ended_by: str = ""
    reconnections: tuple[Reconnection, ...] = ()
    reconnection: Ending | None = None
    parameters: dict[str, float] = field(init=False)
    # conditions on outputs that may end a run
    _until: tuple[tuple[str, str, float, float], ...] = ()
    _chosen: bool = False  # whether the samples are at instants that `at` was asked for
    _moved: FloatArray | None = None  # where samples of `at` are taken, s: on a side of an event
    _held: str = ""  # sentences on frictions that joints and drivers hold at rest
    _motion: Motion | None = None  # behind the samples; None: of an analysis without one
    _mechanism: "Mechanism | None" = None  # that moves; None: it is not known

    def __post_init__(self, p: FloatArray) -> None:
        self.parameters = dict(zip(self.description.parameters.names, p.tolist(), strict=False))

    def __getstate__(self) -> dict[str, Any]:
        """Without the arrays that follow from the others."""
        found = ("data", "_afterwards")
        return {name: value for name, value in vars(self).items() if name not in found}

    @property
    def failed(self) -> bool:
        """Whether the analysis ended before its end."""
        return self.outcome is not Outcome.OK

    @property
    def t(self) -> FloatArray:
        """Instants in s, shape (k,)."""
        return self.samples.t

    @property
    def instants_of_states(self) -> FloatArray:
        """Instants of the samples, s, (k,): `t`, except at the sides of events and kinks."""
        motion = self._motion
        times = self.t if self._moved is None else self._moved
        return times if motion is None else np.maximum(times, motion.behind)

    @cached_property
    def data(self) -> "xr.Dataset":
        """All series as an `xarray.Dataset`, units in the attributes."""
        from runtime.results.dataset import dataset

        return dataset(self)

    def to_pandas(self) -> "pd.DataFrame":
        """A data frame, a row for each instant, a column for each series, units in ``attrs``."""
        from runtime.results.export import frame

        return frame(self)

    @readers.reads(count=readers.count(1))
    def table(self, *names: str, count: int = 11, unit: Any = ()) -> "pd.DataFrame":
        """Series at a few instants, with the least and greatest value of all samples.

        Parameters
        ----------
        names
            As in `series`; without any, the coordinates and states. A column names its unit.
        count, unit
            How many instants, in s, from the first sample to the last; units as in `plot`.
        """
        from runtime.results.export import short_table

        return short_table(self, names, count, unit)

    @readers.reads(path=readers.path)
    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the result to a file; a failure leaves no incomplete file.

        Parameters
        ----------
        path
            A file ending in .nc (netCDF 4), .zarr, .csv, .parquet, .mat or .html; an older one is
            replaced.

        Raises
        ------
        InputError
            If the ending is another one, the folder does not exist or cannot be written, or a
            library for the format is not installed.
        """
        from runtime.results.export import save

        return save(self, Path(path))

    def at(
        self, t: float | npt.ArrayLike, side: Literal["before", "after"] | None = None
    ) -> "Result":
        """The motion at any instant: a result like this one, with its samples at `t`.

        The run is repeated from a checkpoint, with the same steps. Each quantity equals, to the
        last digit, that of a run with `t` among the instants of `t_eval`; a work equals it up to
        rounding.

        Parameters
        ----------
        t
            An instant in s or several, in any order, from the start of the run to its end.
        side
            "before" or "after": the side of the event, if `t` is the instant of one of `events`; by
            default the side of a sample, before a change of modes.

        Returns
        -------
        Result
            The same quantities at one instant, shape (1,), or at the instants of `t`.

        Raises
        ------
        InputError
            If `t` is not within the result, or this is the result of an equilibrium.
        """
        return at(self, t, side)

    def state(
        self, t: float | None = None, side: Literal["before", "after"] | None = None
    ) -> State:
        """The state at an instant, at which another simulation may start.

        Parameters
        ----------
        t, side
            An instant in s, and the side of an event, as `at` takes them; by default the end of the
            motion, or the last sample of a result that `at` returned.

        Raises
        ------
        InputError
            If the result has no sample, or `t` is not within the result.
        """
        return state(self, t, side)

    def resume(
        self, t_end: float, t_eval: "npt.ArrayLike | int | str | None" = None, *,
        max_steps: int | None = None, progress: bool = True,
    ) -> "Result":  # fmt: skip
        """Continue a simulation from where it stopped, with the same settings.

        The steps and the bits are those of a single run to the new end. Earlier steps are repeated
        if they depend on the end of the run: if laws of time are not sums of powers and sines, or
        if Baumgarte's time is not given. A run that a condition ended goes on until the condition
        begins to hold the next time.

        Parameters
        ----------
        t_end, t_eval
            As `simulate` takes them, both after the instant at which the run stopped.
        max_steps, progress
            Largest number of trial steps, including earlier ones; whether a terminal shows a bar.

        Returns
        -------
        Result
            The motion from that instant on; works, counts and `at` include the earlier part.

        Raises
        ------
        InputError
            If `t_end` is not later, or if this is not a simulation or has an accuracy target.
        AnalysisError
            If the run ended where the motion cannot go on.
        """
        motion, found = self._motion, None
        if motion is not None:
            found = motion.resumed(self, t_end, t_eval, max_steps, progress)
        if found is None:
            raise InputError(
                f"{self.description.title}: a simulation goes on from where it stopped, and this "
                f"is a result of {self.analysis}. Ask for that up to a later instant, or simulate "
                "from it, start=result."
            )
        result: Result = found
        return result

    def facts(self) -> dict[str, Any]:
        """The run as JSON: model, scene, outcome, parameters, statistics, accuracy, joints."""
        facts = {
            "model": self.description.model,
            "scene": self.description.scene,
            "analysis": self.analysis,
            "outcome": self.outcome.name,
            "message": self.message,
            "site": self.site,
            "parameters": self.parameters,
            "stats": plain(self.stats),
            "not_unique": ", ".join(self.not_unique),
            "singular": [row.facts() for row in self.singular],
            "accuracy": self.accuracy and self.accuracy.facts(),
            "ended_by": self.ended_by,
            "reconnections": [plain(change._asdict()) for change in self.reconnections],
        }
        rare = ("site", "accuracy", "ended_by", "reconnections")
        return {name: fact for name, fact in facts.items() if fact or name not in rare}

    def about(self) -> dict[str, str]:
        """The run in texts, as files carry it: its facts, and the versions of programs."""
        versions = {"linkwright": __version__, "generator": self.description.generator}
        facts = {**self.facts(), **versions, "numpy": np.__version__}
        return {k: fact if isinstance(fact, str) else json.dumps(fact) for k, fact in facts.items()}

    def __repr__(self) -> str:
        """The headline, and what there is to look up."""
        return text_of(self)

    def _repr_html_(self) -> str:
        """The same with a table of the coordinates, for notebooks."""
        return html_of_result(self)

    @property
    def headline(self) -> str:
        """Title, span and outcome."""
        count = len(self.t)
        ends = f" to {self.t[-1]:g}" if count > 1 else ""
        span = f"t = {self.t[0]:g}{ends} s" if count else "nothing computed"
        return (
            f"{self.description.title}, {self.analysis}: "
            f"{counted(count, 'instant')}, {span}\n"
            f"  {self.outcome.name}: {self.message}"
        )
