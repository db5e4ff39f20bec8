"""Without anything that numba does not document, the whole way gives the same bits."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.slow

PROGRAM = """
import hashlib, json
import numpy as np
import linkwright as lw
from codegen.machine_code.undocumented_names import PLAIN

RUNS = (
    ("slider_crank", "compressor", 0.1), ("web_cutter", "running", 0.3),
    ("four_bar", "constant_torque", 0.3),
)


def digest(*arrays):
    joined = b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)
    return hashlib.sha256(joined).hexdigest()


said = {}
for model, scene, t_end in RUNS:
    machine = lw.load(model, scene=scene)
    start = machine.assemble()
    result = machine.simulate(t_end, 31, progress=False)
    names = [row.name for row in machine.coordinates]
    said[model] = {
        "kernels": type(machine.kernels.constraints).__name__,
        "start": digest(start.q, start.v),
        "outcome": result.outcome.name,
        "instants": digest(result.t),
        "coordinates": digest(*map(result.q, names)),
        "velocities": digest(*map(result.v, names)),
        "events": [[event.name, float(event.time).hex()] for event in result.events],
    }
print(json.dumps([PLAIN, said]))
"""
MACHINES = ("slider_crank", "web_cutter", "four_bar")
QUANTITIES = ("start", "outcome", "instants", "coordinates", "velocities", "events")


@pytest.fixture(scope="module")
def said(root: Path) -> dict[str, Any]:
    """What a process says by each way, of each machine."""
    found = {}
    for way, environment in (("plain", {"LINKWRIGHT_NUMBA": "plain"}), ("usual", {})):
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM], cwd=root, capture_output=True, text=True, check=False,
            env={**os.environ, **environment},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        is_plain, found[way] = json.loads(done.stdout.splitlines()[-1])
        assert is_plain == (way == "plain")
    return found


@pytest.mark.parametrize("machine", MACHINES)
def test_the_ways_differ(said: dict[str, Any], machine: str) -> None:
    assert said["plain"][machine]["kernels"] == "CPUDispatcher"
    assert said["usual"][machine]["kernels"] == "Kernel"


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("quantity", QUANTITIES)
def test_the_results_have_the_same_bits(said: dict[str, Any], machine: str, quantity: str) -> None:
    assert said["plain"][machine][quantity] == said["usual"][machine][quantity]
