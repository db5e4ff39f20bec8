"""The cost of a run of a scene: steps, evaluations, events and wall time.

This is the one place where the compiler uses the runtime: when a run is requested, not when the
module is imported. The import rules name the exception.
"""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from codegen.errors import InputError
from codegen.explain.kernel_timer import Floats
from codegen.explain.sample_states import COUNT

MEASURED = 2  # measured: runs of which the faster counts; the first may find cold caches


@dataclass(frozen=True)
class Run:
    """A run with the scene's defaults.

    Attributes
    ----------
    evaluations, steps, rejected, retakes
        Evaluations of `accelerations`; steps accepted, rejected for their error, and repeated for
        the location of events.
    seconds
        Wall time of the integration.
    events
        Effect → number of its events.
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


def simulate(model: Path, scene: str, t_end: float) -> Run:
    """Simulate a declared scene of a model file, `MEASURED` times.

    Raises
    ------
    InputError
        If the run does not reach its end, with the runtime's message.
    """
    from runtime import load

    machine = load(model, scene)
    instants = np.linspace(0.0, t_end, COUNT)
    results = [machine.simulate(t_end, instants, progress=False) for _ in range(MEASURED)]
    first = results[0]
    if first.failed:
        raise InputError(f"--run: the run does not reach its end; {first.message}")
    return Run(
        t_end,
        int(first.stats["rhs_evaluations"]),
        int(first.stats["steps"]),
        int(first.stats["rejected"]),
        int(first.stats["retakes"]),
        min(result.stats["integration_seconds"] for result in results),
        Counter(event.name.partition(":")[0] for event in first.events),
        first.samples.t,
        first.samples.q,
        first.samples.v,
    )
