"""Whole machines and their hand-derived equations of one degree of freedom: the same numbers."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import machines, twins
from benchmarks.hand import linkages
from benchmarks.operation_counts import cost
from models.studies.linkage import FourBar, Rider

CHANGED = {
    "slider_crank": {"J1": 900.0, "rod_length": 2.6, "motor_torque": 50e3},
    "quick_return": {"J3": 4000.0, "m6": 100.0, "T3": 150e3, "cutting_force": 100e3},
    "four_bar": {"AB": 0.8, "BC": 2.1, "CD": 2.9, "AD": 2.3, "density": 1.7, "crank_torque": 9.0},
    "web_cutter": {"cut_force": 700.0, "motor_gain": 15.0, "drive_speed": 7.0},
}


@pytest.fixture(scope="session")
def folder(request: pytest.FixtureRequest) -> Path:
    """Where generated modules stay while they do not change."""
    place: Path = request.config.cache.mkdir("benchmarks")
    return place / "generated"


def named(machine: machines.Machine) -> str:
    return machine.name


@pytest.mark.parametrize("machine", machines.REDUCED, ids=named)
def test_twins_agree(machine: machines.Machine, folder: Path) -> None:
    (twin,) = machines.twins([machine], folder)
    assert len(twin.states.q) == machines.STATES
    assert twins.difference(twin) < 1e-10
    assert twin.generated.counts["accelerations"][1] <= machines.BAR * cost(twin.hand)


@pytest.mark.parametrize("machine", machines.REDUCED, ids=named)
def test_twins_agree_for_other_parameters(machine: machines.Machine, folder: Path) -> None:
    changed = CHANGED[machine.name]
    (twin,) = machines.twins([machine], folder, changed)
    names = [name for name, *_ in twin.generated.module.PARAMETERS]
    assert all(twin.p[names.index(name)] == value for name, value in changed.items())
    assert twins.difference(twin) < 1e-10


@pytest.mark.parametrize("name", ["slider_crank", "quick_return", "web_cutter"])
def test_the_states_meet_every_condition(name: str, folder: Path) -> None:
    machine = next(machine for machine in machines.REDUCED if machine.name == name)
    (twin,) = machines.twins([machine], folder)
    together = twin.states.modes.prod(axis=1)
    if name == "slider_crank":  # of its four, none holds with all the others
        together = twin.states.modes[:, 3]
    assert 0 < together.sum() < len(together)


def test_the_hand_derived_linkage_is_that_of_the_study() -> None:
    ab, bc, cd, ad, density, torque = 1.0, 2.5, 2.5, 2.0, 1.0, 5.0
    riders = (
        Rider(0, ab / 2, density * ab, density * ab**3 / 12),
        Rider(1, bc, 2 * density * bc, density * (2 * bc) ** 3 / 12),
        Rider(2, cd / 2, density * cd, density * cd**3 / 12),
    )
    study = FourBar(0j, complex(ad), ab, bc, cd, 1, riders, 9.81)
    p = linkages.four_bar_parameters(np.array([ab, bc, cd, ad, density, torque]))
    a, none = np.zeros(9), np.zeros(0, dtype=np.int64)
    for phi in np.linspace(0.1, 6.2, 23):
        q, v = np.zeros(9), np.zeros(9)
        q[2], v[2] = phi, 3.0
        assert linkages.four_bar(0.0, q, v, p, none, a, np.zeros(8)) == 0
        inertia, slope = study.inertia(phi)
        expected = (torque - study.potential(phi)[1] - 0.5 * slope * 9.0) / inertia
        assert abs(a[2] - expected) < 1e-11 * max(1.0, abs(expected))


OF_USERS = {
    "engine", "quarter_car", "robot_arm", "scotch_yoke", "trebuchet", "watt_six_bar"
}  # fmt: skip
"""Machines beside those of the book; their tests have independent solutions, not twins by hand."""


def test_every_machine_of_the_library_is_measured(root: Path) -> None:
    declared = {path.stem for path in (root / "models").glob("*.py") if path.stem[0] != "_"}
    assert {machine.name for machine in machines.MACHINES} == declared - OF_USERS


def test_pace_is_time_by_weighted_operations(folder: Path) -> None:
    chosen = [m for m in machines.MACHINES if m.name in ("four_bar", "coil_spring")]
    rows = machines.measure(chosen, folder, 500, 1)
    assert [row.machine for row in rows] == ["four_bar", "coil_spring"]
    for row in rows:
        assert row.cost > row.operations > 100
        assert row.pace == pytest.approx(row.nanoseconds / row.cost)
