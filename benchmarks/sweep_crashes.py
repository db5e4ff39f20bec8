"""``python -m benchmarks.sweep_crashes``: a sweep whose processes are killed at random instants.

Workers, the scheduler of a Dask cluster, and the whole tree of processes are ended by SIGKILL, each
so many times; where a sweep ends by it, it is resumed. At the end the rows must be those of a sweep
that nobody disturbed: as many, each once, with the same bits. Linux alone, which tells the children
of a process.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from random import Random
from typing import Annotated, BinaryIO, NamedTuple

import numpy as np
import typer

from runtime.sweeps.store import open_store
from runtime.sweeps.study import load_study

ROOT = Path(__file__).resolve().parent.parent
MODES = ("worker", "scheduler", "whole")
SETTINGS = {  # as docs/how-to/sweeps.md advises: they take 5 % and 3 % of each worker's processor
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "1s",
}
COMPARED = ("outcome", "message", "t_last")


class Campaign(NamedTuple):
    """What is swept, and how often it is disturbed."""

    folder: Path
    side: int  # of a grid of side x side runs
    kills: int
    draw: Random
    t_end: float = 1.0

    def command(self, store: str, *words: str) -> list[str]:
        """The command of a sweep, which goes on where its store exists."""
        return [
            *(sys.executable, "-m", "runtime", "sweep", "slider_crank", "--scene", "compressor"),
            *("--over", f"J1=200:1000:{self.side}"),
            *("--over", f"motor_torque=35000:50000:{self.side}"),
            *("--quantity", "max:B.fx", "--quantity", "crank.omega", "--quantity", "event:gas"),
            *("--t-end", str(self.t_end), "--out", str(self.folder / store), "--resume", *words),
        ]

    def start(self, store: str, *words: str) -> "subprocess.Popen[bytes]":
        """A sweep in a session of its own."""
        with (self.folder / "sweep.log").open("ab") as log:
            return subprocess.Popen(
                self.command(store, *words), cwd=ROOT, start_new_session=True, stderr=log
            )


def descendants(pid: int) -> list[int]:
    """The processes that a process has started, and those that these have."""
    found = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            children = [int(word) for word in task.read_text().split()]
        except OSError:
            continue
        for child in children:
            found += [child, *descendants(child)]
    return found


def kill(*pids: int) -> int:
    """End processes by SIGKILL; how many there were."""
    count = 0
    for pid in pids:
        try:
            os.kill(pid, signal.SIGKILL)
            count += 1
        except ProcessLookupError:
            continue
    return count


def _service(command: list[str], log: BinaryIO) -> "subprocess.Popen[bytes]":
    return subprocess.Popen(
        command, cwd=ROOT, stdout=log, stderr=log, env={**os.environ, **SETTINGS}
    )


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[tuple[str, "subprocess.Popen[bytes]"]]:
    """A real scheduler and workers, as processes; the address and the scheduler's process."""
    file = folder / f"scheduler-{time.monotonic_ns()}.json"
    program = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    processes = []
    with (folder / "cluster.log").open("ab") as log:
        words = ("--port", "0", "--no-dashboard", "--scheduler-file", str(file))
        processes.append(_service([*program, *words], log))
        while not file.exists():
            time.sleep(0.05)
        program = [sys.executable, "-m", "distributed.cli.dask_worker"]
        more = ("--nthreads", "1", "--no-dashboard", "--scheduler-file", str(file))
        command = [*program, *more, "--death-timeout", "60", "--local-directory", str(folder)]
        processes += [_service(command, log) for _ in range(workers)]
    try:
        yield json.loads(file.read_text())["address"], processes[0]
    finally:
        kill(*(pid for one in processes for pid in (*descendants(one.pid), one.pid)))
        for one in processes:
            one.wait()


def undisturbed(campaign: Campaign) -> float:
    """The reference, by one process; its time in s."""
    began = time.perf_counter()
    process = campaign.start("reference.zarr", "--workers", "1")
    assert process.wait() == 0, (campaign.folder / "sweep.log").read_text()
    return time.perf_counter() - began


def disturbed(campaign: Campaign, mode: str) -> int:
    """A sweep that is disturbed; how often its processes were killed."""
    store, kills, begun = f"{mode}.zarr", 0, 0
    while True:
        begun += 1
        if mode == "scheduler":
            with cluster(campaign.folder, 2) as (address, scheduler):
                process = campaign.start(store, "--scheduler", address)
                if kills < campaign.kills and wait(campaign, store, process, kills):
                    kills += kill(scheduler.pid)
                status = process.wait()
        else:
            process = campaign.start(store, "--workers", "2")
            while kills < campaign.kills and wait(campaign, store, process, kills):
                below = descendants(process.pid)
                if mode == "whole":
                    kills += bool(kill(process.pid, *below))
                    break
                kills += kill(campaign.draw.choice(below)) if below else 0
            status = process.wait()
        if status == 0:
            return kills
        assert begun < 5 * campaign.kills + 5, (campaign.folder / "sweep.log").read_text()


def runs_made(store: Path) -> int:
    """Number of the runs of a store that have been written."""
    if not store.exists():
        return 0
    return int((open_store(store).columns["outcome"][:] != "").sum())


def wait(campaign: Campaign, store: str, process: "subprocess.Popen[bytes]", kills: int) -> bool:
    """Wait until some runs more are made, drawn at random so that every kill finds one to make.

    False if the sweep ends before.
    """
    path, runs = campaign.folder / store, campaign.side**2
    share, delay = campaign.draw.random(), campaign.draw.uniform(0.0, 0.05)
    before = runs_made(path)
    wanted = before + 1 + int(share * (runs - before - 1) / (campaign.kills - kills + 1))
    while process.poll() is None:
        if runs_made(path) >= wanted:
            time.sleep(delay)
            return process.poll() is None
        time.sleep(0.01)
    return False


def judge(campaign: Campaign, store: str) -> str:
    """What is wrong with the rows of a store; nothing if they are those of the reference."""
    path = campaign.folder / store
    if len(open_store(path).unmade()):
        return "runs are not made"
    study, reference = load_study(path), load_study(campaign.folder / "reference.zarr")
    if len(study) != campaign.side**2 or not study.complete:
        return f"{len(study)} rows, {study.outcomes}"
    for name in (*study.factors, *study.quantities, *COMPARED):
        ours, theirs = (one.data[name].values for one in (study, reference))
        if ours.dtype.kind == "f":
            ours, theirs = ours.view(np.uint64), theirs.view(np.uint64)
        if not (ours == theirs).all():
            return f"{int((ours != theirs).sum())} rows differ in {name}"
    return ""


def main(
    side: Annotated[int, typer.Option(help="Runs of the grid along each of two axes.")] = 100,
    kills: Annotated[int, typer.Option(help="Kills of each kind.")] = 5,
    seed: Annotated[int, typer.Option(help="Seed of the instants.")] = 0,
    mode: Annotated[list[str] | None, typer.Option(help="worker, scheduler, whole.")] = None,
) -> None:
    """Disturb sweeps, and compare them with one that nobody disturbed."""
    with tempfile.TemporaryDirectory(prefix="sweep-crashes-") as folder:
        campaign = Campaign(Path(folder), side, kills, Random(seed))
        seconds = undisturbed(campaign)
        print(f"undisturbed, one process: {side**2} runs in {seconds:.1f} s")
        failed = False
        for one in mode or MODES:
            began = time.perf_counter()
            count = disturbed(campaign, one)
            found = judge(campaign, f"{one}.zarr")
            failed |= bool(found) or count < kills
            took = time.perf_counter() - began
            verdict = found or f"{side**2} rows, each once, bit for bit those of the reference"
            print(f"{one}: killed {count} times, {took:.1f} s; {verdict}", flush=True)
    raise SystemExit(failed)


if __name__ == "__main__":
    typer.run(main)
