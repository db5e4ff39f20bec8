"""The method and coordinates of a simulation with an accuracy target.

Reduced coordinates are two to four times as fast, and contain the derivatives that implicit methods
take; both are companion modules, whose first build takes seconds. They are taken only if they are
built already.
"""

from dataclasses import dataclass, replace

from codegen.errors import InputError
from runtime.core.outcomes import Outcome
from runtime.dynamics.formulations import Coordinates, formulate
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.integrate.method import LEADING
from runtime.integrate.problem import Correction, Formulation
from runtime.integrate.trajectory import Trajectory
from runtime.mechanism.mechanism import Mechanism


@dataclass(frozen=True)
class Choice:
    """Method and coordinates of the next run.

    Attributes
    ----------
    taken
        The coordinates.
    free
        Those of the two that the user left open: "method", "formulation".
    reasons
        For the choice, in clauses.
    """

    method: str
    formulation: Formulation
    taken: Coordinates
    free: frozenset[str]
    reasons: tuple[str, ...]


def choose(
    ready: PreparedSimulation,
    method: str | None,
    formulation: Formulation | None,
    correction: Correction,
) -> Choice:
    """Method and coordinates of the first run.

    Parameters
    ----------
    method, formulation
        Fixed by the user; None: chosen here.
    """
    mechanism = ready.mechanism
    given = {"method": method, "formulation": formulation}
    free = frozenset(name for name, value in given.items() if value is None)
    if formulation is None and mechanism.has_companion("reduced"):
        chosen = method or "auto"
        try:
            taken = formulate(ready, "reduced", chosen, correction)
        except InputError as error:
            why = f"reduced coordinates are refused ({error.problems[0]})"
        else:
            return Choice(chosen, "reduced", taken, free, ())
    elif formulation is None:
        why = "reduced coordinates are not built (python -m codegen build --reduced)"
    else:
        why = ""
    chosen = method or _method(mechanism, formulation or "cartesian", ready)
    taken = formulate(ready, formulation or "cartesian", chosen, correction)
    return Choice(chosen, formulation or "cartesian", taken, free, (why,) if why else ())


def revise(
    choice: Choice, ready: PreparedSimulation, run: Trajectory, correction: Correction
) -> Choice:
    """The choice for the next run, given the first."""
    if choice.formulation == "reduced" and run.outcome is not Outcome.OK:
        if "formulation" not in choice.free:
            return choice
        method = choice.method
        if "method" in choice.free:
            method = _method(ready.mechanism, "cartesian", ready)
        taken = formulate(ready, "cartesian", method, correction)
        why = f"in reduced coordinates the run ends at t = {run.final_t:.6g} s ({run.outcome.name})"
        return replace(choice, method=method, formulation="cartesian", taken=taken, reasons=(why,))
    if choice.method == "auto" and "method" in choice.free and len(run.methods) == 1:
        return replace(choice, method=LEADING)
    return choice


def _method(mechanism: Mechanism, formulation: Formulation, ready: PreparedSimulation) -> str:
    """The method that detects stiffness, where its derivatives exist; else the explicit one."""
    if formulation == "reduced":
        return "auto"
    return "auto" if mechanism.has_companion("tangents") and not ready.begin.redundant else LEADING
