"""The command line in a process of its own, with caches of its own, for campaigns that harm it."""

import argparse
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from codegen.machine_code.code_folders import unique_name

ROOT = Path(__file__).resolve().parents[2]
MODEL = """\
from codegen import Model, t

model = Model("rods", gravity=(0, -9.81))
first = model.body("first", 1.0, 0.1)
second = model.body("second", 1.0, 0.1)
model.revolute("A", model.ground.at(0, 0), first.at(-0.5, 0))
model.revolute("B", first.at(0.5, 0), second.at(-0.5, 0))
model.spring("brake", first.at(0.5, 0), model.ground.at(0, 2), damping=1e-3)
model.driver("turn", first.phi, 0.5 * t)
model.driver("swing", second.phi, 0.3 * t)
model.scene("free", ["gravity", "brake"])
model.scene("driven", ["gravity"], ["turn", "swing"])
"""


FOREIGN = ("Traceback", "free()", "double free", "Aborted", "core dumped", "Exception ignored")
"""Words that are not ours."""


class Findings(NamedTuple):
    """What a campaign has found."""

    kinds: Counter[str]  # ends by their kind
    faults: list[str]

    @classmethod
    def none(cls) -> "Findings":
        """Nothing yet."""
        return cls(Counter(), [])


class End(NamedTuple):
    """How a process ended."""

    status: int  # as a shell tells it: 128 + number where a signal ended it
    wall: float  # s, from the first signal to the end, or the whole time
    work: float  # s of processor time over the same time
    before: float  # s of processor time up to the first signal
    output: str  # of stdout and stderr


class Workplace:
    """A folder with a model, in which commands run; none of its caches is anybody else's.

    The runtime's machine code is copied from where it lies beside the sources, so that it need not
    be compiled.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.code, self.byte_code = folder, folder / "code", folder / "byte_code"
        self.found = Findings.none()  # of the campaign that is under way
        (folder / "models").mkdir(parents=True)
        (folder / "models" / "rods.py").write_text(MODEL)
        self._copy(ROOT / "runtime")
        self._copy(ROOT / "codegen" / "machine_code")

    def _copy(self, beside: Path) -> None:
        target = self.code / unique_name(beside)
        for cache in beside.glob("__pycache__/lw-*"):
            shutil.copytree(cache, target / cache.name)

    def start(self, *command: str) -> subprocess.Popen[str]:
        """Start `python -m COMMAND`, with the signals as a terminal leaves them."""

        def usual_signals() -> None:
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                signal.signal(number, signal.SIG_DFL)

        environment = {
            **os.environ,
            "NUMBA_CACHE_DIR": str(self.code),
            "PYTHONPYCACHEPREFIX": str(self.byte_code),
            "PYTHONPATH": str(ROOT),
        }
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        with (self.folder / "output").open("w") as output:
            self.process = subprocess.Popen(
                [sys.executable, "-m", *command], cwd=self.folder, env=environment, text=True,
                stdin=subprocess.DEVNULL, stdout=output, stderr=output,
                preexec_fn=usual_signals,  # noqa: PLW1509 (the process has one thread)
            )  # fmt: skip
        return self.process

    def end(
        self, process: "subprocess.Popen[str]", numbers: Sequence[int] = (), gap: float = 0.1,
        limit: float = 600.0,
    ) -> End:  # fmt: skip
        """Send signals, `gap` s apart, and wait; a process that does not end is killed."""
        before, began = processor_seconds(process.pid), time.monotonic()
        for count, number in enumerate(numbers):
            if count:
                time.sleep(gap)
            if process.poll() is None:
                process.send_signal(number)
        at_start = _children()
        try:
            process.wait(limit)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        code, used = process.returncode, _children() - at_start
        output = (self.folder / "output").read_text(errors="replace")
        wall = time.monotonic() - began
        return End(code if code >= 0 else 128 - code, wall, used - before, before, output)

    def run(self, *command: str) -> End:
        """Run a command to its end."""
        return self.end(self.start(*command))

    def leftovers(self) -> list[Path]:
        """Temporary folders that are still there."""
        return list(self.folder.rglob(".linkwright-*"))


def processor_seconds(pid: int) -> float:
    """Processor time that a process and those that it has started have used; 0 if it is gone."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        started = descendants(pid)
    except OSError:
        return 0.0
    own = sum(int(field) for field in fields[11:15])  # of itself, and of those that have ended
    return own / os.sysconf("SC_CLK_TCK") + sum(processor_seconds(child) for child in started)


def descendants(pid: int) -> list[int]:
    """The processes that any thread of a process has started, and that have not ended."""
    threads = Path(f"/proc/{pid}/task").glob("*/children")
    return [int(child) for thread in threads for child in thread.read_text().split()]


def _children() -> float:
    times = os.times()
    return times.children_user + times.children_system


def main(title: str, campaign: Callable[[Workplace, int, int], Findings]) -> None:
    """Run a campaign by its command: tries and seed in, kinds and faults out."""
    parser = argparse.ArgumentParser(description=title)
    parser.add_argument("tries", type=int, nargs="?", default=200)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    for number in (signal.SIGINT, signal.SIGTERM):  # what was found until then is told
        signal.signal(number, signal.default_int_handler)
    with tempfile.TemporaryDirectory() as folder:
        place = Workplace(Path(folder) / "work")
        try:
            found = campaign(place, arguments.tries, arguments.seed)
        except KeyboardInterrupt:
            found = place.found
            place.process.kill()
    lines = [f"{count:4d} {kind}" for kind, count in found.kinds.items()]
    tries = f"{found.kinds.total()} of {arguments.tries} tries"
    last = f"{len(found.faults)} faults in {tries}, seed {arguments.seed}\n"
    sys.stdout.write("\n".join([*lines, *found.faults, last]))
    sys.exit(bool(found.faults))
