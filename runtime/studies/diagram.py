"""A work-precision diagram as data: settings, runs, reference, modelling choices."""

import math
from dataclasses import asdict, dataclass, field
from itertools import chain
from typing import TYPE_CHECKING, Any

from codegen.object_display import counted, html_of, html_table
from codegen.readers.calls import checked_class
from runtime.accuracy_target.error_norms import Errors, Scale
from runtime.results.samples import plain
from runtime.studies.harness import Setting, titled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Point:
    """One run."""

    rtol: float
    # "OK"; the name of a `runtime.Outcome`; "TIMEOUT" where the limit of time ended it; "NOT_TRIED"
    # where looser tolerances had met the limit twice; "OTHER_END" where joints come and go, or a
    # condition ends the run, otherwise than in the reference
    outcome: str
    message: str = ""  # how it ended, in a sentence
    errors: Errors | None = None  # against the reference; None of a run that did not reach its end
    beyond: bool = False  # whether the error is smaller than that of the reference: not known
    seconds: float = math.nan  # processor time of the integration alone, the least of the runs
    spread: float = math.nan  # median of the runs' times over the least
    runs: int = 0
    counts: dict[str, float] = field(default_factory=dict)  # entries of `Result.stats`
    position_residual: float = math.nan  # largest |Φ| over the machine's size
    velocity_residual: float = math.nan  # largest |Φ_q q̇ - ν| over the largest velocity
    energy: float | None = None  # largest error over its largest magnitude; None without energy

    @property
    def worst(self) -> float:
        """The largest scaled error; nan of a run that failed."""
        return math.nan if self.errors is None else self.errors.worst

    @property
    def digits(self) -> float:
        """-log10 of the largest scaled error; nan of a run that failed."""
        return math.nan if self.errors is None else -math.log10(max(self.worst, 1e-17))


@dataclass(frozen=True)
class Line:
    """A setting at all tolerances, the loosest first; or why the scene cannot take it."""

    setting: Setting
    points: tuple[Point, ...] = ()
    refused: str = ""

    @property
    def done(self) -> tuple[Point, ...]:
        """The runs that reached their end."""
        return tuple(point for point in self.points if point.errors is not None)

    @property
    def known(self) -> tuple[Point, ...]:
        """Those of them whose error the reference can resolve."""
        return tuple(point for point in self.done if not point.beyond)

    @property
    def failed(self) -> tuple[Point, ...]:
        """The runs that did not reach their end."""
        return tuple(point for point in self.points if point.errors is None)


@dataclass(frozen=True)
class Check:
    """A run that confirms the reference to a scaled error."""

    title: str
    error: float


@dataclass(frozen=True)
class Reference:
    """The solution with which all runs are compared."""

    source: str  # the file, or the setting of a run at a tolerance that no other run has
    independent: bool  # whether it was given, not computed by the methods that are compared
    checks: tuple[Check, ...]  # runs of other methods that confirm it
    floor: float  # scaled error to which it is known: the least difference of a check
    horizon: float | None = None  # instant, s, from which on it is known to fewer than six digits


@dataclass(frozen=True)
class Choice:
    """The scene with one thing modelled differently."""

    title: str  # ``rod as link``
    kind: str  # of the thing
    scene: str  # that was run
    setting: Setting | None = None  # of the run; None where none was possible
    point: Point | None = None  # the loosest run whose error is that of the model alone
    reason: str = ""  # why there is no run


@checked_class
@dataclass(frozen=True)
class WorkPrecision:
    """The time that the accuracy of a scene's motion costs.

    Attributes
    ----------
    t_start, t_end, instants
        The run, s, and the number of instants at which it is compared.
    quantities
        The compared quantities, and the scales of their errors.
    energy
        What the energy is compared with: "start" where it is conserved, "reference" where it
        changes, "" where the scene has none.
    limit, steps
        Wall-clock time, s, and steps that a run may take.
    build
        Stage → seconds of building the scene anew once, apart from all runs.
    environment
        Machine and versions.
    model_sha256, artefact
        SHA-256 of the model's file, where it has one, and of the generated module.
    """

    model: str
    scene: str
    t_start: float
    t_end: float
    instants: int
    quantities: tuple[Scale, ...]
    energy: str
    limit: float
    steps: int
    reference: Reference
    lines: tuple[Line, ...]
    choices: tuple[Choice, ...] = ()
    build: dict[str, float] = field(default_factory=dict)
    environment: dict[str, str] = field(default_factory=dict)
    model_sha256: str = ""
    artefact: str = ""

    def __getitem__(self, title: str) -> Line:
        """The line of a setting, by its title."""
        return titled("setting", {line.setting.title: line for line in self.lines}, title)

    def plot(self) -> "Figure":
        """Draw the error of every setting over the time that it takes.

        Raises
        ------
        InputError
            If matplotlib is not installed.
        """
        from runtime.studies.pictures import draw_diagram

        return draw_diagram(self)

    def __repr__(self) -> str:
        """The scene, the run, and what the study concludes, a line each."""
        from runtime.studies.conclusions import sentences

        span = f"t = {self.t_start:g} to {self.t_end:g} s"
        title = (
            f"{self.model}/{self.scene}, accuracy: {counted(len(self.lines), 'setting')}, {span}"
        )
        return "\n  ".join((title, *sentences(self)))

    def _repr_html_(self) -> str:
        """The same with the table of times, for notebooks."""
        from runtime.studies.conclusions import SCORES, score_sections

        rows = chain(*score_sections(self))
        return html_of(f"{self!r}\n  Times in ms:", html_table(SCORES, rows))

    def facts(self) -> dict[str, Any]:
        """All fields and the sentences, as JSON; a number that is not finite is null."""
        from runtime.studies.conclusions import sentences

        return {**plain(asdict(self)), "sentences": list(sentences(self, whole=True))}
