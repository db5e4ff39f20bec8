"""Classification of the singular configurations of a driven machine, and the messages about them.

u and x are the left and the right null vector of Phi_q there. Where uᵀ Phi_t does not vanish, no
velocities satisfy the drivers: time turns back along the curve of positions, a fold, and the
machine locks up. Where it vanishes, curves of positions cross, a branch point, and the quadratic
form uᵀ gamma of the velocities v_p + c x gives their directions (see `bifurcation_branches`).
"""

from collections.abc import Sequence

import numpy as np

from codegen.errors import AnalysisError
from runtime.continuation.bifurcation_branches import SOLVED, Branch, RankDeficiency
from runtime.integrate.problem import Crossing
from runtime.linalg.rank_policy import LOST
from runtime.mechanism.dense_equations import Equations, FloatArray, row_lengths
from runtime.results.run_records import Kind, SingularPosition

# measured: part of the largest share in a rank deficiency; constraints above it are named
_PART = 0.05
_FEW = 4  # layout: branches that a message lists, and joints that stand in the way of a driver


def describe(at: RankDeficiency, kind: Kind, v: FloatArray, rate: float) -> SingularPosition:
    """Describe a singular position and the velocities there; `rate` is the drivers' pace, 1/s."""
    table = at.equations.description.constraints
    count, null = (at.k, at.null) if len(at.rows) == at.equations.m else _of_all(at)
    parts = dict[str, float]()
    for row, part in zip(at.rows, np.linalg.norm(at.left, axis=1), strict=True):
        name = table[int(row)].element
        parts[name] = float(np.hypot(parts.get(name, 0.0), part))
    ranked = sorted(parts, key=lambda name: -parts[name])
    elements = [name for name in ranked if parts[name] > _PART * parts[ranked[0]]]
    return SingularPosition(
        kind, at.t, *_drivers_and_joints(at.equations, elements), count,
        tuple(_named(at.equations, x) for x in _simple(null)), singular_value=float(at.values[-1]),
        drift=at.drift(rate), q=at.q.copy(), v=v.copy(),
        size=float(at.scale[at.equations.description.is_length].max(initial=0.0)) or 1.0,
    )  # fmt: skip


def describe_crossings(
    equations: Equations, t: float, q: FloatArray, mobility: FloatArray, run: Sequence[Crossing]
) -> tuple[SingularPosition, ...]:
    """Describe the crossings of a simulation that began at (t, q), its columns scaled by masses.

    A simulation keeps one constraint and one direction of each, and no state.
    """
    size = equations.size(t, q)
    units = mobility / equations.scale(size)
    table = equations.description.constraints
    found = []
    for row in run:
        named = _drivers_and_joints(equations, [table[row.rows[0]].element])
        direction = _named(equations, row.direction * units)
        found.append(
            SingularPosition(
                "crossing", row.t, *named, row.lost, (direction,), np.nan, np.nan, size=size
            )
        )
    return tuple(found)


def _drivers_and_joints(
    equations: Equations, elements: Sequence[str]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The drivers and the joints among these elements, each named once."""
    names, drivers = dict.fromkeys(elements), equations.description.drivers
    return (
        tuple(name for name in names if name in drivers),
        tuple(name for name in names if name not in drivers),
    )


def driven_instant(equations: Equations, t: float, q: FloatArray) -> float:
    """The instant near t at which the drivers demand the position q."""
    for _ in range(3):
        nu = equations.velocity_rhs(t, q)
        square = float(nu @ nu)
        if square == 0.0:
            break
        t += float(equations.constraints(t, q) @ nu) / square
    return t


def lock_up(equations: Equations, found: SingularPosition) -> str:
    """The message of a run that ends in a lock-up."""
    drivers = found.drivers or equations.description.drivers
    why = "asks for what the machine cannot reach"
    if found.joints:
        rest = f" and {len(found.joints) - _FEW} more" if len(found.joints) > _FEW else ""
        why = f"cannot go on, joints {', '.join(found.joints[:_FEW])}{rest} stand in the way"
    return (
        f"Locked up at t = {found.time:.12g} s: driver {', '.join(drivers)} {why}. Change the "
        f"dimensions or the range of the driver, or drive another coordinate: with the drivers at "
        f"rest the machine could move by {found.free}. (Velocities grow without bound there. "
        f"Smallest singular value of Phi_q: {found.singular_value:.1e}; share of the drivers' "
        f"motion that no velocities give: {found.drift:.2g}.)"
    )


def undefined(equations: Equations, t: float, ahead: float, q: FloatArray) -> str:
    """The message where an element has no value a little later; empty where all have."""
    later = equations.constraints(t + ahead * 1e-6 * max(abs(t), 1e-3), q)
    table = equations.description.constraints
    without = [table[int(row)].element for row in np.flatnonzero(~np.isfinite(later))]
    if not without:
        return ""
    return (
        f"Stopped at t = {t:.9g} s: {', '.join(dict.fromkeys(without))} has no value just "
        f"after. Look for a table evaluated beyond its ends, a division by zero or a root of a "
        f"negative number."
    )


def unclear(found: SingularPosition) -> str:
    """The message where neither a smooth motion nor a fold was found."""
    return (
        f"Stopped at t = {found.time:.9g} s, at a position that is singular or too near to one to "
        f"be distinguished from it (smallest singular value of Phi_q {found.singular_value:.1e}, "
        f"{', '.join((*found.drivers, *found.joints))}): no smooth motion leads on. With the "
        f"drivers at rest the machine could move by {found.free}. Change a dimension by a little, "
        f"or drive one of these coordinates."
    )


def crossings(found: list[SingularPosition]) -> str:
    """Sentence about the positions that were crossed; empty without any."""
    if not found:
        return ""
    where = ", ".join(f"{row.time:.6g}" for row in found[:5])
    first = found[0]
    return (
        f" Crossed {len(found)} singular position(s) at t = {where} s on the branch on which the "
        f"velocity is continuous; at the first of them {', '.join(first.drivers + first.joints)} "
        f"left the machine free to move by {first.free}."
    )


def no_start(equations: Equations, found: SingularPosition, choices: list[Branch]) -> AnalysisError:
    """The error of a singular start whose branch is undecided."""
    description = equations.description
    names = (*found.drivers, *found.joints)
    head = (
        f"{description.title}: the machine starts in a singular position at t = {found.time:g} s "
        f"({', '.join(names)} {'has' if len(names) == 1 else 'have'} no hold here; free to move: "
        f"{found.free})"
    )
    if not choices:
        locked = "" if found.drift <= SOLVED else " (a lock-up: no velocities satisfy the drivers)"
        return AnalysisError(
            f"{head}, and no smooth motion leads out of it{locked}. Start a little off it: "
            f"another t_start, or other start values."
        )
    listed = "; ".join(
        f"({number}) {_apart(equations, branch, choices)}"
        for number, branch in enumerate(choices[:_FEW], 1)
    )
    rest = f" and {len(choices) - _FEW} more" if len(choices) > _FEW else ""
    return AnalysisError(
        f"{head}, where {len(choices)} motions meet, and the start velocities are as near to one "
        f"as to another: {listed}{rest}. Give start velocities of the one that is meant."
    )


def _apart(equations: Equations, branch: Branch, choices: list[Branch]) -> str:
    """The velocities in which a branch differs from the others."""
    all_v = np.array([other.v for other in choices])
    differs = np.ptp(all_v, axis=0) > 1e-6 * max(float(np.abs(all_v).max()), 1e-300)
    coordinates = equations.description.coordinates
    rows = ((coordinates[int(k)], branch.v[k]) for k in np.flatnonzero(differs))
    return ", ".join(f"{row.velocity} = {v:.6g} {row.velocity_unit}" for row, v in rows)


def _named(equations: Equations, x: FloatArray) -> dict[str, float]:
    coordinates, sizes = equations.description.coordinates, np.abs(x)
    shares = (x / x[sizes.argmax()]).tolist()
    places = np.flatnonzero(sizes > 1e-9 * sizes.max()).tolist()
    return {coordinates[k].name: shares[k] for k in places}


def _of_all(at: RankDeficiency) -> tuple[int, FloatArray]:
    """Rank deficiency of all rows together, at most `at.k`, and their null directions, (n, k).

    Rows that follow from others elsewhere may be independent where those are not, which leaves
    fewer directions free.
    """
    matrix = at.equations.jacobian(at.t, at.q) * at.scale
    _, values, right = np.linalg.svd(matrix / row_lengths(matrix)[:, None])
    rank = int((values[: len(at.rows)] >= LOST).sum())
    # A position that is counted as singular, however large its singular value, has lost one.
    count = min(max(len(at.rows) - rank, 1), at.k)
    return count, right[len(at.q) - count :].T


def _simple(null: FloatArray) -> FloatArray:
    """A basis of the null directions, each free of the others' largest coordinates, (k, n)."""
    rows = null.T.copy()
    for i in range(len(rows)):
        pick = i + int(np.abs(rows[i:]).max(axis=1).argmax())
        column = int(np.abs(rows[pick]).argmax())
        rows[[i, pick]] = rows[[pick, i]]
        rows[i] /= rows[i, column]
        for other in range(len(rows)):
            if other != i:
                rows[other] -= rows[other, column] * rows[i]
    return rows
