"""Tolerances of the runs of a search for an accuracy target, each from the runs before it.

The first run is planned by a power law of the target, and the second has a tolerance so much
tighter that scatter matters little. Every later run is planned by the error of the last one: that
of the run before, which the difference shows, times a power of the ratio of the tolerances.
"""

from runtime.integrate.method import IMPLICIT
from runtime.integrate.trajectory import Trajectory
from runtime.studies.accuracy_target import run_difference as runs
from runtime.studies.accuracy_target.run_difference import Pair

MARGIN = 0.5  # safety: share of the target that a run is planned for, and judged by
TIGHTEST = 1e-14  # safety: rtol of any run
LAST = 3e-14  # measured: the same where errors are small; a tighter run errs more, by rounding

_FIRST, _SLOPE = 1e-3, 0.9  # measured: rtol of the first run for a target of 1e-3; its power law
_LOOSEST = 5e-4  # measured: and at most; looser runs lose whole motions
_WIDE = 5e-4  # measured: rtol of the second run over that of the first
_STIFF = 0.015  # measured: the same with an implicit method
# measured: rtol of an implicit run after an explicit one for a target of 1e-3, and at most; its
# power law is that of the first run
_CHANGED = 7.5e-7
_NEAR, _FAR = 0.1, 1e-6  # safety: rtol of later runs over that of the last
_EXPECTED_POWER = 0.95  # measured: power of rtol with which errors are expected to fall
_NEXT = 0.03  # measured: rtol of the next run over that of the last, if that shows nothing


def first_tolerance(target: float) -> float:
    """rtol of the first run."""
    planned = float(_FIRST * (target / 1e-3) ** _SLOPE)
    return min(max(planned, LAST / _WIDE), _LOOSEST)


def implicit_tolerance(target: float) -> float:
    """rtol of an implicit run after an explicit one."""
    return float(max(LAST, _CHANGED * min(1.0, target / 1e-3) ** _SLOPE))


def second_tolerance(method: str, target: float, first: float, path: Trajectory) -> float:
    """rtol of the second run, with this method, after a first one.

    A first run whose steps stability limits errs by much more than its tolerance suggests.
    """
    if any(name in IMPLICIT for _, name in path.methods):
        return max(LAST, _STIFF * first)
    return implicit_tolerance(target) if method in IMPLICIT else max(LAST, _WIDE * first)


def next_tolerance(pair: Pair, target: float) -> float:
    """rtol of the next run after these, so that its estimated error is the target less a margin."""
    largest, rtol = pair.difference.largest, pair.tight.options.rtol
    if largest >= runs.DIVERGED or not pair.conclusive:
        return max(TIGHTEST, _NEXT * rtol)
    error = largest * (rtol / pair.loose.options.rtol) ** _EXPECTED_POWER
    factor = runs.sufficient_ratio(MARGIN * target / error)
    following = rtol * min(_NEAR, max(_FAR, factor))
    return max(following, runs.ROUNDING if rtol > runs.ROUNDING else tightest_tolerance(pair))


def tightest_tolerance(pair: Pair) -> float:
    """Tightest rtol after these two runs."""
    near = pair.conclusive and pair.difference.largest < runs.DIVERGED
    return LAST if near else TIGHTEST
