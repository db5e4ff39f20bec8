"""What studies share: the scene, loaded; the words of `simulate` for their runs; timed runs.

Undeclared variants of a scene are compiled in a cache. A study hands to each of its runs what it
does not set itself, with the annotations and defaults of `Machine.simulate`, where they are
explained.

Processor time is measured, not wall-clock time: the scheduler interrupts a run longer than its time
slice nearly every time where processors are busy, a short run hardly ever, so that wall-clock time
would overstate the longer run. Other processes only ever lengthen a run, through the caches, and
for a while at a time: runs are therefore repeated in turns, and the least time counts.
"""

import math
import os
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from inspect import Parameter, signature
from pathlib import Path
from time import perf_counter, process_time
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from codegen import __version__
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
from runtime.validation.arguments import KINDS, check, refuse_integration

if TYPE_CHECKING:
    from codegen import Model, Scene

Place = str | os.PathLike[str]
Report = Callable[[str], None]  # receives a line before every step that takes time
Study = TypeVar("Study", bound=Callable[..., Any])
Answer = TypeVar("Answer")

CACHE = ".linkwright_cache"  # folder for modules of undeclared scenes, in the user's folder
_CORRECTIONS = {"step": "", "stage": ", every stage", "projection": ", projection"}
TIMEOUT = "TIMEOUT"
TIME = "integration_seconds"  # entry of `Result.stats`
LEFT_OUT = "none"  # fidelity of an effect left out: `codegen.reading.scene_selection.Variant.word`
LIBRARIES = ("numba", "llvmlite", "numpy", "scipy", "sympy")
MOST = 30  # safety: runs for one measured time, however short they are

_OF_THE_STUDY = {
    *("self", "parameters", "guess", "start", "progress", "out"),
    *(option.name for option in OPTIONS if not option.of_studies),
}


READERS = {name: KINDS[name] for name in ("parameters", "guess", "t_start")} | {
    "model": readers.model, "scene": readers.optional(readers.scene),
    "folder": readers.optional(readers.path), "generated": readers.optional(readers.path),
    "t_end": readers.optional(KINDS["t_end"]), "start": KINDS["parameters"],
    "analysis": readers.optional(KINDS["analysis"]), "progress": readers.study_reporter,
}  # fmt: skip
"""Arguments that studies take."""


class Source(NamedTuple):
    """A model and a scene of it, the folder of the work, that of the modules."""

    given: "str | Model"  # the model as the user named it
    folder: Place | None
    generated: Place | None
    model: "Model"
    scene: "Scene"

    @property
    def title(self) -> str:
        """MODEL/SCENE."""
        return f"{self.model.name}/{self.scene.name}"

    def machine(self, scene: "Scene | None" = None) -> Machine:
        """The machine of the scene, or of another of the model, as `load` finds it."""
        scene = scene or self.scene
        declared = self.model.scenes or {scene.name: scene}
        if self.given is not self.model and declared.get(scene.name) == scene:
            return load(self.given, scene.name, folder=self.folder, generated=self.generated)
        return self.variant(scene)

    def variant(self, scene: "Scene") -> Machine:
        """The machine of an undeclared scene of the model, compiled in the cache."""
        return load(self.model, scene, folder=cache_folder(self.folder))


def read_source(
    model: Any, scene: "str | Scene | None", folder: Place | None, generated: Place | None
) -> Source:
    """Read the model, and find the scene in it: the first unless one is named."""
    from codegen.reading.scene_selection import declared

    return Source(model, folder, generated, *declared(model, scene))


def cache_folder(folder: Place | None) -> Path:
    """The cache in the user's folder, created if need be and hidden from version control."""
    path = Path(folder or "").absolute() / CACHE
    try:
        path.mkdir(exist_ok=True)
        (path / ".gitignore").write_text("*\n", encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{path}: undeclared scenes are compiled in this folder, which cannot be written "
            f"({error.strerror}); give folder=, or work in another folder."
        ) from error
    return path


def require_time_span(
    machine: Machine, analysis: str, t_start: float, t_end: float | None
) -> float:
    """The last instant of a run, s; refused if it is missing, or not after the first.

    An equilibrium ends where it begins.
    """
    title = machine.description.title
    if analysis == "equilibrium":
        return float(t_start)
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


def takes_simulation_arguments(*without: str) -> Callable[[Study], Study]:
    """A study with these words in place of its `**run`, which receives those that are given.

    `without` are words that the study sets besides.
    """

    def decorate(study: Study) -> Study:
        about, words = signature(study), signature(Machine.simulate).parameters.values()
        own = [p for p in about.parameters.values() if p.kind is not Parameter.VAR_KEYWORD]
        more = [p for p in words if p.name not in {*_OF_THE_STUDY, *without}]
        more = [p.replace(kind=Parameter.KEYWORD_ONLY) for p in more]
        study.__signature__ = about.replace(parameters=[*own, *more])  # type: ignore[attr-defined]
        return study

    return decorate


def read_simulation_arguments(
    machine: Machine, run: Mapping[str, Any], analysis: str = "simulate"
) -> dict[str, Any]:
    """Those with another value than that of `Machine.simulate`.

    Raises InputError where some misfit, or would be ignored since the analysis integrates nothing.
    """
    usual = signature(Machine.simulate).parameters
    given = {name: value for name, value in run.items() if value is not usual[name].default}
    until = given.pop("until", None)
    words = check(machine.mechanism, given)
    if until is not None:
        read_conditions(machine.description, until)
        words["until"] = until
    if analysis != "simulate":
        refuse_integration(machine.description.title, analysis, words)
    return words


def arguments_of_variant(machine: Machine, given: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of an analysis for a variant of a scene: of what is given by name, its own."""
    states = {name for row in machine.coordinates for name in (row.name, row.velocity)}
    known = {
        "parameters": machine.parameters.names, "guess": states, "start": states,
        "controllers": machine.description.controllers,
    }  # fmt: skip
    found = dict(given)
    for word, names in known.items():
        kept = {name: x for name, x in (found.pop(word, None) or {}).items() if name in names}
        found |= {word: kept} if kept else {}
    return found


@dataclass(frozen=True)
class Setting:
    """How a scene is integrated: arguments of `simulate`."""

    method: str
    formulation: str = "cartesian"
    correction: str = "step"

    @property
    def title(self) -> str:
        """``dop853, reduced``, or ``dop853, cartesian, every stage``."""
        return f"{self.method}, {self.formulation}{_CORRECTIONS[self.correction]}"

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
    limit: float  # time of a run, s
    steps: int  # trial steps of a run
    # parameters over the scene's defaults, and words of `Machine.simulate`
    words: Mapping[str, Any] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """MODEL/SCENE."""
        return self.machine.description.title

    def run(self, setting: Setting, rtol: float) -> Result:
        """Run once; `Outcome.INTERRUPTED` is a run that the limit of time ended."""
        about = self.machine.description
        given: dict[str, Any] = {
            "t_end": float(self.instants[-1]), "t_eval": self.instants, "rtol": rtol,
            "t_start": self.begin.t, "start": self.begin, "step_limit": self.steps,
            **asdict(setting), **self.words,
        }  # fmt: skip
        until = given.pop("until", None)
        conditions = () if until is None else read_conditions(about, until)
        analyse = partial(simulate, self.machine.mechanism)
        others = any(row.reconnects for row in about.watched)
        for _ in range(2 if others else 1):  # in the first run scenes that follow may be built
            given["progress"] = limit = TimeLimit(self.limit)
            result = simulate_until(analyse, conditions, given) if conditions else analyse(**given)
            if not limit.exceeded:
                break
        if result.outcome is Outcome.INTERRUPTED and not limit.exceeded:
            raise KeyboardInterrupt  # by the user
        return result

    def seconds(self, setting: Setting, rtol: float) -> float | None:
        """Processor time of another run; None where it does not reach its end."""
        result = self.run(setting, rtol)
        return None if result.failed else result.stats[TIME]


def outcome_name(result: Result) -> str:
    """The name of the `Outcome`, or "TIMEOUT": the limit of time alone interrupts a run."""
    return TIMEOUT if result.outcome is Outcome.INTERRUPTED else str(result.outcome)


def processor_time(run: Callable[[], Answer]) -> tuple[Answer, float]:
    """The answer of a run, and its processor time in s."""
    started = process_time()
    answer = run()
    return answer, process_time() - started


class TimeLimit:
    """Progress callback that interrupts a run which takes too long; compilation does not count."""

    def __init__(self, limit: float) -> None:
        self.limit, self.exceeded = limit, False
        self.started: float | None = None

    def __call__(self, fraction: float) -> None:
        """Note the first sign of life; interrupt once the limit has passed since."""
        if self.started is None:
            self.started = perf_counter()
        elif perf_counter() - self.started > self.limit:
            self.exceeded = True
            raise KeyboardInterrupt  # ends the run with the part that it has computed


def time_runs(
    runs: Iterable[Callable[[], float | None]], first: Sequence[float], rounds: int, least: float
) -> list[list[float]]:
    """Processor times of runs, s, which take turns until each is done or, None, is cut short.

    Each is run `rounds` times and for `least` s, or `MOST` times; of one that takes `least` alone
    two times are enough. That of a `first` run counts only if it was long: a short one met cold
    caches.
    """
    times = [[seconds] if seconds >= least else [] for seconds in first]
    waiting = dict(enumerate(runs))
    while waiting:
        for k, run in [*waiting.items()]:
            seconds, found = run(), times[k]
            found += [] if seconds is None else [seconds]
            enough = rounds if sum(found) >= least else MOST
            if seconds is None or len(found) >= (2 if min(found) >= least > 0.0 else enough):
                del waiting[k]
    return [found or [seconds] for found, seconds in zip(times, first, strict=True)]


def time_to_error(points: Iterable[tuple[float, float]], error: float) -> float:
    """Time in which runs, from the loosest to the tightest, first reach an error.

    Interpolated between the (error, time) of the run that reaches it and of the run before,
    logarithm over logarithm; the time of the first run if that reaches it; infinite if no run does.
    """
    loose: tuple[float, float] | None = None
    for worst, seconds in points:
        if worst <= error:
            if loose is None or math.isinf(loose[0]):
                return seconds
            far, near = math.log(loose[0]), math.log(max(worst, 1e-17))
            share = (far - math.log(error)) / (far - near)
            fast, slow = math.log(loose[1]), math.log(seconds)
            return math.exp(fast + share * (slow - fast))
        loose = worst, seconds
    return math.inf


def environment() -> dict[str, str]:
    """Processor, operating system and versions: name → text."""
    facts = {
        "machine": processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "linkwright": __version__,
    }
    for name in LIBRARIES:
        with suppress(PackageNotFoundError):  # a library in a bundle may come without metadata
            facts[name] = version(name)
    return facts


def processor() -> str:
    """Name of the processor."""
    information = Path("/proc/cpuinfo")
    if information.is_file():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
