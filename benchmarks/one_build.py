"""``python -m benchmarks.one_build FAMILY SIZE UNROLL FOLDER``: one build in a process of its own.

Prints the processor time of each stage, from the first import to the first call of the compiled
`accelerations`, that of the processes it starts included, the memory of all of them, and the path
of the module, as JSON.
"""

import json
import os
import resource
import sys
from collections.abc import Callable
from itertools import chain as joined
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.chain import SCENE, chain
from codegen import Model, build
from codegen.declare.symbols import dotted
from codegen.files.generated_modules import import_generated
from models.hard.n_four_bar import n_four_bar

FAMILIES: dict[str, tuple[Callable[[int], Model], str]] = {
    "chain": (chain, SCENE),
    "n_four_bar": (n_four_bar, "fall"),
}
STAGES = ("declare", "check", "derive", "lower", "examine", "emit", "compile")
Array = npt.NDArray[np.float64]


def processor_time() -> float:
    """That of this process and of those that it started and that have ended, s."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def memory() -> float:
    """A bound of what this process and those beside it took at the same time, in MB."""
    kinds = resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN
    alone, largest = (resource.getrusage(kind).ru_maxrss / 1024 for kind in kinds)
    return alone + (os.cpu_count() or 1) * largest


class Stages:
    """Processor time by stage, each from its announcement to that of the next."""

    def __init__(self) -> None:
        self.seconds = {"import": processor_time()} | dict.fromkeys(STAGES, 0.0)
        self._stage, self._began = "declare", processor_time()

    def begin(self, message: str) -> None:
        """End the stage before, and begin the one that a message of the driver ends with."""
        now, stage = processor_time(), message.rpartition(": ")[2]
        self.seconds[self._stage] += now - self._began
        self._stage, self._began = stage if stage in STAGES else "check", now


def start_of(model: Model, scene: str) -> Array:
    """The coordinates as the scene states or guesses them."""
    known = dict(joined(model.scenes[scene].guess, model.scenes[scene].start))
    names = (dotted(q) for body in model.bodies.values() for q in body.coordinates)
    return np.array([known.get(name, 0.0) for name in names])


def arrays(module: ModuleType) -> tuple[Array, Array, Array]:
    """Those of parameters, of which there are none, accelerations and multipliers."""
    p, a, lam = map(np.zeros, (0, len(module.COORDINATES), len(module.CONSTRAINTS)))
    return p, a, lam


def measured(family: str, size: int, unroll: Any, folder: Path) -> dict[str, Any]:
    """All that is printed."""
    stages, (declare, scene) = Stages(), FAMILIES[family]
    model = declare(size)
    report = build(model, scene, folder, unroll=unroll, progress=stages.begin)
    stages.begin("")
    module, q = import_generated(report.scenes[0].path), start_of(model, scene)
    p, a, lam = arrays(module)
    module.accelerations(0.0, q, 0.0 * q, p, np.zeros(0, dtype=np.int64), a, lam)
    path = str(report.scenes[0].path)
    whole = {"whole": processor_time(), "megabytes": memory()}
    return {"seconds": stages.seconds, **whole, "path": path}


if __name__ == "__main__":
    print(json.dumps(measured(sys.argv[1], int(sys.argv[2]), sys.argv[3], Path(sys.argv[4]))))
