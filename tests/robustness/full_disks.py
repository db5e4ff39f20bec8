"""Disks that are full after a random number of bytes: `python -m tests.robustness.full_disks`.

Results in all formats, pictures and generated modules are written where a random number of bytes
has room: on a small disk of its own where that can be mounted, else under a limit of the size of
files. A file is written whole, or an error names it and an older one is as it was.
"""

import random
import resource
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from codegen import build
from codegen.errors import InputError
from runtime import load
from runtime.results.result import Result
from tests.robustness.command_line import Findings, Workplace, main

ENDINGS = (".nc", ".csv", ".parquet", ".html", ".py")


def campaign(place: Workplace, tries: int, seed: int) -> Findings:
    """Ends by their kind, and what was wrong."""
    place.found = Findings.none()
    chance, (kinds, faults) = random.Random(seed), place.found
    result = load("rods", "free", folder=place.folder).simulate(5.0, np.linspace(0.0, 5.0, 501))
    needed = {ending: _size(place, result, ending) for ending in ENDINGS}
    for attempt in range(tries):
        ending = chance.choice(ENDINGS)
        room = int(needed[ending] * chance.choice([0.0, 1.0, 1.3]) * chance.random())
        old = b"old" if chance.random() < 0.5 else None
        with _disk(place.folder / "disk", room, old) as folder:
            kind, found = write(place, result, ending, folder, old)
        kinds[f"{ending} {kind}"] += 1
        faults += [f"{attempt}: {ending}, room for {room} bytes: {fault}" for fault in found]
    return place.found


def write(
    place: Workplace, result: Result, ending: str, folder: Path, old: bytes | None
) -> tuple[str, list[str]]:
    """Write a file of this ending into a folder; how that went, and what was wrong."""
    module = ending == ".py"
    path, faults = folder / ("rods__free.py" if module else f"result{ending}"), list[str]()
    if old is not None:
        path.write_bytes(old)
    try:
        if module:
            build(place.folder / "models" / "rods.py", "free", folder, compile=False)
        else:
            result.save(path)
        kind = "written"
    except InputError as error:
        kind = "refused"
        if str(path) not in str(error) or "KiB free" not in str(error):
            faults.append(f"the error does not say what to do: {error}")
        if (path.read_bytes() if path.exists() else None) != old:
            faults.append("the older file is another one")
    except Exception as error:
        return "failed", [f"{type(error).__name__}: {error}"]
    if kind == "written" and ending == ".csv" and len(path.read_text().splitlines()) != 502:
        faults.append("the file is half")
    faults += [f"{left} is left" for left in folder.glob(".linkwright-*")]
    return kind, faults


@contextmanager
def _disk(folder: Path, room: int, old: bytes | None) -> Iterator[Path]:
    """A disk with room for about so many bytes beside an older file, or a limit of that size."""
    folder.mkdir(exist_ok=True)
    pages = max(1, room // 4096) + (old is not None)
    mount = ["mount", "-t", "tmpfs", "-o", f"size={pages * 4096}", "none", str(folder)]
    try:
        mounted = subprocess.run(mount, capture_output=True, check=False).returncode == 0
    except OSError:
        mounted = False
    limit, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    if not mounted:
        resource.setrlimit(resource.RLIMIT_FSIZE, (max(room, 4096), most))
    try:
        yield folder
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))
        if mounted:
            subprocess.run(["umount", str(folder)], check=True)
        shutil.rmtree(folder)


def _size(place: Workplace, result: Result, ending: str) -> int:
    folder = place.folder / "whole"
    folder.mkdir(exist_ok=True)
    write(place, result, ending, folder, None)
    return max(path.stat().st_size for path in folder.glob(f"*{ending}"))


if __name__ == "__main__":
    main(__doc__, campaign)
