"""What both studies share: the scene, loaded; the words of `simulate` for their runs; a timed run.

Undeclared variants of a scene are compiled in a cache. A study hands to each of its runs what it
does not set itself, with the annotations and defaults of `Machine.simulate`, where they are
explained.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial, wraps
from inspect import Parameter, signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, ParamSpec, TypeVar

from codegen.errors import AnalysisError, InputError
from codegen.readers import arguments as readers
from runtime.core.outcomes import Outcome
from runtime.dynamics.connected_simulation import simulate
from runtime.dynamics.output_conditions import read_conditions, simulate_until
from runtime.integrate.method import IMPLICIT
from runtime.integrate.simulation_options import OPTIONS
from runtime.machine_facade import Machine
from runtime.machine_loading import load
from runtime.mechanism.dense_equations import FloatArray
from runtime.results.assembled_state import Assembly
from runtime.results.result import Result
from runtime.studies.timing import Stopwatch, TimeLimit
from runtime.validation.arguments import check

if TYPE_CHECKING:
    from codegen import Model, Scene

Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")

CACHE = ".linkwright_cache"  # folder for modules of undeclared scenes, in the user's folder
FORMULATIONS = ("cartesian", "reduced")
_CORRECTIONS = {"step": "", "stage": ", every stage", "projection": ", projection"}
TIMEOUT = "TIMEOUT"
TIME = "integration_seconds"  # entry of `Result.stats`
LEFT_OUT = "none"  # fidelity of an effect left out: `codegen.reading.scene_selection.Variant.word`

_OF_THE_STUDY = {
    *("self", "parameters", "guess", "start", "progress", "out"),
    *(option.name for option in OPTIONS if not option.of_studies),
}

_VALUES = readers.optional(readers.values('{"mass": 2.0}'))
_INSTANT = readers.number("a finite number of seconds")
READERS = {
    "model": readers.model, "scene": readers.optional(readers.scene),
    "folder": readers.optional(readers.path), "generated": readers.optional(readers.path),
    **dict.fromkeys(("parameters", "guess", "start"), _VALUES),
    "t_end": readers.optional(_INSTANT), "t_start": _INSTANT, "progress": readers.study_reporter,
}  # fmt: skip
"""Arguments that all studies take."""


class Source(NamedTuple):
    """The model and scene that a user named, the folder of the work, that of the modules."""

    given: "str | os.PathLike[str] | Model"
    given_scene: "str | Scene | None"
    folder: str | os.PathLike[str] | None
    generated: str | os.PathLike[str] | None
    model: "Model"
    scene: "Scene"

    def machine(self, scene: "Scene | None" = None) -> Machine:
        """The machine of the named scene, or of another of the model, as `load` finds it."""
        named = self.given_scene if scene is None else scene.name if scene.root is None else scene
        scene = scene or self.scene
        if isinstance(named, str | None) and not hasattr(self.given, "scenes"):
            return load(self.given, scene.name, folder=self.folder, generated=self.generated)
        return self.variant(scene)

    def variant(self, scene: "Scene") -> Machine:
        """The machine of an undeclared scene of the model, compiled in the cache."""
        return load(self.model, scene, folder=cache_folder(self.folder))


def read_source(
    model: "str | os.PathLike[str] | Model", scene: "str | Scene | None",
    folder: str | os.PathLike[str] | None, generated: str | os.PathLike[str] | None = None,
) -> Source:  # fmt: skip
    """Read the model, and find the scene in it: the first unless one is named."""
    from codegen.reading.scene_selection import declared

    read = declared(Path(model) if isinstance(model, os.PathLike) else model, scene)
    return Source(model, scene, folder, generated, *read)


def cache_folder(folder: str | os.PathLike[str] | None) -> Path:
    """The cache in the user's folder, created if need be and hidden from version control."""
    path = (Path(folder) if folder is not None else Path.cwd()) / CACHE
    try:
        path.mkdir(exist_ok=True)
        (path / ".gitignore").write_text("*\n", encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{path}: undeclared scenes are compiled in this folder, which cannot be written "
            f"({error.strerror}); give folder=, or work in another folder."
        ) from error
    return path


def known_values(
    machine: Machine, parameters: Mapping[str, float], guess: Mapping[str, float],
    start: Mapping[str, float],
) -> dict[str, dict[str, float]]:  # fmt: skip
    """The arguments of an analysis: those values that the scene has; `start` where it has one."""
    rows = machine.coordinates
    states = {*rows.names, *(row.velocity for row in rows)}
    values = {
        "parameters": {k: x for k, x in parameters.items() if k in machine.parameters.names},
        "guess": {k: x for k, x in guess.items() if k in states},
    }
    kept = {k: x for k, x in start.items() if k in states}
    return values | ({"start": kept} if kept else {})


def require_time_span(machine: Machine, t_start: float, t_end: float | None) -> float:
    """The last instant of a run, s; refused if it is missing, or not after the first."""
    title = machine.description.title
    if t_end is None:
        raise AnalysisError(f"{title}: t_end is missing; give the last instant in s (--t-end).")
    if not t_start < t_end < float("inf"):
        raise AnalysisError(
            f"{title}: the time span from {t_start:g} to {t_end:g} s must be finite and positive."
        )
    return float(t_end)


def analysis_of(machine: Machine) -> str:
    """The analysis that a scene is meant for."""
    description = machine.description
    if description.analysis == "equilibrium":
        return "equilibrium"
    if description.drivers and machine.is_determined:
        return "inverse_dynamics" if description.has_masses else "kinematics"
    return "simulate"


def takes_simulation_arguments(
    *without: str,
) -> Callable[[Callable[Arguments, Answer]], Callable[Arguments, Answer]]:
    """A study with these words in place of its `**run`, which receives those that are given.

    `without` are words that the study sets besides.
    """

    def decorate(study: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
        @wraps(study)
        def taking(*positional: Arguments.args, **named: Arguments.kwargs) -> Answer:
            return study(*positional, **named)

        about, words = signature(study), signature(Machine.simulate).parameters.values()
        own = [p for p in about.parameters.values() if p.kind is not Parameter.VAR_KEYWORD]
        more = [p for p in words if p.name not in {*_OF_THE_STUDY, *without}]
        more = [p.replace(kind=Parameter.KEYWORD_ONLY) for p in more]
        taking.__signature__ = about.replace(parameters=[*own, *more])  # type: ignore[attr-defined]
        return taking

    return decorate


def read_simulation_arguments(machine: Machine, run: Mapping[str, Any]) -> dict[str, Any]:
    """Those with another value than that of `Machine.simulate`; InputError where some misfit."""
    usual = {name: word.default for name, word in signature(Machine.simulate).parameters.items()}
    given = {name: value for name, value in run.items() if value is not usual[name]}
    until = given.pop("until", None)
    words = check(machine.mechanism, **given)
    if until is not None:
        read_conditions(machine.description, until)
        words["until"] = until
    return words


def refuse_simulation_arguments(run: Mapping[str, Any], title: str, analysis: str) -> None:
    """Raise InputError where words are given to a study of an analysis that integrates nothing."""
    if run:
        raise InputError(
            f"{title}: {analysis} integrates nothing, so {', '.join(run)} would be ignored. Leave "
            "out what a simulation takes."
        )


def arguments_of_variant(machine: Machine, run: Mapping[str, Any]) -> dict[str, Any]:
    """The words for a variant of a scene: it has the controllers of its own sampled values."""
    words = dict(run)
    if words.get("controllers"):
        own = machine.description.controllers
        words["controllers"] = {k: one for k, one in words["controllers"].items() if k in own}
    return words


@dataclass(frozen=True)
class Setting:
    """How a scene is integrated: arguments of `simulate`."""

    method: str
    formulation: str = "cartesian"
    correction: str = "step"

    @property
    def title(self) -> str:
        """``dop853, reduced``, or ``dop853, cartesian, every stage``."""
        correction = _CORRECTIONS.get(self.correction, self.correction)
        return f"{self.method}, {self.formulation}{correction}"

    @property
    def companion(self) -> str:
        """The companion module that it takes: "reduced", "tangents", or "" for none."""
        if self.formulation == "reduced":
            return "reduced"
        return "tangents" if self.method in IMPLICIT else ""


def all_settings(methods: Sequence[str], formulations: Sequence[str]) -> tuple[Setting, ...]:
    """Every method in every formulation; "dop853" in all coordinates in every correction."""
    settings = [Setting(method, formulation) for method in methods for formulation in formulations]
    if "dop853" in methods and "cartesian" in formulations:
        settings += [Setting("dop853", "cartesian", way) for way in ("stage", "projection")]
    return tuple(settings)


@dataclass(frozen=True)
class Runner:
    """A scene, assembled and ready to be run in any setting."""

    machine: Machine
    begin: Assembly
    instants: FloatArray  # at which it is compared, s, (k,)
    parameters: dict[str, float]  # over the scene's defaults
    limit: float  # time of a run, s
    steps: int  # trial steps of a run
    # of `Machine.simulate`, besides
    words: Mapping[str, Any] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """MODEL/SCENE."""
        return self.machine.description.title

    def run(self, setting: Setting, rtol: float) -> Result:
        """Run once; `Outcome.INTERRUPTED` is a run that the limit of time ended."""
        others = any(row.reconnects for row in self.machine.description.watched)
        for _ in range(2 if others else 1):  # in the first run scenes that follow may be built
            limit = TimeLimit(self.limit)
            words = arguments_of_variant(self.machine, self.words)
            until = words.pop("until", None)
            given = {
                "t_end": float(self.instants[-1]), "t_eval": self.instants, "rtol": rtol,
                "t_start": self.begin.t, "parameters": self.parameters, "start": self.begin,
                "step_limit": self.steps, "progress": limit, **asdict(setting), **words,
            }  # fmt: skip
            analyse = partial(simulate, self.machine.mechanism)
            if until is None:
                result = analyse(**given)
            else:
                conditions = read_conditions(self.machine.description, until)
                result = simulate_until(analyse, conditions, given)
            if not limit.exceeded:
                break
        if result.outcome is Outcome.INTERRUPTED and not limit.exceeded:
            raise KeyboardInterrupt  # by the user
        return result

    def stopwatch(self, setting: Setting, rtol: float, *times: float) -> Stopwatch:
        """Repeats a run; one that does not reach its end has no time of a whole run."""

        def seconds() -> float | None:
            result = self.run(setting, rtol)
            return None if result.failed else result.stats[TIME]

        return Stopwatch(seconds, *times)


def outcome_name(result: Result) -> str:
    """The name of the `Outcome`, or "TIMEOUT": the limit of time alone interrupts a run."""
    return TIMEOUT if result.outcome is Outcome.INTERRUPTED else str(result.outcome)
