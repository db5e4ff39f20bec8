"""The net and the roller chain, at small sizes, and the row of four-bars at a large one."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from benchmarks.net_reference import free_knots, knots_of_net
from codegen import Model
from models.hard.n_four_bar import n_four_bar
from models.hard.net import model as net
from models.hard.roller_chain import PITCH, TOOTH, layout, pitch_radius, roller_chain, teeth
from models.hard.roller_chain import model as chain
from runtime import Machine, Outcome, Result, load

SIDE, ROLLERS = 4, 30


@cache
def machine(model: Model) -> Machine:
    with TemporaryDirectory() as folder:
        return load(model, folder=folder)


@cache
def swing() -> Result:
    return machine(net).simulate(1.0, rtol=1e-9, progress=False)


@cache
def drive(rtol: float) -> Result:
    return machine(chain).simulate(1.0, rtol=rtol, progress=False)


def test_the_net_moves_as_the_sum_of_two_polygons() -> None:
    result, names = swing(), [f"knot_{i}_{j}" for i, j in free_knots(SIDE)]
    assert result.outcome is Outcome.OK, result.message
    assert len(machine(net).coordinates) - len(machine(net).constraints) == 2 * SIDE - 4
    found = np.array([[result.q(f"{n}.x")[-1], result.q(f"{n}.y")[-1]] for n in names])
    assert np.abs(found - knots_of_net(SIDE, 1.0)).max() < 1e-9
    moved = [np.ptp(result.q(f"{n}.x")) for n in names]
    assert min(moved) > 0.05


def test_the_net_keeps_its_energy() -> None:
    energy = swing().energy()
    assert np.abs(energy - energy[0]).max() < 1e-8 * swing().energy("kinetic").max()


@pytest.mark.parametrize("rollers", [20, 50, 100, 200])
def test_the_chain_lies_around_its_sprockets_at_the_start(rollers: int) -> None:
    distance, places = layout(rollers)
    at = np.array(places)
    assert len(at) == rollers
    links = np.linalg.norm(at - np.roll(at, 1, axis=0), axis=1)
    np.testing.assert_allclose(links, PITCH, rtol=1e-12)
    for count, x in zip(teeth(rollers), (0.0, distance), strict=True):
        gaps = np.linalg.norm(at - (x, 0.0), axis=1) - pitch_radius(count)
        seated = np.abs(gaps) < 1e-12
        assert gaps.min() > -1e-12
        assert abs(seated.sum() - count / 2) <= 2.0


@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
def test_the_sprockets_turn_in_the_ratio_of_their_teeth(rtol: float) -> None:
    result, (driving, driven) = drive(rtol), teeth(ROLLERS)
    assert result.outcome is Outcome.OK, result.message
    assert result.stats["events"] > 100
    off = result.q("driven.phi") - result.q("driving.phi") * driving / driven
    assert np.abs(off).max() < TOOTH / pitch_radius(driven)
    assert result.q("driving.phi")[-1] < -8.0


def test_the_links_keep_their_length_and_two_tolerances_agree() -> None:
    loose, tight = drive(1e-6), drive(1e-8)
    ends = [np.stack([tight.q(f"roller_{k}.{x}") for x in "xy"]) for k in range(ROLLERS)]
    links = [np.linalg.norm(ends[k] - ends[k - 1], axis=0) for k in range(ROLLERS)]
    assert np.abs(np.array(links) - PITCH).max() < 1e-10
    assert np.abs(loose.q("driven.phi") - tight.q("driven.phi")).max() < 1e-5


@pytest.mark.slow
def test_contacts_that_touch_at_rest_have_modes(tmp_path: Path) -> None:
    """All seated rollers have a gap of zero without a speed: no look ahead tells their modes."""
    result = load(roller_chain(50), folder=tmp_path).simulate(0.01, rtol=1e-6, progress=False)
    assert result.outcome is Outcome.OK, result.message


def test_a_crossing_of_many_loops_names_a_few_constraints(tmp_path: Path) -> None:
    """Of 6 A.x, 5 B.x and 5 C.x."""
    result = load(n_four_bar(5), "fall", folder=tmp_path).simulate(1.0, progress=False)
    assert "constraints A0.x, A1.x, A2.x, A3.x, A4.x, A5.x and 10 others became" in result.message


@pytest.mark.slow
def test_a_sample_beside_a_crossing_of_many_loops_ends(tmp_path: Path) -> None:
    """Rounding grows with the row's length: no return brings the sample onto the constraints."""
    result = load(n_four_bar(400), "fall", folder=tmp_path).simulate(1.0, progress=False)
    assert (result.outcome, result.stats["singular_crossings"]) == (Outcome.OK, 1)
    assert max(np.abs(result.q(f"coupler_{k}.phi")).max() for k in range(1, 401)) < 1e-9
