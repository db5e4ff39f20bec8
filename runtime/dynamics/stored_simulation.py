"""Simulations whose rows are written into a store while the run goes on.

What the run holds of its samples is one chunk, whatever their number. Its result has them mapped
from files, so that checks, plots and `Result.at` are those of any other result.
"""

import time as clock
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import InputError
from runtime.core.arrays import IntegerMatrix, Matrix, Vector
from runtime.dynamics.output_quantities import evaluate
from runtime.dynamics.simulation import ends_early, prepare_run, require_memory_of, run_prepared
from runtime.mechanism.dense_equations import Equations
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

    def __init__(self, store: ResultStore, equations: Equations) -> None:
        self.store, self.equations = store, equations
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
        t, y, modes = map(np.concatenate, zip(*self.waiting, strict=True))
        n, step = y.shape[1] // 2, self.store.rows
        self.waiting = [(t[count:], y[count:], modes[count:])] if count < len(t) else []
        self.count = len(t) - count
        for first in range(0, count, step):
            rows = slice(first, min(first + step, count))
            q, v = y[rows, :n], y[rows, n:]
            self.store.append(evaluate(self.equations, t[rows], q, v, modes[rows]))


def simulate_into(
    out: Path, mechanism: Mechanism, t_end: float, t_eval: Any = None, *, progress: Progress,
    **settings: Any,
) -> Result:  # fmt: skip
    """The result of `simulate_joints`, whose rows are written into a store at `out`.

    Where the run fails, the store has what was computed before, and the error.
    """
    began = clock.perf_counter()
    require_memory_of(mechanism, t_eval, 0, "Take fewer instants, or t_eval='steps'.")
    coordinates, options = prepare_run(mechanism, t_end, t_eval, **settings)
    ready, description = coordinates.ready, coordinates.equations.description
    if out.suffix.lower() != ".zarr":
        raise InputError(
            f"out={str(out)!r}: rows are written into a Zarr store while the run goes on. "
            "Choose a name that ends in .zarr, or save the result: Result.save."
        )
    if out.exists():
        raise InputError(f"{out} is there already. Choose another name, or remove it.")
    check_place(out)
    store = ResultStore(out, description, ready.p)
    writer = Writer(store, coordinates.equations)
    try:
        run = ready.run(coordinates, replace(options, sink=writer.take), progress)
        if ends_early(description, run) and (writer.last is None or run.final_t > writer.last):
            y = np.concatenate([run.final_q, run.final_v])[None]
            writer.take(np.array([run.final_t]), y, run.final_modes[None])
        writer.finish()
        samples = store.mapped()
        run = run._replace(t=samples.t, q=samples.q, v=samples.v, modes=samples.modes)
        result = run_prepared(
            coordinates, options, began, progress, run, works=False, samples=samples
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
