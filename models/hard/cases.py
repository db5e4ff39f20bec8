"""The cases, in the order of the page. A group of them is a module of `suite`.

A further group is added to `GROUPS`: a module with a tuple of `Case`.
"""

from models.hard.suite import edges, long_runs, loops, singular, springs, surfaces, switches
from models.hard.suite.case import Case

GROUPS: dict[str, tuple[Case, ...]] = {
    "Long runs": long_runs.CASES,
    "Loops and masses": loops.CASES,
    "Singular and redundant": singular.CASES,
    "Springs": springs.CASES,
    "Switching": switches.CASES,
    "Surfaces": surfaces.CASES,
    "Edges": edges.CASES,
}
"""Heading on the page → its cases."""

CASES: tuple[Case, ...] = tuple(case for group in GROUPS.values() for case in group)


def find(name: str) -> Case:
    """The case of that name."""
    return next(case for case in CASES if case.name == name)
