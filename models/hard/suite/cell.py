"""One cell: a case run with one method, one correction and one tolerance, and its verdict."""

import time
from contextlib import suppress
from dataclasses import asdict, dataclass
from enum import StrEnum
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from codegen.errors import AnalysisError
from models.hard.suite.case import KEPT, WORTH, Array, Case
from runtime import Outcome, Result
from runtime.integrate.method import IMPLICIT, METHODS, REGISTER
from runtime.integrate.problem import CORRECTIONS

if TYPE_CHECKING:
    from runtime import Machine

_ENOUGH = 1000  # steps that a first run may take: Baumgarte's time is a thousandth of its own
RESIDUAL = 1e-10
"""The largest |Φ| that a run may show at any output, m or rad, where it returns to Φ = 0."""

DRIFTING = ("baumgarte", "hybrid")
"""Corrections that let |Φ| grow to the size of the tolerance, and do not claim more."""


class Setting(NamedTuple):
    """Method and correction of a run."""

    method: str
    correction: str


COMPARED = "dop853"
"""The method with which corrections are compared."""

SETTINGS = (
    *(Setting(method, CORRECTIONS[0]) for method in METHODS),
    *(Setting(COMPARED, correction) for correction in CORRECTIONS[1:]),
)
"""Every method with the usual correction, and one of them with the others."""


REFUSED = "REFUSED"
"""The outcome of a run that an error refused before its first step, with a reason."""


class Verdict(StrEnum):
    """The verdict on a cell."""

    CORRECT = "correct"
    BEYOND = "beyond the horizon"
    EXPECTED = "named outcome as expected"
    STOPPED = "stopped, by name"
    HANGS = "HANGS"
    WRONG = "WRONG"


@dataclass(frozen=True)
class Cell:
    """The record of a run.

    Attributes
    ----------
    error, bound
        The largest error and its bound, at the row where their ratio is largest.
    until
        Last instant that was compared, s; NaN where the bound is too large for a comparison.
    residual
        Largest |Φ|, m or rad.
    drift
        Largest departure from the balance of energy, over the largest kinetic energy; NaN where
        the work is not known.
    cpu
        Processor time of the integration and its outputs, s, without the compiling and loading of
        a first run.
    outcome, message
        Of the run; `reached` is its last instant, s.
    note
        Reason for a verdict other than "correct".
    """

    case: str
    method: str
    correction: str
    rtol: float
    verdict: Verdict
    error: float
    bound: float
    until: float
    residual: float
    drift: float
    steps: int
    rejected: int
    repartitions: int
    events: int
    cpu: float
    outcome: str
    reached: float
    message: str
    note: str

    @classmethod
    def hanging(cls, case: str, setting: Setting, rtol: float, seconds: float) -> "Cell":
        """The record of a run that was ended after so many seconds."""
        return cls._without(case, setting, rtol, Verdict.HANGS, f"no answer after {seconds:g} s")

    @classmethod
    def refusing(cls, case: Case, setting: Setting, rtol: float, why: str) -> "Cell":
        """The record of a run that an error refused, with its reason."""
        expected = REFUSED in case.ends
        verdict = Verdict.EXPECTED if expected else Verdict.STOPPED
        note = "" if expected else why
        return cls._without(case.name, setting, rtol, verdict, note, REFUSED, why)

    @classmethod
    def _without(
        cls,
        case: str,
        setting: Setting,
        rtol: float,
        verdict: Verdict,
        note: str,
        outcome: str = "",
        message: str = "",
    ) -> "Cell":
        """A cell without numbers."""
        nothing = dict.fromkeys(("error", "bound", "until", "residual", "drift"), np.nan)
        counts = dict.fromkeys(("steps", "rejected", "repartitions", "events"), 0)
        return cls(
            case=case,
            method=setting.method,
            correction=setting.correction,
            rtol=rtol,
            verdict=verdict,
            **nothing,
            **counts,
            cpu=np.nan,
            outcome=outcome,
            reached=np.nan,
            message=message,
            note=note,
        )

    def record(self) -> dict[str, Any]:
        """As plain values; what is not a number is None."""
        return {
            name: None if isinstance(value, float) and not np.isfinite(value) else value
            for name, value in asdict(self).items()
        }


def suits(case: Case, setting: Setting) -> bool:
    """Whether a case is run in a setting: very long code is not compiled with derivatives."""
    return not (case.long and setting.method in IMPLICIT)


def run(case: Case, setting: Setting, rtol: float) -> Cell:
    """Run a case once, from an assembled start, and evaluate it."""
    prepare(case, setting)
    loaded = case.machine()
    start = loaded.assemble(start=dict(case.start), parameters=dict(case.parameters))
    began = time.process_time()
    try:
        result = loaded.simulate(
            case.t_end,
            case.instants(),
            method=setting.method,
            correction=setting.correction,
            rtol=rtol,
            parameters=dict(case.parameters),
            start=start,
            progress=False,
            **case.options,
        )
    except AnalysisError as error:
        return Cell.refusing(case, setting, rtol, str(error))
    return evaluate(case, setting, rtol, result, time.process_time() - began)


def prepare(case: Case, setting: Setting) -> None:
    """Build, load and compile whatever a first run of the case does, and ask for its reference."""
    case.reference()
    _first_run(case.machine(), setting)


@cache
def _first_run(loaded: "Machine", setting: Setting) -> None:
    with suppress(AnalysisError):  # the run itself reports it
        loaded.simulate(
            1e-9,
            method=setting.method,
            correction=setting.correction,
            progress=False,
            max_steps=_ENOUGH,
        )


def evaluate(case: Case, setting: Setting, rtol: float, result: Result, cpu: float) -> Cell:
    """Compare a run with the reference, its constraints and its energy."""
    error, bound, until, note = _compared(case, setting, rtol, result)
    residual = float(result.samples.residual[:, 0].max(initial=0.0))
    outcome = result.outcome
    largest = RESIDUAL + (KEPT * rtol if setting.correction in DRIFTING else 0.0)
    if note == "" and not residual <= largest:
        note = f"|Φ| reaches {residual:.1e}, more than {largest:.0e}"
    if note != "":
        verdict = Verdict.WRONG
    elif outcome.name not in case.ends:
        verdict, note = Verdict.STOPPED, result.message
    elif outcome is not Outcome.OK:
        verdict = Verdict.EXPECTED
    else:
        verdict = Verdict.CORRECT if np.isfinite(until) else Verdict.BEYOND
    return Cell(
        case=case.name,
        method=setting.method,
        correction=setting.correction,
        rtol=rtol,
        verdict=verdict,
        error=error,
        bound=bound,
        until=until,
        residual=residual,
        drift=_drift(case, result),
        steps=int(result.stats["steps"]),
        rejected=int(result.stats["rejected"]),
        repartitions=int(result.stats["repartitions"]),
        events=int(result.stats["events"]),
        cpu=cpu,
        outcome=outcome.name,
        reached=float(result.t[-1]),
        message=result.message,
        note=note,
    )


def _compared(
    case: Case, setting: Setting, rtol: float, result: Result
) -> tuple[float, float, float, str]:
    """Error, bound, last instant compared, and the failure, if any."""
    reference = case.reference()
    measured = case.measure(result)
    expected, times = reference.values, reference.times
    ended = result.outcome.name in case.ends
    if ended and len(measured) != len(expected):
        return (
            np.inf,
            np.nan,
            np.nan,
            f"{len(measured)} numbers where there should be {len(expected)}",
        )
    # A run that stopped has as many rows as it has reached instants of the reference.
    rows = min(len(measured), int(np.sum(times <= result.t[-1])) if not ended else len(expected))
    bounds = reference.bound(rtol, REGISTER[setting.method].order)[:rows]
    errors = np.abs(measured[:rows] - expected[:rows])
    if not np.isfinite(errors).all():
        return np.inf, np.nan, np.nan, "a number is not finite"
    near = bounds <= WORTH
    if rows == 0 or not near.any():
        return np.nan, np.nan, np.nan, ""
    ratio = np.where(near, errors / bounds, -1.0)
    at = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    error, bound = float(errors[at]), float(bounds[at])
    last = float(times[:rows][near.reshape(rows, -1).any(axis=1)][-1])
    if ratio[at] <= 1.0:
        return error, bound, last, ""
    return (
        error,
        bound,
        last,
        (f"off by {error:.1e} at t = {times[at[0]]:.6g} s, where {bound:.1e} is allowed"),
    )


def _drift(case: Case, result: Result) -> float:
    """Largest |E - E0 - W| over the largest kinetic energy."""
    if case.work is None:
        return np.nan
    energy: Array = result.energy()
    scale = float(np.abs(result.energy("kinetic")).max(initial=0.0))
    off = float(np.abs(energy - energy[0] - case.work(result)).max(initial=0.0))
    return off / scale if scale > 0.0 else off
