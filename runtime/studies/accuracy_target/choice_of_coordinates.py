"""Method and coordinates of the runs of a search, and the tolerance of its second run.

Reduced coordinates are two to four times as fast, and contain the derivatives that implicit methods
take; both are companion modules, whose first build takes seconds. They are taken only if they are
built already.
"""

from dataclasses import dataclass
from typing import NamedTuple

from codegen.errors import InputError
from runtime.core.outcomes import Outcome
from runtime.dynamics.formulations import Coordinates, formulate
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.integrate.method import IMPLICIT, LEADING
from runtime.integrate.problem import Correction, Formulation
from runtime.integrate.trajectory import Trajectory
from runtime.studies.accuracy_target.run_pair import Run

WIDE = 1e-3  # measured: rtol of the second run over that of the first
_STIFF = 0.03  # measured: the same with an implicit method
_CHANGED = 1.5e-3  # measured: the same with an implicit method after an explicit one
_DECAY = 2.0  # measured: -h Re λ in explicit steps from which on an implicit method costs less,
_COARSE = 1e-8  # measured: and its rtol down to which it does
_SHORT = 25  # measured: such steps below which BDF, which begins at order one, is not worth it


class Choice(NamedTuple):
    """Method and coordinates of a run."""

    method: str
    formulation: Formulation
    coordinates: Coordinates
    reasons: tuple[str, ...] = ()  # for the choice, in clauses


@dataclass
class Choices:
    """How each run is chosen, given those before it."""

    ready: PreparedSimulation
    method: str | None  # this and the formulation are chosen where they are None
    formulation: Formulation | None
    correction: Correction  # that of the coordinates may differ
    contradiction: str = ""  # what a check says of a run in reduced coordinates

    def first(self) -> Choice:
        """Method and coordinates of the first run."""
        if self.contradiction:
            found = self.contradiction.rstrip(".")
            return self._choice(
                "cartesian", f"a check contradicts the run in reduced coordinates ({found})"
            )
        if self.formulation is not None:
            return self._choice(self.formulation)
        reason = "reduced coordinates are not built (linkwright build --reduced)"
        if self.ready.mechanism.has_companion("reduced"):
            try:
                return self._choice("reduced")
            except InputError as error:
                reason = f"reduced coordinates are refused ({error.problems[0]})"
        return self._choice("cartesian", reason)

    def revised(self, choice: Choice, first: Run) -> Choice:
        """The choice for the next run, given the first."""
        run = first.path
        if choice.formulation == "reduced" and run.outcome is not Outcome.OK:
            if self.formulation is not None:
                return choice
            end = f"t = {run.final_t:.6g} s ({run.outcome.name})"
            return self._choice("cartesian", f"in reduced coordinates the run ends at {end}")
        if choice.method == "auto" and self.method is None and len(run.methods) == 1:
            if run.decay < _DECAY or first.options.rtol * _CHANGED < _COARSE:
                return choice._replace(method=LEADING)
            # In too few steps for the run to change by itself.
            return choice._replace(method="radau5" if run.statistics.steps < _SHORT else "bdf")
        return choice

    def _choice(self, formulation: Formulation, *reasons: str) -> Choice:
        """With the method that detects stiffness, where its derivatives exist; else explicit."""
        ready = self.ready
        stiff = ready.mechanism.has_companion("tangents") and not ready.begin.redundant
        method = self.method or ("auto" if formulation == "reduced" or stiff else LEADING)
        coordinates = formulate(ready, formulation, method, self.correction)
        return Choice(method, formulation, coordinates, reasons)


def second_ratio(choice: Choice, first: Trajectory) -> float:
    """rtol of the second run, with this choice, over that of the first.

    A first run whose steps stability limits errs by much more than its tolerance suggests.
    """
    if any(method in IMPLICIT for _, method in first.methods):
        return _STIFF
    return _CHANGED if choice.method in IMPLICIT else WIDE
