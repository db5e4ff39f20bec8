"""The examples of docs/how-to/control-and-connections.md, run as they stand there."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.documented import run_cells


@pytest.fixture(scope="module")
def shown(root: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Everything that the page's code defines."""
    page = root / "docs" / "how-to" / "control-and-connections.md"
    return run_cells(page, tmp_path_factory.mktemp("control"))


def test_motor(shown: dict[str, Any]) -> None:
    r = shown["spin"]
    matrix = np.array([[-200.0, -10.0], [50.0, -0.5]])
    values, vectors = np.linalg.eig(matrix)
    final = -np.linalg.solve(matrix, [1200.0, 0.0])
    parts = np.linalg.solve(vectors, [1.0, 0.0] - final)
    exact = final[0] + np.exp(np.outer(r.t, values)) @ (vectors[0] * parts)
    # Its steps are at the limit of stability, where the dense output has fewer digits than steps.
    assert_allclose(r.y("current"), exact, atol=5e-5)


def test_controllers(shown: dict[str, Any]) -> None:
    turn = shown["turn"]
    assert abs(turn.q("arm.phi")[-1] - 1) < 0.1
    assert np.abs(turn.y("u")).max() == 5.0
    assert np.abs(shown["coarse"].q("arm.phi") - turn.q("arm.phi")).max() > 1e-3
    controlled = shown["controlled"]
    assert abs(controlled.q("arm.phi")[-1] - 1) < 0.01
    asked = np.clip(10 * (1 - controlled.q("arm.phi")) - controlled.v("arm.omega"), -5, 5)
    assert np.abs(controlled.y("torque") - asked).max() < 1.0


def test_latch_and_end(shown: dict[str, Any]) -> None:
    race = shown["race"]
    push = 2 * (2.0**2 - 1.0**2) / 2 / 8.0  # m, over which the thruster takes it to 2 m/s
    arrives = 0.3 + (2.0 - 1.0) / 4.0 + (3.0 - 0.3 - push) / 2.0
    assert race.ended_by == "home"
    assert_allclose(race.t[-1], arrives, atol=1e-8)
    assert {*race.y("burning")} == {0.0, 1.0}


def test_shear_pin(shown: dict[str, Any]) -> None:
    whole, sheared = shown["whole"], shown["sheared"]
    # F = g (1 - cos²θ / 1.1 + 2 sin²θ / 1.1) for the angle θ below the horizontal
    sine = np.sqrt((1.1 * (20 / 9.81 - 1) + 1) / 3)
    assert whole.ended_by == "shear"
    assert_allclose(whole.q("lever.y")[-1], -sine, atol=1e-8)
    omega, last = np.sqrt(2 * 9.81 * sine / 1.1), 2.0 - whole.t[-1]
    height = -sine - omega * np.sqrt(1 - sine**2) * last - 9.81 * last**2 / 2
    assert_allclose(sheared.q("lever.y")[-1], height, atol=1e-6)


def test_connections(shown: dict[str, Any]) -> None:
    flight, cut = shown["flight"], shown["cut"]
    assert_allclose(flight.at(cut.time).q("bob.phi"), 0.5, atol=1e-8)
    last = 1.5 - cut.time
    omega = np.sqrt(49 - 2 * 9.81 * (np.sin(0.5) + 1) / 1.1)
    height = np.sin(0.5) + omega * np.cos(0.5) * last - 9.81 * last**2 / 2
    assert_allclose(flight.q("bob.y")[-1], height, atol=1e-6)
    assert str(cut).startswith("Joint 'hinge' was released at t = 0.")
    caught = shown["caught"]
    assert_allclose([caught.time, caught.energy_lost], [1 / 3, 3.0], atol=1e-8)
    assert_allclose(np.abs([*caught.impulse.values()]), [2.0], atol=1e-8)
    changes = shown["index"].reconnections
    assert [change.action for change in changes] == ["engage", "release"]
    assert_allclose([change.time for change in changes], [np.pi / 8, 3 * np.pi / 8], atol=1e-8)


def test_freewheel(shown: dict[str, Any]) -> None:
    coast = shown["coast"]
    assert [event.word for event in coast.events if event.word] == ["overruns"]
    assert_allclose(coast.at(0.5).torque("clutch"), 1.0, atol=1e-9)
    together = 1.5 + 2.0 * np.minimum(coast.t, 1.0)  # two of 0.5 kg m² under 2 N m
    assert_allclose(coast.v("disc.phi"), together, atol=1e-8)
    assert_allclose(coast.v("shaft.phi")[-1], together[-1] - 4.0, atol=1e-8)
