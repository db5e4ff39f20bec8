"""A chain of uniform bars in the angles of its bars: a dense matrix, its LDLᵀ written out.

Angles θ_i from the level, counted from the hinge on the ground. With a_i = n - i - 1/2 (what hangs
on the far end of bar i, and half of it), bars of 1 m and 1 kg have

    M_ij = a_max(i,j) cos(θ_i - θ_j),  M_ii = n - i - 2/3,
    Σ_j M_ij θ̈_j = -g a_i cos θ_i - Σ_j a_max(i,j) sin(θ_i - θ_j) ω_j².

Every entry is a scalar, every loop is unrolled, and the outermost bar is eliminated first.
"""

import linecache
import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numba

from benchmarks.floor.dop853 import OPTIONS, integrator

DURATION = 2.0
GRAVITY = 9.81


def written_out(links: int) -> str:
    """The text of (θ, ω, gravity) → (ω, ω̇)."""
    every = range(links)
    angles, speeds = [f"q{i}" for i in every], [f"w{i}" for i in every]
    lines = [f"def slope({', '.join([*angles, *speeds])}, gravity):"]
    for i in every:
        lines += [
            f"    s{i}, c{i} = math.sin(q{i}), math.cos(q{i})",
            f"    o{i} = w{i} * w{i}",
            f"    b{i} = gravity * {i + 0.5 - links} * c{i}",
            f"    m{i}_{i} = {links - i - 2 / 3!r}",
        ]
        for j in range(i):
            arm = links - i - 0.5
            lines += [
                f"    m{i}_{j} = {arm} * (c{i} * c{j} + s{i} * s{j})",
                f"    d = {arm} * (s{i} * c{j} - c{i} * s{j})",
                f"    b{i} -= d * o{j}",
                f"    b{j} += d * o{i}",
            ]
    for k in reversed(every):
        lines.append(f"    e{k} = 1.0 / m{k}_{k}")
        for i in range(k):
            lines += [f"    l{k}_{i} = m{k}_{i} * e{k}", f"    b{i} -= l{k}_{i} * b{k}"]
            lines += [f"    m{i}_{j} -= l{k}_{i} * m{k}_{j}" for j in range(i + 1)]
    for k in every:
        known = "".join(f" - l{k}_{i} * x{i}" for i in range(k))
        lines.append(f"    x{k} = b{k} * e{k}{known}")
    lines.append(f"    return {', '.join(speeds)}, {', '.join(f'x{i}' for i in every)}")
    return "\n".join(lines) + "\n"


@cache
def equation(links: int) -> Callable[..., Any]:
    """The equation, compiled."""
    text, name = written_out(links), f"<floor of a chain of {links}>"
    linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)
    space: dict[str, Any] = {"math": math}
    exec(compile(text, name, "exec"), space)
    made: Callable[..., Any] = numba.njit(**OPTIONS)(space["slope"])
    return made


@cache
def runner(links: int) -> Callable[..., Any]:
    """The compiled integrator of the chain."""
    states = [f"{letter}{i}" for letter in "qw" for i in range(links)]
    return integrator(equation(links), states, ("gravity",))


def answer(links: int, tolerance: float) -> tuple[tuple[float, ...], int, int]:
    """The angles after two seconds from rest, all bars level; accepted and rejected steps."""
    start = (0.0,) * (2 * links)
    *states, steps, rejected = runner(links)(*start, 0.0, DURATION, 1e-3, tolerance, GRAVITY)
    return tuple(states[:links]), steps, rejected
