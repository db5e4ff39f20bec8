"""Quantities that follow from states: accelerations, reactions, powers, energies, residuals, works.

A power is smooth within a step and may jump at an event, where a step ends. So a run with works
samples each step at Gauss' nodes of the intervals between its ends and the output instants in it
(`runtime.integrate.sampling`), which integrates each interval to the order of ten. An impact
changes velocities at an instant; the energy that it takes away is no power, and in no work.

In sliding modes, where the motion slides, friction sticks, or a contact is closed, the outputs are
those of the forces there.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.constraints.partitioning import evaluate_jacobian
from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.arrays import (
    IntegerMatrix,
    Matrix,
    Vector,
    i8,
    integer_matrix,
    integers,
    matrix,
    named_tuple_type,
    none,
    vector,
)
from runtime.core.jit import ADDRESSES, compiled, inner, unlocked
from runtime.core.kinds import FRICTION, MIXED, OPEN, SLIDING
from runtime.hybrid.filippov_shares import mix_reactions
from runtime.hybrid.mode_consistency import count_sliding
from runtime.hybrid.rest_forces import is_prescribed, is_resting, set_unit
from runtime.integrate.sampling import INTERVAL, WEIGHTS
from runtime.integrate.wiring import Wiring, wire
from runtime.linalg.least_multipliers import minimise_norm, take_least_multipliers
from runtime.linalg.vectors import largest_magnitude
from runtime.mechanism.dense_equations import KEPT, Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.mechanism.typical_sizes import measure_length, start_table, write_scale
from runtime.results.result import Result
from runtime.results.samples import Samples, empty_samples

ENERGIES = ("kinetic_energy", "potential")
# numba's type of `Samples`
SAMPLES = named_tuple_type([vector, *[matrix] * 8, integer_matrix, matrix], Samples)


@inner
def settle_multipliers(
    kernels: Any, t: Any, q: Any, p: Any, rows: Any, columns: Any, slopes: Any, redundant: Any,
    free: Any, lam: Any,
) -> None:  # fmt: skip
    """Make multipliers those of least norm, of which so many `redundant` constraints leave open."""
    if free.size > 0:
        free.fill(0.0)
        abi.free_multipliers_of(kernels)(t, q, p, free)
        minimise_norm(free, redundant, lam)
    else:
        take_least_multipliers(rows, columns, slopes, len(q), redundant, lam)


@unlocked(
    none(ADDRESSES, SAMPLES, vector, integer_matrix, integers, integers, vector, vector, i8, vector)
)
def evaluate_samples(
    kernels: Any, s: Any, p: Any, modes: Any, rows: Any, columns: Any, slopes: Any, phi: Any,
    redundant: Any, free: Any,
) -> None:  # fmt: skip
    """Write what follows from the states of samples; `modes`, (k, s), are 0 and 1.

    Where constraints are `redundant`, so many, multipliers are those of least norm; `free` is room
    for others that exert no force, (k m,), where a kernel finds these.
    """
    for k in range(len(s.t)):
        t, q, v, a, lam, mode = s.t[k], s.q[k], s.v[k], s.a[k], s.lam[k], modes[k]
        if abi.accelerations_of(kernels)(t, q, v, p, mode, a, lam) != 0:
            a[:] = np.nan
            lam[:] = np.nan
        abi.constraints_of(kernels)(t, q, p, phi)
        s.residual[k, 0] = largest_magnitude(phi)
        abi.velocity_rhs_of(kernels)(t, q, p, phi)
        abi.jacobian_of(kernels)(t, q, p, slopes)
        for j in range(len(rows)):
            phi[rows[j]] -= slopes[j] * v[columns[j]]
        s.residual[k, 1] = largest_magnitude(phi)
        if redundant > 0:
            settle_multipliers(kernels, t, q, p, rows, columns, slopes, redundant, free, lam)
        abi.reactions_of(kernels)(t, q, v, p, lam, s.reaction[k])
        abi.switched_reactions_of(kernels)(t, q, v, p, mode, lam, s.reaction[k])
        if kernels[abi.DERIVED] != 0:
            abi.derived_outputs_of(kernels)(t, q, v, a, p, s.reaction[k])
        abi.powers_of(kernels)(t, q, v, p, mode, lam, s.power[k])
        s.energy[k, 0] = abi.kinetic_energy_of(kernels)(q, v, p)
        s.energy[k, 1] = abi.potential_of(kernels)(t, q, p, mode)


@compiled(none(ADDRESSES, SAMPLES, vector, matrix, matrix, integers))
def _find_modes(kernels: Any, s: Any, p: Any, bands: Any, work: Any, at_zero: Any) -> None:
    g, rate = work[0], work[1]
    for k in range(len(s.t)):
        t, q, v, modes = s.t[k], s.q[k], s.v[k], s.modes[k]
        abi.switching_of(kernels)(t, q, v, p, g)
        boundary = False
        for i in range(len(g)):
            modes[i] = 1 if g[i] > 0.0 else 0
            boundary = boundary or abs(g[i]) <= bands[0, i]
        if boundary:
            abi.accelerations_of(kernels)(t, q, v, p, modes, s.a[k], s.lam[k])
            abi.switching_rates_of(kernels)(t, q, v, s.a[k], p, rate)
            for i in range(len(g)):
                if g[i] == 0.0 and at_zero[i] == MIXED:
                    modes[i] = SLIDING
                elif g[i] == 0.0 and rate[i] > bands[1, i] and at_zero[i] != OPEN:
                    modes[i] = 1  # g > 0 does not hold yet
                elif abs(g[i]) <= bands[0, i] and abs(rate[i]) <= bands[1, i]:
                    modes[i] = min(at_zero[i], SLIDING)  # 2: the mean of both sides, or mixed


def _find_bands(equations: Equations, samples: Samples) -> Matrix:
    """Of g and dg/dt, (2, s): joints and drivers keep both at zero so closely where they do.

    A machine that stands has a trace of a speed, and accelerations as rounded as its forces.
    """
    rates, n, s = equations.kernels.switching_rates, equations.n, samples.modes.shape[1]
    size, speed = np.abs(samples.q).max(axis=0), np.abs(samples.v).max(axis=0)
    speed = np.maximum(speed, KEPT * max(1.0, float(size.max(initial=0.0))))

    def rates_at(v: Vector, a: Vector) -> Vector:
        out = np.zeros(s)
        rates(samples.t[0], samples.q[0], v, a, equations.p, out)
        return out

    still = np.zeros(n)
    rest, spread = rates_at(still, still), np.zeros(s)
    for by_position, by_velocity in zip(np.diag(size), np.diag(speed), strict=True):
        spread += np.abs(rates_at(by_position, still) - rest)
        spread += np.abs(rates_at(still, by_velocity) - rest)
    per_second = float((speed[size > 0.0] / size[size > 0.0]).max(initial=0.0))
    bands: Matrix = KEPT * np.nan_to_num(np.outer([1.0, per_second], spread))
    if equations.description.has_masses:
        for by_acceleration in np.diag(_free_accelerations(equations, samples)):
            change = np.abs(rates_at(still, by_acceleration) - rest)
            bands[1] += KEPT * np.nan_to_num(change, posinf=0.0)
    return bands


def _free_accelerations(equations: Equations, samples: Samples) -> Vector:
    """Sizes of what the forces alone would give, (n,), at the ends of the samples."""
    most = np.zeros(equations.n)
    for row in (0, -1):
        t, q, v = float(samples.t[row]), samples.q[row], samples.v[row]
        masses = np.abs(equations.masses(q))
        for modes in (np.zeros_like(samples.modes[0]), np.ones_like(samples.modes[0])):
            forces = np.abs(np.nan_to_num(equations.forces(t, q, v, modes), posinf=0.0, neginf=0.0))
            most = np.maximum(
                most, np.divide(forces, masses, np.zeros_like(most), where=masses > 0.0)
            )
    return most


def evaluate(
    equations: Equations, t: Vector, q: Matrix, v: Matrix, modes: IntegerMatrix | None = None
) -> Samples:
    """Accelerations, reactions, powers, energies and residuals at the instants `t`, (k,).

    States are (k, n), modes (k, s); these are determined from the states by default.
    """
    description, p = equations.description, equations.p
    s, samples = len(description.switches), empty_samples(description, len(t))
    t, q, v = (np.ascontiguousarray(array, dtype=np.float64) for array in (t, q, v))
    samples = samples._replace(t=t, q=q, v=v)
    samples.share.fill(np.nan)
    if modes is not None:
        samples = samples._replace(modes=np.ascontiguousarray(modes, dtype=np.int64))
    if modes is None and s:
        bands = _find_bands(equations, samples)
        _find_modes(equations.table, samples, p, bands, np.zeros((2, s)), description.boundaries)
    if description.unknown:
        from runtime.dynamics.unknown_forces import Transmission  # others load none of it

        Transmission(equations, samples).write_samples(samples)
    else:
        evaluate_rows(equations, samples)
    return samples


def evaluate_rows(equations: Equations, samples: Samples) -> None:
    """Write what follows from the states and modes of samples."""
    equations = equations.whole
    description = equations.description
    plain = np.where(samples.modes == SLIDING, 0, samples.modes)
    closed = [contact.switch for contact in description.rigid]
    closed += [k for k, row in enumerate(description.switches) if row.one_way]
    if closed:
        plain[:, closed] = 1
    rows, columns = description.jacobian_rows, description.jacobian_columns
    evaluate_samples(
        equations.table, samples, equations.p, plain, rows.astype(np.int64),
        columns.astype(np.int64), np.zeros(len(rows)), np.zeros(equations.m),
        len(description.redundant), _room_of_multipliers(equations),
    )  # fmt: skip
    if (samples.modes == SLIDING).any():
        _overwrite_sliding(equations, samples)
    leave_out_unknown(description, samples)


def _room_of_multipliers(equations: Equations) -> Vector:
    """Room for multipliers that exert no force, where a kernel finds them; else of no size."""
    return np.zeros(equations.description.free * equations.m)


def leave_out_unknown(description: Description, samples: Samples) -> None:
    """Make no numbers of what the kernels do not compute or an expression has not, and 0 of -0."""
    if description.recovered is not None:
        every = np.arange(len(description.constraints))
        samples.lam[..., np.setdiff1d(every, description.recovered)] = np.nan
    if description.has_masses:
        for k, name in enumerate(ENERGIES):
            if name not in description.kernels:
                samples.energy[..., k] = np.nan
    own = [k for k, row in enumerate(description.reactions) if not row.component]
    values = samples.reaction[..., own]
    samples.reaction[..., own] = np.where(np.isfinite(values), values, np.nan)
    for values in (samples.reaction, samples.power):
        np.add(values, 0.0, out=values)


def along_intervals(t: FloatArray, power: FloatArray) -> FloatArray:
    """Integrals of a power, W, over the intervals of a quadrature: (k,) each, k samples of it."""
    nodes = power[1:].reshape(-1, INTERVAL)[:, :-1]
    pieces: FloatArray = 0.5 * np.diff(t[::INTERVAL]) * (nodes @ WEIGHTS)
    return pieces


def integrate_works(result: Result, count: int, times: npt.ArrayLike | None) -> None:
    """Add the works that its scene asks for to a result, and drop the samples at nodes.

    The result's run has the start as its first sample, then for each interval its nodes and its
    end: `count` samples; possibly then the state in which it stopped. `times` are the output
    instants in s; None: the end of every step.
    """
    samples = result.samples
    ends = samples.t[:count:INTERVAL]
    kept = np.zeros(len(samples.t), dtype=np.bool_)
    kept[:count:INTERVAL] = True if times is None else np.isin(ends, times)
    if result.failed or result.ended_by:
        kept[-1:] = True
    for name, column in result.description.work_rows.items():
        pieces = along_intervals(samples.t[:count], samples.power[:count, column])
        work = np.full(len(samples.t), np.nan)
        work[:count:INTERVAL] = np.concatenate([[0.0], np.cumsum(pieces)])[: len(ends)]
        result.works[name] = work[kept]
        result.work_at_end[name] = float(pieces.sum())
    result.samples = samples.at(kept)


@inner
def prepare_mixing(
    context: Any, start: Any, diagonal: Any, t: float, q: Any, p: Any, masses: Any
) -> None:  # fmt: skip
    """Write the sizes of coordinates and of the rates of switching functions, and the masses at q.

    By these it is judged whether a response is more than rounding, as in a run. `diagonal` has the
    coordinate of each non-zero of M, -1 beside the diagonal, and `masses` is room for these;
    `start` is a table of `start_table`.
    """
    size, projection = ws.row_of(context, ws.SIZE), ws.row_of(context, ws.PROJECTION)
    n, rates = q.size, abi.switching_rates_of(start)
    write_scale(start, measure_length(start, t, q, p), start.change_scale)
    for j in range(n):
        size[j], size[n + j], projection[j] = start.change_scale[j], start.change_scale[j], 0.0
    abi.mass_of(start)(q, p, masses)
    for e in range(masses.size):
        if diagonal[e] >= 0 and masses[e] > 0.0:
            projection[diagonal[e]] = 1.0 / masses[e]
    still, change = ws.positions(context, ws.SAMPLE), ws.velocities(context, ws.SAMPLE)
    rest, moved = ws.switch_row(context, ws.SCAN), ws.switch_row(context, ws.SCAN + 1)
    spread = context.largest
    still.fill(0.0)
    change.fill(0.0)
    spread.fill(0.0)
    rates(t, q, still, still, p, rest)
    for j in range(n):
        change[j] = start.change_scale[j]
        for of_velocity in range(2):
            if of_velocity == 0:
                rates(t, q, change, still, p, moved)
            else:
                rates(t, q, still, change, p, moved)
            for k in range(spread.size):
                away = abs(moved[k] - rest[k])
                spread[k] += away if np.isfinite(away) else 0.0
        change[j] = 0.0
    for k in range(spread.size):
        context.reserve[k] = spread[k]


@inner
def mix_rows(
    context: Any, start: Any, diagonal: Any, s: Any, p: Any, masses: Any, powers: Any,
    redundant: Any, free: Any,
) -> None:  # fmt: skip
    """Overwrite the outputs of the samples in which a function is in mode 2."""
    base, other, reaction = powers[0], powers[1], context.reaction
    modes, base_lam, lam = (
        context.kernel_modes,
        context.given_multipliers,
        context.mixed_multipliers,
    )
    evaluate_powers = abi.powers_of(start)
    prepared = False
    for row in range(s.t.size):
        t, q, v, sliding = s.t[row], s.q[row], s.v[row], False
        for k in range(s.modes.shape[1]):
            sliding = sliding or s.modes[row, k] == SLIDING
        if not sliding:
            continue
        if not prepared:
            prepare_mixing(context, start, diagonal, t, q, p, masses)
            prepared = True
        count_sliding(context, s.modes[row])
        ft.modified_accelerations_of(context)(context, t, q, v, s.modes[row], s.a[row], s.lam[row])
        if redundant > 0:
            sparse = evaluate_jacobian(context, t, q)
            places = sparse.rows, sparse.columns, sparse.values
            settle_multipliers(start, t, q, p, *places, redundant, free, s.lam[row])
        mix_reactions(context, t, q, v, s.lam[row])
        for i in range(len(reaction)):
            s.reaction[row, i] = reaction[i]
        if start[abi.DERIVED] != 0:
            abi.derived_outputs_of(start)(t, q, v, s.a[row], p, s.reaction[row])
        evaluate_powers(t, q, v, p, modes, base_lam, base)
        for i in range(len(base)):
            s.power[row, i] = base[i]
        for c in range(context[ft.SLIDING_COUNT]):
            k = context.sliding_functions[c]
            s.share[row, k] = context.share[k]
            if context.stiction_place[k] >= 0:
                # Between the friction forces of both directions, at the present normal force.
                force, limit = reaction[context.limits[2 * k]], reaction[context.limits[2 * k + 1]]
                part = 0.5 * context.share_high[k] * force / limit
                s.share[row, k] = 0.5 - part if limit > 0.0 else np.nan
            if context.sticks[k] == FRICTION and is_resting(context, c):
                s.share[row, k] = np.nan  # any would do
            if is_prescribed(context, k):
                continue
            for i in range(len(lam)):
                lam[i] = base_lam[i] + context.unit_multipliers[c, i]
            set_unit(context, k, 1)
            evaluate_powers(t, q, v, p, modes, lam, other)
            set_unit(context, k, 0)
            for i in range(len(base)):
                s.power[row, i] += context.share[k] * (other[i] - base[i])


@compiled(none(ADDRESSES, ADDRESSES, integers, SAMPLES, vector, vector, matrix, i8, vector))
def _mix(
    context: Any, start: Any, diagonal: Any, s: Any, p: Any, masses: Any, powers: Any,
    redundant: Any, free: Any,
) -> None:  # fmt: skip
    mix_rows(context, start, diagonal, s, p, masses, powers, redundant, free)


def wire_mixing(mechanism: Mechanism, p: Vector) -> Wiring:
    """A table for `mix_rows`."""
    return wire(mechanism.system, "dopri5", p, 1)


def _overwrite_sliding(equations: Equations, samples: Samples) -> None:
    """Overwrite what depends on accelerations in mode 2, and `share`: 0 is mode 0, 1 is mode 1."""
    mechanism = equations.mechanism  # whose equations other threads may share
    wiring, start = wire_mixing(mechanism, equations.p), start_table(mechanism)
    diagonal = equations.description.mass_diagonal
    masses, powers = np.zeros(len(diagonal)), np.zeros((2, samples.power.shape[1]))
    redundant, free = len(equations.description.redundant), _room_of_multipliers(equations)
    _mix(wiring.table, start.table, diagonal, samples, equations.p, masses, powers, redundant, free)
