"""Tasks are handed to workers, which may end; a store takes the place of nothing else."""

import signal
from collections import Counter
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from codegen.errors import InputError, LinkwrightError
from codegen.termination_signals import SignalDeferral
from runtime import load, load_study
from runtime.sweeps.execution import LostWorkerError, Pool, _made_rows
from runtime.sweeps.request import KILLED, Rows, rows_without_runs
from runtime.sweeps.store import open_store
from runtime.sweeps.study import Study


def test_a_result_replaces_no_study(whole: Study, tmp_path: Path) -> None:
    result = load("slider_crank", scene="compressor").simulate(0.05, 21, progress=False)
    with pytest.raises(InputError, match="left alone"):
        result.save(whole.path)
    assert load_study(whole.path).complete
    result.save(tmp_path / "run.zarr")
    result.save(tmp_path / "run.zarr")
    xr.Dataset({"a": ("k", [1.0])}).to_zarr(
        tmp_path / "own.zarr", zarr_format=3, consolidated=False
    )
    with pytest.raises(InputError, match="left alone"):
        result.save(tmp_path / "own.zarr")


class Waiting(Pool):
    """Takes four tasks at a time; the workers of one run end, and one of another run once."""

    room = 4

    def __init__(self, asked: Any, stop_at: float = -1.0) -> None:
        self.request, self.taken, self.stop_at = asked, list[list[float]](), stop_at

    def submit(self, points: Any) -> "Future[Rows]":
        future, runs = Future[Rows](), points[:, 0].tolist()
        if 7.0 in runs or (13.0 in runs and runs not in self.taken and len(runs) > 1):
            future.set_exception(LostWorkerError("killed"))
        else:
            future.set_result(rows_without_runs(self.request, len(runs), "OK"))
        self.taken.append(runs)
        if self.stop_at in runs:
            signal.raise_signal(signal.SIGINT)
        return future


def test_a_run_at_which_workers_end_is_found_and_all_others_are_made_once(whole: Study) -> None:
    asked, points = open_store(whole.path).request, np.arange(20.0)[:, np.newaxis]
    tasks = [range(first, first + 5) for first in range(0, 20, 5)]
    with SignalDeferral(computing=True) as signals:
        pool = Waiting(asked)
        counts = Counter[range]()
        found = list(_made_rows(pool, points, tasks, signals, counts))
    outcomes = {
        run: text for runs, rows in found for run, text in zip(runs, rows.outcomes, strict=True)
    }
    assert outcomes == {run: KILLED if run == 7 else "OK" for run in range(20)}
    assert sum(len(runs) for runs, _ in found) == 20
    assert counts[range(7, 8)] == 3


def test_a_signal_ends_the_handing_out(whole: Study) -> None:
    asked, points = open_store(whole.path).request, np.arange(20.0)[:, np.newaxis]
    tasks = [range(run, run + 1) for run in range(20)]
    with SignalDeferral(computing=True) as signals:
        pool = Waiting(asked, stop_at=2.0)
        counts = Counter[range]()
        assert len(list(_made_rows(pool, points, tasks, signals, counts))) < 4
        signals.answered = True
    assert pool.taken == [[0.0], [1.0], [2.0]]


def test_workers_that_end_without_a_row_end_the_sweep(whole: Study) -> None:
    class Deadly(Waiting):
        def submit(self, points: Any) -> "Future[Rows]":
            future = Future[Rows]()
            future.set_exception(LostWorkerError("killed"))
            return future

    asked, points = open_store(whole.path).request, np.arange(1000.0)[:, np.newaxis]
    with SignalDeferral(computing=True) as signals:
        found = _made_rows(Deadly(asked), points, [range(1000)], signals, Counter())
        rows = list[range]()
        with pytest.raises(LinkwrightError, match="51 runs in a row have ended"):
            rows += (runs for runs, _ in found)
    assert len(rows) == 50
