"""Simulations whose rows are written into a store while the run goes on.

What the run holds of its samples is one chunk, whatever their number. Its result has them mapped
from files, so that checks, plots and `Result.at` are those of any other result.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import InputError
from runtime.core.arrays import IntegerMatrix, Matrix, Vector
from runtime.dynamics.formulations import Coordinates
from runtime.dynamics.output_quantities import evaluate
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.dynamics.simulation import ends_early, run_prepared
from runtime.integrate.problem import Options
from runtime.mechanism.mechanism import Mechanism
from runtime.progress_bar import Progress
from runtime.results.export import check_place
from runtime.results.result import Result
from runtime.results.zarr_store import ResultStore


def refuse_store(mechanism: Mechanism, settings: Mapping[str, Any], until: Any) -> None:
    """Raise InputError with all that needs more than one run, or all its samples at once."""
    description, problems = mechanism.description, list[str]()
    if settings.get("accuracy") is not None:
        problems.append("accuracy= makes several runs; give rtol")
    if settings.get("formulation") == "reduced":
        problems.append('formulation="reduced" finds the other coordinates at the end of the run')
    if until is not None:
        problems.append("until= makes two runs; conditions of the scene make one")
    if any(row.reconnects for row in description.watched):
        problems.append("joints come and go in this scene, one run after the other")
    if description.work_rows:
        problems.append("works are sums over the whole run")
    if problems:
        raise InputError(
            f"{mechanism.title}: out= writes the rows of one run as they come, and {problem}. "
            "Leave out= away, and save the result: Result.save."
            for problem in problems
        )


class Writer:
    """Takes the samples of a run, computes all quantities and writes them chunk by chunk."""

    def __init__(self, store: ResultStore, mechanism: Mechanism, p: Vector) -> None:
        self.store, self.mechanism, self.p = store, mechanism, p
        self.waiting: list[tuple[Vector, Matrix, IntegerMatrix]] = []
        self.count = 0  # of rows that wait
        self.last: float | None = None  # instant of the last row, s

    def take(self, t: Vector, y: Matrix, modes: IntegerMatrix) -> None:
        """Write as many chunks as are full."""
        self.waiting.append((t, y, modes))
        self.count += len(t)
        self.last = float(t[-1])
        if self.count >= self.store.rows:
            self._write(self.count - self.count % self.store.rows)

    def finish(self) -> None:
        """Write the rows that are left."""
        if self.count:
            self._write(self.count)

    def _write(self, count: int) -> None:
        joined = map(np.concatenate, zip(*self.waiting, strict=True))
        t, y, modes = joined
        n, step = y.shape[1] // 2, self.store.rows
        self.waiting = [(t[count:], y[count:], modes[count:])] if count < len(t) else []
        self.count = len(t) - count
        for first in range(0, count, step):
            rows = slice(first, min(first + step, count))
            q, v = y[rows, :n], y[rows, n:]
            self.store.append(evaluate(self.mechanism, self.p, t[rows], q, v, modes[rows]))


def _check_place(path: Path) -> None:
    """Refuse a place at which no store can begin."""
    if path.suffix.lower() != ".zarr":
        raise InputError(
            f"out={str(path)!r}: rows are written into a Zarr store while the run goes on. "
            "Choose a name that ends in .zarr, or save the result: Result.save."
        )
    if path.exists():
        raise InputError(f"{path} is there already. Choose another name, or remove it.")
    check_place(path)


def simulate_into(
    out: Path, ready: PreparedSimulation, coordinates: Coordinates, options: Options,
    began: float, progress: Progress,
) -> Result:  # fmt: skip
    """The result of a simulation whose rows are written into a store at `out`.

    Where the run fails, the store has what was computed before, and the error.
    """
    mechanism = coordinates.mechanism
    _check_place(out)
    store = ResultStore(out, mechanism.description, ready.p)
    writer = Writer(store, mechanism, ready.p)
    try:
        run = ready.run(coordinates, replace(options, sink=writer.take), progress)
        if ends_early(mechanism, run) and (writer.last is None or run.final_t > writer.last):
            y = np.concatenate([run.final_q, run.final_v])[None]
            writer.take(np.array([run.final_t]), y, run.final_modes[None])
        writer.finish()
        samples = store.mapped()
        run = replace(run, t=samples.t, q=samples.q, v=samples.v, modes=samples.modes)
        result = run_prepared(
            ready, coordinates, options, began, progress, run, works=False, samples=samples
        )
    except BaseException as error:
        with suppress(Exception):
            writer.finish()
            store.fail(error)
        raise
    finally:
        store.close()
    store.finish(result.about())
    return result
