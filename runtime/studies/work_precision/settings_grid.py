"""The grid of settings and tolerances of a study."""

from collections.abc import Sequence

from codegen.errors import InputError
from runtime.integrate.method import METHODS
from runtime.mechanism.description import unknown
from runtime.studies.work_precision.diagram import Setting

FORMULATIONS = ("cartesian", "reduced")
RTOLS = tuple(10.0 ** -(2.0 + 0.5 * m) for m in range(17))
"""1e-2 to 1e-10, two a decade."""
FURTHER = tuple(10.0 ** -(10.5 + 0.5 * m) for m in range(4))
"""To 1e-12, for settings that do not reach nine digits with the others."""
QUICK = (1e-3, 1e-5, 1e-7, 1e-9)
TIGHTEST = 1e-13  # accuracy: rtol of reference runs; the compared runs stay a digit away
LEAST_RTOL = 1e-12  # accuracy: tightest rtol of a compared run
LEAST_POINTS = 2


def all_settings(methods: Sequence[str], formulations: Sequence[str]) -> tuple[Setting, ...]:
    """Every method in every formulation; other returns onto the constraints with one of them.

    Correction at every stage and projection are compared with "dop853" in all coordinates.
    """
    found = [Setting(method, formulation) for method in methods for formulation in formulations]
    if "dop853" in methods and "cartesian" in formulations:
        found += [Setting("dop853", "cartesian", way) for way in ("stage", "projection")]
    return tuple(found)


def check_sequences(**given: Sequence[object]) -> None:
    """Refuse a text where a sequence of names belongs, whose letters would be taken for names.

    Raises
    ------
    InputError
        With every one, by the name of the argument.
    """
    problems = [
        f"{argument} is {value!r}; it must be a sequence of names, such as ({value!r},)."
        for argument, value in given.items()
        if isinstance(value, str)
    ]
    if problems:
        raise InputError(problems)


def check_grid(
    methods: Sequence[str], formulations: Sequence[str], rtols: Sequence[float], points: int,
    limit: float, steps: int,
) -> None:  # fmt: skip
    """Refuse settings that make no study, all at once.

    Raises
    ------
    InputError
        With every problem.
    """
    problems = [unknown("method", name, METHODS) for name in methods if name not in METHODS]
    problems += [
        unknown("formulation", name, FORMULATIONS)
        for name in formulations
        if name not in FORMULATIONS
    ]
    for what, given in (("method", methods), ("formulation", formulations), ("rtol", rtols)):
        if not given:
            problems.append(f"There is no {what} to try; name one, or leave the argument out.")
    problems += [
        f"rtol is {rtol:g}; it lies from {LEAST_RTOL:g} to 0.1, so that the reference, at "
        f"{TIGHTEST:g}, is better."
        for rtol in rtols
        if not LEAST_RTOL <= rtol <= 0.1
    ]
    if points < LEAST_POINTS:
        problems.append(
            f"points is {points}; runs are compared at {LEAST_POINTS} or more instants."
        )
    if not limit > 0.0:
        problems.append(f"limit is {limit:g}; a run may take a positive time, in s.")
    if steps < 1:
        problems.append(f"steps is {steps}; a run takes at least one step.")
    if problems:
        raise InputError(problems)
