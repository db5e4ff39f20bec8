"""Which method and coordinates a simulation takes that is asked for an accuracy.

Reduced coordinates are two to four times as fast, and the derivatives of implicit methods come with
them; both stand in modules of their own, whose first build takes seconds. So they are taken where
they are built, and else done without.
"""

from dataclasses import dataclass, replace

from codegen.errors import InputError
from runtime.core.outcomes import Outcome
from runtime.dynamics.formulations import Coordinates
from runtime.dynamics.prepared_simulation import PreparedSimulation
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
        Which of the two the program may change: "method", "formulation".
    reasons
        Why they are what they are, in clauses.
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
        Those that the user fixed; None: the program may choose.
    """
    mechanism = ready.mechanism
    free = {"method": method is None, "formulation": formulation is None}
    may = frozenset(name for name, is_free in free.items() if is_free)
    if formulation is None and mechanism.has_companion("reduced"):
        chosen = method or "auto"
        try:
            taken = ready.coordinates("reduced", chosen, correction)
        except InputError as error:
            why = f"reduced coordinates are refused ({error.problems[0]})"
        else:
            return Choice(chosen, "reduced", taken, may, ())
    elif formulation is None:
        why = "reduced coordinates are not built (python -m codegen build --reduced)"
    else:
        why = ""
    chosen = method or _method(mechanism, formulation or "cartesian", ready)
    taken = ready.coordinates(formulation or "cartesian", chosen, correction)
    return Choice(chosen, formulation or "cartesian", taken, may, (why,) if why else ())


def after(
    choice: Choice, ready: PreparedSimulation, run: Trajectory, correction: Correction
) -> Choice:
    """What the next run takes, once a run has shown what the motion is like."""
    if choice.formulation == "reduced" and run.outcome is not Outcome.OK:
        if "formulation" not in choice.free:
            return choice
        free = "method" in choice.free
        method = _method(ready.mechanism, "cartesian", ready) if free else choice.method
        taken = ready.coordinates("cartesian", method, correction)
        why = f"in reduced coordinates the run ends at t = {run.final_t:.6g} s ({run.outcome.name})"
        return replace(choice, method=method, formulation="cartesian", taken=taken, reasons=(why,))
    if choice.method == "auto" and "method" in choice.free and len(run.methods) == 1:
        return replace(choice, method="dop853")
    return choice


def _method(mechanism: Mechanism, formulation: Formulation, ready: PreparedSimulation) -> str:
    """The one that finds stiffness, where it has its derivatives; else the explicit one."""
    if formulation == "reduced":
        return "auto"
    return "auto" if mechanism.has_companion("tangents") and not ready.begin.redundant else "dop853"
