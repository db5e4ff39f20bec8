"""Random mechanisms: closed in their pose, the same in any process and in any units."""

import hashlib
import os
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from codegen.reading.scene_selection import valid_scenes
from tests.random_mechanisms import DRIVEN, FAMILIES, RandomMechanism, Scales, random_mechanism
from tests.random_mechanisms.pose_analysis import column_sizes, constraint_rows

SEEDS = 60
UNITS = Scales()
FINGERPRINT = (
    "from tests.random_mechanisms.test_generator import fingerprint; print(fingerprint(15))"
)


def fingerprint(seeds: int) -> str:
    """Of the first mechanisms, to the last digit."""
    text = "".join(repr(random_mechanism(seed)) for seed in range(seeds))
    return hashlib.sha256(text.encode()).hexdigest()


@pytest.fixture(scope="module")
def machines() -> list[RandomMechanism]:
    """The first seeds."""
    return [random_mechanism(seed) for seed in range(SEEDS)]


def test_every_joint_is_closed_and_moves_as_its_start_says(machines: list[RandomMechanism]) -> None:
    """Residuals of positions and velocities vanish to rounding."""
    for machine in machines:
        length, time = machine.scales.length, machine.scales.time
        sizes = column_sizes(machine.parts.coordinates, length)
        for rows in constraint_rows(machine.parts, machine.q, machine.v, 0.0).values():
            for row in rows:
                steepest = np.max(np.abs(row.by_q) * sizes)
                assert abs(row.value) <= 1e-13 * steepest
                assert abs(row.rate) <= 1e-12 * steepest / time


def test_all_kinds_come(machines: list[RandomMechanism]) -> None:
    """Every family, driven in every way, with few and with several freedoms."""
    assert {m.family for m in machines} == {*FAMILIES}
    assert {m.driven for m in machines} == {*DRIVEN}
    assert len(Counter(m.freedoms for m in machines)) >= 4


def test_a_hash_seed_changes_nothing(root: Path) -> None:
    """Two processes with other hash seeds make the same mechanisms as this one."""
    environment = os.environ | {"PYTHONHASHSEED": "4711"}
    command = [sys.executable, "-c", FINGERPRINT]
    answer = subprocess.run(
        command, cwd=root, env=environment, capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == fingerprint(15)


@pytest.mark.parametrize("seed", range(8))
def test_other_units_give_the_same_mechanism(seed: int) -> None:
    """Poses in typical lengths, and kind, are the same."""
    one = random_mechanism(seed, scales=UNITS)
    other = random_mechanism(seed, scales=replace(UNITS, length=2.0**-20, mass=2.0**30, time=2.0))
    assert (one.kind, one.freedoms, list(one.start)) == (
        other.kind,
        other.freedoms,
        list(other.start),
    )
    sizes = column_sizes(one.parts.coordinates, 2.0**-20)
    np.testing.assert_allclose(other.q, one.q * sizes, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(2.0 * other.v, one.v * sizes, rtol=1e-9, atol=1e-9 * 2.0**-20)


@pytest.mark.parametrize("family", FAMILIES)
def test_every_family_can_be_declared(family: str) -> None:
    """The declarations are checked without a complaint."""
    for seed in range(3):
        machine = random_mechanism(seed, family, friction="sticking", contacts="yielding")
        assert [s.name for s in valid_scenes(machine.model(), None)] == ["run"]
