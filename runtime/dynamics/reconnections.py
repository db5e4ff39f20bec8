"""Runs in which joints come and go: one run after the other, each with the joints that act.

Every set of joints is a scene of its own, with its own module and partition. Where a joint engages,
velocities that it does not permit end in an impact, M Δv + Φ_qᵀ Λ = 0, Φ_q (v + Δv) = ν.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from runtime.assembly.assemble import assemble
from runtime.core.outcomes import Outcome
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism, Values
from runtime.mechanism.module_tables import Description
from runtime.results.assembled_state import Assembly
from runtime.results.reconnection import Reconnection
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.validation.parameters import parameter_values

_CLOSED = 1e-6  # safety: of the machine's size; a joint further open than this does not engage


class Ending(NamedTuple):
    """The state in which a run ended, in its own machine."""

    t: float
    q: FloatArray
    v: FloatArray
    modes: FloatArray


class Gap(Exception):  # noqa: N818 (it is caught where runs follow one another)
    """A joint that does not close where it is to engage."""


def cross(
    before: Mechanism, after: Mechanism, row: int, end: Ending, parameters: Values | None
) -> tuple[Assembly, Reconnection]:
    """The state behind the instant at which condition `row` of WATCHED ended a run; raises Gap."""
    watched = before.description.watched[row]
    known = {name: k for k, name in enumerate(before.description.coordinates.names)}
    names = after.description.coordinates.names
    q, v = (np.array([x[known[n]] if n in known else 0.0 for n in names]) for x in (end.q, end.v))
    values = {
        k: x for k, x in (parameters or {}).items() if k in after.description.parameters.names
    }
    equations = Equations(after, parameter_values(after, values))
    impulse, lost = {}, 0.0
    if watched.action == "engage":
        _require_closed(equations, watched.target, end.t, q)
        v, multipliers = impact(equations, end.t, q, v)
        moving = [np.array(x) for x in (v, end.v)]
        energy = [
            machine.kernels.kinetic_energy(at, x, of.p)
            for machine, at, x, of in (
                (before, end.q, moving[1], Equations(before, parameter_values(before, parameters))),
                (after, q, moving[0], equations),
            )
        ]
        lost = float(energy[0] - energy[1])
        impulse = _impulses(after, equations, watched.target, end.t, q, v, multipliers)
    rates = [row.velocity for row in after.description.coordinates]
    guess = dict(zip((*names, *rates), map(float, (*q, *v)), strict=True))
    start = assemble(after, guess, values, end.t)
    return start, Reconnection(end.t, watched.target, watched.action, impulse, lost)


def impact(
    equations: Equations, t: float, q: FloatArray, v: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Velocities after an impact of all constraints, (n,), and its impulses Λ, (m,)."""
    n, jacobian = equations.n, equations.jacobian(t, q)
    m = len(jacobian)
    matrix = np.block([[equations.mass(q), jacobian.T], [jacobian, np.zeros((m, m))]])
    right = np.concatenate([np.zeros(n), equations.velocity_rhs(t, q) - jacobian @ v])
    change = np.linalg.lstsq(matrix, right, rcond=None)[0]
    return v + change[:n], change[n:]


def _require_closed(equations: Equations, joint: str, t: float, q: FloatArray) -> None:
    rows = equations.description.constraints
    gaps = np.abs(equations.constraints(t, q))
    open_rows = [
        f"{row.name} by {gap:.3g}"
        for row, gap in zip(rows, gaps, strict=True)
        if row.element == joint and gap > _CLOSED * max(1.0, float(np.abs(q).max(initial=0.0)))
    ]
    if open_rows:
        raise Gap(
            f"Joint '{joint}' is to engage at t = {t:.9g} s, where it is open: "
            f"{', '.join(open_rows)}. Choose a condition under which it closes by itself, or a "
            "joint with fewer constraints."
        )


def _impulses(
    mechanism: Mechanism, equations: Equations, joint: str, t: float, q: FloatArray,
    v: FloatArray, multipliers: FloatArray,
) -> dict[str, float]:  # fmt: skip
    """Component → impulse of a joint, as its reactions follow from multipliers."""
    rows = mechanism.description.reactions
    out = np.zeros(len(rows))
    if "reactions" in mechanism.description.kernels:
        mechanism.kernels.reactions(t, q, v, equations.p, multipliers, out)
    pairs = zip(rows, out.tolist(), strict=True)
    return {row.component: value for row, value in pairs if row.element == joint}


def joined(results: Sequence[Result], changes: Sequence[Reconnection]) -> Result:
    """One result of runs that follow one another, in the tables of all their machines."""
    description = _union([result.description for result in results])
    pieces = [_in_tables(result, description) for result in results]
    kept = [np.ones(len(piece.t), np.bool_) for piece in pieces]
    for k in range(1, len(pieces)):
        if len(pieces[k].t) and any(len(p.t) and p.t[-1] == pieces[k].t[0] for p in pieces[:k]):
            kept[k][0] = False
    samples = Samples(
        *(
            np.concatenate([column[rows] for column, rows in zip(columns, kept, strict=True)])
            for columns in zip(*pieces, strict=True)
        )
    )
    last = results[-1]
    parameters = np.array([last.parameters.get(row.name, row.default)
                           for row in description.parameters])  # fmt: skip
    result = Result(
        description, samples, parameters, analysis=last.analysis, outcome=last.outcome,
        message=" ".join([*map(str, changes), last.message]),
        stats=_totals([result.stats for result in results]),
        events=[event for result in results for event in result.events],
        partitions=[one for result in results for one in result.partitions],
        not_unique=tuple(dict.fromkeys(n for result in results for n in result.not_unique)),
        singular=[one for result in results for one in result.singular],
    )  # fmt: skip
    result.contradiction = " ".join(filter(None, (r.contradiction for r in results)))
    result.reconnections = tuple(changes)
    totals: dict[str, float] = {}
    works: dict[str, list[FloatArray]] = {name: [] for r in results for name in r.works}
    for one, rows in zip(results, kept, strict=True):
        for name, parts in works.items():
            work = one.works.get(name, np.zeros(len(one.t)))
            parts.append(totals.get(name, 0.0) + work[rows])
            totals[name] = totals.get(name, 0.0) + (float(work[-1]) if len(work) else 0.0)
    result.works.update({name: np.concatenate(parts) for name, parts in works.items()})
    return result


def _union(descriptions: Sequence[Description]) -> Description:
    """The first description with what the others have besides."""
    first = descriptions[0]
    tables = {}
    for name in ("coordinates", "constraints", "parameters", "effects", "switches", "reactions",
                 "powers"):  # fmt: skip
        rows = [row for d in descriptions for row in getattr(d, name)]
        tables[name] = type(getattr(first, name))(dict.fromkeys(rows))
    gone = {*tables["effects"]}
    tables["left_out"] = type(first.left_out)(row for row in first.left_out if row not in gone)
    drivers = tuple(dict.fromkeys(name for d in descriptions for name in d.drivers))
    return first._replace(**tables, drivers=drivers)


def _in_tables(result: Result, description: Description) -> Samples:
    """The samples of a result by the rows of other tables; what does not act exerts nothing."""
    own, samples = result.description, result.samples

    def spread(values: FloatArray, table: str, missing: float) -> FloatArray:
        rows = list(getattr(description, table))
        places = {row: k for k, row in enumerate(getattr(own, table))}
        out = np.full((len(values), len(rows)), missing, values.dtype)
        for k, row in enumerate(rows):
            if row in places:
                out[:, k] = values[:, places[row]]
        return out

    def rows_of(name: str, table: str, missing: float) -> FloatArray:
        return spread(getattr(samples, name), table, missing)

    return samples._replace(
        q=rows_of("q", "coordinates", np.nan), v=rows_of("v", "coordinates", np.nan),
        a=rows_of("a", "coordinates", np.nan), lam=rows_of("lam", "constraints", 0.0),
        reaction=rows_of("reaction", "reactions", 0.0), power=rows_of("power", "powers", 0.0),
        modes=rows_of("modes", "switches", 0), share=rows_of("share", "switches", np.nan),
    )  # fmt: skip


def _totals(stats: Sequence[dict[str, float]]) -> dict[str, float]:
    """Counts of all runs together; of what is a largest value the largest."""
    largest = {"crossing_error", "largest_correction"}
    return {
        name: (max if name in largest else sum)(one.get(name, 0) for one in stats)
        for name in stats[0]
    }


def stopped_at(result: Result, note: str) -> Result:
    """The result of a run that cannot go on, as a joint is open that is to engage."""
    result.outcome = Outcome.INCONSISTENT
    result.message = note
    return result
