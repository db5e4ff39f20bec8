"""A work-precision diagram as data: settings, runs, reference, modelling choices."""

import math
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

from runtime.integrate.method import IMPLICIT
from runtime.results.samples import plain
from runtime.studies.error_norms import Errors, Scale

DONE = "OK"
TIMEOUT = "TIMEOUT"
NOT_TRIED = "NOT_TRIED"
_CORRECTIONS = {"step": "", "stage": ", every stage", "projection": ", projection"}


class Setting(NamedTuple):
    """How a scene is integrated: arguments of `simulate`."""

    method: str
    formulation: str = "cartesian"
    correction: str = "step"

    @property
    def title(self) -> str:
        """``dop853, reduced``, or ``dop853, cartesian, every stage``."""
        return (
            f"{self.method}, {self.formulation}{_CORRECTIONS.get(self.correction, self.correction)}"
        )

    @property
    def companion(self) -> str:
        """The companion module that it takes: "reduced", "tangents", or "" for none."""
        if self.formulation == "reduced":
            return "reduced"
        return "tangents" if self.method in IMPLICIT else ""


@dataclass(frozen=True)
class Point:
    """One run.

    Attributes
    ----------
    outcome, message
        "OK"; the name of a `runtime.Outcome`; "TIMEOUT" where the limit of time ended it;
        "NOT_TRIED" where looser tolerances had met the limit twice. How it ended, in a sentence.
    errors
        Against the reference; None of a run that did not reach its end.
    beyond
        Whether the error is smaller than that of the reference, and so is not known itself.
    seconds
        Processor time of the integration in s, without assembly and outputs: least of `runs`.
    spread
        The median of the runs' times over the least.
    counts
        Entries of `Result.stats`.
    position_residual, velocity_residual
        Largest |Φ| over the machine's size, and |Φ_q q̇ - ν| over the largest velocity.
    energy
        Largest error of the energy over its largest magnitude; None where there is none.
    """

    rtol: float
    outcome: str
    message: str = ""
    errors: Errors | None = None
    beyond: bool = False
    seconds: float = math.nan
    spread: float = math.nan
    runs: int = 0
    counts: dict[str, float] = field(default_factory=dict)
    position_residual: float = math.nan
    velocity_residual: float = math.nan
    energy: float | None = None

    @property
    def digits(self) -> float:
        """-log10 of the worst scaled error; nan of a run that failed."""
        if self.errors is None:
            return math.nan
        return -math.log10(max(self.errors.worst, 1e-17))


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
    """A run that confirms the reference to a scaled error; or why it does not."""

    title: str
    error: float | None
    reason: str = ""


@dataclass(frozen=True)
class Reference:
    """The solution with which all runs are compared.

    Attributes
    ----------
    source
        The file, or the setting of a run at a tolerance that no other run has.
    independent
        Whether it was given, not computed by the methods that are compared.
    checks
        Runs of other methods that confirm it.
    floor
        Scaled error to which it is known: the least difference of a check.
    horizon
        The instant, s, from which on it is known to fewer than six digits; None if there is none.
    """

    source: str
    independent: bool
    checks: tuple[Check, ...]
    floor: float
    horizon: float | None = None


@dataclass(frozen=True)
class Choice:
    """The scene with one thing modelled differently.

    Attributes
    ----------
    title, kind, scene
        ``rod as link``, the kind of the thing, and the scene that was run.
    setting
        Of the run; None where none was possible.
    point
        The loosest run whose error is that of the model and not of the integration.
    reason
        Why there is no run.
    """

    title: str
    kind: str
    scene: str
    setting: Setting | None = None
    point: Point | None = None
    reason: str = ""


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
        for line in self.lines:
            if line.setting.title == title:
                return line
        there = "; ".join(line.setting.title for line in self.lines)
        raise KeyError(f"{title!r}; there are: {there}")

    def facts(self) -> dict[str, Any]:
        """All fields and the sentences, as JSON; a number that is not finite is null."""
        from runtime.studies.work_precision.interpretation import sentences

        facts: dict[str, Any] = plain(_as_mappings(asdict(self)))
        return {**facts, "sentences": list(sentences(self, whole=True))}


def _as_mappings(facts: dict[str, Any]) -> dict[str, Any]:
    """Named tuples as mappings: `asdict` leaves them as they are."""
    facts["quantities"] = [scale._asdict() for scale in facts["quantities"]]
    for entry in (*facts["lines"], *facts["choices"]):
        if entry["setting"] is not None:
            entry["setting"] = entry["setting"]._asdict()
    return facts
