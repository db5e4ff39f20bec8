"""Processes killed at random instants: `python -m tests.robustness.kills [TRIES]`.

A killed process can clean up nothing. Whatever it leaves, the files that it writes are there as
they should be or not at all, and the next process reaches its end with the same result.
"""

import os
import random
import shutil
import signal
import time
from pathlib import Path

from tests.robustness.command_line import Findings, Workplace, main, processor_seconds

COMMAND = (
    *("runtime", "simulate", "rods", "--scene", "free", "--t-end", "20", "--points", "4001"),
    *("--out", "result.csv"),
)
CHECKED = 10  # tries, after which a process must reach its end


def campaign(place: Workplace, tries: int, seed: int) -> Findings:
    """What the killed processes left, by kind, and what was wrong."""
    place.found = Findings.none()
    chance, (kinds, faults) = random.Random(seed), place.found
    whole = place.run(*COMMAND).work  # with the build and all compilation
    expected = {path: path.read_bytes() for path in _written(place)}
    quick = place.run(*COMMAND).work
    for attempt in range(tries):
        fresh = chance.choice(["as it is", "as it is", "without a module", "without machine code"])
        (place.folder / "result.csv").unlink(missing_ok=True)
        if fresh == "without a module":
            shutil.rmtree(place.folder / "generated", ignore_errors=True)
        elif fresh == "without machine code":
            for path in place.code.glob("generated*/rods*"):
                path.unlink()
        process = place.start(*COMMAND)
        instant = chance.uniform(0.0, quick if fresh == "as it is" else whole)
        while processor_seconds(process.pid) < instant and process.poll() is None:
            time.sleep(0.002)
        place.end(process, (signal.SIGKILL,))
        for path in _written(place):
            if path.read_bytes() != expected[path]:
                faults.append(f"{attempt}: {path} is half after {instant:.2f} s")
        kinds[f"{fresh}: {'a' if (place.folder / 'result.csv').exists() else 'no'} result"] += 1
        if (attempt + 1) % CHECKED == 0 or attempt + 1 == tries:
            faults += [f"{attempt}: {fault}" for fault in _check(place, expected)]
    return place.found


def _check(place: Workplace, expected: dict[Path, bytes]) -> list[str]:
    """What is wrong with the next process; it removes what others left long ago."""
    for left in place.leftovers():
        os.utime(left, (0, 0))
    (place.folder / "generated" / "rods__free.py").unlink(missing_ok=True)
    end = place.run(*COMMAND)
    faults = [] if end.status == 0 else [f"status {end.status}: {end.output[-1000:]}"]
    for path, content in expected.items():
        if not path.exists() or path.read_bytes() != content:
            faults.append(f"{path} is another one")
    return faults + [f"{path} is left" for path in place.leftovers()]


def _written(place: Workplace) -> list[Path]:
    return [*place.folder.glob("result.csv"), *place.folder.glob("generated/*.py")]


if __name__ == "__main__":
    main(__doc__, campaign)
