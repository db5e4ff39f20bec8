"""Random mechanisms in space against the dense equations: `python -m ... spatial_campaign 0 300`.

Every machine is built, compiled and run. At each sample accelerations and reactions are compared
with Newton's and Euler's equations in the same state, and the motion with the dense motion. With
`--statics` nothing is compiled or run: the interpreter evaluates the kernels at some states. With
`--others` or `--statics_of_others` the machines have the joints that the families do not have.
"""

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import LinkwrightError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.results.result import Result
from tests.random_mechanisms.seed_range import run_campaign
from tests.random_mechanisms.spatial_constraints import SpatialState
from tests.random_mechanisms.spatial_declaration import coordinates, declare
from tests.random_mechanisms.spatial_dynamics import SpatialDense, SpatialSolution
from tests.random_mechanisms.spatial_generator import (
    OTHER,
    RandomSpatialMechanism,
    random_spatial_mechanism,
)
from tests.random_mechanisms.spatial_motion import motion
from tests.random_mechanisms.spatial_statics import MET, Statics, counted, differences

MOTION = 1e-6  # m, and of entries of rotation matrices
METHODS = {"dop853": 1e-11, "radau5": 1e-10, "bdf": 1e-9}  # with their tolerances
SAMPLES = 4


@dataclass(frozen=True)
class Verdict:
    """The largest differences of one machine and method, as parts of 1 or of the largest value."""

    statics: float
    motion: float
    complaints: tuple[str, ...]


class Comparison:
    """A machine, loaded, beside its dense equations and their motion."""

    def __init__(self, machine: RandomSpatialMechanism, folder: Path) -> None:
        self.mechanism, self.state = machine.parts, machine.state
        self.dense = SpatialDense(self.mechanism)
        self.instants = np.linspace(0.0, machine.horizon, SAMPLES)
        self.exact = motion(self.dense, self.state, self.instants.tolist())
        self.driven = machine.freedoms == 0
        self.loaded: Machine = load(declare(self.mechanism, f"space_{machine.seed}"), folder=folder)
        self.start = self._assembled()

    def judge(self, method: str) -> Verdict:
        """Run it by a method, and compare everything."""
        result, complaints = self.run(method), [*self._redundancy()]
        if result.outcome is not Outcome.OK:
            return Verdict(np.inf, np.inf, (*complaints, f"{method}: {result.message}"))
        n = len(self.mechanism.bodies)
        q, a = (x[:, : 7 * n].reshape(-1, n, 7) for x in (result.samples.q, result.samples.a))
        states = [self._state(result, k, q[k]) for k in range(SAMPLES)]
        found = [max(self._apart(result, k, s, a[k])) for k, s in enumerate(states)]
        off = max(
            float(np.abs([*(s.r - e.r).ravel(), *(s.R - e.R).ravel()]).max())
            for s, e in zip(states, self.exact, strict=True)
        )
        statics = max(found)
        if not statics < MET:
            complaints.append(f"{method}: accelerations or reactions are {statics:.1e} apart")
        if not off < MOTION:
            complaints.append(f"{method}: the motion is {off:.1e} off")
        return Verdict(statics, off, tuple(complaints))

    def run(self, method: str) -> Result:
        """Inverse dynamics where nothing is free, else a simulation."""
        if self.driven:
            return self.loaded.inverse_dynamics(self.instants, start=self.start, progress=False)
        return self.loaded.simulate(
            self.instants[-1], self.instants, start=self.start, rtol=METHODS[method],
            atol=METHODS[method], method=method, progress=False,
        )  # fmt: skip

    def _assembled(self) -> Any:
        q, v = (x.tolist() for x in coordinates(self.state))
        columns = [*self.loaded.coordinates]  # behind those of bodies stand coordinates of joints
        own = counted(self.dense, self.state, self.dense.solve(self.state))
        for row in columns[len(q) :]:
            place, rate, _ = own[row.name]
            q, v = [*q, float(place)], [*v, float(rate)]
        names = (*(row.name for row in columns), *(row.velocity for row in columns))
        return self.loaded.assemble(guess=dict(zip(names, [*q, *v], strict=True)))

    def _redundancy(self) -> Iterator[str]:
        """Whether the freedoms, the redundant rows and the joints that share a load are named."""
        freedoms, redundant = self.dense.freedoms(self.state)
        found = self.start.degrees_of_freedom, len(self.start.redundant)
        if found != (freedoms, redundant):
            yield f"freedoms and redundant rows are {found}, not {(freedoms, redundant)}"
        solved = self.dense.solve(self.state)
        shared = {
            joint.name for joint in self.mechanism.joints
            if not self._determined(joint, self.state, solved).all()
        }  # fmt: skip
        if shared != {*self.start.not_unique}:
            yield f"not unique are {sorted(shared)}, named are {sorted(self.start.not_unique)}"

    def _determined(self, joint: Any, state: SpatialState, solved: SpatialSolution) -> Any:
        return self.dense.reaction(joint.name, state, solved).determined

    def _state(self, result: Result, k: int, q: Any) -> SpatialState:
        names = [body.name for body in self.mechanism.bodies]
        R = np.array([result.rotation(name)[k] for name in names])
        v = np.array([[result.v(f"{n}.{c}")[k] for c in ("x", "y", "z")] for n in names])
        w = np.array([[result.v(f"{n}.omega_{c}")[k] for c in "xyz"] for n in names])
        w = np.einsum("bij,bj->bi", R, w)
        return SpatialState(q[:, :3], R, v, w, self.exact[k].turned)

    def _apart(self, result: Result, k: int, state: SpatialState, a: Any) -> Iterator[float]:
        """Differences of accelerations and wrenches, and what is missing in Newton's law."""
        p = result.samples.q[k, : a.size].reshape(-1, 7)[:, 3:]

        def reaction(joint: str, letter: str) -> float:
            return float(result.reaction(joint, letter)[k])

        rows = self.loaded.description.reactions
        return differences(self.dense, state, float(result.t[k]), p, a, rows, reaction)


def methods_of(seed: int) -> tuple[str, ...]:
    """The explicit method, and for every third machine an implicit one."""
    return ("dop853", *{1: ("radau5",), 4: ("bdf",)}.get(seed % 6, ()))


def judge(seed: int, family: str | None = None) -> tuple[tuple[str, ...], str]:
    """Complaints about a machine, and what it is."""
    machine = random_spatial_mechanism(seed, family)
    about = f"; {machine.family} {machine.driven} {list(machine.loops)} {machine.redundant}"
    with tempfile.TemporaryDirectory() as folder:
        try:
            compared = Comparison(machine, Path(folder))
            methods = methods_of(seed)[: 1 if compared.driven else 2]
            verdicts = [compared.judge(method) for method in methods]
        except LinkwrightError as error:
            return (f"{type(error).__name__}: {str(error)[:600]}",), about
    about += "".join(
        f"; {m} {v.statics:.0e} {v.motion:.0e}" for m, v in zip(methods, verdicts, strict=True)
    )
    return tuple(c for verdict in verdicts for c in verdict.complaints), about


def judge_statics(seed: int, family: str | None = None) -> tuple[tuple[str, ...], str]:
    """Complaints about the lowered equations of a machine, and what it is."""
    machine = random_spatial_mechanism(seed, family)
    about = f"; {machine.family} {machine.driven} {list(machine.loops)} {machine.redundant}"
    try:
        statics = Statics(machine)
    except LinkwrightError as error:
        return (f"{type(error).__name__}: {str(error)[:600]}",), about
    states = statics.states(SAMPLES)
    return tuple(statics.complaints(states)), f"{about}; {len(states)} states"


if __name__ == "__main__":
    others = {"others": judge, "statics_of_others": judge_statics}
    others = {name: partial(of, family=OTHER) for name, of in others.items()}
    run_campaign(__doc__, judge, statics=judge_statics, **others)
