"""Machines whose joints change at one instant, in orders of declaration: `python -m ... 0 500`.

Each order gives the same motion; what changes, its impulses, the velocities behind it and the
energy that it takes are those by hand; and between impacts the energy changes by the works.
"""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from codegen.errors import LinkwrightError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.results.result import Result
from tests.random_mechanisms.changing_joints import Machine, random_machine, rounds
from tests.random_mechanisms.seed_range import run_campaign

ORDERS = 2
MOST = 1e-9  # of momentum, energy and positions, relative to their size
SETTINGS = ({"method": "radau5"}, {"formulation": "reduced"}, {"method": "bdf"})
"""Of every tenth machine; they need constraints that are independent."""


def judge(machine: Machine, folder: Path, orders: int = ORDERS) -> list[str]:
    """Run a machine in several orders of declaration; what is wrong, in words."""
    found, ends, done = [], [], rounds(machine)
    others = machine.seed % 10 == 0 and done and all(each.unique for each in done[0])
    settings = SETTINGS[machine.seed // 10 % len(SETTINGS)] if others else {}
    for number in range(orders):
        order = np.random.default_rng([machine.seed, number]) if number else None
        try:
            loaded = load(machine.model(f"changing{machine.seed}_{number}", order), folder=folder)
            r = loaded.simulate(machine.end, rtol=1e-12, atol=1e-13, progress=False, **settings)
            complaints = [*differences(machine, r)]
            ends.append((r.samples.q[-1], r.samples.v[-1], told(r)))
        except LinkwrightError as error:
            complaints = [f"{type(error).__name__}: {error}"]
        found += [f"order {number}: {complaint}" for complaint in complaints]
    for number, (q, v, changes) in enumerate(ends[1:], 1):
        off = max(np.abs(q - ends[0][0]).max(), np.abs(v - ends[0][1]).max())
        if changes != ends[0][2] or not off < 100 * MOST:
            found.append(f"order {number} ends {off:.1e} off the first; {changes}, {ends[0][2]}")
    return found


def told(r: Result) -> list[tuple[float, str, str]]:
    """The changes of joints, sorted."""
    return sorted((round(c.time, 6), c.joint, c.action) for c in r.reconnections)


def differences(machine: Machine, r: Result) -> Iterator[str]:
    """In what a result differs from what is so by hand."""
    if r.outcome is not Outcome.OK:
        yield f"{r.outcome.name} {r.message[:400]}"
        return
    done = rounds(machine)
    assert done is not None
    expected, v_after, _ = done
    here = [c for c in r.reconnections if abs(c.time - machine.first) < 1e-6]
    wanted = sorted(one.name for each in expected for one in each.changed)
    if sorted(c.joint for c in here) != wanted or len({c.time for c in here}) != 1:
        yield f"changes {[(c.time, c.joint) for c in here]}, expected {wanted} at {machine.first}"
        return
    columns = [r.description.coordinates.index(name) for name in names(machine)]
    before, after = (r.at(here[0].time, side) for side in ("before", "after"))
    for what, got, right in (
        ("q", before.samples.q[0, columns], machine.there[0]),
        ("v before", before.samples.v[0, columns], machine.there[1]),
        ("v after", after.samples.v[0, columns], v_after),
    ):
        off = np.abs(got - right).max() / (1 + np.abs(right).max())
        if not off < MOST:
            yield f"{what} is {got}, expected {right}, {off:.1e} off"
    for each in expected:
        own = [c for c in here if c.joint in {one.name for one in each.changed}]
        lost = sum(c.energy_lost for c in own)
        if not abs(lost - each.lost) < MOST * (1 + abs(each.lost)) or lost < -MOST:
            yield f"energy lost {lost}, expected {each.lost}"
        for c in own:
            got, right = np.array([*c.impulse.values()]), each.impulses.get(c.joint, np.zeros(0))
            if each.unique and not np.allclose(got[: len(right)], right, rtol=MOST, atol=MOST):
                yield f"impulse of {c.joint} {c.impulse}, expected {right}"
    yield from imbalance(machine, r, columns)


def names(machine: Machine) -> list[str]:
    """The coordinates in the order of the reference."""
    plain = len(machine.mass) - 3 * machine.bar
    found = [f"r{k}.phi" if machine.rotor[k] else f"s{k}.x" for k in range(plain)]
    return found + ["bar.x", "bar.y", "bar.phi"] * machine.bar


def imbalance(machine: Machine, r: Result, columns: list[int]) -> Iterator[str]:
    """By how much energy and works differ, without the jumps at impacts."""
    jumps = {float(c.time) for c in r.reconnections} | {float(e.time) for e in r.events}
    total, scale = 0.0, 1.0
    for at in sorted(jumps):
        sides = [r.at(at, side).samples.v[0, columns] for side in ("before", "after")]
        one, two = (float(machine.mass @ v**2) / 2 for v in sides)
        total, scale = total + two - one, max(scale, one, two)
    ends = [float(machine.mass @ r.samples.v[k][columns] ** 2) / 2 for k in (0, -1)]
    work = sum(float(series[-1]) for series in r.works.values())
    off = (ends[1] - ends[0] - total - work) / scale
    if not abs(off) < MOST:
        yield f"energy {off:.1e} off its works, of {scale:.3g} J"


def judge_seed(seed: int) -> tuple[list[str], str]:
    """Complaints of the machine of a seed."""
    with tempfile.TemporaryDirectory() as folder:
        return [*judge(random_machine(seed), Path(folder))], ""


if __name__ == "__main__":
    run_campaign(__doc__, judge_seed)
