"""Accuracy target: simulations with a prescribed global error in place of tolerances."""

from collections.abc import Callable, Sequence
from functools import partial

from codegen.errors import InputError
from runtime.integrate.problem import Formulation
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.results.result import Result

FINEST = 1e-12  # accuracy: tightest target; rounding shows below it
COARSEST = 0.1  # accuracy: loosest target


def prepare_search(
    mechanism: Mechanism, accuracy: float | None, quantities: Sequence[str] | None,
    rtol: float | None, atol: float | None, method: str | None, formulation: Formulation | None,
) -> Callable[..., Result]:  # fmt: skip
    """The simulation with these settings, to be called with times; InputError if they conflict."""
    problems = []
    if accuracy is None:
        problems.append("quantities without accuracy: give the error too, accuracy=1e-6.")
    else:
        if not FINEST <= accuracy <= COARSEST:
            problems.append(
                f"accuracy = {accuracy:g} must lie between {FINEST:g}, below which rounding shows, "
                f"and {COARSEST:g}."
            )
        problems += [
            f"accuracy = {accuracy:g} and {name} = {value:g} are both given; an accuracy chooses "
            "the tolerances. Leave one of them out."
            for name, value in (("rtol", rtol), ("atol", atol))
            if value is not None
        ]
    problems = [f"{mechanism.title}: {text}" for text in problems]
    problems += _series_problems(mechanism.description, quantities or ())
    if accuracy is None or problems:
        raise InputError(problems)
    from runtime.accuracy_target.search import simulate_to

    return partial(
        simulate_to, mechanism, accuracy=accuracy, quantities=quantities, method=method,
        formulation=formulation,
    )  # fmt: skip


def _series_problems(description: Description, names: Sequence[str]) -> list[str]:
    """Why a result has no series of these names.

    Of joints that come and go a result says it, since a scene that follows has series of its own.
    """
    problems = list[str]()
    for name in names if not any(row.reconnects for row in description.watched) else ():
        try:
            description.series.find(name)
        except InputError as error:
            problems += error.problems
    return problems
