"""Formulations: the coordinates in which a motion is integrated, and the return to all of them."""

from dataclasses import replace

import numpy as np

from codegen.errors import InputError
from runtime.assembly.kernels_for_redundant_constraints import projection_only, with_redundancy
from runtime.assembly.masses_far_apart import suited_to_masses
from runtime.core.system import System
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.integrate.method import IMPLICIT
from runtime.integrate.problem import Correction, Formulation
from runtime.integrate.trajectory import Trajectory
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism

FORMULATIONS = ("cartesian", "reduced")
# measured: rate of an angle by the kept coordinates that tells a dead centre of its loop
_STEEP = 1e6
# safety: ratio of two mobilities, beside typical sizes; their squares are the weights of
# corrections, and lie as far apart as a pivot may be weak
_WIDEST = 3e4
_CORRECTIONS = ("step", "stage")


class Coordinates:
    """The coordinates that are integrated, and their equations."""

    mechanism: Mechanism  # with kernels of least norm where constraints are redundant
    system: System
    p: FloatArray  # parameters of the equations
    q: FloatArray  # at the start, (f,)
    v: FloatArray
    scale: FloatArray  # typical changes, (f,)
    sizes: FloatArray  # typical sizes, (f,)
    mobility: FloatArray  # typical changes of all coordinates, (n,)
    spreads: FloatArray  # see `Problem`, (s,)
    correction: Correction

    def all_coordinates(self, run: Trajectory) -> Trajectory:
        """A run in all coordinates, its outcome in terms of all constraints."""
        return run


class CartesianCoordinates(Coordinates):
    """The machine's own coordinates."""

    def __init__(self, ready: PreparedSimulation, method: str, correction: Correction) -> None:
        begin, self.mechanism, self.correction = ready.begin, ready.mechanism, correction
        self.p, self.sizes = ready.p, ready.sizes
        if begin.redundant:
            self.mechanism = with_redundancy(ready.mechanism, begin)
            self.correction = projection_only(ready.mechanism, begin, method, correction)
        else:
            self.mechanism = suited_to_masses(ready.mechanism, begin.t, begin.q, ready.p)
        self.system = self.mechanism.system
        self.spreads = np.zeros(len(self.mechanism.description.switches))
        if method in IMPLICIT:
            self.system = replace(self.system, **self.mechanism.tangents._asdict())
        self.q, self.v = np.ascontiguousarray(begin.q), np.ascontiguousarray(begin.v)
        mass = Equations(ready.mechanism, ready.p).mass(begin.q)
        self.scale = self.mobility = _mobility(mass, self.sizes)


class ReducedCoordinates(Coordinates):
    """Coordinates that no constraint gives explicitly.

    Raises InputError with all reasons why this machine has none.
    """

    def __init__(self, ready: PreparedSimulation, correction: Correction) -> None:
        _refuse(ready, correction)
        begin, self.mechanism, self.correction = ready.begin, ready.mechanism, correction
        self.reduced = reduced = ready.mechanism.reduced
        self.system, self._start, kept = reduced.system, (begin.t, begin.q), reduced.kept
        self.q, self.v = begin.q[kept].copy(), begin.v[kept].copy()
        self.sizes = ready.sizes[kept]
        self.p = reduced.parameters(ready.p, begin.t, begin.q)
        self._refuse_dead_centre()
        values, mass = np.zeros(len(reduced.mass[0])), np.zeros((len(kept), len(kept)))
        reduced.kernels.mass(self.q, self.p, values)
        mass[reduced.mass] = values
        self.scale = _mobility(mass, self.sizes)
        self.spreads = _spreads(ready)
        self.mobility = np.ones(len(begin.q))
        self.mobility[kept] = self.scale

    def all_coordinates(self, run: Trajectory) -> Trajectory:
        """All coordinates at the samples, the events and the end."""
        reduced, events = self.reduced, run.events
        count, n = len(run.t), len(self.mechanism.description.coordinates)
        t = np.concatenate([run.t, events.t, [run.final_t]])
        q = np.vstack([run.q, events.q, run.final_q[None, :]])
        v = np.vstack([run.v, events.v, run.final_v[None, :]])
        order = np.argsort(t, kind="stable")
        all_q, all_v = np.empty((len(t), n)), np.empty((len(t), n))
        all_q[order], all_v[order] = reduced.expanded(
            t[order], q[order], v[order], self.p, self._start, self.sizes
        )
        free = np.zeros((len(run.partitions.t), n), dtype=np.bool_)
        free[:, reduced.kept] = run.partitions.independent
        switched = run.outcome.of_switch or run.index < 0
        crossings = []
        for crossing in run.crossings:
            direction = np.zeros(n)
            direction[reduced.kept] = crossing.direction
            rows = tuple(map(reduced.row, crossing.rows))
            crossings.append(replace(crossing, rows=rows, direction=direction))
        return replace(
            run, q=all_q[:count], v=all_v[:count], final_q=all_q[-1], final_v=all_v[-1],
            events=replace(events, q=all_q[count:-1], v=all_v[count:-1]),
            partitions=replace(run.partitions, independent=free),
            index=run.index if switched else reduced.row(run.index), crossings=tuple(crossings),
        )  # fmt: skip

    def _refuse_dead_centre(self) -> None:
        description, (t, _) = self.mechanism.description, self._start
        steep = self.reduced.steepness(t, self.q, self.p, self.sizes)
        problems = [
            f"{description.title}: the run starts with {description.constraints[row].name} at a "
            "dead centre of its loop, where both ways to close it meet "
            f"({description.coordinates[column].name} moves {ratio:.1e} times as fast as what is "
            "left), and reduced coordinates follow one of them; "
            f'start further away, or take formulation="cartesian".'
            for (column, row), ratio in zip(self.reduced.branches, steep, strict=True)
            if not ratio < _STEEP
        ]
        if problems:
            raise InputError(problems)


def formulate(
    ready: PreparedSimulation, formulation: Formulation, method: str, correction: Correction
) -> Coordinates:
    """The coordinates of a formulation; InputError if it does not exist or suit this machine."""
    if formulation not in FORMULATIONS:
        raise InputError(f"formulation = {formulation!r} must be one of {', '.join(FORMULATIONS)}.")
    if formulation == "reduced":
        return ReducedCoordinates(ready, correction)
    return CartesianCoordinates(ready, method, correction)


def _mobility(mass: FloatArray, sizes: FloatArray) -> FloatArray:
    """Typical size of a change of each coordinate, 1/√M_kk, shape (n,).

    A coordinate without mass, such as the place of a contact on a cam, follows most easily: ten
    times the size of the most mobile body makes it one of the dependent coordinates. Beside typical
    `sizes` of the coordinates mobilities lie at most `_WIDEST` apart: they say which coordinate
    follows more easily, not which constraints are independent.
    """
    inertia = np.diag(mass)
    heavy = inertia > 0.0
    mobility: FloatArray = 1.0 / np.sqrt(np.where(heavy, inertia, 0.01 * inertia[heavy].min()))
    beside = mobility / sizes
    most, least = float(beside.max()), float(beside.min())
    if most <= _WIDEST * least:
        return mobility
    compressed = (beside / most) ** (np.log(_WIDEST) / np.log(most / least))
    within: FloatArray = sizes * most * compressed
    return within


def _spreads(ready: PreparedSimulation) -> FloatArray:
    """Σ |∂g/∂(q, q̇)| times the typical sizes, to which the rounding of g is proportional.

    At a dead centre of a switching function the reduced coordinates alone would not show it.
    """
    n, s = len(ready.sizes), len(ready.mechanism.description.switches)
    spreads, rest, now = np.zeros((3, s))
    unit = np.zeros(2 * n)

    def write_rates(out: FloatArray) -> None:
        rates, begin = ready.mechanism.kernels.switching_rates, ready.begin
        rates(begin.t, begin.q, unit[:n], unit[n:], ready.p, out)

    write_rates(rest)
    for j in range(2 * n):
        unit[j] = ready.sizes[j % n]
        write_rates(now)
        unit[j] = 0.0
        change = np.abs(now - rest)
        spreads += np.where(np.isfinite(change), change, 0.0)
    return spreads


def _refuse(ready: PreparedSimulation, correction: Correction) -> None:
    description, begin, problems = ready.mechanism.description, ready.begin, []
    if correction not in _CORRECTIONS:
        problems.append(
            f"correction={correction!r} returns onto constraints that reduced coordinates "
            f"eliminate; take one of {', '.join(_CORRECTIONS)}"
        )
    if begin.redundant:
        problems.append(
            f"{', '.join(row.name for row in begin.redundant)} follow from other constraints, and "
            "reduced coordinates need independent ones; remove them"
        )
    stuck = [*description.stiction, *(k for k, *_ in description.friction_limits)]
    if stuck:
        names = dict.fromkeys(description.switches[k].name for k in stuck)
        problems.append(
            f"{', '.join(names)} stick by a force that follows from a reaction, "
            "which reduced coordinates leave out; give them creep="
        )
    if begin.degrees_of_freedom == 0:
        problems.append(
            "nothing is left to integrate, as constraints and drivers determine all coordinates; "
            "ask for inverse_dynamics"
        )
    if problems:
        raise InputError(
            f'{description.title}: {problem}, or take formulation="cartesian".'
            for problem in problems
        )
