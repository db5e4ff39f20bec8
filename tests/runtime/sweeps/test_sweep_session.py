"""Time and threads of one session of a sweep, and what is refused before it begins."""

from pathlib import Path
from typing import Any

import pytest

from codegen.errors import InputError
from runtime import sweep
from runtime.sweeps import planning, statistics
from runtime.sweeps import sweep as in_sweep
from runtime.sweeps.block import BlockReport
from runtime.sweeps.execution import Execution
from runtime.sweeps.store import Store
from runtime.sweeps.workers import ClusterWorkers


@pytest.mark.parametrize(
    ("simulation", "overhead", "text"),
    [
        (0.0, 0.0, "3 runs in 2.0 s"),
        (0.0, 1.0, "3 runs in 2.0 s"),
        (1.5, 0.5, "3 runs in 2.0 s; 75.0% of the processor time is simulation"),
    ],
)
def test_times_of_a_session(simulation: float, overhead: float, text: str) -> None:
    there = Execution(3, 2.0, simulation, overhead, 0)
    assert statistics._time(there) == text


def test_members_that_were_run_beforehand_count_with_their_time(
    about: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real, clock, made = in_sweep.estimate_of, [100.0], list[Any]()

    def estimate(*arguments: Any) -> Any:
        clock[0] += 7.0
        made.append(real(*arguments)._replace(simulation=5.0, overhead=2.0))
        return made[0]

    def report(job: Any, number: int) -> BlockReport:
        clock[0] += 1.0
        return BlockReport(number, 1, 0.75, 0.25)

    monkeypatch.setattr(in_sweep, "estimate_of", estimate)
    monkeypatch.setattr("time.perf_counter", lambda: clock[0])
    monkeypatch.setattr("runtime.sweeps.workers.run_block", report)
    monkeypatch.setattr(Store, "unfinished", lambda *arguments: [])
    found = sweep(over={"J1": [200.0, 300.0]}, out=tmp_path / "s.zarr", workers=0, **about)
    there = found._execution
    assert there is not None
    assert (there.runs, there.seconds) == (2, 7.0 + 2.0)
    assert (there.simulation, there.overhead) == (5.0 + 1.5, 2.0 + 0.5)


def test_loading_and_compiling_are_no_simulation(
    about: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock, real, made = [0.0], in_sweep.estimate_of, list[Any]()
    times = iter([5.0, 0.25, 0.25])  # s, of which the first compiles
    evaluate = planning.evaluate_member

    def slow(*arguments: Any) -> Any:
        found = evaluate(*arguments)
        clock[0] += next(times)
        return found

    monkeypatch.setattr(planning.time, "process_time", lambda: clock[0])
    monkeypatch.setattr(planning, "evaluate_member", slow)
    monkeypatch.setattr(in_sweep, "estimate_of", lambda *x: made.append(real(*x)) or made[0])
    sweep(over={"J1": "200:300:3"}, out=tmp_path / "s.zarr", workers=0, **about)
    assert (made[0].seconds, made[0].simulation, made[0].overhead) == (0.25, 0.75, 4.75)


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
    monkeypatch.setattr(distributed, "Client", LostClient)
    with pytest.raises(InputError, match=r"No Dask scheduler answers at tcp://x \(the stream is"):
        ClusterWorkers("tcp://x")
    assert LostClient.closed == 1


def test_a_store_that_exists_is_refused_before_a_model_is_loaded(
    about: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "s.zarr").mkdir()
    monkeypatch.setattr(in_sweep, "load", lambda *x, **y: pytest.fail("a model is loaded"))
    with pytest.raises(InputError) as raised:
        sweep(over={"J1": "1:2:x"}, out=tmp_path / "s.zarr", **about)
    assert len(raised.value.problems) == 2  # of the values, and of the place
    assert "overwrites nothing" in raised.value.problems[1]
    assert "s.zarr" in str(raised.value)
