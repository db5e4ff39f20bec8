"""Linkages with guesses far off: whatever says whether a scene assembles says the same.

500 by hand, in half an hour: `python -m tests.random_mechanisms.start_verdict_campaign 0 500`.
"""

import pytest

from tests.random_mechanisms.linkages import DRIVES, KINDS, random_linkage
from tests.random_mechanisms.start_verdict_campaign import judge

SEEDS = (1, 4, 6, 8, 11, 23, 118)
"""Those of 6 and 23 assemble far from their guesses, and 118 near a singular position."""


@pytest.mark.parametrize("seed", SEEDS)
def test_all_verdicts_are_one(seed: int) -> None:
    complaints, about = judge(seed)
    assert complaints == []
    assert about.startswith(", assembled") == random_linkage(seed).closes


def test_linkages_are_of_many_kinds() -> None:
    chosen = [random_linkage(seed) for seed in SEEDS]
    assert {one.kind for one in chosen} == {*KINDS}
    assert {one.drive for one in chosen} == {*DRIVES}
    assert {one.closes for one in chosen} == {True, False}
