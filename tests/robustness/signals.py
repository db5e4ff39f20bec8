"""SIGINT, SIGTERM and SIGHUP at random instants: `python -m tests.robustness.signals [TRIES]`.

A process must end within a second of work, with the status 128 + number; what it computed must lie
in the file that was asked for, and nothing else beside it. Before the first line of the library,
Python answers signals in its own way; there the process must end, and nothing more is asked. A
program of a user's own meets SIGINT as a KeyboardInterrupt, or as the outcome of its run.
"""

import csv
import random
import shutil
import signal
import time
from collections.abc import Sequence

from tests.robustness.command_line import FOREIGN, End, Findings, Workplace, main, processor_seconds

RUN = ("rods", "--t-end", "1e6", "--points", "2001", "--out", "result.csv")
COMMANDS = (
    ("runtime", "simulate", *RUN, "--scene", "free"),
    ("runtime", "simulate", *RUN, "--scene", "free", "--accuracy", "1e-9"),
    ("runtime", "simulate", *RUN, "--scene", "free", "--method", "radau5"),
    ("runtime", "kinematics", *RUN, "--scene", "driven"),
    ("codegen", "build", "rods", "--out", "elsewhere"),
    ("program", "1e6"),
)
LAST_SCENE = "rods, scene driven: written"  # what a build says when all of it is there
KERNELS = "generated*/rods*.lwo"
PROGRAM = """
import sys
from runtime import load

print(load("rods", "free").simulate(float(sys.argv[1]), [0.0, float(sys.argv[1])]).outcome)
"""
SIGNALS = (
    (signal.SIGINT,), (signal.SIGTERM,), (signal.SIGHUP,), (signal.SIGINT,) * 3,
    (signal.SIGTERM, signal.SIGTERM, signal.SIGINT),
)  # fmt: skip
PYTHON = 0.1  # s of processor time in which Python, and not yet the library, is at work, at most
COLD = 0.2  # share of the tries that compile their kernels
WITHIN = 1.0  # s of processor time from a signal to the end: other processes take no part in it


def campaign(
    place: Workplace, tries: int, seed: int, commands: Sequence[tuple[str, ...]] = COMMANDS
) -> Findings:
    """Ends by their kind, and what was wrong."""
    place.found = Findings.none()
    chance, (ends, wrong) = random.Random(seed), place.found
    (place.folder / "program.py").write_text(PROGRAM)
    start_up = {command: _start_up(place, command) for command in commands}
    whole = len(list(place.code.glob(KERNELS)))
    for attempt in range(tries):
        command, numbers = chance.choice(commands), chance.choice(SIGNALS)
        if command[0] == "program":
            numbers = SIGNALS[0]
        shutil.rmtree(place.folder / "elsewhere", ignore_errors=True)
        (place.folder / "result.csv").unlink(missing_ok=True)
        if chance.random() < COLD:
            for path in place.code.glob(KERNELS):
                path.unlink()
        cold = len(list(place.code.glob(KERNELS))) < whole
        process = place.start(*command)
        instant = chance.uniform(0.0, 1.5 * start_up[command])  # s of processor time
        while processor_seconds(process.pid) < instant and process.poll() is None:
            time.sleep(0.002)
        running = process.poll() is None
        end = place.end(process, numbers)
        computing = not cold and end.before > 1.3 * start_up[command]
        kind, faults = judge(place, end, numbers[0], computing)
        if command[0] == "program":
            kind, faults = judge_program(end)
        ends[kind if running else "ended by itself"] += 1
        title = f"{attempt}: {' '.join(command[:2])}, {' '.join(n.name for n in numbers)}"
        wrong += [f"{title} after {end.before:.2f} s: {fault}" for fault in faults if running]
    return place.found


def judge(place: Workplace, end: End, number: int, computing: bool) -> tuple[str, list[str]]:
    """How a process ended, and what was wrong with that; `computing`: surely it had begun to."""
    if end.before < PYTHON and end.status != 128 + number:
        return "in Python's own start", []
    faults = [] if end.status == 128 + number else [f"status {end.status}"]
    if end.work > WITHIN:
        faults.append(f"{end.work:.2f} s of work after it")
    if end.before > PYTHON:
        faults += [f"it says {word}" for word in FOREIGN if word in end.output]
    faults += [f"{path} is left" for path in place.leftovers()]
    result = place.folder / "result.csv"
    if LAST_SCENE in end.output:  # Python itself was at its end
        return "after all work", faults
    if not result.exists():
        if "nothing had been computed" not in end.output and end.before > PYTHON:
            faults.append(f"no word of what was computed: {end.output[-500:]}")
        if computing and not (place.folder / "elsewhere").exists():
            faults.append("the result is lost")
        return "before a result", faults
    with result.open(newline="") as file:
        rows = list(csv.reader(file))
    if len(rows) < 2 or any(len(row) != len(rows[0]) for row in rows):
        faults.append(f"the result is half: {len(rows)} rows")
    return "with a result", faults


def judge_program(end: End) -> tuple[str, list[str]]:
    """The same of a user's own program; a run that is interrupted does not end the program."""
    faults = [word for word in FOREIGN[1:] if word in end.output]
    if end.status == 0 and "INTERRUPTED" in end.output:
        return "a program that goes on", faults
    if end.before > PYTHON and (end.status != 130 or "KeyboardInterrupt" not in end.output):
        faults.append(f"status {end.status}: {end.output[-500:]}")
    if end.work > WITHIN:
        faults.append(f"{end.work:.2f} s of work after it")
    return "a program that ends", faults


def _start_up(place: Workplace, command: tuple[str, ...]) -> float:
    """Processor time of a command that has next to nothing to compute, s; the second one counts."""
    short = ["2" if word == "1e6" else word for word in command]
    place.run(*short)
    shutil.rmtree(place.folder / "elsewhere", ignore_errors=True)
    return place.run(*short).work


if __name__ == "__main__":
    main(__doc__, campaign)
