"""The valve lifter against the equation of its one freedom, written out by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from models.studies.valve_lifter import (
    ECCENTRICITIES,
    RPM,
    SEPARATES,
    contact_force,
    leaves_at,
    parts_at,
    study,
    table,
)
from runtime import load


def test_force_on_the_pushrod_is_that_of_one_freedom() -> None:
    for (k, rpm), run in study().driven.items():
        expected = contact_force(k, rpm, run.t)
        assert_allclose(run.reaction("lift", "fy"), expected, atol=1e-11 * expected.max())
        assert_allclose(run.reaction("lift", "fx"), 0, atol=1e-12 * expected.max())


def test_verdicts_are_the_books() -> None:
    for case, run in study().driven.items():
        assert (run.reaction("lift", "fy").min() < 0) == (case in SEPARATES)


def test_free_follower_leaves_where_the_force_vanishes_and_only_there() -> None:
    for case, run in study().free.items():
        assert not run.failed, run.message
        parted = parts_at(run)
        if case not in SEPARATES:
            assert parted == np.inf
            continue
        assert_allclose(parted, leaves_at(*case), rtol=2e-3)
        assert parted < leaves_at(*case)
        gap = run.q("pushrod.y") - study().driven[case].q("pushrod.y")
        assert gap.max() > 5e-4


@pytest.mark.parametrize("stiffness", [2e6, 2e8])
def test_free_follower_approaches_the_rigid_cam_as_the_contact_stiffens(stiffness: float) -> None:
    """It leaves earlier by less than one period of the mass on the contact."""
    machine = load("valve_lifter", "free_follower")
    case = (10.0, 3000.0)
    force = float(contact_force(*case, np.zeros(1))[0])
    level = machine.assemble().q[machine.coordinates.index("pushrod.y")]
    run = machine.simulate(
        0.01,
        rtol=1e-10,
        parameters={"k": 1000.0, "speed": 3000 * RPM, "K": stiffness, "C": 0.0},
        start={"pushrod.y": level - force / stiffness},
    )
    early = leaves_at(*case) - parts_at(run)
    period = 2 * np.pi * np.sqrt(0.23 / stiffness)
    assert abs(early) < period


def test_closed_loop_keeps_its_constraints_and_its_energy() -> None:
    run = load("valve_lifter", "inverse_dynamics").inverse_dynamics(np.linspace(0, 0.02, 201))
    assert run.data["constraint_residual"].max() < 1e-12
    total = run.data["energy"].sel(part="total").to_numpy()
    power = run.data["power"].sel(source="camshaft").to_numpy()
    # The cam's turn is periodic, so sums are integrals to the last digit.
    assert_allclose(total[-1], total[0], rtol=1e-12)
    assert_allclose(power[:-1].sum() / np.abs(power).sum(), 0, atol=1e-13)
    spectrum = np.fft.rfft(total[:-1] - total[:-1].mean())
    rate = np.fft.irfft(1j * np.arange(101) * 100 * np.pi * spectrum, 200)
    assert_allclose(rate, power[:-1], atol=1e-9 * np.abs(power).max())


def test_lift_is_twice_the_eccentricity() -> None:
    for e in ECCENTRICITIES:
        lift = np.ptp(study().lifts[e].q("valve.y"))
        assert_allclose(lift, 2 * e / 100, rtol=1e-12)


def test_table_has_every_verdict() -> None:
    rows = table()
    assert sum(row.book in ("negative", "positive") for row in rows) == 5
    for row in rows:
        assert_allclose(row.ours, row.exact, rtol=2e-3)
        if isinstance(row.book, float):
            assert row.reason
