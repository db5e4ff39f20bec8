"""Random mechanisms against the dense formulation, run as they are: `python -m ... campaign 0 100`.

Every machine is built, compiled and run. At each sample its accelerations and reactions are
compared with those of the dense equations in the same state, its motion with the dense motion.
An outcome that is not OK has to be one that the dense equations explain.
"""

import argparse
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import linprog

from codegen.errors import LinkwrightError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.results.result import Result
from tests.random_mechanisms import parts
from tests.random_mechanisms.dense_dynamics import Dense
from tests.random_mechanisms.dense_hybrid import Hybrid, switching_effects
from tests.random_mechanisms.dense_motion import driven_motion, free_motion, growth
from tests.random_mechanisms.generator import CONTACTS, FRICTION, RandomMechanism, random_mechanism
from tests.random_mechanisms.kernel_comparison import Generated, differences

MET = 1e-10  # of accelerations and reactions, in a state that both are given
MOTION = 1e-7  # of positions in typical sizes, for a run at RTOL, without growth of errors
RTOL = 1e-11
LOST = 1e-3  # least singular value that explains a singular position or a lock-up
NEAR = 1e-3  # of a typical length: stops between which impacts follow ever faster
INFEASIBLE = 2  # of `linprog`: nothing meets all conditions
SAMPLES = 6


@dataclass(frozen=True)
class Verdict:
    """What came of one machine; `complaint` is empty where all agrees."""

    outcome: str
    statics: float = 0.0
    motion: float = 0.0
    complaint: str = ""


def judge(machine: RandomMechanism, folder: Path) -> Verdict:
    """Build a machine, run it and compare it."""
    dense = Dense(machine.parts, machine.scales.length)
    instants = np.linspace(0.0, machine.horizon, SAMPLES)
    try:
        loaded = load(machine.model(), machine.scene, folder=folder)
        result = run(loaded, machine, instants)
    except LinkwrightError as error:
        rigid = any(isinstance(f, parts.RigidContact) for f in machine.parts.effects)
        if rigid and machine.freedoms == 0 and "inverse dynamics does not decide" in str(error):
            return Verdict("refused")
        return Verdict(type(error).__name__, complaint=str(error)[:300])
    order = [result.description.coordinates.names.index(name) for name in dense.names]
    q, v, a = (x[:, order] for x in (result.samples.q, result.samples.v, result.samples.a))
    known = np.isfinite(a).all(axis=1)
    if result.outcome is Outcome.LOCKED:
        known[-1] = False  # forces without bound, of which rounding of the state decides
    statics = max(
        (
            samples_apart(machine, dense, result, k, (q[k], v[k], a[k]))
            for k in np.flatnonzero(known)
        ),
        default=0.0,
    )
    complaint = "" if statics < MET else f"accelerations or reactions are {statics:.1e} apart"
    if result.outcome is not Outcome.OK:
        last, at = result.samples.q[-1, order], float(result.t[-1])
        if result.outcome is Outcome.LOCKED and result.singular:  # which has no forces
            last, at = result.singular[-1].q[order], result.singular[-1].time
        least = dense.least_singular_value(last, at)
        if result.outcome is Outcome.LOCKED:
            modes = _modes(machine, result, -1)
            kept = [name for name, mode in modes.items() if mode == 0]
            least = min(least, dense.least_singular_value(last, at, kept))
        explained = result.outcome in (Outcome.SINGULAR, Outcome.LOCKED) and least < LOST
        if result.outcome is Outcome.INCONSISTENT:
            explained = driven_onto_stop(dense, last, at)
        if result.outcome is Outcome.ZENO:
            explained = squeezed(dense, last, at)
        why = "" if explained else f"{result.outcome.name}, least singular value {least:.1e}"
        return Verdict(result.outcome.name, statics, 0.0, complaint or why)
    try:
        apart, permitted = motion_apart(machine, dense, instants, q)
    except ArithmeticError as error:
        return Verdict("OK", statics, np.inf, f"OK, and the dense motion stops: {error}")
    if apart > permitted:
        complaint = f"the motion is {apart:.1e} off, {permitted:.1e} is permitted"
    return Verdict("OK", statics, apart, complaint)


def driven_onto_stop(dense: Dense, q: Any, t: float) -> bool:
    """Whether stops that touch close by what joints and drivers prescribe: nothing can give way."""
    scalars = dense.equations(q, np.zeros(dense.n), t).scalars
    stops = [
        f.name for f in dense.mechanism.effects
        if isinstance(f, parts.RigidContact) and abs(scalars[f.name].value) < MET * dense.length
    ]  # fmt: skip
    return bool(stops) and not dense.independent(q, t, stops)


def squeezed(dense: Dense, q: Any, t: float) -> bool:
    """Whether no velocity keeps all stops that nearly touch from closing: their room vanishes."""
    e = dense.equations(q, np.zeros(dense.n), t)
    scalars = [
        e.scalars[f.name] for f in dense.mechanism.effects
        if isinstance(f, parts.RigidContact) and abs(e.scalars[f.name].value) < NEAR * dense.length
    ]  # fmt: skip
    if not scalars:
        return False
    rows = np.array([s.by_q for s in scalars]) * dense.sizes
    limits = np.array([s.by_t for s in scalars])
    joints = {"A_eq": e.jacobian * dense.sizes, "b_eq": e.nu} if e.rows else {}
    found = linprog(np.zeros(dense.n), -rows, limits, bounds=(None, None), **joints)
    return bool(found.status == INFEASIBLE)


def judge_kernels(machine: RandomMechanism) -> Verdict:
    """Compare the kernels alone, which Python runs, in the pose of the start and beside it."""
    try:
        generated = Generated(machine)
    except LinkwrightError as error:
        return Verdict(type(error).__name__, complaint=str(error)[:300])
    dense = Dense(machine.parts, machine.scales.length)
    random = np.random.default_rng(machine.seed)
    states = [(machine.q, machine.v)]
    for size in (0.03, 0.1):
        shift = size * random.normal(size=(2, dense.n)) * dense.sizes
        moved = machine.q + shift[0], machine.v + shift[1] / machine.scales.time
        try:
            states.append(dense.closed(*moved, 0.0))
        except ArithmeticError:  # the joints do not close so far from the pose
            continue
    found = [differences(machine, generated, dense, q, v, 0.0).worst for q, v in states]
    worst = max(found)
    return Verdict("OK", worst, 0.0, "" if worst < MET else f"kernels are {worst:.1e} apart")


def run(loaded: Machine, machine: RandomMechanism, instants: Any) -> Result:
    """Inverse dynamics where nothing is free, else a simulation."""
    if machine.freedoms == 0:
        return loaded.inverse_dynamics(instants, progress=False)
    atol = RTOL * min(1.0, machine.scales.length)
    end = float(instants[-1])
    return loaded.simulate(end, t_eval=instants, rtol=RTOL, atol=atol, progress=False)


def samples_apart(
    machine: RandomMechanism, dense: Dense, result: Result, k: int, state: Any
) -> float:
    """Accelerations and reactions of a sample, relative to the largest of their kind."""
    q, v, a = state
    t, modes = float(result.t[k]), _modes(machine, result, k)
    kept = [name for name, mode in modes.items() if mode == 0]
    given = {}
    if not dense.independent(q, t, kept):
        # Their forces are not unique; with those of the run its motion has to follow.
        values = zip(result.description.reactions, result.samples.reaction[k], strict=True)
        given = {
            row.element: float(value) for row, value in values
            if row.element in kept and row.component in ("force", "torque")
        }  # fmt: skip
    ours = dense.solve(q, v, t, modes, given)
    sizes, length, period = dense.sizes, machine.scales.length, machine.scales.time
    expected = ours.a / sizes
    scale = max(float(np.abs(expected).max()), 1.0 / period**2)
    apart = float(np.abs(a / sizes - expected).max()) / scale
    force = machine.scales.mass * length / period**2
    pairs = []
    for row, value in zip(result.description.reactions, result.samples.reaction[k], strict=True):
        mine = ours.reactions.get((row.element, row.component))
        if mine is not None:
            arm = length if row.unit == "N m" else 1.0
            pairs.append((value / arm, mine / arm))
    if not pairs:
        return apart
    theirs, mine = np.array(pairs).T
    return max(apart, float(np.abs(theirs - mine).max()) / max(float(np.abs(mine).max()), force))


def _modes(machine: RandomMechanism, result: Result, k: int) -> dict[str, int]:
    """The modes of a sample, as `Dense.solve` takes them."""
    effects, modes = switching_effects(machine.parts), {}
    for switch, mode in zip(result.description.switches, result.samples.modes[k], strict=True):
        if switch.name in effects and not isinstance(effects[switch.name], parts.Contact):
            rigid = isinstance(effects[switch.name], parts.RigidContact)
            modes[switch.name] = {0: 0 if rigid else -1, 1: 1, 2: 0}[int(mode)]
    return modes


def motion_apart(
    machine: RandomMechanism, dense: Dense, instants: Any, q: Any
) -> tuple[float, float]:
    """How far the positions are off, in typical sizes, and how far they may be."""
    if machine.freedoms == 0:
        expected = driven_motion(dense, machine.q, instants)[0]
    else:
        expected = moved(dense, machine.q, machine.v, instants)
    apart = float(np.abs((q - expected) / dense.sizes).max())
    permitted = MOTION * max(1.0, float(np.abs(expected / dense.sizes).max()))
    if apart > permitted and machine.freedoms:
        permitted *= max(1.0, 1e-2 * growth(moved, dense, machine.q, machine.v, instants))
    return apart, permitted


def moved(dense: Dense, q: Any, v: Any, instants: Any) -> Any:
    """Positions at instants by the dense equations, with events where the mechanism has any."""
    if switching_effects(dense.mechanism):
        return Hybrid(dense).motion(q, v, instants)[0]
    return free_motion(dense, q, v, instants)[0]


def main() -> None:
    """Judge the machines of a range of seeds and say what differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("first", type=int)
    parser.add_argument("last", type=int)
    parser.add_argument(
        "--contacts", choices=CONTACTS, default="none", help="stops of all machines"
    )
    parser.add_argument("--kernels", action="store_true", help="kernels alone, not compiled")
    parser.add_argument("--friction", choices=FRICTION, help="of all machines")
    chosen = parser.parse_args()
    seen: Counter[str] = Counter()
    worst = {"statics": 0.0, "motion": 0.0}
    for seed in range(chosen.first, chosen.last):
        began = time.perf_counter()
        machine = random_mechanism(seed, friction=chosen.friction, contacts=chosen.contacts)
        if chosen.kernels:
            verdict = judge_kernels(machine)
        else:
            with tempfile.TemporaryDirectory() as folder:
                verdict = judge(machine, Path(folder))
        seen[verdict.outcome] += 1
        seen["differ"] += bool(verdict.complaint)
        worst["statics"] = max(worst["statics"], verdict.statics)
        if not verdict.complaint:
            worst["motion"] = max(worst["motion"], verdict.motion)
        spent = time.perf_counter() - began
        say(
            f"{seed}: {verdict.outcome} {verdict.statics:.0e} {verdict.motion:.0e} "
            f"{spent:.0f} s; {machine.kind} {verdict.complaint}"
        )
    say(f"{dict(seen)} {worst}")


def say(text: str) -> None:
    """Write a line at once."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
