"""Time and threads of one session of a sweep, and what is refused before it begins."""

import threading
from pathlib import Path
from typing import Any

import pytest

from codegen.errors import InputError
from runtime import sweep
from runtime.sweeps import execution, run_sweep, statistics
from runtime.sweeps.block import BlockReport
from runtime.sweeps.execution import Execution


@pytest.mark.parametrize(
    ("simulation", "overhead", "text"),
    [
        (0.0, 0.0, "3 runs in 2.0 s"),
        (0.0, 1.0, "3 runs in 2.0 s"),
        (1.5, 0.5, "3 runs in 2.0 s; 75.0% of the processor time is simulation"),
    ],
)
def test_times_of_a_session(simulation: float, overhead: float, text: str) -> None:
    there = Execution(3, 2.0, simulation, overhead, 1, 0, stopped=False)
    assert statistics._time(there) == text


def test_members_that_were_run_beforehand_count_with_their_time(
    about: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real, clock, made = run_sweep.estimate_of, [100.0], list[Any]()

    def estimate(*arguments: Any) -> Any:
        clock[0] += 7.0
        made.append(real(*arguments)._replace(simulation=5.0, overhead=2.0))
        return made[0]

    def report(job: Any, number: int) -> BlockReport:
        clock[0] += 1.0
        return BlockReport(number, 1, 0.75, 0.25)

    monkeypatch.setattr(run_sweep, "estimate_of", estimate)
    monkeypatch.setattr("time.perf_counter", lambda: clock[0])
    monkeypatch.setattr("runtime.sweeps.block.run_block", report)
    monkeypatch.setattr(execution, "_require_rows", lambda *arguments: None)
    found = sweep(over={"J1": [200.0, 300.0]}, out=tmp_path / "s.zarr", workers=0, **about)
    there = found._execution
    assert there is not None
    assert (there.runs, there.seconds) == (2, 7.0 + 2.0)
    assert (there.simulation, there.overhead) == (5.0 + 1.5, 2.0 + 0.5)


def test_loading_and_compiling_are_no_simulation(
    about: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from runtime.sweeps import planning

    clock, real, made = [0.0], run_sweep.estimate_of, list[Any]()
    times = iter([5.0, 0.25, 0.25])  # s, of which the first compiles
    evaluate = planning.evaluate_member

    def slow(*arguments: Any) -> Any:
        found = evaluate(*arguments)
        clock[0] += next(times)
        return found

    monkeypatch.setattr(planning.time, "process_time", lambda: clock[0])
    monkeypatch.setattr(planning, "evaluate_member", slow)
    monkeypatch.setattr(run_sweep, "estimate_of", lambda *x: made.append(real(*x)) or made[0])
    sweep(over={"J1": "200:300:3"}, out=tmp_path / "s.zarr", workers=0, **about)
    assert (made[0].seconds, made[0].simulation, made[0].overhead) == (0.25, 0.75, 4.75)


def test_a_library_that_does_not_import_ends_no_sweep() -> None:
    failures = list[Any]()
    before, threading.excepthook = threading.excepthook, failures.append
    try:
        thread = threading.Thread(target=execution._import_ahead, args=("no_such_library",))
        thread.start()
        thread.join()
    finally:
        threading.excepthook = before
    assert failures == []


def test_libraries_are_imported_by_a_thread_that_keeps_no_process(
    about: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real, daemons = threading.Thread, list[bool]()

    def noted(*arguments: Any, **words: Any) -> threading.Thread:
        if words.get("target") is execution._import_ahead:
            daemons.append(words.get("daemon", False))
        return real(*arguments, **words)

    monkeypatch.setattr(threading, "Thread", noted)
    sweep(over={"J1": [200.0, 300.0]}, out=tmp_path / "s.zarr", workers=1, **about)
    assert daemons == [True]


class LostClient:
    """A client whose scheduler ends between its answer and the first question."""

    closed = 0

    def __init__(self, *arguments: Any, **words: Any) -> None:
        pass

    def nthreads(self) -> Any:
        raise RuntimeError("the stream is closed")

    def close(self, **words: Any) -> None:
        type(self).closed += 1


def test_a_scheduler_that_ends_at_once_is_an_input_error(monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed")
    from runtime.sweeps.dask_cluster import ClusterWorkers

    monkeypatch.setattr(distributed, "Client", LostClient)
    with pytest.raises(InputError, match=r"No Dask scheduler answers at tcp://x \(the stream is"):
        ClusterWorkers("tcp://x")
    assert LostClient.closed == 1


def test_a_store_that_exists_is_refused_before_a_model_is_loaded(
    about: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "s.zarr").mkdir()
    monkeypatch.setattr(run_sweep, "load", lambda *x, **y: pytest.fail("a model is loaded"))
    with pytest.raises(InputError) as raised:
        sweep(over={"J1": "1:2:x"}, out=tmp_path / "s.zarr", **about)
    assert len(raised.value.problems) == 2  # of the values, and of the place
    assert "overwrites nothing" in raised.value.problems[1]
    assert "s.zarr" in str(raised.value)
