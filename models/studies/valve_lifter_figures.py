"""Figures 8.5.1 and 8.5.2 of the book, and what happens where the force is negative."""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from models.studies.valve_lifter import NOMINAL, SPEEDS, STIFFNESSES, Study, parts_at, study

COLOURS = ("#d1495b", "#00798c", "#30638e")
UNDER = "#d1495b"


def figures() -> Iterator[tuple[str, Figure]]:
    """(number in the book, picture)."""
    runs = study()
    yield "8_5_1", _force(runs, "8.5.1 Pushrod reaction force, 3000 rpm", "k = {0:g} N/cm",
                          [(k, NOMINAL[1]) for k in STIFFNESSES])  # fmt: skip
    yield "8_5_2", _force(runs, "8.5.2 Pushrod reaction force, k = 25 N/cm", "{1:g} rpm",
                          [(NOMINAL[0], rpm) for rpm in SPEEDS])  # fmt: skip
    yield "8_5_free", _free(runs)


def _force(runs: Study, title: str, label: str, cases: list[tuple[float, float]]) -> Figure:
    """The force between cam and pushrod over the cam's turns; where negative, it is shaded."""
    figure = Figure(figsize=(7.5, 3.8), layout="constrained")
    axes = figure.subplots()
    for case, colour in zip(cases, COLOURS, strict=True):
        run = runs.driven[case]
        force = run.reaction("lift", "fy")
        axes.plot(1e3 * run.t, force, color=colour, label=label.format(*case))
        axes.fill_between(1e3 * run.t, force, 0.0, where=force < 0.0, color=UNDER, alpha=0.25)
    axes.axhline(0.0, color="black", linewidth=0.8)
    longest = max(runs.driven[case].t[-1] for case in cases)
    axes.set(title=title, xlabel="t, ms", ylabel="force on the pushrod, N",
             xlim=(0, 1e3 * longest))  # fmt: skip
    axes.legend(ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.18))
    return figure


def _free(runs: Study) -> Figure:
    """Lift of cam and pushrod, 10 N/cm at 3000 rpm, the follower free to leave."""
    case = (STIFFNESSES[0], NOMINAL[1])
    held, free = runs.driven[case], runs.free[case]
    figure = Figure(figsize=(7.5, 5.2), layout="constrained")
    lift, apart = figure.subplots(2, 1, sharex=True)
    floor = held.q("pushrod.y")[0]
    for run, look in ((held, {"color": "#30638e", "linestyle": "--", "label": "held on the cam"}),
                      (free, {"color": UNDER, "label": "free to leave it"})):  # fmt: skip
        lift.plot(1e3 * run.t, 1e3 * (run.q("pushrod.y") - floor), **look)
    gap = 1e3 * (free.q("pushrod.y") - np.interp(free.t, held.t, held.q("pushrod.y")))
    apart.plot(1e3 * free.t, np.maximum(gap, 0.0), color=UNDER)
    apart.axvline(1e3 * parts_at(free), color="black", linewidth=0.8, linestyle=":")
    lift.set(title="Separation after the negative force: k = 10 N/cm, 3000 rpm",
             ylabel="lift of the pushrod, mm")  # fmt: skip
    lift.legend(loc="upper left")
    apart.set(xlabel="t, ms", ylabel="gap between cam and face, mm", xlim=(0, 1e3 * free.t[-1]))
    return figure
