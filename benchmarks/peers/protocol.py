"""The protocol of a peer's process: JSON, a line per point."""

import json
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict
from functools import partial
from importlib.metadata import version
from typing import Any

from benchmarks.precision import Point, least
from benchmarks.problems import PROBLEMS, Problem

TOLERANCES = tuple(10.0 ** (-k / 2) for k in range(6, 27))
"""10⁻³ … 10⁻¹³, two a decade."""
TIGHT = TOLERANCES[4:]
"""From 10⁻⁵ on; looser tolerances show nothing and cost minutes."""
LONGEST = 6_000.0
"""Milliseconds of a run, after which no tighter setting is tried."""
Solver = Callable[[Problem], None]


def write(**entries: Any) -> None:
    """One line."""
    print(json.dumps(entries), flush=True)


def point(
    problem: Problem,
    contestant: str,
    method: str,
    setting: float,
    run: Callable[[], Any],
    evaluations: Callable[[Any], int] = lambda answer: 0,
    angles: Callable[[Any], Iterable[float]] = lambda answer: answer,
) -> Point:
    """Run and time one setting, and write its point."""
    try:
        milliseconds, answer = least(run)
        error = problem.error(list(map(float, angles(answer))))
        found = Point(contestant, method, setting, error, milliseconds, evaluations(answer))
    except (ArithmeticError, RuntimeError, ValueError) as reason:
        note = f"{type(reason).__name__}: {str(reason).splitlines()[0] if str(reason) else ''}"
        found = Point(contestant, method, setting, float("inf"), 0.0, 0, note[:120])
    write(point=asdict(found))
    return found


def sweep(
    problem: Problem,
    contestant: str,
    method: str,
    settings: Iterable[float],
    run: Callable[[float], Any],
    evaluations: Callable[[Any], int] = lambda answer: 0,
    angles: Callable[[Any], Iterable[float]] = lambda answer: answer,
) -> None:
    """All settings of a method, the loosest first, until a run takes too long."""
    for setting in settings:
        found = point(
            problem, contestant, method, setting, partial(run, setting), evaluations, angles
        )
        if found.milliseconds > LONGEST:
            return


def main(packages: Iterable[str], solvers: Mapping[str, Solver]) -> None:
    """The process of a peer: which problems it has, or one of them."""
    problems = sys.argv[1:]
    if not problems:
        write(problems=sorted(solvers))
        return
    write(versions={name: version(name) for name in packages})
    for name in problems:
        solvers[name](PROBLEMS[name])
