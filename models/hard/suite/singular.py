"""Singular positions that are passed or barely missed, and constraints that repeat each other."""

from functools import cache, partial

import numpy as np

from models.hard.n_four_bar import n_four_bar
from models.hard.suite.case import Case, Reference, conservative, coordinates, table
from models.hard.suite.linkages import (
    crank_angle,
    crank_growth,
    equal_rods_angle,
    table_angle,
    table_growth,
)

ALONG = np.linspace(0.0, 20.0, 81)
SWINGING = np.linspace(0.0, 10.0, 41)
SPINNING = np.linspace(0.0, 20.0, 41)
LENGTHS = {"even": 0.0, "longer": 1e-3, "shorter": -1e-3}
# Where a method of order 8 has to cross while the second loop bends 5 ms away, rounding leaves 4e-9
# of the energy; what remains is about this.
BENT = {"longer": 1e-6, "shorter": 1e-12}
LOOPS = (1, 2, 5, 10, 40)
LONG = 10  # from so many loops on, its code takes longer than a test may


@cache
def _row(loops: int) -> Reference:
    values = crank_angle(loops, ALONG)[:, None]
    growth = crank_growth(loops, ALONG)[:, None]
    return Reference(np.hstack([values, values]), ALONG, growth, 300, 1e-12)


def _n_four_bar(loops: int) -> Case:
    declare = None if loops == 2 else partial(n_four_bar, loops)
    return Case(
        name=f"n_four_bar_{loops}",
        hard=(
            f"{2 * loops + 1} bars in a row of four-bars: about twenty times in 20 s all lie in "
            f"a line, and {loops} constraints cease to be independent."
        ),
        see="The cranks stay parallel; one step crosses each position, and no step collapses.",
        model="hard/n_four_bar",
        scene="fall",
        t_end=20.0,
        quantity="φ of the first crank and the last, rad",
        measure=coordinates("crank_0.phi", f"crank_{loops}.phi"),
        reference=partial(_row, loops),
        origin=(
            "closed form by the elliptic amplitude in 25 digits, which agrees with the benchmark's "
            "to 1e-14; growth by starts with other speeds"
        ),
        work=conservative,
        declare=declare,
        long=loops >= LONG,
    )


@cache
def _five(kind: str) -> Reference:
    if kind == "even":
        times = SWINGING
        values = np.repeat(crank_angle(2, times)[:, None], 3, axis=1)
        return Reference(values, times, crank_growth(2, times)[:, None], 200, 1e-12)
    rows = table(f"five_bar_{kind}.csv")
    # The column is for the speed at the top, 1 rad/s; the tolerance for 7 rad/s at the bottom
    # changes the energy by 49 times as much.
    growth = 1.0 + 49.0 * np.maximum.accumulate(rows[:, 4:5])
    return Reference(rows[:, 1:4], rows[:, 0], growth, 1000, BENT[kind])


def _five_bar(kind: str) -> Case:
    difficulty = {
        "even": "Two parallelograms side by side, both singular at once.",
        "longer": (
            "The same with the last crank 1 mm too long: one loop passes its level position while "
            "the other misses it and bends, within 5 ms of each other."
        ),
        "shorter": (
            "The same with the last crank 1 mm too short: the second loop misses its level "
            "position by √ε, and goes on as a contra-parallelogram."
        ),
    }
    return Case(
        name=f"five_bar_{kind}",
        hard=difficulty[kind],
        see="The run crosses positions that it meets, and follows the bends of near misses.",
        model="hard/five_bar",
        scene="fall",
        t_end=10.0,
        quantity="φ of all three cranks, rad",
        measure=coordinates(*(f"crank_{k}.phi" for k in range(3))),
        reference=partial(_five, kind),
        origin=(
            "closed form by the elliptic amplitude"
            if kind == "even"
            else "angles with multipliers in 34 digits by extrapolation, a looser run agrees to "
            "1e-18; growth by another start 1e-12 rad/s faster"
        ),
        work=conservative,
        parameters={"excess": LENGTHS[kind]},
    )


@cache
def _equal_rods() -> Reference:
    # Nothing acts, so that a relative error of the speed, whose largest value is 4.7 rad/s, is one
    # of the angle that has been turned.
    growth = 1.0 + 2 * 4.7 * SPINNING[:, None]
    return Reference(equal_rods_angle(SPINNING)[:, None], SPINNING, growth, 450, 1e-12)


@cache
def _table() -> Reference:
    values = np.repeat(table_angle(4, SWINGING)[:, None], 4, axis=1)
    return Reference(values, SWINGING, table_growth(4, SWINGING)[:, None], 160, 1e-12)


CASES = (
    *(_n_four_bar(loops) for loops in LOOPS),
    *(_five_bar(kind) for kind in LENGTHS),
    Case(
        name="equal_rods",
        hard="A slider-crank with equal rods: the slider may pass through the crank's bearing.",
        see="It passes each time; otherwise it would have to stop.",
        model="hard/equal_rods",
        scene="spin",
        t_end=20.0,
        quantity="φ of the crank, rad",
        measure=coordinates("crank.phi"),
        reference=_equal_rods,
        origin="quadrature of the energy integral over the crank's angle in 25 digits",
        work=conservative,
    ),
    Case(
        name="parallel_linkage",
        hard=(
            "A table on four parallel cranks, two more than it needs: two constraints are "
            "redundant in every position, and three more are lost where the cranks are level."
        ),
        see="It moves as a pendulum, by every method.",
        model="hard/parallel_linkage",
        scene="fall",
        t_end=10.0,
        quantity="φ of all four cranks, rad",
        measure=coordinates(*(f"crank_{k}.phi" for k in range(4))),
        reference=_table,
        origin="closed form by elliptic functions in 25 digits; growth by other starts",
        work=conservative,
    ),
)
