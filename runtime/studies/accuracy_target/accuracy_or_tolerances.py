"""Whether a simulation is asked for an accuracy or for tolerances: one of the two."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, cast

from codegen.errors import InputError
from runtime.integrate.problem import Formulation
from runtime.mechanism.mechanism import Mechanism
from runtime.results.result import Result

FINEST, COARSEST = 1e-12, 0.1
"""Accuracies that can be asked for."""


def accuracy_or_tolerances(
    mechanism: Mechanism,
    accuracy: float | None,
    quantities: Sequence[str] | None,
    rtol: float | None,
    atol: float | None,
    method: str | None,
    formulation: Formulation | None,
) -> Callable[..., Result]:
    """The simulation that is meant, still to be told of its times and options.

    Raises
    ------
    InputError
        If both are asked for, or an accuracy that is none.
    """
    if accuracy is None and quantities is None:
        from runtime.dynamics.simulation import simulate

        chosen = {"rtol": rtol, "atol": atol, "method": method, "formulation": formulation}
        fixed: dict[str, Any] = {name: x for name, x in chosen.items() if x is not None}
        return partial(simulate, mechanism, **fixed)
    problems = []
    if accuracy is None:
        problems.append("quantities say whose error is meant; give the error too, accuracy=1e-6.")
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
