"""Machines whose kernels are loops run as those whose kernels are written out."""

from pathlib import Path

import numpy as np
import pytest

import runtime
from benchmarks.chain import SCENE, chain
from benchmarks.growth import hanging
from runtime import Machine

LINKS = 36  # more than 3000 operations in `accelerations`, so that it becomes loops


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    folder: Path = tmp_path_factory.mktemp("loops")
    return runtime.load(chain(LINKS), SCENE, folder=folder)


def test_the_workspace_stands_behind_the_constants(machine: Machine) -> None:
    description = machine.mechanism.description
    assert description.workspace > LINKS
    assert len(machine.parameter_values()) == description.parameter_slots
    assert "for k in range(" in machine.path.read_text(encoding="utf-8")


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_long_chain_swings_as_its_own_equations_say(machine: Machine, method: str) -> None:
    result = machine.simulate(2.0, method=method, rtol=1e-9, atol=1e-9, progress=False)
    angles = [float(result.q(f"link_{k}.phi")[-1]) for k in range(LINKS)]
    assert np.abs(np.array(angles) - hanging(LINKS)).max() < 1e-6
