"""The method and coordinates of a simulation with an accuracy target.

Reduced coordinates are two to four times as fast, and contain the derivatives that implicit methods
take; both are companion modules, whose first build takes seconds. They are taken only if they are
built already.
"""

from dataclasses import dataclass, replace

from codegen.errors import InputError
from runtime.core.outcomes import Outcome
from runtime.dynamics.integration_coordinates import Coordinates, formulate
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.integrate.method import LEADING
from runtime.integrate.problem import Correction, Formulation
from runtime.integrate.trajectory import Trajectory


@dataclass(frozen=True)
class Choice:
    """Method and coordinates of the next run."""

    method: str
    formulation: Formulation
    coordinates: Coordinates
    free: frozenset[str]  # those of "method" and "formulation" that the user left open
    correction: Correction  # as the user named it; that of the coordinates may differ
    reasons: tuple[str, ...] = ()  # for the choice, in clauses


def choose(
    ready: PreparedSimulation,
    method: str | None,
    formulation: Formulation | None,
    correction: Correction,
) -> Choice:
    """Method and coordinates of the first run; those that are None are chosen here."""
    settings = {"method": method, "formulation": formulation}
    free = frozenset(name for name, value in settings.items() if value is None)
    reasons: tuple[str, ...] = ()
    if formulation is None and ready.mechanism.has_companion("reduced"):
        chosen = method or "auto"
        try:
            coordinates = formulate(ready, "reduced", chosen, correction)
        except InputError as error:
            reasons = (f"reduced coordinates are refused ({error.problems[0]})",)
        else:
            return Choice(chosen, "reduced", coordinates, free, correction)
    elif formulation is None:
        reasons = ("reduced coordinates are not built (python -m codegen build --reduced)",)
    used = formulation or "cartesian"
    chosen = method or _method(ready, used)
    coordinates = formulate(ready, used, chosen, correction)
    return Choice(chosen, used, coordinates, free, correction, reasons)


def revise(choice: Choice, ready: PreparedSimulation, run: Trajectory) -> Choice:
    """The choice for the next run, given the first."""
    if choice.formulation == "reduced" and run.outcome is not Outcome.OK:
        if "formulation" not in choice.free:
            return choice
        method = _method(ready, "cartesian") if "method" in choice.free else choice.method
        coordinates = formulate(ready, "cartesian", method, choice.correction)
        why = f"in reduced coordinates the run ends at t = {run.final_t:.6g} s ({run.outcome.name})"
        return replace(
            choice, method=method, formulation="cartesian", coordinates=coordinates, reasons=(why,)
        )
    if choice.method == "auto" and "method" in choice.free and len(run.methods) == 1:
        return replace(choice, method=LEADING)
    return choice


def _method(ready: PreparedSimulation, formulation: Formulation) -> str:
    """The method that detects stiffness, where its derivatives exist; else the explicit one."""
    stiff = ready.mechanism.has_companion("tangents") and not ready.begin.redundant
    return "auto" if formulation == "reduced" or stiff else LEADING
