"""The cost of a run of a scene: steps, evaluations, events and wall time.

This is the one place where the compiler uses the runtime: when a run is requested, not when the
module is imported. The import rules name the exception.
"""

from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen.errors import InputError
from codegen.explain.ledger_records import RunCosts
from codegen.explain.sample_states import COUNT

MEASURED = 2  # measured: runs of which the faster counts; the first may find cold caches


class Run(NamedTuple):
    """The costs of a run, effect → number of its events, and the states along it: t, q, v."""

    costs: RunCosts
    events: Counter[str]
    samples: Any


def simulate(model: Path, scene: str, t_end: float) -> Run:
    """Simulate a declared scene `MEASURED` times; InputError if it does not reach its end."""
    from runtime import load

    machine = load(model, scene)
    instants = np.linspace(0.0, t_end, COUNT)
    results = [machine.simulate(t_end, instants, progress=False) for _ in range(MEASURED)]
    first = results[0]
    if first.failed:
        raise InputError(f"--run: the run does not reach its end; {first.message}")
    events = Counter(event.name.partition(":")[0] for event in first.events)
    seconds = min(result.stats["integration_seconds"] for result in results)
    evaluations, steps, rejected, retakes = (
        int(first.stats[name]) for name in ("rhs_evaluations", "steps", "rejected", "retakes")
    )
    costs = RunCosts(t_end, evaluations, steps, rejected, retakes, events.total(), seconds)
    return Run(costs, events, first.samples)
