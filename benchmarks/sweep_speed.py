"""``python -m benchmarks.sweep_speed``: a sweep by one process, and by a Dask cluster of several.

Both make the same rows. Wall-clock times say what a user waits; where others use the machine as
well, the processor times of the processes say what the sweep itself takes: the speed-up is then the
processor time of the one process over that of the busiest of several, their start included.
Processes find their modules compiled to byte code, as those of a user do, from the second turn on.
"""

import os
import subprocess
import tempfile
import time
from pathlib import Path
from random import Random
from typing import Annotated, NamedTuple

import typer

from benchmarks.sweep_crashes import Campaign, cluster, descendants, judge

_TICK = os.sysconf("SC_CLK_TCK")


class Taken(NamedTuple):
    """What a sweep took."""

    wall: float  # s, from the command to its end
    busiest: float  # s of the processor, of the process that took most of those that run members


def processor_seconds(pid: int) -> float:
    """The processor time of a process so far, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICK


def measured(campaign: Campaign, store: str, *words: str, workers: tuple[int, ...] = ()) -> Taken:
    """Make a sweep; `workers` are processes of a cluster, which outlive it."""
    began = time.perf_counter()
    before = {pid: processor_seconds(pid) for pid in workers}
    process = subprocess.Popen(
        campaign.command(store, *words), stderr=subprocess.PIPE, text=True, cwd=campaign.folder
    )
    _, told = process.communicate()
    wall = time.perf_counter() - began
    assert process.returncode == 0, told
    used = [processor_seconds(pid) - start for pid, start in before.items()]
    if not used:
        ended = os.times()
        used = [ended.children_user + ended.children_system]
    return Taken(wall, max(used))


def main(
    side: Annotated[int, typer.Option(help="Runs of the grid along each of two axes.")] = 100,
    workers: Annotated[int, typer.Option(help="Processes of the cluster.")] = 2,
    rounds: Annotated[int, typer.Option(help="Turns, of which the least times count.")] = 2,
) -> None:
    """Measure both in turns."""
    with tempfile.TemporaryDirectory(prefix="sweep-speed-") as folder:
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        os.environ["PYTHONPYCACHEPREFIX"] = str(Path(folder, "byte-code"))
        campaign = Campaign(Path(folder), side, 0, Random(0))
        alone, together = list[Taken](), list[Taken]()
        for turn in range(rounds):
            before = os.times()
            one = measured(campaign, "reference.zarr" if not turn else f"one-{turn}.zarr",
                           "--workers", "0")  # fmt: skip
            earlier = before.children_user + before.children_system
            alone.append(one._replace(busiest=one.busiest - earlier))
            with cluster(Path(folder), workers) as (address, scheduler):
                time.sleep(5.0)  # until the workers have registered
                own = tuple(
                    pid
                    for pid in descendants(os.getpid())
                    if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()
                    and scheduler.pid != pid
                )
                name = f"cluster-{turn}.zarr"
                together.append(measured(campaign, name, "--scheduler", address, workers=own))
            assert judge(campaign, name) == "", judge(campaign, name)
        runs = side**2
        for title, taken in (("one process", alone), (f"cluster of {workers}", together)):
            wall, busiest = min(one.wall for one in taken), min(one.busiest for one in taken)
            print(
                f"{title}: {runs} runs in {wall:.1f} s; {busiest:.1f} s of the processor in the "
                "busiest process"
            )
        wall = min(one.wall for one in alone) / min(one.wall for one in together)
        busy = min(one.busiest for one in alone) / min(one.busiest for one in together)
        print(f"speed-up: {wall:.2f} by the wall clock, {busy:.2f} by processor time")


if __name__ == "__main__":
    typer.run(main)
