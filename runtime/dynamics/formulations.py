"""Formulations: the coordinates in which a motion is integrated, and the return to all of them."""

from copy import copy
from dataclasses import replace
from typing import Self

import numpy as np

from codegen.errors import InputError
from runtime.assembly.redundancy import suited_equations
from runtime.core.arrays import Integers
from runtime.core.system import System
from runtime.dynamics.changes_of_coordinates import Changes
from runtime.dynamics.controllers import remembered
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.integrate.checkpoints import Checkpoint, restore
from runtime.integrate.method import IMPLICIT
from runtime.integrate.problem import (
    Correction,
    Formulation,
    Options,
    Problem,
    Trajectory,
    refuse_misfits,
)
from runtime.integrate.recording_buffers import in_order
from runtime.integrate.run import Change, Progress, Run
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.typical_sizes import measure_mobility

FORMULATIONS = ("cartesian", "reduced")
_CORRECTIONS = ("step", "stage")


class Coordinates:
    """The coordinates that are integrated, and their equations."""

    name: Formulation
    equations: Equations
    system: System
    mobility: FloatArray  # typical changes of all coordinates, (n,)
    correction: Correction

    def __init__(self, ready: PreparedSimulation) -> None:
        self.ready, self.begin = ready, ready.begin

    def again(self, t_end: float) -> Self:
        """The same for another run, to an end in s; they share nothing that a run writes."""
        other = copy(self)
        other.ready = self.ready.again(t_end)
        other.equations = Equations(self.equations.mechanism, other.ready.p)
        return other

    def problem(self, t: float, q: FloatArray, v: FloatArray) -> Problem:
        """The problem of a run from a state in all coordinates, (n,) each, to the end."""
        raise NotImplementedError

    def run(
        self, options: Options, change: Change, kept: Checkpoint | None = None,
        known: tuple[float, FloatArray] | None = None, progress: Progress | None = None, *,
        again: bool = True,
    ) -> Trajectory:  # fmt: skip
        """The run from a checkpoint, None: its start; in all coordinates.

        `change` decides how far it goes. Where it is made `again`, it has the same steps, samples
        of its own, and the answers that a user's functions gave. `known` is a state that it passed,
        in all coordinates: angles are followed from there.
        """
        begin = self.begin
        problem = self.problem(begin.t, begin.q, begin.v)
        if again:
            problem = problem._replace(controllers=remembered(problem.controllers))
        else:
            refuse_misfits(problem, options)
        run = Run(self.system, problem, options)
        if kept is not None:
            restore(run, kept.state)
        path = run.execute(progress, change, started=kept is not None)
        return path._replace(events=in_order(path.events, path.final_t, self.system.rigid))


class CartesianCoordinates(Coordinates):
    """The machine's own coordinates."""

    name = "cartesian"

    def __init__(self, ready: PreparedSimulation, method: str, correction: Correction) -> None:
        super().__init__(ready)
        begin = ready.begin
        self.equations = suited_equations(ready.equations, begin)
        self.correction = correction
        mechanism = self.equations.mechanism
        self.system = mechanism.system
        if method in IMPLICIT:
            self.system = replace(self.system, **mechanism.tangents._asdict())
        counted, masses = ready.mechanism.shape["counted"], self.equations.masses(begin.q)
        self.mobility = _mobility(masses, ready.sizes, counted, compressed=True)
        scaled = self.equations.scaled(self.mobility, self.equations.independent)
        drivers = mechanism.description.driver_rows
        self.shortest = scaled.least_lengths(begin.t, begin.q, ready.sizes, drivers)

    def problem(self, t: float, q: FloatArray, v: FloatArray) -> Problem:
        """In the machine's own coordinates."""
        ready, q, v = self.ready, np.ascontiguousarray(q), np.ascontiguousarray(v)
        return Problem(
            t, ready.t_end, q, v, ready.p, self.mobility, ready.sizes,
            shortest=self.shortest, stops=ready.stops,
            samples_taken=ready.samples_taken, controllers=ready.controllers,
            discrete=ready.discrete,
        )  # fmt: skip


class ReducedCoordinates(Coordinates):
    """Coordinates that no constraint gives explicitly.

    Raises InputError with all reasons why this machine has none.
    """

    name = "reduced"

    def __init__(self, ready: PreparedSimulation, correction: Correction) -> None:
        super().__init__(ready)
        _refuse(ready, correction)
        begin, self.correction = ready.begin, correction
        self.equations = suited_equations(ready.equations, begin)
        self.reduced = ready.mechanism.reduced
        self.system, self.spreads = self.reduced.system, _spreads(ready)
        self.mobility, state = np.ones(len(begin.q)), (begin.t, begin.q, begin.v)
        self.first = self._problem(*state)
        self.squares_at_start = self.reduced.squares(*state, ready.p)
        scale = self.first.scale
        self.mobility[self.reduced.kept] = np.where(np.isfinite(scale), scale, 1.0)

    def problem(self, t: float, q: FloatArray, v: FloatArray) -> Problem:
        """In the kept coordinates, on the branches on which the machine stands at (t, q)."""
        if q is not self.begin.q or v is not self.begin.v:
            return self._problem(t, q, v)
        first, ready = self.first, self.ready
        return first._replace(t_end=ready.t_end, p=first.p.copy(), stops=ready.stops)

    def squares(self, t: float, q: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
        """Of the machine, see `Reduced.squares`."""
        if q is self.begin.q and v is self.begin.v:
            return self.squares_at_start
        return self.reduced.squares(t, q, v, self.ready.p)

    def _problem(self, t: float, q: FloatArray, v: FloatArray) -> Problem:
        reduced, ready = self.reduced, self.ready
        kept, p = reduced.kept, reduced.parameters(ready.p, t, q)
        sizes = ready.sizes[kept]
        inertia = np.diag(reduced.inertia(t, q[kept], p))
        scale = _mobility(inertia, sizes, ready.mechanism.shape["counted"][kept])
        return Problem(
            t, ready.t_end, q[kept], v[kept], p, scale, sizes, self.spreads, stops=ready.stops,
            samples_taken=ready.samples_taken, discrete=ready.discrete,
        )  # fmt: skip

    def run(
        self, options: Options, change: Change, kept: Checkpoint | None = None,
        known: tuple[float, FloatArray] | None = None, progress: Progress | None = None, *,
        again: bool = True,
    ) -> Trajectory:  # fmt: skip
        """Past dead centres in all coordinates; no functions of a user's take part."""
        return Changes(self, options).run(change, kept, known, progress)

    def cartesian(self, method: str) -> CartesianCoordinates:
        """The machine's own coordinates, in which a run passes dead centres."""
        return CartesianCoordinates(self.ready, method, self.correction)

    def all_coordinates(
        self, run: Trajectory, start: tuple[float, FloatArray], p: FloatArray
    ) -> Trajectory:
        """A run in all coordinates: its samples, its events and its end.

        `start` is where it begins, with all coordinates, (n,), `p` has the branches of its loops.
        """
        reduced, events = self.reduced, run.events
        count, n = len(run.t), self.equations.n
        t = np.concatenate([run.t, events.t, [run.final_t]])
        q = np.vstack([run.q, events.q, run.final_q[None, :]])
        v = np.vstack([run.v, events.v, run.final_v[None, :]])
        order = np.argsort(t, kind="stable")
        all_q, all_v = np.empty((2, len(t), n))
        all_q[order], all_v[order] = reduced.expanded(
            t[order], q[order], v[order], p, start, self.ready.sizes[reduced.kept]
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
        return run._replace(
            q=all_q[:count], v=all_v[:count], final_q=all_q[-1], final_v=all_v[-1],
            events=replace(events, q=all_q[count:-1], v=all_v[count:-1]),
            partitions=replace(run.partitions, independent=free),
            index=run.index if switched else reduced.row(run.index), crossings=tuple(crossings),
        )  # fmt: skip


def formulate(
    ready: PreparedSimulation, formulation: Formulation, method: str, correction: Correction
) -> Coordinates:
    """The coordinates of a formulation; InputError if it does not exist or suit this machine.

    A run that goes on with other joints, which reduced coordinates do not suit, is in all of them.
    """
    if formulation not in FORMULATIONS:
        raise InputError(f"formulation = {formulation!r} must be one of {', '.join(FORMULATIONS)}.")
    if formulation == "reduced":
        try:
            return ReducedCoordinates(ready, correction)
        except InputError:
            if ready.given_length is None:
                raise
    return CartesianCoordinates(ready, method, correction)


def _mobility(
    inertia: FloatArray, sizes: FloatArray, counted: Integers, *, compressed: bool = False
) -> FloatArray:
    """Typical changes of coordinates, (n,), of the masses M_kk and typical sizes, (n,) each."""
    mobility = np.zeros(len(inertia))
    measure_mobility(np.array(inertia), sizes, counted, mobility, int(compressed))
    return mobility


def _spreads(ready: PreparedSimulation) -> FloatArray:
    """Σ |∂g/∂(q, q̇)| times the typical sizes, to which the rounding of g is proportional.

    At a dead centre of a switching function the reduced coordinates alone would not show it.
    """
    n, begin, rates = len(ready.sizes), ready.begin, ready.mechanism.kernels.switching_rates
    spreads, rest, now = np.zeros((3, len(ready.mechanism.description.switches)))
    rates(begin.t, begin.q, np.zeros(n), np.zeros(n), ready.p, rest)
    for unit in np.diag(np.tile(ready.sizes, 2)):
        rates(begin.t, begin.q, unit[:n], unit[n:], ready.p, now)
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
    stuck = [*description.stiction, *(k for k, *_ in description.friction_limits)]
    if stuck:
        names = dict.fromkeys(description.switches[k].name for k in stuck)
        problems.append(
            f"{', '.join(names)} stick by a force that follows from a reaction, "
            "which reduced coordinates leave out; give them creep="
        )
    if ready.controllers:
        problems.append(
            f"functions of your own compute {', '.join(description.controllers)} from all "
            "coordinates, which a run in reduced ones has only between its steps"
        )
    if begin.is_determined:
        problems.append(
            "nothing is left to integrate, as constraints and drivers determine all coordinates; "
            "ask for inverse_dynamics"
        )
    if problems:
        raise InputError(
            f'{description.title}: {problem}, or take formulation="cartesian".'
            for problem in problems
        )
