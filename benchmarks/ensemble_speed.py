"""An ensemble of compressors: in one thread, in two, and as a loop of single runs.

All make the same rows, which is checked bit by bit on a sample. Wall-clock times say what a user
waits, on a machine without other work; processor times hardly depend on that. Turns alternate, and
the least times count.
"""

from dataclasses import dataclass
from time import perf_counter, process_time
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from benchmarks.report import Report, records, verdict

if TYPE_CHECKING:
    import xarray as xr

    from runtime.machine_facade import Machine

RUNS = 10_000
FASTER = 1.8
"""Two threads, in times of one: at least."""
_INSTANTS = np.linspace(0.0, 1.0, 51)  # s
_SAMPLE = 200  # single runs, which say what the others take
_THREADS = (1, 2)


@dataclass(frozen=True)
class Row:
    """A way to make the runs; times in ms a run."""

    way: str
    runs: int
    wall: float
    processor: float
    equal: int  # rows that were compared with single runs, all of them equal bit by bit


def compare(machine: "Machine", found: "xr.Dataset", inertias: npt.NDArray[np.float64]) -> int:
    """How many rows have the bits and the words of single runs; raises AssertionError if not."""
    places = range(0, len(inertias), max(1, len(inertias) // _SAMPLE))
    for run in places:
        parameters = {"J1": float(inertias[run])}
        single = machine.simulate(1.0, _INSTANTS, parameters=parameters, progress=False)
        assert found["outcome"].values[run] == str(single.outcome)
        assert found["message"].values[run] == single.message
        for name, variable in single.data.data_vars.items():
            np.testing.assert_array_equal(found[name].values[run], variable.values)
    return len(places)


def measure(runs: int = RUNS, turns: int = 3) -> list[Row]:
    """The loop of single runs, of a sample, then ensembles in one and in two threads."""
    from runtime import load

    machine = load("slider_crank", scene="compressor")
    inertias = np.linspace(200.0, 1000.0, runs)
    machine.ensemble(1.0, _INSTANTS, parameters={"J1": inertias[:8]}, threads=2, progress=False)
    walls, processors = np.full((2, turns, 1 + len(_THREADS)), np.inf)
    equal = 0
    for turn in range(turns):
        chosen = inertias[:: max(1, runs // _SAMPLE)]
        began, before = perf_counter(), process_time()
        for inertia in chosen:
            machine.simulate(1.0, _INSTANTS, parameters={"J1": float(inertia)}, progress=False)
        walls[turn, 0] = (perf_counter() - began) / len(chosen)
        processors[turn, 0] = (process_time() - before) / len(chosen)
        for column, threads in enumerate(_THREADS, start=1):
            began, before = perf_counter(), process_time()
            found = machine.ensemble(
                1.0, _INSTANTS, parameters={"J1": inertias}, threads=threads, progress=False
            )
            walls[turn, column] = (perf_counter() - began) / runs
            processors[turn, column] = (process_time() - before) / runs
            if turn == 0:
                equal = compare(machine, found, inertias)
    counts = (len(inertias[:: max(1, runs // _SAMPLE)]), runs, runs)
    ways = ("simulate, one after the other", "ensemble, one thread", "ensemble, two threads")
    return [
        Row(way, count, float(wall), float(processor), 0 if way.startswith("simulate") else equal)
        for way, count, wall, processor in zip(
            ways, counts, 1e3 * walls.min(axis=0), 1e3 * processors.min(axis=0), strict=True
        )
    ]


def report(quick: bool) -> list[Report]:
    """The table and its verdict."""
    rows = measure(*((400, 1) if quick else (RUNS, 3)))
    single, one, two = rows
    table = [
        (row.way, str(row.runs), f"{row.wall:.3f}", f"{row.processor:.3f}", str(row.equal))
        for row in rows
    ]
    processor = (
        f"One thread is {single.processor / one.processor:.2f} times as fast as single runs, and "
        f"two take {two.processor / one.processor:.2f} times its processor time."
    )
    times = verdict("Two threads, in times of one:", two.wall / one.wall, 1.0 / FASTER)
    headings = ("way", "runs", "ms a run", "ms of the processor", "rows compared")
    title = "ensemble: compressors of other inertias, 1 s each"
    return [Report("ensemble", title, headings, table, (times, processor), records(rows))]
