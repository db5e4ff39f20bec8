"""Closed loops: Andrews' mechanism, and couplers of any mass."""

from functools import cache

import numpy as np

from models.hard.suite.case import Case, Reference, conservative, coordinates, table
from models.hard.suite.closed_linkages import four_bar

BODIES = tuple(f"K{i}.phi" for i in range(1, 8))
RATIOS = {"light": 1e-8, "even": 1.0, "heavy": 1e8}
SPEED, SPAN = 12.0, 2.0


@cache
def _andrews() -> Reference:
    rows = table("andrews.csv")
    # K1 turns more than the others: a perturbation of its start is 40 times as large at the end.
    growth = np.array([40.0, 10.0, 7.0, 11.0, 1.0, 10.0, 4.0])
    return Reference(rows[:, 1:], rows[:, 0], growth, 210, 1e-14)


def _mass_ratio(ratio: float) -> Case:
    @cache
    def reference() -> Reference:
        angle = four_bar(ratio, SPAN, SPEED)
        # The tolerance for a velocity of 12 rad/s is 12 rtol, and it is 5 times as large in φ.
        return Reference(np.array([[angle]]), np.array([SPAN]), 12 * 5.0, 230, 1e-13)

    name = next(key for key, value in RATIOS.items() if value == ratio)
    return Case(
        name=f"mass_ratio_{name}",
        hard=f"A four-bar whose coupler has {ratio:g} kg between bars of 1 kg.",
        see="Errors and steps are those of even masses, whatever the ratio.",
        model="hard/mass_ratio",
        scene="turning",
        t_end=SPAN,
        quantity="φ of the crank at the end, rad",
        measure=lambda run: run.q("crank.phi")[-1:, None],
        reference=reference,
        origin=("quadrature of the energy integral over the crank's angle in 25 digits"),
        sampled=False,
        parameters={"ratio": ratio},
        work=conservative,
    )


CASES = (
    Case(
        name="andrews",
        hard=(
            "Seven bodies in three loops that meet in one point: the crank turns at up"
            " to 1140 rad/s beside bodies that hardly move."
        ),
        see="Every angle is right to 1e-9 at rtol 1e-11, whatever the method.",
        model="hard/andrews",
        scene="released",
        t_end=0.05,
        quantity="φ of all seven bodies, rad",
        measure=coordinates(*BODIES),
        reference=_andrews,
        origin=(
            "given solution of the benchmark, minimal coordinates, 12 digits and "
            "more; growth measured by starting 1e-7 rad further on"
        ),
        tolerances=(1e-3, 1e-6, 1e-9, 1e-11, 1e-13),
        work=lambda run: 0.033 * (run.q("K1.phi") - run.q("K1.phi")[0]),
    ),
    *(_mass_ratio(ratio) for ratio in RATIOS.values()),
)
