"""Accuracy target: simulations with a prescribed global error in place of tolerances."""

from collections.abc import Callable, Sequence
from functools import partial

from codegen.errors import InputError
from runtime.integrate.problem import Formulation
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
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
        problems += _unknown_quantities(mechanism.description, quantities or ())
    if accuracy is None or problems:
        raise InputError(f"{mechanism.title}: {text}" for text in problems)
    from runtime.accuracy_target.search import simulate_to

    return partial(
        simulate_to, mechanism, accuracy=accuracy, quantities=quantities, method=method,
        formulation=formulation,
    )  # fmt: skip


def _unknown_quantities(description: Description, names: Sequence[str]) -> list[str]:
    """Names of series that no result has; whether it has works and energies, a result says.

    So it does of joints that come and go, since a scene that follows has series of its own.
    """
    if any(row.reconnects for row in description.watched):
        return []
    from runtime.mechanism.series_table import ENERGIES
    from runtime.studies.series_by_name import own_name, series_names, unknown_series

    known = series_names(description)
    existing = {*ENERGIES, *(name for listed in known.values() for name in listed)}
    return [
        unknown_series(name, known)
        for name in names
        if own_name(description, name) not in existing and not name.startswith("work(")
    ]
