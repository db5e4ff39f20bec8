"""What is told of a scene whose accuracy was weighed against time; nothing here computes."""

import math
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

from runtime.integrate.method import IMPLICIT
from runtime.results.json_values import plain
from runtime.studies.error_norms import Errors, Scale

DONE = "OK"
TIMEOUT = "TIMEOUT"
NOT_TRIED = "NOT_TRIED"
_WAYS = {"step": "", "stage": ", every stage", "projection": ", projection"}


class Setting(NamedTuple):
    """How a scene is integrated: arguments of `simulate`."""

    method: str
    formulation: str = "cartesian"
    correction: str = "step"

    @property
    def title(self) -> str:
        """``dop853, reduced``, or ``dop853, cartesian, every stage``."""
        return f"{self.method}, {self.formulation}{_WAYS.get(self.correction, self.correction)}"

    @property
    def companion(self) -> str:
        """The file beside the scene's own that it takes: "reduced", "tangents", or "" for none."""
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
        "NOT_TRIED" where looser tolerances had met it twice. How it ended, in a sentence.
    errors
        Against the reference; None of a run that did not reach its end.
    beyond
        Whether the error is below what the reference is known to, and so is not known itself.
    seconds
        Processor time of the integration, assembly and outputs not included: the least of `runs`.
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
    """A setting at all tolerances, the loosest first; or why it is none for this scene."""

    setting: Setting
    points: tuple[Point, ...] = ()
    refused: str = ""

    @property
    def done(self) -> tuple[Point, ...]:
        """The runs that reached their end."""
        return tuple(point for point in self.points if point.errors is not None)

    @property
    def known(self) -> tuple[Point, ...]:
        """Those of them whose error the reference can tell."""
        return tuple(point for point in self.done if not point.beyond)

    @property
    def failed(self) -> tuple[Point, ...]:
        """The runs that did not."""
        return tuple(point for point in self.points if point.errors is None)


@dataclass(frozen=True)
class Check:
    """A run that confirms the reference, to a scaled error; or why it does not."""

    title: str
    error: float | None
    reason: str = ""


@dataclass(frozen=True)
class Reference:
    """What all runs are compared with.

    Attributes
    ----------
    source
        The file, or the setting of a run at a tolerance that no other run has.
    independent
        Whether it was given, and not made by the methods that are compared.
    checks
        What it was confirmed by: runs of other methods.
    floor
        To how small a scaled error it is known: the least by which a check differs.
    horizon
        The instant, s, from which on it is known to less than six digits; None: it is throughout.
    """

    source: str
    independent: bool
    checks: tuple[Check, ...]
    floor: float
    horizon: float | None = None


@dataclass(frozen=True)
class Choice:
    """Something modelled otherwise than the scene does.

    Attributes
    ----------
    title, kind, scene
        ``rod as link``, what it is, and the scene that was run.
    setting
        How; None where none was possible.
    point
        The loosest run whose error is that of the model and not of the integration.
    reason
        Why there is none.
    """

    title: str
    kind: str
    scene: str
    setting: Setting | None = None
    point: Point | None = None
    reason: str = ""


@dataclass(frozen=True)
class WorkPrecision:
    """What the accuracy of a scene's motion costs.

    Attributes
    ----------
    t_start, t_end, instants
        The run, s, and at how many instants it is compared.
    quantities
        What is compared, and in which scales.
    energy
        What the energy is held against: "start" where nothing takes or gives any, "reference"
        where something does, "" where the scene has none.
    limit, steps
        Time that passes, s, and steps that a run may take.
    build
        Stage → seconds of building the scene anew: apart from all runs, once.
    environment
        Machine and versions.
    model_sha256, artefact
        Of the model's file, where it has one, and of the generated module.
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
        """Everything, as JSON knows it: what is no finite number is null."""
        from runtime.studies.work_precision.interpretation import sentences

        facts: dict[str, Any] = plain(_named(asdict(self)))
        return {**facts, "sentences": list(sentences(self, whole=True))}


def _named(facts: dict[str, Any]) -> dict[str, Any]:
    """Named tuples as mappings: `asdict` leaves them as they are."""
    facts["quantities"] = [scale._asdict() for scale in facts["quantities"]]
    for entry in (*facts["lines"], *facts["choices"]):
        if entry["setting"] is not None:
            entry["setting"] = entry["setting"]._asdict()
    return facts
