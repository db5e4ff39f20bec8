"""Dormand and Prince's 8(5,3), written out for one equation of few scalar states.

What a user could write who knows the equation in its fewest coordinates, the method, and how numba
likes its code: every stage is one line of scalars, the equation is compiled into it, nothing is
sampled, stored or looked for. The stepsize control is that of Hairer's program. It is the least
time that the method can take, and what the runtime is measured against.
"""

import linecache
import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numba

from codegen.tableaus.dop853 import TABLEAU as METHOD

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract"}}


def products(row: Sequence[Fraction], state: str) -> str:
    """A linear combination of the stages of a state."""
    terms = (f"{float(a)!r} * {state}_{k}" for k, a in enumerate(row, 1) if a)
    return " + ".join(terms)


def written_out(states: Sequence[str], parameters: Sequence[str]) -> str:
    """The text of the integrator of dy/dt = slope(*y, *parameters)."""

    def called(stage: int, at: Sequence[str]) -> str:
        slopes = ", ".join(f"{state}_{stage}" for state in states)
        return f"{slopes}{',' if len(states) == 1 else ''} = slope({', '.join([*at, *parameters])})"

    lines = [
        f"def run({', '.join(states)}, t, t_end, h, tolerance, {', '.join(parameters)}):",
        "    steps = rejected = 0",
        "    before, failed = 1e-4, False",
        f"    {called(1, states)}",
        "    while t < t_end:",
        "        if t + 1.01 * h >= t_end:",
        "            h = t_end - t",
    ]
    for number, stage in enumerate(METHOD.stages, 2):
        lines += [f"        z_{s} = {s} + h * ({products(stage.a, s)})" for s in states]
        lines.append(f"        {called(number, [f'z_{s}' for s in states])}")
    lines.append("        large = small = 0.0")
    for s in states:
        lines += [
            f"        rate = {products(METHOD.b, s)}",
            f"        next_{s} = {s} + h * rate",
            f"        size = tolerance * (1.0 + max(abs({s}), abs(next_{s})))",
            f"        large += (({products(METHOD.error, s)}) / size) ** 2",
            f"        small += ((rate - ({products(METHOD.lower, s)})) / size) ** 2",
        ]
    lines += [
        "        error = 0.0",
        "        if large + small > 0.0:",
        f"            error = h * large / math.sqrt((large + 0.01 * small) * {len(states)})",
        "        if error > 1.0:",
        f"            h *= max({METHOD.shrink!r}, {METHOD.safety!r} / error**0.125)",
        "            failed = True",
        "            rejected += 1",
        "            continue",
        "        t += h",
        *(f"        {s} = next_{s}" for s in states),
        f"        {called(1, states)}",
        f"        ratio = {METHOD.grow!r}",
        "        if error > 0.0:",
        (
            f"            ratio = {METHOD.safety!r} * before**{METHOD.beta!r}"
            f" / error**{0.125 - 0.75 * METHOD.beta!r}"
        ),
        f"        ratio = max({METHOD.shrink!r}, min({METHOD.grow!r}, ratio))",
        "        h *= min(ratio, 1.0) if failed else ratio",
        "        before, failed = max(error, 1e-4), False",
        "        steps += 1",
        f"    return {', '.join(states)}, steps, rejected",
    ]
    return "\n".join(lines) + "\n"


def integrator(slope: Any, states: Sequence[str], parameters: Sequence[str]) -> Callable[..., Any]:
    """The compiled integrator of an equation.

    Parameters
    ----------
    slope
        A numba function of the states and parameters that answers a tuple of derivatives.

    Returns
    -------
    run(*states, t, t_end, first step, tolerance, *parameters) → (*states, steps, rejected).
    """
    text = written_out(states, parameters)
    name = f"<floor of {slope.__name__}>"
    linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)
    space: dict[str, Any] = {"slope": slope, "math": math}
    exec(compile(text, name, "exec"), space)
    made: Callable[..., Any] = numba.njit(**OPTIONS)(space["run"])
    return made
