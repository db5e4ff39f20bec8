"""Every element's generated kernels and its hand-written formulas: the same numbers."""

import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks import elements, elements_in_space, twins
from benchmarks.hand import drivers, forces, joints
from benchmarks.operation_counts import cost, operations
from codegen.elements.registry import kinds_of_elements
from codegen.model import Model
from codegen.model.space_model import SpaceModel

MOST, SIGNS = 1.3, 3
"""A generated kernel needs at most so many times the operations of a hand-written one, and signs,
which the ledger counts."""
DEARER = {
    "bushing in space": 1.32,
    "friction in space, in a pin": 2.3,
    "friction in space, in a guide": 3.1,
    "friction in space, in a sleeve": 4.3,
}
"""Those known to need more: reactions are built in global axes and projected on those of the joint,
where by hand they are multipliers, and rates of θ come from Euler parameters, not from ω."""


@pytest.fixture(scope="session")
def folder(request: pytest.FixtureRequest) -> Path:
    """Where generated modules stay while they do not change."""
    place: Path = request.config.cache.mkdir("benchmarks")
    return place / "generated"


def named(sample: elements.Sample) -> str:
    return sample.label.replace(" ", "-")


@pytest.mark.parametrize("sample", elements.SAMPLES, ids=named)
def test_twins_agree(sample: elements.Sample, folder: Path) -> None:
    for twin in elements.twins([sample], folder):
        assert twins.difference(twin) < 1e-12, twin.kernel


@pytest.mark.parametrize("sample", elements.SAMPLES, ids=named)
def test_operations_are_counted(sample: elements.Sample, folder: Path) -> None:
    for twin in elements.twins([sample], folder):
        counted, weighted = twin.generated.counts[twin.kernel]
        assert counted == dict(twin.generated.module.OPERATIONS)[twin.kernel]
        assert operations(twin.hand) <= cost(twin.hand)
        # in space a row has a sign each, and the weights, in which signs are free, are the bar
        assert sample.space or counted <= MOST * operations(twin.hand) + SIGNS
        assert weighted <= DEARER.get(sample.label, MOST) * cost(twin.hand)


def test_every_kind_of_element_has_a_sample() -> None:
    library = {kind.name for kind in kinds_of_elements().values() if not kind.is_user_defined}
    assert {sample.kind for sample in elements.PLANAR} == library


def test_every_kind_of_element_in_space_has_a_sample() -> None:
    """Its own kinds, and those of the plane whose method `SpaceModel` leaves as it is."""
    registered = kinds_of_elements(space=True).values()
    own = {kind.name for kind in registered if not kind.is_user_defined}
    shared = set()
    for kind in kinds_of_elements().values():
        if not kind.is_user_defined:
            *_, word = re.findall(r"model\.(\w+)", kind.element.example)
            if getattr(SpaceModel, word) is getattr(Model, word):
                shared.add(kind.name)
    assert len(own) > 20
    assert {"spring", "driver", "contact"} < shared
    assert {sample.kind for sample in elements_in_space.SAMPLES} == own | shared


def test_conditions_hold_in_some_states_and_not_in_others(folder: Path) -> None:
    contact = next(sample for sample in elements.SAMPLES if sample.kind == "contact")
    (twin,) = elements.twins([contact], folder)
    modes = twin.states.modes
    assert modes.shape == (elements.STATES, 1)
    assert 0 < modes.sum() < elements.STATES
    closed, opened = (
        twins.call(twin.kernel, twin.hand, twin.states, k, twin.p) for k in (0, len(modes) - 1)
    )
    assert np.abs(closed).max() > 0
    assert not opened.any()


def test_a_wrong_twin_is_noticed(folder: Path) -> None:
    revolute = next(sample for sample in elements.SAMPLES if sample.kind == "revolute")
    (jacobian, _) = elements.twins([revolute], folder)
    wrong = twins.Twin(
        jacobian.subject,
        jacobian.kernel,
        jacobian.generated,
        joints.weld_jacobian,
        jacobian.states,
        range(10),
        jacobian.p,
        jacobian.hand_p,
    )
    assert twins.difference(wrong) > 0.1


def _both(modes: list[int], x: float) -> float:
    both = modes[0] & modes[1]
    return 2.0 * x if both else x


def test_the_yardstick_of_hand_written_code() -> None:
    # two sines and cosines, and of each rotation four products and two sums
    assert operations(joints.revolute_jacobian) == 2 * 8
    assert cost(joints.revolute_jacobian) == 2 * (2 * 20 + 6)
    # s'_y F'_x and the like are numbers that the compiler works out
    assert operations(forces.following) == 8
    assert operations(forces.gravity) == 0
    # conditions are free
    assert operations(_both) == 1
    # -1.2 sin 2t
    assert operations(drivers.motion_rhs) == 3
    assert cost(drivers.motion_rhs) == 22
    # six additions, three products, a division, a root and two rotations
    assert cost(drivers.distance_jacobian) - operations(drivers.distance_jacobian) == 4 * 19 + 2 * 4


def test_measurement_reports_all_kernels(folder: Path) -> None:
    spring = next(sample for sample in elements.SAMPLES if sample.kind == "spring")
    gear = next(sample for sample in elements.SAMPLES if sample.kind == "gear")
    rows = twins.measure(elements.twins([gear, spring], folder), 500, 1)
    assert [(row.subject, row.kernel) for row in rows] == [
        ("gear", "jacobian"),
        ("gear", "acceleration_rhs"),
        ("spring", "applied_forces"),
    ]
    assert all(row.ratio > 0 and row.difference < 1e-12 for row in rows)
