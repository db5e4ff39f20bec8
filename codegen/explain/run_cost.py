"""What a run of a scene took, asked of the runtime's command line.

The compiler knows nothing of the runtime: it asks as a user would, and reads the answer.
"""

import csv
import json
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from codegen.derive.equations import Equations
from codegen.errors import InputError
from codegen.explain.kernel_timer import Floats
from codegen.explain.sample_states import COUNT

MEASURED = 2
"""Runs of which the faster counts."""


@dataclass(frozen=True)
class Run:
    """A run with the scene's defaults.

    Attributes
    ----------
    evaluations, steps, rejected, retakes
        Calls of `accelerations`; steps taken, refused for their error, and taken again for events.
    seconds
        Wall time of the integration.
    events
        Effect → its events.
    t, q, v
        States along the run, (k,), (k, n), (k, n).
    """

    t_end: float
    evaluations: int
    steps: int
    rejected: int
    retakes: int
    seconds: float
    events: dict[str, int]
    t: Floats
    q: Floats
    v: Floats


def run(model: Path, equations: Equations, t_end: float) -> Run:
    """Simulate a declared scene of a model file by `python -m runtime simulate`.

    Raises
    ------
    InputError
        If it does not run to its end: with what the runtime says.
    """
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "run.csv"
        command = [
            *(sys.executable, "-m", "runtime", "simulate", str(model)),
            *("--scene", equations.scene.name, "--t-end", repr(t_end)),
            *("--points", str(COUNT), "--json"),
        ]
        answers = [_answer([*command, "--out", str(table)])]
        answers += [_answer(command) for _ in range(MEASURED - 1)]
        with table.open(newline="", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
    stats = answers[0]["stats"]
    times = [answer["stats"]["integration_seconds"] for answer in answers]
    names = [c.name for c in equations.coordinates], [c.rate.name for c in equations.coordinates]
    positions, velocities = ([dotted(name) for name in side] for side in names)
    events = Counter(event["name"].partition(":")[0] for event in answers[0]["events"])
    return Run(
        t_end,
        int(stats["rhs_evaluations"]),
        int(stats["steps"]),
        int(stats["rejected"]),
        int(stats["retakes"]),
        min(times),
        dict(events),
        _columns(rows, ["time"])[:, 0],
        _columns(rows, positions),
        _columns(rows, velocities),
    )


def dotted(name: str) -> str:
    """``crank_phi`` → ``crank.phi``."""
    owner, _, letter = name.rpartition("_")
    return f"{owner}.{letter}"


def _answer(command: Sequence[str]) -> dict[str, Any]:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        said = done.stderr.strip().splitlines() or ["no reason given"]
        raise InputError(f"--run: the run does not reach its end; {said[-1]}")
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def _columns(rows: list[dict[str, str]], names: list[str]) -> Floats:
    def found(row: dict[str, str], name: str) -> float:
        column = next(key for key in row if key.partition(" ")[0] == name)
        return float(row[column])

    return np.array([[found(row, name) for name in names] for row in rows])
