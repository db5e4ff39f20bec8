"""A sample of the campaign: random mechanisms that are built, run and compared."""

from pathlib import Path

import pytest

from tests.random_mechanisms import random_mechanism
from tests.random_mechanisms.campaign import MET, MOTION, judge


@pytest.mark.parametrize("seed", [3, 5, 11])
def test_a_run_agrees_with_the_dense_motion(seed: int, request: pytest.FixtureRequest) -> None:
    """Loops that are free, a pinion that is driven, and a tree that rubs."""
    folder: Path = request.config.cache.mkdir("random-mechanisms")
    verdict = judge(random_mechanism(seed), folder)
    assert verdict.complaint == ""
    assert verdict.outcome == "OK"
    assert verdict.statics < MET
    assert verdict.motion < MOTION * 10


def test_sticking_and_impacts_agree_with_the_dense_motion(request: pytest.FixtureRequest) -> None:
    """A pinion and its rack that rub, change their direction, strike a stop, and stick."""
    folder: Path = request.config.cache.mkdir("random-mechanisms")
    machine = random_mechanism(5, driven="free", friction="sticking", contacts="rigid")
    verdict = judge(machine, folder)
    assert (verdict.outcome, verdict.complaint) == ("OK", "")
    assert verdict.motion < MOTION


@pytest.mark.slow
@pytest.mark.parametrize("seed", [11, 16])
def test_friction_beside_one_that_sticks_is_on_its_law(
    seed: int, request: pytest.FixtureRequest
) -> None:
    """A pin rubs while the guide sticks: its force is no linear function of the guide's."""
    folder: Path = request.config.cache.mkdir("random-mechanisms")
    verdict = judge(random_mechanism(seed, friction="sticking", contacts="rigid"), folder)
    assert (verdict.outcome, verdict.complaint) == ("OK", "")
    assert verdict.motion < MOTION
