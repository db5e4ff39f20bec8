"""Whether a simulation has an accuracy target or tolerances: one of the two."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, cast

from codegen.errors import InputError
from runtime.integrate.problem import Formulation
from runtime.mechanism.mechanism import Mechanism
from runtime.results.result import Result

FINEST = 1e-12  # accuracy: tightest target; rounding shows below it
COARSEST = 0.1  # accuracy: loosest target


def accuracy_or_tolerances(
    mechanism: Mechanism,
    accuracy: float | None,
    quantities: Sequence[str] | None,
    rtol: float | None,
    atol: float | None,
    method: str | None,
    formulation: Formulation | None,
) -> Callable[..., Result]:
    """The simulation with these settings, to be called with times and options.

    Raises
    ------
    InputError
        If both an accuracy and a tolerance are given, or the accuracy is out of range.
    """
    if accuracy is None and quantities is None:
        from runtime.dynamics.simulation import simulate

        given = {"rtol": rtol, "atol": atol, "method": method, "formulation": formulation}
        settings: dict[str, Any] = {name: x for name, x in given.items() if x is not None}
        return partial(simulate, mechanism, **settings)
    problems = []
    if accuracy is None:
        problems.append("quantities without accuracy: give the error too, accuracy=1e-6.")
    elif not FINEST <= accuracy <= COARSEST:
        problems.append(
            f"accuracy = {accuracy:g} must lie between {FINEST:g}, below which rounding shows, and "
            f"{COARSEST:g}."
        )
    for name, value in (("rtol", rtol), ("atol", atol)):
        if accuracy is not None and value is not None:
            problems.append(
                f"accuracy = {accuracy:g} and {name} = {value:g} are both given; an accuracy "
                f"chooses the tolerances. Leave one of them out."
            )
    if problems:
        raise InputError(f"{mechanism.title}: {text}" for text in problems)
    from runtime.studies.accuracy_target.search import simulate_to

    return partial(
        simulate_to,
        mechanism,
        accuracy=cast(float, accuracy),
        quantities=quantities,
        method=method,
        formulation=formulation,
    )
