"""Controlled chains against dense matrices and SciPy: `python -m ... 0 60`.

Every chain is built, compiled and run by two methods in both formulations; instants of what
changes, states, values and the end are compared. What a result says at other instants, what a file
gives back and what a state starts are compared with the run itself.
"""

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import LinkwrightError
from runtime import load, load_result
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.results.result import Result
from tests.random_mechanisms.controlled_chain_motion import ControlledMotion, Motion
from tests.random_mechanisms.controlled_chains import ControlledChain, controlled_chain
from tests.random_mechanisms.seed_range import run_campaign

METHODS = ("dop853", "dopri5", "radau5", "bdf", "tsit5", "auto")
FORMULATIONS = ("cartesian", "reduced")
OFF = {"bdf": 3e-6}  # of states, relative to their size and 1, at rtol 1e-10
MOST_OFF = 5e-7
INSTANT = 1e-6  # s: of changes and ends
SAMPLES = 17


def instants(chain: ControlledChain) -> Any:
    """The samples of a run."""
    return np.linspace(chain.begin, chain.end, SAMPLES)


def reference(chain: ControlledChain) -> Motion:
    """The motion by dense matrices, at the samples of a run."""
    return ControlledMotion(chain).run(instants(chain))


def judge(
    chain: ControlledChain, folder: Path, methods: Sequence[str],
    formulations: Sequence[str] = FORMULATIONS, motion: Motion | None = None,
) -> list[str]:  # fmt: skip
    """Build a chain, run it and compare it with `reference(chain)`; what differs, in words."""
    times = instants(chain)
    motion = motion or reference(chain)
    found = []
    machine = load(chain.model(), folder=folder)
    for method in methods:
        for formulation in formulations:
            try:
                r = machine.simulate(
                    chain.end, times, t_start=chain.begin, method=method, formulation=formulation,
                    rtol=1e-10, atol=1e-11, progress=False,
                )  # fmt: skip
                complaints = [*differences(chain, r, motion, OFF.get(method, MOST_OFF))]
                if method == methods[0]:
                    complaints += repetitions(machine, chain, r, folder)
            except LinkwrightError as error:
                complaints = [f"{type(error).__name__}: {error}"]
            found += [f"{method} {formulation}: {complaint}" for complaint in complaints]
    return found


def differences(chain: ControlledChain, r: Result, motion: Motion, most: float) -> Iterator[str]:
    """In what a result differs from the reference."""
    if r.outcome is not Outcome.OK:
        yield f"{r.outcome.name} {r.message[:300]}"
        return
    words = {("release", False): "release", ("engage", True): "engage", ("release", True): "unlock"}
    changes = [(one.time, words[one.action, one.joint == "lock"]) for one in r.reconnections]
    if [word for _, word in changes] != [word for _, word in motion.changes] or any(
        abs(ours - exact) > INSTANT
        for (ours, _), (exact, _) in zip(changes, motion.changes, strict=True)
    ):
        yield f"changes {changes}, expected {motion.changes}"
        return
    if abs(r.t[-1] - motion.end) > INSTANT or bool(r.ended_by) != motion.stopped:
        yield f"ends at {r.t[-1]} by {r.ended_by!r}, expected {motion.end}, {motion.stopped}"
        return
    worst, place = 0.0, ""
    for t, (y, values) in motion.samples.items():
        rows = np.flatnonzero(r.t == t)
        if not len(rows):
            yield f"no sample at {t}"
            continue
        changed = any(abs(t - at) < INSTANT for at, _ in changes)
        for name, (got, expected) in pairs(chain, r, int(rows[0]), y, changed).items():
            error = abs(got - expected) / (1.0 + abs(expected))
            if error > worst:
                worst, place = error, f"{name} at {t:.6g}: {got:.9g}, expected {expected:.9g}"
        yield from values_apart(chain, r, int(rows[0]), values)
    if worst > most:
        yield f"off by {worst:.1e}, {place}; changes {motion.changes}"


def pairs(
    chain: ControlledChain, r: Result, row: int, y: Any, changed: bool
) -> dict[str, tuple[float, float]]:
    """Values of a sample and of the reference by name; no velocities where joints change."""
    n, found = 3 * chain.rods, {}
    names = zip(("x", "y", "phi"), ("vx", "vy", "omega"), strict=True)
    for k, (place, rate) in enumerate(names):
        for i in range(chain.rods):
            found[f"b{i}.{place}"] = r.q(f"b{i}.{place}")[row], y[3 * i + k]
            if not changed:
                found[f"b{i}.{rate}"] = r.v(f"b{i}.{rate}")[row], y[n + 3 * i + k]
    if chain.motor is not None:
        found["current"] = r.y("current")[row], y[-2]
    return found


def values_apart(
    chain: ControlledChain, r: Result, row: int, values: dict[str, float]
) -> Iterator[str]:
    """Which of the values that are kept between samples differ; none where they are renewed."""
    t = float(r.t[row])
    renewed = [one.level for one in conditions(chain) if one.kind == "time"]
    if (clock := chain.controller) is not None:
        every = clock.every
        renewed += [round((t - by) / every) * every + by for by in (0.0, clock.delay)]
    if any(abs(t - at) < INSTANT for at in renewed):
        return
    has = {"u": chain.controller, "on": chain.latch, "count": chain.count}
    for name in (name for name, one in has.items() if one is not None):
        got = r.y(name)[row]
        if abs(got - values[name]) > 1e-5 and not _at_an_event(r, t):
            yield f"{name} at {t:.6g}: {got}, expected {values[name]}"


def _at_an_event(r: Result, t: float) -> bool:
    return any(abs(event.time - t) < INSTANT for event in r.events)


def conditions(chain: ControlledChain) -> list[Any]:
    """The conditions of a chain."""
    pushes = [p for p in (chain.latch, chain.push) if p is not None]
    given = [chain.count, chain.until, *(one for p in pushes for one in (p.when, p.reset))]
    given += [chain.release[1]] if chain.release else []
    return [one for one in given if one is not None]


def repetitions(machine: Machine, chain: ControlledChain, r: Result, folder: Path) -> Iterator[str]:
    """In what the run differs from itself: at instants, from a file, resumed, from a state."""
    if r.outcome is not Outcome.OK or len(r.t) < 2:
        return
    given = chain.begin + np.array([0.013, 0.111, 0.4])
    times = np.union1d(r.t[3:6], given)
    times = times[times < r.t[-1]]
    there = r.at(times)
    for t in np.intersect1d(times, r.t):
        ours, whole = (one.samples.v[np.flatnonzero(one.t == t)[0]] for one in (there, r))
        if ours.tobytes() != whole.tobytes():
            yield f"at({t}) differs by {np.abs(ours - whole).max():.1e}"
    back = load_result(r.save(folder / "run.nc"), machine).at(times)
    for name in ("q", "v"):
        ours, whole = getattr(back.samples, name), getattr(there.samples, name)
        if ours.tobytes() != whole.tobytes():
            yield f"{name} of the file differs by {np.nanmax(np.abs(ours - whole)):.1e}"
    if r.reconnections or r.ended_by or len(r.t) < SAMPLES:
        return
    middle, settings = r.t[7], {"rtol": 1e-10, "atol": 1e-11, "progress": False}
    half = machine.simulate(float(middle), r.t[:8], t_start=chain.begin, **settings)
    rest = machine.simulate(chain.end, r.t[8:], start=half.state(), **settings)
    apart = np.abs(rest.samples.v - r.samples.v[8:]).max()
    if half.reconnections == () and apart > 1e-5:
        yield f"from a state: differs by {apart:.1e}"


def judge_seed(seed: int) -> tuple[list[str], str]:
    """Complaints of the chain of a seed, and its parts."""
    chain = controlled_chain(seed)
    with tempfile.TemporaryDirectory() as folder:
        complaints = [*judge(chain, Path(folder), ("dop853", METHODS[1 + seed % 5]))]
    return complaints, f"; {chain.parts}"


if __name__ == "__main__":
    run_campaign(__doc__, judge_seed)
